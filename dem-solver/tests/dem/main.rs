//! The DEM against exact solutions, discrete identities and its own promises.

mod common;

mod bodies;
mod bodies_oracle;
mod bodies_round;
mod bodies_scene;
mod bounds;
mod bulk;
mod coarse_grain;
mod constraints;
mod coupling;
mod energy;
mod flow;
mod haff;
mod integrators;
mod invariance;
mod janssen;
mod lanes;
mod lubrication;
mod oblique;
mod over_time;
mod partition;
mod rest;
mod restitution;
mod rolling;
mod scene_features;
mod scene_keys;
mod split;
mod state;
mod walls;
mod window_drag;
