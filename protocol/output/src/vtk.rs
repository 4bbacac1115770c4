//! Files for ParaView and other viewers of VTK: points with data (`.vtp`), a uniform grid with cell
//! data (`.vti`), and the list of files over time (`.pvd`). Appended raw binary, 64-bit floats.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::OutputError;
use crate::file::atomic_write;

/// Values of an array.
#[derive(Clone, Debug)]
pub enum Values {
    /// Floats, `components` per point or cell.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i64>),
}

/// One array of a file.
#[derive(Clone, Debug)]
pub struct Array {
    /// Name that the viewer shows.
    pub name: &'static str,
    /// Numbers per point or cell: 1, 3 for a vector, 9 for a tensor.
    pub components: usize,
    /// The numbers, point by point.
    pub values: Values,
}

impl Array {
    /// One float per point.
    #[must_use]
    pub fn scalar(name: &'static str, values: Vec<f64>) -> Self {
        Self { name, components: 1, values: Values::Real(values) }
    }

    /// `components` floats per point.
    #[must_use]
    pub fn real(name: &'static str, components: usize, values: Vec<f64>) -> Self {
        Self { name, components, values: Values::Real(values) }
    }

    /// One whole number per point.
    #[must_use]
    pub fn whole(name: &'static str, values: Vec<i64>) -> Self {
        Self { name, components: 1, values: Values::Whole(values) }
    }

    fn kind(&self) -> &'static str {
        match self.values {
            Values::Real(_) => "Float64",
            Values::Whole(_) => "Int64",
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match &self.values {
            Values::Real(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::Whole(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}

/// Text of a file and the blocks that follow it.
struct Writer {
    text: String,
    blocks: Vec<u8>,
}

impl Writer {
    fn new(kind: &str) -> Self {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n"
        );
        Self { text, blocks: Vec::new() }
    }

    fn time(&mut self, time: f64) {
        let _ = write!(
            self.text,
            "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" \
             format=\"ascii\">{time:e}</DataArray>\n</FieldData>\n"
        );
    }

    fn array(&mut self, array: &Array) {
        let bytes = array.bytes();
        let _ = writeln!(
            self.text,
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>",
            array.kind(),
            array.name,
            array.components,
            self.blocks.len()
        );
        self.blocks.extend((bytes.len() as u64).to_le_bytes());
        self.blocks.extend(bytes);
    }

    fn finish(self, closing: &str) -> Vec<u8> {
        let mut bytes = self.text.into_bytes();
        bytes.extend(closing.as_bytes());
        bytes.extend(b"<AppendedData encoding=\"raw\">\n_");
        bytes.extend(self.blocks);
        bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
        bytes
    }
}

/// Points with data, `.vtp`; every point is a vertex, so that it shows without a filter.
#[must_use]
pub fn points(time: f64, position: Vec<f64>, data: &[Array]) -> Vec<u8> {
    let count = position.len() / 3;
    let mut writer = Writer::new("PolyData");
    writer.text += "<PolyData>\n";
    writer.time(time);
    let _ = writeln!(
        writer.text,
        "<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n<PointData>"
    );
    data.iter().for_each(|array| writer.array(array));
    writer.text += "</PointData>\n<Points>\n";
    writer.array(&Array::real("position", 3, position));
    writer.text += "</Points>\n<Verts>\n";
    writer.array(&Array::whole("connectivity", (0..count as i64).collect()));
    writer.array(&Array::whole("offsets", (1..=count as i64).collect()));
    writer.text += "</Verts>\n";
    writer.finish("</Piece>\n</PolyData>\n")
}

/// Cell data on a uniform grid, `.vti`; x fastest.
#[must_use]
pub fn image(time: f64, origin: [f64; 3], spacing: [f64; 3], cells: [usize; 3], data: &[Array]) -> Vec<u8> {
    let extent = format!("0 {} 0 {} 0 {}", cells[0], cells[1], cells[2]);
    let list = |v: [f64; 3]| format!("{:e} {:e} {:e}", v[0], v[1], v[2]);
    let mut writer = Writer::new("ImageData");
    let _ = writeln!(
        writer.text,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">",
        list(origin),
        list(spacing)
    );
    writer.time(time);
    let _ = writeln!(writer.text, "<Piece Extent=\"{extent}\">\n<CellData>");
    data.iter().for_each(|array| writer.array(array));
    writer.text += "</CellData>\n";
    writer.finish("</Piece>\n</ImageData>\n")
}

/// Adds `file` (a name in the folder of the list) at `time` to a `.pvd`, in order of time; a file
/// already listed is moved to the new time.
///
/// # Errors
/// [`OutputError::File`].
pub fn list(path: &Path, time: f64, file: &str) -> Result<(), OutputError> {
    let old = std::fs::read_to_string(path).unwrap_or_default();
    let attribute = |line: &str, name: &str| {
        let rest = line.split_once(&format!("{name}=\""))?.1;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let mut entries: Vec<(f64, String)> = old
        .lines()
        .filter_map(|line| Some((attribute(line, "timestep")?.parse().ok()?, attribute(line, "file")?)))
        .filter(|(_, name)| name != file)
        .collect();
    entries.push((time, file.to_owned()));
    entries.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, name) in entries {
        let _ = writeln!(text, "<DataSet timestep=\"{time:e}\" group=\"\" part=\"0\" file=\"{name}\"/>");
    }
    text += "</Collection>\n</VTKFile>\n";
    atomic_write(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_point_at_the_blocks() {
        let bytes = points(0.5, vec![1.0, 2.0, 3.0], &[Array::scalar("radius", vec![0.25])]);
        let text = String::from_utf8_lossy(&bytes);
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let start = bytes.windows(mark.len()).position(|window| window == mark).unwrap() + mark.len();
        let real = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        assert!(text.contains("Name=\"radius\" NumberOfComponents=\"1\" format=\"appended\" offset=\"0\""));
        assert_eq!(u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap()), 8);
        assert_eq!(real(start + 8), 0.25);
        assert!(text.contains("offset=\"16\"") && real(start + 24) == 1.0 && real(start + 40) == 3.0);
    }

    #[test]
    fn the_list_is_in_order_of_time_and_names_each_file_once() {
        let path = std::env::temp_dir().join(format!("bedload-list-{}.pvd", std::process::id()));
        let _ = std::fs::remove_file(&path);
        for (time, name) in [(0.2, "b.vtp"), (0.1, "a.vtp"), (0.3, "b.vtp")] {
            list(&path, time, name).unwrap();
        }
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let (a, b) = (text.find("a.vtp").unwrap(), text.find("b.vtp").unwrap());
        assert!(a < b && text.matches("b.vtp").count() == 1 && text.contains("timestep=\"3e-1\""));
    }
}
