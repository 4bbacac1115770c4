//! What stands at the beginning of a log, so that the log alone is enough for a replay.

use std::collections::BTreeMap;

use super::error::LogError;
use crate::message::{PROTOCOL_VERSION, layout_hash};
use crate::participant::Role;

/// Name of the metadata record.
pub(crate) const METADATA: &str = "bedload";
/// Name of the attachment with the scene.
pub(crate) const SCENE: &str = "scene.toml";

/// The facts of a run that its messages do not carry.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Version of the Bedload that wrote it.
    pub version: String,
    /// Its [`PROTOCOL_VERSION`].
    pub protocol: u64,
    /// Its [`layout_hash`].
    pub layout: u64,
    /// Title of the scene.
    pub title: String,
    /// Command of the fluid solver, empty if the scene has none (then no loads are logged).
    pub fluid_command: Vec<String>,
    /// Command of the DEM, empty if the scene has none (then no kinematics are logged).
    pub dem_command: Vec<String>,
    /// Planned window, s.
    pub dt: f64,
    /// Planned end, s; infinite if open.
    pub until: f64,
    /// First window in this log: 0, or that of the checkpoint a run was resumed from.
    pub first_step: u64,
    /// Its start, s.
    pub first_time: f64,
    /// Radius of every grain, m (for viewers); its length is the number of grains.
    pub radii: Vec<f64>,
    /// The resolved scene, TOML.
    pub scene: String,
}

impl Manifest {
    /// A manifest of this build for a run from the start with both solvers.
    pub fn new(title: &str, scene: &str, radii: Vec<f64>, dt: f64, until: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            protocol: PROTOCOL_VERSION,
            layout: layout_hash(),
            title: title.to_owned(),
            fluid_command: vec!["bedload-fluid".to_owned()],
            dem_command: vec!["bedload-dem".to_owned()],
            dt,
            until,
            first_step: 0,
            first_time: 0.0,
            radii,
            scene: scene.to_owned(),
        }
    }

    /// Number of grains in every message.
    pub fn grains(&self) -> usize {
        self.radii.len()
    }

    /// Whether a solver of that role takes part.
    pub fn has(&self, role: Role) -> bool {
        match role {
            Role::Fluid => !self.fluid_command.is_empty(),
            Role::Dem => !self.dem_command.is_empty(),
        }
    }

    /// Refuses a log whose messages this build would misread.
    pub(crate) fn check_layout(&self, file: &str) -> Result<(), LogError> {
        if self.layout == layout_hash() && self.protocol == PROTOCOL_VERSION {
            return Ok(());
        }
        Err(LogError::Layout {
            file: file.to_owned(),
            version: self.version.clone(),
            theirs_version: self.protocol,
            theirs: self.layout,
            ours: layout_hash(),
        })
    }

    /// As the metadata record of an MCAP file: text by key. Numbers are written so that they come
    /// back to the bit.
    pub(crate) fn to_metadata(&self) -> BTreeMap<String, String> {
        let words = |command: &[String]| serde_json::json!(command).to_string();
        [
            ("version", self.version.clone()),
            ("protocol", self.protocol.to_string()),
            ("layout", format!("{:016x}", self.layout)),
            ("title", self.title.clone()),
            ("fluid_command", words(&self.fluid_command)),
            ("dem_command", words(&self.dem_command)),
            ("dt", self.dt.to_string()),
            ("until", self.until.to_string()),
            ("first_step", self.first_step.to_string()),
            ("first_time", self.first_time.to_string()),
            ("grains", self.grains().to_string()),
            ("radii", run_lengths(&self.radii)),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into()
    }

    /// From the metadata record and the scene's attachment.
    pub(crate) fn from_metadata(map: &BTreeMap<String, String>, scene: &str) -> Result<Self, String> {
        Ok(Self {
            version: text(map, "version")?.to_owned(),
            protocol: number(map, "protocol")?,
            layout: u64::from_str_radix(text(map, "layout")?, 16).map_err(|e| e.to_string())?,
            title: text(map, "title")?.to_owned(),
            fluid_command: command(map, "fluid_command")?,
            dem_command: command(map, "dem_command")?,
            dt: number(map, "dt")?,
            until: number(map, "until")?,
            first_step: number(map, "first_step")?,
            first_time: number(map, "first_time")?,
            radii: expand(text(map, "radii")?, number(map, "grains")?)?,
            scene: scene.to_owned(),
        })
    }
}

fn text<'a>(map: &'a BTreeMap<String, String>, key: &str) -> Result<&'a str, String> {
    map.get(key).map(String::as_str).ok_or_else(|| format!("its manifest has no `{key}`"))
}

fn number<T: std::str::FromStr>(map: &BTreeMap<String, String>, key: &str) -> Result<T, String> {
    let value = text(map, key)?;
    value.parse().map_err(|_| format!("`{key}` of its manifest is `{value}`, not a number"))
}

fn command(map: &BTreeMap<String, String>, key: &str) -> Result<Vec<String>, String> {
    serde_json::from_str(text(map, key)?)
        .map_err(|error| format!("`{key}` of its manifest is no list of words: {error}"))
}

/// Radii as `value*count` words: most packings have a few sizes.
fn run_lengths(radii: &[f64]) -> String {
    let runs = radii.chunk_by(|a, b| a.to_bits() == b.to_bits());
    runs.map(|run| format!("{}*{}", run[0], run.len())).collect::<Vec<_>>().join(" ")
}

/// Inverse of [`run_lengths`]; `grains` bounds what a hostile count can ask for.
fn expand(text: &str, grains: usize) -> Result<Vec<f64>, String> {
    let bad = || format!("`radii` of its manifest do not describe {grains} grains");
    let mut radii = Vec::new();
    for word in text.split_ascii_whitespace() {
        let (value, count) = word.split_once('*').ok_or_else(bad)?;
        let value: f64 = value.parse().map_err(|_| bad())?;
        let count: usize = count.parse().map_err(|_| bad())?;
        // A payload cannot hold more grains than its limit.
        if count > grains.min(super::codec::LIMIT / 64).saturating_sub(radii.len()) {
            return Err(bad());
        }
        radii.resize(radii.len() + count, value);
    }
    if radii.len() == grains { Ok(radii) } else { Err(bad()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifest_comes_back_to_the_bit() {
        let mut manifest = Manifest::new("title", "a = 1\n", vec![0.1, 0.1, 1.0 / 3.0], 1e-3, 2.0);
        manifest.until = f64::INFINITY;
        manifest.first_time = 0.1 + 0.2;
        manifest.dem_command = vec!["my dem".into(), "--x=\"y\"".into()];
        manifest.fluid_command.clear();
        let back = Manifest::from_metadata(&manifest.to_metadata(), "a = 1\n").unwrap();
        assert_eq!(back, manifest);
        assert!(back.has(Role::Dem) && !back.has(Role::Fluid));
    }

    #[test]
    fn hostile_radii_are_refused() {
        assert!(expand("1*18446744073709551615", usize::MAX).is_err());
        assert!(expand("1*99999999999", 3).is_err());
        assert!(expand("1*2", 3).is_err());
        assert!(expand("1", 1).is_err());
        assert_eq!(expand("1*2 2*1", 3).unwrap(), [1.0, 1.0, 2.0]);
    }
}
