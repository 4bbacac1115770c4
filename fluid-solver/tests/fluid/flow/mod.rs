//! The Navier–Stokes core against exact solutions and discrete identities.

pub(crate) mod common;
mod reference;

mod drive;
mod equations;
mod flow_rate;
mod identities;
mod open;
mod order;
mod radial;
mod ranks;
mod repeat;
mod solve;
mod terms;
mod transforms;
mod walls;
