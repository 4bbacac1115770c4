//! A change of a scene's text.

use bedload_program::RunOptions;
use bedload_scene::SceneSource;
use toml::{Table, Value};

use crate::prepare::Prepared;
use crate::scratch::scratch;

/// Keys to set and keys to leave out, dotted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Change {
    set: Vec<(&'static str, Value)>,
    remove: Vec<String>,
    overrides: Vec<String>,
}

impl Change {
    /// Also sets `key`.
    pub(super) fn set(mut self, key: &'static str, value: impl Into<Value>) -> Self {
        self.set.push((key, value.into()));
        self
    }

    /// Also leaves `key` out, if it is there.
    pub(crate) fn remove(mut self, key: impl Into<String>) -> Self {
        self.remove.push(key.into());
        self
    }

    /// Also sets what `KEY=VALUE` of `--set` would, in the end.
    pub(crate) fn overrides(mut self, overrides: Vec<String>) -> Self {
        self.overrides.extend(overrides);
        self
    }

    /// The changed text; nothing where a key runs through something that is no table.
    pub(super) fn of(&self, text: &str) -> Option<String> {
        let mut table: Table = text.parse().ok()?;
        for key in &self.remove {
            leave_out(&mut table, key);
        }
        for (key, value) in &self.set {
            let (parents, name) = split(key);
            let parent = parents.iter().try_fold(&mut table, |table, part| {
                table.entry(*part).or_insert_with(|| Table::new().into()).as_table_mut()
            })?;
            parent.insert(name.to_owned(), value.clone());
        }
        let source = SceneSource { file: String::new(), text: toml::to_string(&table).ok()? };
        Some(source.with_overrides(&self.overrides).ok()?.text)
    }

    /// The changed text and its plan; nothing where it is refused.
    pub(crate) fn prepared(&self, text: &str, options: &RunOptions) -> Option<(String, Prepared)> {
        let scene = self.of(text)?;
        let folder = scratch().ok()?;
        let file = folder.path().join("scene.toml");
        std::fs::write(&file, &scene).ok()?;
        let (threads, no_commands) = (options.threads, options.no_commands);
        let options = RunOptions { threads, no_commands, ..RunOptions::of_scene(&file) };
        Some((scene, Prepared::new(&options).ok()?))
    }
}

/// Removes a key, and a table that has no other; says whether it was there.
fn leave_out(table: &mut Table, key: &str) -> bool {
    let Some((first, rest)) = key.split_once('.') else { return table.remove(key).is_some() };
    let Some(inner) = table.get_mut(first).and_then(Value::as_table_mut) else { return false };
    let was_there = leave_out(inner, rest);
    if was_there && inner.is_empty() {
        table.remove(first);
    }
    was_there
}

/// `a.b.c` → (a, b), c.
fn split(key: &str) -> (Vec<&str>, &str) {
    let mut parts: Vec<&str> = key.split('.').collect();
    let name = parts.pop().unwrap_or(key);
    (parts, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_set_and_left_out_and_the_rest_stays() {
        let change = Change::default()
            .set("fluid.time.convection", false)
            .set("until", 2.0)
            .remove("domain.cells")
            .remove("not.there")
            .remove("dem.lubrication.form")
            .overrides(vec!["grains[0].density=3.0".to_owned()]);
        let text = "until = 1.0\n[domain]\ncells = [1, 2]\ngeometry = \"plane\"\n[[grains]]\n\
                    [dem.lubrication]\nform = 1\n";
        let text = change.of(text).unwrap();
        let table: Table = text.parse().unwrap();
        assert_eq!(table["until"].as_float(), Some(2.0));
        assert_eq!(table["fluid"]["time"]["convection"].as_bool(), Some(false));
        assert!(table["domain"].get("cells").is_none() && table.get("dem").is_none());
        assert_eq!(table["domain"]["geometry"].as_str(), Some("plane"));
        assert_eq!(table["grains"][0]["density"].as_float(), Some(3.0));
        assert!(Change::default().set("until.deep", 1.0).of("until = 1.0").is_none());
    }
}
