//! The Navier–Stokes core against exact solutions and discrete identities.

mod common;

mod identities;
mod order;
mod radial;
mod repeat;
mod solve;
mod space;
mod transforms;
mod walls;
