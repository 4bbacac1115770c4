//! Writes the files: a header in XML, then the arrays that it names, each with its length in front.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::OutputError;
use crate::file::replace;

use super::read::attribute;

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
    pub fn scalar(name: &'static str, values: Vec<f64>) -> Self {
        Self { name, components: 1, values: Values::Real(values) }
    }

    /// `components` floats per point.
    pub fn real(name: &'static str, components: usize, values: Vec<f64>) -> Self {
        Self { name, components, values: Values::Real(values) }
    }

    /// One whole number per point.
    pub fn whole(name: &'static str, values: Vec<i64>) -> Self {
        Self { name, components: 1, values: Values::Whole(values) }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self.values {
            Values::Real(_) => "Float64",
            Values::Whole(_) => "Int64",
        }
    }

    /// Bytes of the block: its length and the numbers.
    fn size(&self) -> usize {
        8 + 8 * match &self.values {
            Values::Real(values) => values.len(),
            Values::Whole(values) => values.len(),
        }
    }

    fn append(&self, bytes: &mut Vec<u8>) {
        bytes.extend((self.size() as u64 - 8).to_le_bytes());
        match &self.values {
            Values::Real(values) => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
            Values::Whole(values) => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
        }
    }
}

/// The first lines of a file.
pub(super) fn opening(kind: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n"
    )
}

/// Text of a file and the arrays whose blocks follow it.
struct Writer<'a> {
    text: String,
    arrays: Vec<&'a Array>,
    /// Bytes of their blocks.
    length: usize,
}

impl<'a> Writer<'a> {
    fn new(kind: &str) -> Self {
        Self { text: opening(kind), arrays: Vec::new(), length: 0 }
    }

    fn time(&mut self, time: f64) {
        let _ = write!(
            self.text,
            "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" \
             format=\"ascii\">{time:e}</DataArray>\n</FieldData>\n"
        );
    }

    fn array(&mut self, array: &'a Array) {
        let _ = writeln!(
            self.text,
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>",
            array.kind(),
            array.name,
            array.components,
            self.length
        );
        self.length += array.size();
        self.arrays.push(array);
    }

    /// The arrays between the tags of `section`.
    fn section(&mut self, section: &str, arrays: &'a [Array]) {
        let _ = writeln!(self.text, "<{section}>");
        arrays.iter().for_each(|array| self.array(array));
        let _ = writeln!(self.text, "</{section}>");
    }

    fn finish(mut self, closing: &str) -> Vec<u8> {
        let end = "\n</AppendedData>\n</VTKFile>\n";
        self.text += closing;
        self.text += "<AppendedData encoding=\"raw\">\n_";
        let mut bytes = self.text.into_bytes();
        bytes.reserve_exact(self.length + end.len());
        self.arrays.iter().for_each(|array| array.append(&mut bytes));
        bytes.extend(end.as_bytes());
        bytes
    }
}

/// Points with data, `.vtp`; every point is a vertex, so that it shows without a filter.
pub fn points(time: f64, position: Vec<f64>, data: &[Array]) -> Vec<u8> {
    let ends = (1..=position.len() as i64 / 3).collect();
    poly_data(time, position, ends, "Verts", data)
}

/// Polygons with data, `.vtp`: polygon k ends before the point number `ends[k]` and begins where the one
/// before ends.
pub fn polygons(time: f64, position: Vec<f64>, ends: Vec<i64>, data: &[Array]) -> Vec<u8> {
    poly_data(time, position, ends, "Polys", data)
}

/// Runs of points that make up cells of one kind.
fn poly_data(time: f64, position: Vec<f64>, ends: Vec<i64>, kind: &str, data: &[Array]) -> Vec<u8> {
    let (points, count) = (position.len() / 3, ends.len());
    let [vertices, polygons] = ["Verts", "Polys"].map(|known| if known == kind { count } else { 0 });
    let position = [Array::real("position", 3, position)];
    let cells = [Array::whole("connectivity", (0..points as i64).collect()), Array::whole("offsets", ends)];
    let mut writer = Writer::new("PolyData");
    writer.text += "<PolyData>\n";
    writer.time(time);
    let _ = writeln!(
        writer.text,
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"{polygons}\">"
    );
    writer.section(if kind == "Verts" { "PointData" } else { "CellData" }, data);
    writer.section("Points", &position);
    writer.section(kind, &cells);
    writer.finish("</Piece>\n</PolyData>\n")
}

/// Cell data on a uniform grid, `.vti`; x fastest.
pub fn image(time: f64, origin: [f64; 3], spacing: [f64; 3], cells: [usize; 3], data: &[Array]) -> Vec<u8> {
    let [nx, ny, nz] = cells;
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let list = |v: [f64; 3]| format!("{:e} {:e} {:e}", v[0], v[1], v[2]);
    let mut writer = Writer::new("ImageData");
    let _ = writeln!(
        writer.text,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">",
        list(origin),
        list(spacing)
    );
    writer.time(time);
    let _ = writeln!(writer.text, "<Piece Extent=\"{extent}\">");
    writer.section("CellData", data);
    writer.finish("</Piece>\n</ImageData>\n")
}

/// Cell data on the part of a rectilinear grid with these faces along x, y and z (m; one number along an axis
/// that the grid has not) that begins at layer `first` of cells along z, see [`super::parts()`], `.vtr`; x
/// fastest.
pub fn rectilinear_part(time: f64, faces: &[Vec<f64>; 3], first: usize, data: &[Array]) -> Vec<u8> {
    let [nx, ny, nz] = faces.each_ref().map(|faces| faces.len() - 1);
    let extent = format!("0 {nx} 0 {ny} {first} {}", first + nz);
    let [x, y, z] = faces.each_ref().map(Clone::clone);
    let faces = [Array::scalar("x", x), Array::scalar("y", y), Array::scalar("z", z)];
    let mut writer = Writer::new("RectilinearGrid");
    let _ = writeln!(writer.text, "<RectilinearGrid WholeExtent=\"{extent}\">");
    writer.time(time);
    let _ = writeln!(writer.text, "<Piece Extent=\"{extent}\">");
    writer.section("CellData", data);
    writer.section("Coordinates", &faces);
    writer.finish("</Piece>\n</RectilinearGrid>\n")
}

/// Adds `file` (a name in the folder of the list) at `time` to a `.pvd`, in order of time; a file
/// already listed is moved to the new time.
///
/// # Errors
/// [`OutputError::File`].
pub fn list(path: &Path, time: f64, file: &str) -> Result<(), OutputError> {
    let old = std::fs::read_to_string(path).unwrap_or_default();
    let entry =
        |line: &str| Some((attribute(line, "timestep")?.parse().ok()?, attribute(line, "file")?.to_owned()));
    let others = old.lines().filter_map(entry).filter(|(_, name)| name != file);
    let mut entries: Vec<(f64, String)> = others.collect();
    entries.push((time, file.to_owned()));
    entries.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <Collection>\n",
    );
    for (time, name) in entries {
        let _ = writeln!(text, "<DataSet timestep=\"{time:e}\" group=\"\" part=\"0\" file=\"{name}\"/>");
    }
    text += "</Collection>\n</VTKFile>\n";
    replace(path, text.as_bytes())
}
