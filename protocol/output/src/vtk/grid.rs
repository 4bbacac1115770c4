//! Reads the field files of the fluid: VTK rectilinear grids (`.vtr`) with floats as cell data.

use std::collections::BTreeMap;
use std::path::Path;

use super::read::{Appended, entries};

/// A field file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vtr {
    /// Time, s.
    pub time: f64,
    /// Coordinates of the faces along x, y and z, m; one number along an axis that the grid has not.
    pub faces: [Vec<f64>; 3],
    /// Cell arrays by name: number of components, values cell by cell, x fastest.
    pub arrays: BTreeMap<String, (usize, Vec<f64>)>,
}

impl Vtr {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let place = |why: String| format!("{}: {why}", path.display());
        let bytes =
            protocol::input_file::read(path).map_err(|error| place(format!("cannot read: {error}")))?;
        Self::parse(&bytes).map_err(place)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let file = Appended::parse(bytes, "RectilinearGrid")?;
        let mut read = Self { time: file.time(), ..Self::default() };
        let (cells, coordinates) =
            file.header.split_once("<Coordinates>").ok_or("its header has no coordinates")?;
        let coordinates = entries(coordinates)?;
        if coordinates.len() != 3 {
            return Err(format!("it has {} coordinate arrays, not 3", coordinates.len()));
        }
        for (faces, entry) in read.faces.iter_mut().zip(&coordinates) {
            *faces = file.real(entry)?;
        }
        let count: usize = read.counts().iter().product();
        for entry in entries(cells)? {
            let array = file.real(&entry)?;
            if array.len() != count * entry.components {
                let (name, length) = (entry.name, array.len());
                return Err(format!("array {name} has {length} values for {count} cells"));
            }
            read.arrays.insert(entry.name.to_owned(), (entry.components, array));
        }
        Ok(read)
    }

    /// Cells along x, y and z.
    pub fn counts(&self) -> [usize; 3] {
        std::array::from_fn(|axis| self.faces[axis].len().saturating_sub(1).max(1))
    }
}
