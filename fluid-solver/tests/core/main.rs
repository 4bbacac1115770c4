//! The Navier–Stokes core against exact solutions and discrete identities.

mod common;

mod flow_rate;
mod identities;
mod open;
mod order;
mod radial;
mod repeat;
mod solve;
mod space;
mod transforms;
mod walls;
