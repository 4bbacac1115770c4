//! Keys and values of scenes that have another name now.
//!
//! Each owner of a section keeps one table of its own names, and refuses them before it reads the
//! section: [`SceneSource::refuse_retired`]. There are no aliases.

use crate::error::SceneError;
use crate::source::{Place, SceneSource, places};

/// A key, or one value of a key, under the name that it had before.
#[derive(Clone, Copy, Debug)]
pub struct Retired {
    /// Dotted key; `[]` after an array stands for each of its items: `grains[].density`.
    pub key: &'static str,
    /// The string value that is retired; without one the key is.
    pub value: Option<&'static str>,
    /// What to write now: the new key, or the new value; of what has no successor, what to do.
    pub now: &'static str,
    /// Whether it has no successor.
    pub dropped: bool,
}

impl Retired {
    /// A retired key, and what to write now.
    pub const fn key(key: &'static str, now: &'static str) -> Self {
        Self { key, value: None, now, dropped: false }
    }

    /// A retired key without a successor, and what to do about it.
    pub const fn dropped(key: &'static str, remedy: &'static str) -> Self {
        Self { key, value: None, now: remedy, dropped: true }
    }

    /// A retired value of a key that stays, and what to write now.
    pub const fn value(key: &'static str, value: &'static str, now: &'static str) -> Self {
        Self { key, value: Some(value), now, dropped: false }
    }
}

impl SceneSource {
    /// Refuses keys and values that have another name now.
    ///
    /// # Errors
    /// At the first retired name that stands in the text, with the new one; if the text is not TOML.
    pub fn refuse_retired(&self, retired: &[Retired]) -> Result<(), SceneError> {
        let tree = self.tree()?;
        let all = places(tree.get_ref());
        for Retired { key, value, now, dropped } in retired {
            let is_it = |place: &&Place<'_>| {
                without_numbers(&place.key) == *key
                    && value.is_none_or(|value| place.value.as_str() == Some(value))
            };
            let Some(Place { key: found, .. }) = all.iter().find(is_it) else { continue };
            if *dropped {
                return Err(self.error(found, "is retired: there is no such choice any more", now));
            }
            let message = match value {
                Some(value) => format!("\"{value}\" is retired; its name is now {now}"),
                None => format!("is retired; its name is now {now}"),
            };
            return Err(self.error(found, message, &format!("write {now}; docs/scene.md lists every key")));
        }
        Ok(())
    }
}

/// `walls[]` of `walls[2]`.
fn without_numbers(key: &str) -> String {
    let parts = key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest));
    parts.collect::<Vec<_>>().join("[]")
}
