//! Files that a scene names: looked up from the scene's folder, wherever the command runs.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

use toml_edit::{DocumentMut, Item, TableLike, Value};

use crate::source::SceneSource;

/// Keys that name a file or a folder; `[]` stands for each entry of a list.
const FILES: [&str; 23] = [
    "grain_files[].file",
    "metrics[].file",
    "dem.initial_state",
    "medium.initial.folder",
    "gravity.file",
    "medium.body_force.file",
    "medium.pressure_gradient.file",
    "medium.flow_rate.mean_velocity.file",
    "grains[].velocity.file",
    "grains[].spin.file",
    "walls[].velocity.file",
    "walls[].spin.file",
    "walls[].servo.pressure.file",
    "domain.boundary.x.velocity.file",
    "domain.boundary.x_lower.velocity.file",
    "domain.boundary.x_upper.velocity.file",
    "domain.boundary.y.velocity.file",
    "domain.boundary.y_lower.velocity.file",
    "domain.boundary.y_upper.velocity.file",
    "domain.boundary.z.velocity.file",
    "domain.boundary.z_lower.velocity.file",
    "domain.boundary.z_upper.velocity.file",
    "domain.boundary.r_upper.velocity.file",
];

/// Keys that hold a command: its program if it is a path, and every word that is a file there.
const COMMANDS: [&str; 2] = ["fluid.command", "dem.command"];

impl SceneSource {
    /// Folder of the scene, from which the files that it names are looked up.
    pub fn folder(&self) -> &Path {
        Path::new(&self.file).parent().unwrap_or(Path::new(""))
    }

    /// The text with every file by its whole path, so that it says the same in any folder.
    pub fn text_for_any_folder(&self) -> Cow<'_, str> {
        let Ok(mut document) = self.text.parse::<DocumentMut>() else { return Cow::Borrowed(&self.text) };
        let mut changed = false;
        for key in FILES {
            at(document.as_item_mut(), key, &mut |value| {
                changed |= value.as_str().map(|name| self.whole(name)).is_some_and(|path| set(value, &path));
            });
        }
        for key in COMMANDS {
            at(document.as_item_mut(), key, &mut |command| {
                let words = command.as_array_mut().into_iter().flat_map(toml_edit::Array::iter_mut);
                for (place, word) in words.enumerate() {
                    let path = word.as_str().and_then(|text| self.word(place, text));
                    changed |= path.is_some_and(|path| set(word, &path));
                }
            });
        }
        if changed { Cow::Owned(document.to_string()) } else { Cow::Borrowed(&self.text) }
    }

    /// Whole paths of the files and folders that the scene names, with their keys.
    pub fn files(&self) -> Vec<(&'static str, PathBuf)> {
        let Ok(mut document) = self.text.parse::<DocumentMut>() else { return Vec::new() };
        let mut files = Vec::new();
        for key in FILES {
            at(document.as_item_mut(), key, &mut |value| {
                files.extend(value.as_str().map(|name| (key, self.whole(name))));
            });
        }
        files
    }

    /// The text with every file by its name alone: where it stands says nothing about a run.
    pub(crate) fn text_without_folders(&self) -> String {
        let Ok(mut document) = self.text.parse::<DocumentMut>() else { return self.text.clone() };
        for key in FILES {
            at(document.as_item_mut(), key, &mut |value| {
                let name = value.as_str().and_then(|text| Path::new(text).file_name()).map(PathBuf::from);
                if let Some(name) = name {
                    set(value, &name);
                }
            });
        }
        document.to_string()
    }

    /// Whole path of a file that the scene names.
    fn whole(&self, name: &str) -> PathBuf {
        let folder = Path::new(".").join(self.folder());
        // A folder that is not there is named as it would be.
        let mut path = folder.canonicalize().or_else(|_| std::path::absolute(&folder)).unwrap_or(folder);
        for part in Path::new(name).components() {
            match part {
                Component::ParentDir => drop(path.pop()),
                part => path.push(part),
            }
        }
        path
    }

    /// Whole path of a word of a command, where it is one.
    fn word(&self, place: usize, text: &str) -> Option<PathBuf> {
        let path = self.whole(text);
        let is_path = if place == 0 { text.contains('/') } else { !text.is_empty() && path.is_file() };
        is_path.then_some(path)
    }
}

/// Replaces a name by its whole path; says whether that is another one.
fn set(value: &mut Value, path: &Path) -> bool {
    let text = path.to_string_lossy();
    let other = value.as_str() != Some(&text);
    if other {
        let decor = value.decor().clone();
        *value = Value::from(text.into_owned());
        *value.decor_mut() = decor;
    }
    other
}

/// Visits the values at a key.
fn at(item: &mut Item, key: &str, visit: &mut dyn FnMut(&mut Value)) {
    if let Some(table) = item.as_table_like_mut() {
        within(table, key, visit);
    }
}

/// The same in a table.
fn within(table: &mut dyn TableLike, key: &str, visit: &mut dyn FnMut(&mut Value)) {
    let (part, rest) = key.split_once('.').unwrap_or((key, ""));
    let (name, list) = part.strip_suffix("[]").map_or((part, false), |name| (name, true));
    let Some(found) = table.get_mut(name) else { return };
    if !list {
        match found.as_value_mut().filter(|_| rest.is_empty()) {
            Some(value) => visit(value),
            None => at(found, rest, visit),
        }
    } else if let Some(tables) = found.as_array_of_tables_mut() {
        tables.iter_mut().for_each(|table| within(table, rest, visit));
    } else if let Some(array) = found.as_array_mut() {
        let tables = array.iter_mut().filter_map(Value::as_inline_table_mut);
        tables.for_each(|table| within(table, rest, visit));
    }
}
