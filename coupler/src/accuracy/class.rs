//! Classes of scenes that have a chart.

use protocol::facts::LoadsForm;
use protocol::scene::{CheckedScene, Grain, MetricKind, Motion, Shape};

use super::charted::{Charted, Run};
use crate::keys;
use crate::number::norm;

/// A class of scenes whose errors one chart tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Free spheres whose rebound is measured.
    Bounce,
    /// Free spheres in a fluid, at Ar of the order of the charted one.
    Settling,
    /// The same where viscosity rules: masks err more there, as fixed spheres in Stokes flow show.
    SlowSettling,
    /// Fixed spheres in a driven fluid at low Reynolds number.
    FixedSpheres,
    /// Grains without a fluid.
    Dry,
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

/// Is its mask thinner than the default?
fn is_thin(run: &Run) -> bool {
    run.setting(keys::WIDTH).and_then(|text| text.parse().ok()).is_some_and(|width: f64| width < 0.5)
}

/// May the carried force go with the grains? It asks for yu-shao-fixed-point, and that no window is repeated.
fn may_advect_force(scene: &CheckedScene) -> bool {
    let says = |key: &str| keys::look_up(scene, key)?.as_str();
    let follows = LoadsForm::YuShaoFixedPoint.to_string();
    let heavy = scene.scene.medium.as_ref().is_some_and(|medium| {
        let mut free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
        free.all(|grain| grain.density >= MAY_REPEAT * medium.density)
    });
    heavy
        && says(keys::METHOD) != Some(keys::DIRECT)
        && says(keys::LOADS).is_none_or(|form| form == follows)
        && scene.scene.coupling.get("scheme").and_then(toml::Value::as_str) != Some("iterated")
}

/// Does its carried force go with the grains?
fn advects_force(run: &Run) -> bool {
    run.setting(keys::TRANSPORT).is_some_and(|text| text.contains(keys::ADVECTED))
}

/// Its time step, s.
fn step(run: &Run) -> Option<f64> {
    run.setting(keys::FLUID_DT)?.parse().ok()
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
        [Self::Bounce, Self::Settling, Self::SlowSettling, Self::FixedSpheres, Self::Dry];

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
                Some(Self::FixedSpheres)
            }
            Some(_) => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bounce => "spheres whose rebound is measured",
            Self::Settling => "free spheres in a fluid, Ar from 200 on",
            Self::SlowSettling => "free spheres in a fluid, Ar below 200",
            Self::FixedSpheres => "fixed spheres in a driven fluid",
            Self::Dry => "grains without a fluid",
        }
    }

    /// File of its chart.
    pub(super) fn chart_file(self) -> &'static str {
        match self {
            Self::Bounce => "docs/charts/bouncing-sphere.csv",
            Self::Settling => "docs/charts/falling-sphere.csv",
            Self::FixedSpheres | Self::SlowSettling => "docs/charts/sphere-array.csv",
            Self::Dry => "docs/charts/oblique-collision.csv",
        }
    }

    /// Its chart, as data.
    pub(super) fn data(self) -> &'static str {
        match self {
            Self::Bounce => include_str!("data/bouncing-sphere.toml"),
            Self::Settling => include_str!("data/falling-sphere.toml"),
            Self::FixedSpheres | Self::SlowSettling => include_str!("data/sphere-array.toml"),
            Self::Dry => include_str!("data/oblique-collision.toml"),
        }
    }

    /// Its own time, s, in which time steps are transferred: of settling (D/|ρ_p/ρ − 1| g)^½, of
    /// viscosity D²/ν. None where steps follow contacts.
    pub(super) fn time(self, scene: &CheckedScene) -> Option<f64> {
        let medium = scene.scene.medium.as_ref()?;
        let gravity = norm(&scene.scene.gravity);
        let of = |grain: &Grain| {
            let diameter = 2.0 * grain.radius;
            let viscous = diameter * diameter / medium.kinematic_viscosity();
            let buoyant = (grain.density / medium.density - 1.0).abs() * gravity;
            match self {
                Self::FixedSpheres | Self::Dry => viscous,
                _ => (diameter / buoyant).sqrt().min(viscous),
            }
        };
        scene.grains.iter().map(of).reduce(f64::min).filter(|time| *time > 0.0 && time.is_finite())
    }

    /// Its chart, without the runs whose method is not for `asking`.
    pub(super) fn charted(self, asking: &CheckedScene) -> Result<Charted, String> {
        let at = |error| format!("has an unusable chart, {}: {error}", self.chart_file());
        let mut chart = Charted::parse(self.data()).map_err(at)?;
        if !matches!(self, Self::FixedSpheres | Self::Dry) {
            let may_advect = may_advect_force(asking);
            let longest = chart.time.filter(|_| self == Self::Settling).map(|time| LONGEST * time);
            let is_too_long = |run: &Run| step(run).zip(longest).is_some_and(|(dt, longest)| dt > longest);
            // A thinner mask is the most exact for a sphere that stands, but one that moves feels the grid with it.
            chart
                .runs
                .retain(|run| !(is_thin(run) || is_too_long(run) || (advects_force(run) && !may_advect)));
        }
        Ok(chart)
    }
}
