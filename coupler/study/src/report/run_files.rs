//! What a report reads of a run, and the scales in which its pictures are drawn.

use std::path::{Path, PathBuf};

use bedload_output::planes::Planes;
use bedload_output::{Series, Summary, refuse_changed_files};
use bedload_scene::{CheckedScene, SceneSource};
use serde_json::Value;

use crate::folder::files;
use crate::pictures::{Instant, instants};
use coupler::failure::Failure;
use coupler::number::AXES;

/// A log above this is not read through for the page; `bedload log info` does that.
const MOST_LOG_BYTES: u64 = 256 << 20;

/// Name of the column of a quantity of a grain along an axis.
pub(super) fn column(quantity: &str, axis: usize, grain: usize) -> String {
    format!("{quantity}_{}[{grain}]", AXES[axis])
}

/// The files of one run. Only the summary must be there.
pub(super) struct RunFiles {
    pub(super) name: String,
    pub(super) summary: Summary,
    /// None: there is none, or it cannot be read here any more.
    pub(super) scene: Option<CheckedScene>,
    pub(super) series: Series,
    pub(super) planes: Option<Planes>,
    /// `plan.json` as it is: of whatever version wrote it.
    pub(super) plan: Option<Value>,
    /// Files of fields and grains in order of time.
    pub(super) instants: Vec<Instant>,
    /// Files of the grains in order of time, of a DEM that wrote them.
    pub(super) grain_files: Vec<PathBuf>,
    /// What `bedload log info` says.
    pub(super) log: Option<String>,
    /// What could not be read, and why.
    pub(super) remarks: Vec<String>,
    pub(super) scales: Scales,
}

/// Units of the pictures: those of Izard et al. 2014 (D, √(D/g), √(gD), submerged weight) where the scene has
/// a grain and gravity, else SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scales {
    /// Are they those of Izard et al. (2014)?
    pub(super) by_gravity: bool,
    /// D, or 1 m.
    pub(super) length: f64,
    /// √(D/g), or 1 s.
    pub(super) time: f64,
    /// Submerged weight, or 1 N.
    pub(super) force: f64,
}

impl Scales {
    const SI: Self = Self { by_gravity: false, length: 1.0, time: 1.0, force: 1.0 };

    /// Of the scene's grain `grain`.
    fn of(scene: &CheckedScene, grain: usize) -> Self {
        let gravity = scene.scene.largest_gravity();
        let Some(grain) = scene.grains.get(grain).filter(|_| gravity > 0.0) else { return Self::SI };
        let length = 2.0 * grain.radius;
        let density = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
        let weight = (grain.density - density).abs() * grain.volume() * gravity;
        let force = if weight > 0.0 { weight } else { grain.mass() * gravity };
        Self { by_gravity: true, length, time: (length / gravity).sqrt(), force }
    }

    /// √(gD), or 1 m/s.
    pub(super) fn speed(&self) -> f64 {
        self.length / self.time
    }
}

impl RunFiles {
    /// Reads what there is in `dir`.
    pub(super) fn read(dir: &Path) -> Result<Self, Failure> {
        let summary = Summary::read(&dir.join("summary.json"))?;
        let mut remarks = Vec::new();
        let mut keep = |what: &str, why: &dyn std::fmt::Display| remarks.push(format!("{what}: {why}"));
        let scene = SceneSource::read(&dir.join("scene.toml"), &[]).and_then(|source| {
            let scene = CheckedScene::new(source)?;
            refuse_changed_files(&scene, &scene.source.text)?;
            Ok(scene)
        });
        let scene = scene.inspect_err(|error| keep("The scene is not shown", error)).ok();
        let series = Series::read(&dir.join("series.csv"));
        let series = series.inspect_err(|error| keep("There are no curves", error)).unwrap_or_default();
        let planes = std::fs::read_to_string(dir.join("planes.csv")).ok();
        let planes = planes.map(|text| Planes::parse(&text));
        let planes =
            planes.and_then(|read| read.inspect_err(|what| keep("There are no profiles", what)).ok());
        let plan = std::fs::read_to_string(dir.join("plan.json")).ok();
        let plan = plan.and_then(|text| serde_json::from_str(&text).ok());
        let grain = observed(&series).first().copied().unwrap_or(0);
        let scales = scene.as_ref().map_or(Scales::SI, |scene| Scales::of(scene, grain));
        let name = std::fs::canonicalize(dir).unwrap_or_else(|_| dir.to_owned());
        let name = name.file_name().unwrap_or(dir.as_os_str()).to_string_lossy().into_owned();
        let (instants, log) = (instants(&dir.join("fields")), log_info(&dir.join("exchange.mcap")));
        let grain_files = files(&dir.join("fields"), "grains_", ".vtp");
        Ok(Self { name, summary, scene, series, planes, plan, instants, grain_files, log, remarks, scales })
    }

    /// Title of the page: the scene's, or the folder's name.
    pub(super) fn title(&self) -> &str {
        let title = self.scene.as_ref().map_or("", |scene| scene.scene.title.as_str());
        if title.is_empty() { &self.name } else { title }
    }

    /// Grains with columns in the series.
    pub(super) fn grains(&self) -> Vec<usize> {
        observed(&self.series)
    }

    /// A column over a scale.
    pub(super) fn scaled(&self, name: &str, scale: f64) -> Option<Vec<f64>> {
        Some(self.series.column(name)?.iter().map(|value| value / scale).collect())
    }

    /// Time of the first contact of `grain` in the series, s: a contact force, or a gap ≤ 0.
    pub(super) fn first_contact(&self, grain: usize) -> Option<f64> {
        let force = |axis| self.series.column(&column("contact_force", axis, grain));
        let forces: Vec<&[f64]> = (0..3).filter_map(force).collect();
        let gap = self.series.column(&format!("gap[{grain}]"));
        let touches = |row: usize| {
            forces.iter().any(|force| force[row] != 0.0 && force[row].is_finite())
                || gap.is_some_and(|gap| gap[row] <= 0.0)
        };
        (0..self.series.len()).find(|row| touches(*row)).map(|row| self.series.time()[row])
    }
}

/// Numbers of the grains that the series has columns of, in order of appearance.
fn observed(series: &Series) -> Vec<usize> {
    let mut grains = Vec::new();
    for name in series.names() {
        let number = name.strip_suffix(']').and_then(|name| name.rsplit_once('[')).map(|(_, number)| number);
        if let Some(grain) = number.and_then(|number| number.parse().ok())
            && !grains.contains(&grain)
        {
            grains.push(grain);
        }
    }
    grains
}

fn log_info(path: &Path) -> Option<String> {
    let bytes = std::fs::metadata(path).ok()?.len();
    if bytes > MOST_LOG_BYTES {
        return Some(format!("{} MiB; `bedload log info` reads it", bytes >> 20));
    }
    let mut text = Vec::new();
    match coupler::log_command::info(path, &mut text) {
        // The first line is the path, which is nobody else's business.
        Err(error) if text.is_empty() => Some(error.to_string()),
        _ => Some(String::from_utf8_lossy(&text).lines().skip(1).collect::<Vec<_>>().join("\n")),
    }
}
