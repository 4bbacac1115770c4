//! Reads the field files of the fluid: VTK rectilinear grids (`.vtr`), appended raw little-endian
//! `Float64` with `UInt64` lengths, cell data. What is not of this form is refused.

use std::collections::BTreeMap;
use std::path::Path;

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

/// One `DataArray` of the header.
struct Entry<'a> {
    name: &'a str,
    components: usize,
    offset: usize,
}

impl Vtr {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let place = |why: String| format!("{}: {why}", path.display());
        let bytes = std::fs::read(path).map_err(|error| place(format!("cannot read: {error}")))?;
        Self::parse(&bytes).map_err(place)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (header, data) = split(bytes)?;
        for needed in ["type=\"RectilinearGrid\"", "byte_order=\"LittleEndian\"", "header_type=\"UInt64\""] {
            if !header.contains(needed) {
                return Err(format!("its header lacks {needed}"));
            }
        }
        let mut read = Self { time: time(header), ..Self::default() };
        let (cells, coordinates) =
            header.split_once("<Coordinates>").ok_or("its header has no coordinates")?;
        let coordinates = entries(coordinates)?;
        if coordinates.len() != 3 {
            return Err(format!("it has {} coordinate arrays, not 3", coordinates.len()));
        }
        for (faces, entry) in read.faces.iter_mut().zip(&coordinates) {
            *faces = values(data, entry)?;
        }
        let count: usize = read.counts().iter().product();
        for entry in entries(cells)? {
            let array = values(data, &entry)?;
            if array.len() != count * entry.components {
                let (name, length) = (entry.name, array.len());
                return Err(format!("array {name} has {length} values for {count} cells"));
            }
            read.arrays.insert(entry.name.to_owned(), (entry.components, array));
        }
        Ok(read)
    }

    /// Cells along x, y and z.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        std::array::from_fn(|axis| self.faces[axis].len().saturating_sub(1).max(1))
    }

    /// Centres of the cells along an axis, m.
    #[must_use]
    pub fn centres(&self, axis: usize) -> Vec<f64> {
        match self.faces[axis].as_slice() {
            [] => Vec::new(),
            [only] => vec![*only],
            faces => faces.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect(),
        }
    }

    /// A component of an array on the plane (x, z) of cells with index `j` along y: rows of constant
    /// z, from below.
    #[must_use]
    pub fn slice(&self, name: &str, component: usize, j: usize) -> Option<Vec<Vec<f64>>> {
        let (components, values) = self.arrays.get(name)?;
        let [nx, ny, nz] = self.counts();
        if component >= *components || j >= ny {
            return None;
        }
        let value = |i: usize, k: usize| values[components * (i + nx * (j + ny * k)) + component];
        Some((0..nz).map(|k| (0..nx).map(|i| value(i, k)).collect()).collect())
    }
}

/// Header as text, and the appended bytes.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let mark = b"<AppendedData encoding=\"raw\">";
    let at = bytes.windows(mark.len()).position(|window| window == mark);
    let at = at.ok_or("it is no VTK file with appended raw data")?;
    let header = std::str::from_utf8(&bytes[..at]).map_err(|_| "its header is not text")?;
    let rest = &bytes[at + mark.len()..];
    let start = rest.iter().position(|byte| *byte == b'_').ok_or("its data do not begin with `_`")?;
    Ok((header, &rest[start + 1..]))
}

fn time(header: &str) -> f64 {
    let text = header.split_once("Name=\"TimeValue\"").and_then(|(_, rest)| rest.split_once('>'));
    let text = text.and_then(|(_, rest)| rest.split_once('<')).map_or("", |(text, _)| text.trim());
    text.parse().unwrap_or(f64::NAN)
}

fn entries(header: &str) -> Result<Vec<Entry<'_>>, String> {
    let tags = header.split("<DataArray ").skip(1).filter_map(|rest| rest.split('>').next());
    tags.filter(|tag| attribute(tag, "format") == Some("appended"))
        .map(|tag| {
            let name = attribute(tag, "Name").ok_or("an array has no name")?;
            if attribute(tag, "type") != Some("Float64") {
                return Err(format!("array {name} is not Float64"));
            }
            let number = |key: &str| attribute(tag, key).and_then(|text| text.parse().ok());
            let offset = number("offset").ok_or(format!("array {name} has no offset"))?;
            Ok(Entry { name, components: number("NumberOfComponents").unwrap_or(1), offset })
        })
        .collect()
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    // The space keeps `Name` apart from `FileName`.
    let tag = tag
        .split_once(&format!("{name}=\""))
        .filter(|(before, _)| before.is_empty() || before.ends_with(' '))?;
    tag.1.split('"').next()
}

fn values(data: &[u8], entry: &Entry) -> Result<Vec<f64>, String> {
    let torn = || format!("array {} lies beyond the end of the file", entry.name);
    let length = data.get(entry.offset..).and_then(|rest| rest.first_chunk::<8>()).ok_or_else(torn)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| torn())?;
    let bytes = data.get(entry.offset + 8..).and_then(|rest| rest.get(..length)).ok_or_else(torn)?;
    Ok(bytes.as_chunks::<8>().0.iter().map(|word| f64::from_le_bytes(*word)).collect())
}
