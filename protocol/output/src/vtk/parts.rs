//! Rectilinear grids whose layers along z lie in several files (`.pvtr`): the list of them, and one grid of
//! all.

use std::fmt::Write as _;
use std::path::Path;

use super::grid::Vtr;
use super::read::attribute;
use super::write::{Array, opening};

/// One of the files of a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name, in the folder of the list.
    pub file: String,
    /// Its first layer of cells along z, and the one after its last.
    pub layers: [usize; 2],
}

/// The list of the files of a grid with so many cells along x and y, `.pvtr`; `data` are the arrays of any of
/// them.
///
/// ```
/// use bedload_output::vtk::{Array, Part, parts, read, rectilinear_part};
///
/// let folder = std::env::temp_dir().join(format!("bedload-parts-{}", std::process::id()));
/// std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
/// let mut list = Vec::new();
/// for k in 0..2 {
///     let layers = [k, k + 1];
///     let faces = [vec![0.0, 1.0], vec![0.0, 1.0], vec![k as f64, k as f64 + 1.0]];
///     let data = [Array::scalar("solid", vec![k as f64])];
///     let file = format!("{k}.vtr");
///     std::fs::write(folder.join(&file), rectilinear_part(0.5, &faces, k, &data)).map_err(|e| e.to_string())?;
///     list.push(Part { file, layers });
/// }
/// let text = parts([1, 1], &[Array::scalar("solid", Vec::new())], &list);
/// std::fs::write(folder.join("all.pvtr"), text).map_err(|error| error.to_string())?;
/// let whole = read(&folder.join("all.pvtr"))?;
/// std::fs::remove_dir_all(&folder).map_err(|error| error.to_string())?;
/// assert_eq!((whole.counts(), whole.faces[2].len()), ([1, 1, 2], 3));
/// assert_eq!(whole.arrays["solid"].1, [0.0, 1.0]);
/// # Ok::<(), String>(())
/// ```
pub fn parts([nx, ny]: [usize; 2], data: &[Array], parts: &[Part]) -> String {
    let nz = parts.last().map_or(0, |part| part.layers[1]);
    let mut text = opening("PRectilinearGrid");
    let _ = write!(
        text,
        "<PRectilinearGrid WholeExtent=\"0 {nx} 0 {ny} 0 {nz}\" GhostLevel=\"0\">\n<PCellData>\n"
    );
    for array in data {
        let (kind, name, count) = (array.kind(), array.name, array.components);
        let _ =
            writeln!(text, "<PDataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{count}\"/>");
    }
    text += "</PCellData>\n<PCoordinates>\n";
    for name in ["x", "y", "z"] {
        let _ = writeln!(text, "<PDataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"1\"/>");
    }
    text += "</PCoordinates>\n";
    for Part { file, layers: [from, to] } in parts {
        let _ = writeln!(text, "<Piece Extent=\"0 {nx} 0 {ny} {from} {to}\" Source=\"{file}\"/>");
    }
    text += "</PRectilinearGrid>\n</VTKFile>\n";
    text
}

/// The files that a list names.
fn sources(text: &str) -> Result<Vec<&str>, String> {
    if !text.contains("type=\"PRectilinearGrid\"") {
        return Err("its header lacks type=\"PRectilinearGrid\"".into());
    }
    let pieces = text.split("<Piece ").skip(1).filter_map(|rest| rest.split('>').next());
    let source = |tag| attribute(tag, "Source").ok_or_else(|| "a piece of it has no source".to_owned());
    pieces.map(source).collect()
}

/// Reads a grid from its file (`.vtr`), or from all files of a list (`.pvtr`).
///
/// # Errors
/// What is wrong with which file.
pub fn read(path: &Path) -> Result<Vtr, String> {
    if path.extension().is_none_or(|end| end != "pvtr") {
        return Vtr::read(path);
    }
    let place = |why: String| format!("{}: {why}", path.display());
    let text =
        protocol::input_file::read_text(path).map_err(|error| place(format!("cannot read: {error}")))?;
    listed(path, &text).map_err(place)
}

/// The files of the list at `path`, whose text this is, as one grid.
fn listed(path: &Path, text: &str) -> Result<Vtr, String> {
    let mut whole: Option<Vtr> = None;
    for source in sources(text)? {
        let part = Vtr::read(&path.with_file_name(source))?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => append(whole, part).map_err(|why| format!("{source}: {why}"))?,
        }
    }
    whole.ok_or_else(|| "it names no files".into())
}

/// Adds the layers that follow.
fn append(whole: &mut Vtr, part: Vtr) -> Result<(), String> {
    let [x, y, z] = &mut whole.faces;
    let [part_x, part_y, part_z] = part.faces;
    if *x != part_x || *y != part_y || z.last() != part_z.first() || whole.time != part.time {
        return Err("does not go on where the file before it ends".into());
    }
    z.extend(&part_z[1..]);
    if !whole.arrays.keys().eq(part.arrays.keys()) {
        return Err("holds other arrays than the file before it".into());
    }
    for (name, (components, values)) in part.arrays {
        let same = whole.arrays.get_mut(&name).filter(|(own, _)| *own == components);
        let (_, all) = same.ok_or_else(|| format!("array {name} has not {components} components before"))?;
        all.extend(values);
    }
    Ok(())
}
