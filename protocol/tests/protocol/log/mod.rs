//! The log from outside: round trips, damage, kills, full disks, replays.

mod codec;
mod damage;
mod difference;
mod recording;
mod round_trip;
mod schema;
mod sequence;
mod support;
