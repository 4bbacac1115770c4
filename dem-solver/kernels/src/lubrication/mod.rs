//! Lubrication between near surfaces: the law of one gap, and the simultaneous solution of many.

mod brake;
mod film_list;
pub mod law;
mod packs;
mod rows;
pub mod settings;
pub(crate) mod simultaneous;
mod sliding;
mod visit;
