//! Files for ParaView and other viewers of VTK, appended raw binary, 64-bit floats: points with data
//! (`.vtp`), cell data on a uniform (`.vti`) or a rectilinear grid (`.vtr`, in several files `.pvtr`), and
//! the list of files over time (`.pvd`). What is written here is read here: [`points`] by [`Appended`],
//! [`rectilinear_part`] by [`Vtr`].
//!
//! ```
//! use bedload_output::vtk::{Appended, Array, points};
//!
//! let bytes = points(0.5, vec![1.0, 2.0, 3.0], &[Array::scalar("radius", vec![0.25])]);
//! let file = Appended::parse(&bytes, "PolyData")?;
//! assert_eq!((file.time(), file.real(&file.find("radius")?)?), (0.5, vec![0.25]));
//! # Ok::<(), String>(())
//! ```

mod grid;
mod parts;
mod read;
mod write;

pub use grid::Vtr;
pub use parts::{Part, parts, read};
pub use read::{Appended, Entry};
pub use write::{Array, Values, image, list, points, polygons, rectilinear_part};
