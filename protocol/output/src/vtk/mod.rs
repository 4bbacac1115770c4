//! Files for ParaView and other viewers of VTK, appended raw binary, 64-bit floats: points with data
//! (`.vtp`), cell data on a uniform (`.vti`) or a rectilinear grid (`.vtr`), and the list of files over time
//! (`.pvd`). What is written here is read here: [`points`] by [`Appended`], [`rectilinear`] by [`Vtr`].

mod grid;
mod read;
mod write;

pub use grid::Vtr;
pub use read::{Appended, Entry};
pub use write::{Array, Values, image, list, points, rectilinear};
