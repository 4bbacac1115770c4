//! Runs of the programs as a user starts them.

mod accuracy;
mod blow_up;
mod chart;
mod conformance;
mod coupled;
mod dry;
mod ensemble;
mod evidence;
mod film;
mod handover;
mod kill;
mod light;
mod memory;
mod new;
mod no_room;
mod orphans;
mod over_time;
mod proposals;
mod replay;
mod schemes;
mod stability;
mod storm;
mod totals;
mod unstable;
mod vectors;
mod verify;
