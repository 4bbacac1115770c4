//! A change of a scene's text.

use bedload_scene::SceneSource;
use toml::{Table, Value};

/// Keys to set and keys to leave out, dotted.
#[derive(Clone, Debug, Default)]
pub(super) struct Change {
    set: Vec<(&'static str, Value)>,
    remove: Vec<&'static str>,
    overrides: Vec<String>,
}

impl Change {
    /// Also sets `key`.
    pub(super) fn set(mut self, key: &'static str, value: impl Into<Value>) -> Self {
        self.set.push((key, value.into()));
        self
    }

    /// Also leaves `key` out, if it is there.
    pub(super) fn remove(mut self, key: &'static str) -> Self {
        self.remove.push(key);
        self
    }

    /// Also sets what `KEY=VALUE` of `--set` would, in the end.
    pub(super) fn overrides(mut self, overrides: Vec<String>) -> Self {
        self.overrides.extend(overrides);
        self
    }

    /// The changed text; nothing where a key runs through something that is no table.
    pub(super) fn of(&self, text: &str) -> Option<String> {
        let mut table: Table = text.parse().ok()?;
        for key in &self.remove {
            let (parents, name) = split(key);
            if let Some(parent) = parents.iter().try_fold(&mut table, |t, p| t.get_mut(*p)?.as_table_mut()) {
                parent.remove(name);
            }
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
}

/// `a.b.c` → (a, b), c.
fn split(key: &'static str) -> (Vec<&'static str>, &'static str) {
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
            .overrides(vec!["grains[0].density=3.0".to_owned()]);
        let text =
            change.of("until = 1.0\n[domain]\ncells = [1, 2]\ngeometry = \"plane\"\n[[grains]]\n").unwrap();
        let table: Table = text.parse().unwrap();
        assert_eq!(table["until"].as_float(), Some(2.0));
        assert_eq!(table["fluid"]["time"]["convection"].as_bool(), Some(false));
        assert!(table["domain"].get("cells").is_none());
        assert_eq!(table["domain"]["geometry"].as_str(), Some("plane"));
        assert_eq!(table["grains"][0]["density"].as_float(), Some(3.0));
        assert!(Change::default().set("until.deep", 1.0).of("until = 1.0").is_none());
    }
}
