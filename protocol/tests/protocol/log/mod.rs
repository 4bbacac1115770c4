//! The log from outside: round trips, damage, kills, full disks, replays.

mod damage;
mod recording;
mod round_trip;
mod schema;
mod support;
