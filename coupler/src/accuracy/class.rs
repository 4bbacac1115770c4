//! Classes of scenes that have a chart.

use protocol::scene::{CheckedScene, Grain, MetricKind, Motion, SceneSource, Shape};

use super::pick::Row;
use crate::scheme::norm;
use crate::study::chart::Chart;
use crate::study::{Ladder, Point, parse_csv};

/// A class of scenes whose errors one chart tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Free spheres whose rebound is measured.
    Bounce,
    /// Free spheres in a fluid, at Ar of the order of the charted one.
    Settling,
    /// The same where viscosity rules: masks err more there, as held spheres in Stokes flow show.
    SlowSettling,
    /// Held spheres in a driven fluid at low Reynolds number.
    HeldSpheres,
    /// Grains without a fluid.
    Dry,
}

/// A chart: its scene, the settings of its runs, and what came out.
pub(super) struct Charted {
    pub(super) scene: CheckedScene,
    pub(super) points: Vec<Point>,
    pub(super) rows: Vec<Row>,
}

/// Ar = |ρ_p/ρ − 1| g D³/ν² below which the chart of the falling sphere (Ar = 800) says too little.
const SLOW: f64 = 200.0;

/// Free grains from which on they may be a bed, and the part of their bounding box that they fill then. Beds have no
/// class: what the chart of the inclined bed says of the fluid over a bed at rest does not hold for one that moves.
const BED: (usize, f64) = (20, 0.2);

/// Density ratio below which `auto` may choose repeated windows, at some ν dt/D² (docs/stability.md).
const MAY_REPEAT: f64 = 2.0;

/// Longest step taken from the chart of the falling sphere, in units of the class's own time. It charts the speed in the
/// end: with longer steps the start from rest is 3 % off where that is 1 %.
const LONGEST: f64 = 0.07;

/// Is a rebound measured?
fn bounces(scene: &CheckedScene) -> bool {
    scene.scene.metrics.iter().any(|metric| {
        matches!(
            metric.kind,
            MetricKind::ReboundVelocityRatio { .. }
                | MetricKind::RestitutionAtGap { .. }
                | MetricKind::ReboundHeight { .. }
                | MetricKind::SecondReboundHeight { .. }
                | MetricKind::ReboundRiseTime { .. }
                | MetricKind::ReboundDuration { .. }
        )
    })
}

/// Do its free grains lie close together?
fn is_bed(scene: &CheckedScene) -> bool {
    let free = || scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let edge = |side: f64, axis: usize| {
        free().map(|grain| side * grain.position[axis] + grain.radius).fold(f64::NEG_INFINITY, f64::max)
    };
    let extent: f64 = (0..3).map(|axis| edge(1.0, axis) + edge(-1.0, axis)).product();
    free().count() >= BED.0 && free().map(Grain::volume).sum::<f64>() > BED.1 * extent
}

/// What a run of a chart sets `key` to.
fn setting<'a>(point: &'a Point, key: &str) -> Option<&'a str> {
    point.set.iter().find_map(|text| text.strip_prefix(key)?.strip_prefix('='))
}

/// Is its mask thinner than the default?
fn is_thin(point: &Point) -> bool {
    setting(point, "fluid.immersed.width")
        .and_then(|text| text.parse().ok())
        .is_some_and(|width: f64| width < 0.5)
}

/// May the carried force go with the grains? It asks for yu-shao-fixed-point, and that no window is repeated.
fn may_go_along(scene: &CheckedScene) -> bool {
    let (fluid, coupling) = (&scene.scene.fluid, &scene.scene.coupling);
    let says = |section: &str, key: &str| fluid.get(section)?.get(key)?.as_str();
    let heavy = scene.scene.medium.as_ref().is_some_and(|medium| {
        let mut free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
        free.all(|grain| grain.density >= MAY_REPEAT * medium.density)
    });
    heavy
        && says("immersed", "method") != Some("direct")
        && says("loads", "form").is_none_or(|form| form == "yu-shao-fixed-point")
        && coupling.get("scheme").and_then(toml::Value::as_str) != Some("iterated")
}

/// Does its carried force go with the grains?
fn goes_along(point: &Point) -> bool {
    setting(point, "fluid.immersed.force_transport").is_some_and(|text| text.contains("advected"))
}

/// Its time step, s.
fn step(point: &Point) -> Option<f64> {
    setting(point, "fluid.time.dt")?.parse().ok()
}

/// Least Ar of the free grains; infinite without gravity.
fn archimedes(scene: &CheckedScene) -> f64 {
    let Some(medium) = &scene.scene.medium else { return f64::INFINITY };
    let gravity = norm(&scene.scene.gravity);
    let free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let of = |grain: &Grain| {
        let excess = (grain.density / medium.density - 1.0).abs();
        excess * gravity * (2.0 * grain.radius).powi(3) / medium.kinematic_viscosity().powi(2)
    };
    free.map(of).fold(f64::INFINITY, f64::min)
}

impl Class {
    pub(super) const ALL: [Self; 5] =
        [Self::Bounce, Self::Settling, Self::SlowSettling, Self::HeldSpheres, Self::Dry];

    /// The class of a scene, if it has one.
    pub(super) fn of(scene: &CheckedScene) -> Option<Self> {
        let spheres = !scene.grains.is_empty() && scene.grains.iter().all(|g| g.shape == Shape::Sphere);
        match &scene.scene.medium {
            None => Some(Self::Dry),
            Some(_) if spheres && scene.has_free_grains() => {
                if bounces(scene) {
                    Some(Self::Bounce)
                } else if is_bed(scene) {
                    None
                } else if archimedes(scene) < SLOW {
                    Some(Self::SlowSettling)
                } else {
                    Some(Self::Settling)
                }
            }
            Some(_) if spheres && scene.grains.iter().all(|g| g.motion == Motion::Fixed) => {
                Some(Self::HeldSpheres)
            }
            Some(_) => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bounce => "spheres whose rebound is measured",
            Self::Settling => "free spheres in a fluid, Ar from 200 on",
            Self::SlowSettling => "free spheres in a fluid, Ar below 200",
            Self::HeldSpheres => "held spheres in a driven fluid",
            Self::Dry => "grains without a fluid",
        }
    }

    /// File of its chart.
    pub(super) fn chart_file(self) -> &'static str {
        match self {
            Self::Bounce => "docs/charts/bouncing-sphere.csv",
            Self::Settling => "docs/charts/falling-sphere.csv",
            Self::HeldSpheres | Self::SlowSettling => "docs/charts/sphere-array.csv",
            Self::Dry => "docs/charts/oblique-collision.csv",
        }
    }

    /// The scene that was charted, and its chart.
    fn texts(self) -> (&'static str, &'static str) {
        match self {
            Self::Bounce => (
                include_str!("../../../scenes/bouncing-sphere.toml"),
                include_str!("../../../docs/charts/bouncing-sphere.csv"),
            ),
            Self::Settling => (
                include_str!("../../../scenes/falling-sphere.toml"),
                include_str!("../../../docs/charts/falling-sphere.csv"),
            ),
            Self::HeldSpheres | Self::SlowSettling => (
                include_str!("../../../scenes/drag/sphere-array.toml"),
                include_str!("../../../docs/charts/sphere-array.csv"),
            ),
            Self::Dry => (
                include_str!("../../../scenes/oblique-collision.toml"),
                include_str!("../../../docs/charts/oblique-collision.csv"),
            ),
        }
    }

    /// Its own time, s, in which time steps are carried over: of settling (D/|ρ_p/ρ − 1| g)^½, of
    /// viscosity D²/ν. None where steps follow contacts.
    pub(super) fn time(self, scene: &CheckedScene) -> Option<f64> {
        let medium = scene.scene.medium.as_ref()?;
        let gravity = norm(&scene.scene.gravity);
        let of = |grain: &Grain| {
            let diameter = 2.0 * grain.radius;
            let viscous = diameter * diameter / medium.kinematic_viscosity();
            let buoyant = (grain.density / medium.density - 1.0).abs() * gravity;
            match self {
                Self::HeldSpheres | Self::Dry => viscous,
                _ => (diameter / buoyant).sqrt().min(viscous),
            }
        };
        scene.grains.iter().map(of).reduce(f64::min).filter(|time| *time > 0.0 && time.is_finite())
    }

    /// Its chart, without the runs whose method is not for `asking`.
    pub(super) fn ladder(self, asking: &CheckedScene) -> Result<Charted, String> {
        let (scene, table) = self.texts();
        let at =
            |error: &dyn std::fmt::Display| format!("has an unusable chart, {}: {error}", self.chart_file());
        let source = SceneSource { file: self.chart_file().to_owned(), text: scene.to_owned() };
        let scene = CheckedScene::new(source).map_err(|error| at(&error))?;
        let chart = Chart::read(&scene).map_err(|error| at(&error))?;
        let ladder =
            Ladder::new(&scene, "chart", &chart.set, &chart.vary, &chart.runs).map_err(|error| at(&error))?;
        let (header, rows) = parse_csv(table).map_err(|error| at(&error))?;
        let mut rows = Row::all(&header, &rows).map_err(|error| at(&error))?;
        if !matches!(self, Self::HeldSpheres | Self::Dry) {
            let along = may_go_along(asking);
            let longest =
                if self == Self::Settling { self.time(&scene).map(|time| LONGEST * time) } else { None };
            let is_too_long =
                |point: &Point| step(point).zip(longest).is_some_and(|(dt, longest)| dt > longest);
            // A thinner mask is the most exact for a sphere that stands, but one that moves feels the grid with it.
            let is_not_for_it =
                |point: &Point| is_thin(point) || is_too_long(point) || (goes_along(point) && !along);
            let left_out = |row: &Row| {
                ladder.points.iter().any(|point| point.label == row.label && is_not_for_it(point))
            };
            rows.retain(|row| !left_out(row));
        }
        Ok(Charted { scene, points: ladder.points, rows })
    }
}
