//! What a run is made of: plain data, checked once.

use crate::Vec3;
use crate::error::SpecError;
use crate::general::integrate::Integrator;
use crate::laws::table::{ContactLaw, LawTable};
use crate::laws::walls::Wall;
use crate::lubrication::gap::{FilmIntegration, FilmModel, FilmShape, Lubrication};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Shape of all grains of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Solid sphere: m = 4/3 π R³ ρ, I = 2/5 m R².
    #[default]
    Sphere,
    /// Disc of a plane scene: m = π R² ρ per unit length, I = 1/2 m R².
    Disc,
}

impl Shape {
    /// Mass, kg (per unit length for a disc).
    #[must_use]
    pub fn mass(self, radius: f64, density: f64) -> f64 {
        match self {
            Self::Sphere => 4.0 / 3.0 * PI * radius.powi(3) * density,
            Self::Disc => PI * radius * radius * density,
        }
    }

    /// Moment of inertia about the centre, kg m².
    #[must_use]
    pub fn inertia(self, mass: f64, radius: f64) -> f64 {
        match self {
            Self::Sphere => 0.4 * mass * radius * radius,
            Self::Disc => 0.5 * mass * radius * radius,
        }
    }
}

/// Who moves a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Motion {
    /// Forces do.
    #[default]
    Free,
    /// Nothing does.
    Fixed,
    /// Constant velocity and spin.
    Prescribed {
        /// Velocity, m/s.
        #[serde(default)]
        velocity: [f64; 3],
        /// Angular velocity, rad/s.
        #[serde(default)]
        spin: [f64; 3],
    },
    /// x(t) = x₀ + A (sin(ωt + φ) − sin φ), and likewise an angle about a fixed axis.
    Oscillating {
        /// A, m.
        #[serde(default)]
        amplitude: [f64; 3],
        /// Amplitude of the angle, along its axis, rad.
        #[serde(default)]
        angle: [f64; 3],
        /// ω, rad/s.
        frequency: f64,
        /// φ, rad.
        #[serde(default)]
        phase: f64,
    },
}

impl Motion {
    /// Velocity and spin at time `t` of a grain that forces do not move.
    #[must_use]
    pub fn velocity_at(&self, t: f64) -> (Vec3, Vec3) {
        match *self {
            Self::Free | Self::Fixed => (Vec3::zeros(), Vec3::zeros()),
            Self::Prescribed { velocity, spin } => (velocity.into(), spin.into()),
            Self::Oscillating { amplitude, angle, frequency, phase } => {
                let rate = frequency * (frequency * t + phase).cos();
                (Vec3::from(amplitude) * rate, Vec3::from(angle) * rate)
            }
        }
    }

    /// Mean velocity and spin between `t` and `t + dt`: times `dt` they give the exact path.
    #[must_use]
    pub fn mean_velocity(&self, t: f64, dt: f64) -> (Vec3, Vec3) {
        match *self {
            Self::Oscillating { amplitude, angle, frequency, phase } => {
                let rate = ((frequency * (t + dt) + phase).sin() - (frequency * t + phase).sin()) / dt;
                (Vec3::from(amplitude) * rate, Vec3::from(angle) * rate)
            }
            _ => self.velocity_at(t),
        }
    }

    fn values(&self) -> Vec<f64> {
        match *self {
            Self::Free | Self::Fixed => Vec::new(),
            Self::Prescribed { velocity, spin } => [velocity, spin].concat(),
            Self::Oscillating { amplitude, angle, frequency, phase } => {
                [&amplitude[..], &angle, &[frequency, phase]].concat()
            }
        }
    }
}

/// What does the sub-steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// `bulk` for many grains ([`crate::bulk::FROM`]) where the scene allows it, else `general`.
    #[default]
    Auto,
    /// All laws, films and integrators.
    General,
    /// For many grains: linear contacts and symplectic Euler only, several times as fast.
    Bulk,
}

/// Which motions of a free grain are left to the forces, in the laboratory frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Freedom {
    /// Translation along x, y, z.
    pub translation: [bool; 3],
    /// Rotation about x, y, z.
    pub rotation: [bool; 3],
}

impl Freedom {
    /// All six.
    pub const SPACE: Self = Self { translation: [true; 3], rotation: [true; 3] };
    /// Plane scenes (x, z): y locked, rotation about y only.
    pub const PLANE: Self = Self { translation: [true, false, true], rotation: [false, true, false] };
    /// Axisymmetric scenes: along z only.
    pub const AXIS: Self = Self { translation: [false, false, true], rotation: [false; 3] };

    /// 1 along free axes.
    #[must_use]
    pub fn translation(&self) -> Vec3 {
        self.translation.map(|free| f64::from(u8::from(free))).into()
    }

    /// 1 about free axes.
    #[must_use]
    pub fn rotation(&self) -> Vec3 {
        self.rotation.map(|free| f64::from(u8::from(free))).into()
    }
}

impl Default for Freedom {
    fn default() -> Self {
        Self::SPACE
    }
}

/// One grain at time zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Centre, m.
    pub position: [f64; 3],
    /// Velocity of a free grain, m/s; others have theirs in `motion`.
    pub velocity: [f64; 3],
    /// Angular velocity of a free grain, rad/s.
    pub spin: [f64; 3],
    /// Orientation, unit quaternion (w, x, y, z), body to laboratory.
    pub orientation: [f64; 4],
    /// Radius, m.
    pub radius: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Material.
    pub material: usize,
    /// Who moves it.
    pub motion: Motion,
    /// What is left free of a free grain.
    pub free: Freedom,
}

impl Grain {
    /// A free grain at rest, of material 0.
    #[must_use]
    pub fn new(position: [f64; 3], radius: f64, density: f64) -> Self {
        Self {
            position,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            radius,
            density,
            material: 0,
            motion: Motion::Free,
            free: Freedom::SPACE,
        }
    }

    fn validate(&self, grain: usize) -> Result<(), SpecError> {
        let bad = |quantity, value, allowed| Err(SpecError::Grain { grain, quantity, value, allowed });
        for (quantity, values) in [
            ("position", &self.position[..]),
            ("velocity", &self.velocity),
            ("spin", &self.spin),
            ("motion", &self.motion.values()),
        ] {
            if let Some(&value) = values.iter().find(|c| !c.is_finite()) {
                return bad(quantity, value, "finite");
            }
        }
        for (quantity, value) in [("radius", self.radius), ("density", self.density)] {
            if !(value > 0.0 && value.is_finite()) {
                return bad(quantity, value, "positive and finite");
            }
        }
        let norm = self.orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
        if norm.is_nan() || (norm - 1.0).abs() > 1e-6 {
            return bad("length of the orientation quaternion", norm, "1 (to 1e-6)");
        }
        Ok(())
    }
}

/// Law between two named materials, in place of the general one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialPair {
    /// The two materials; equal for a material against itself.
    pub between: [usize; 2],
    /// Their law.
    pub contact: ContactLaw,
}

/// A whole run: grains, walls, models.
#[derive(Clone, Debug, PartialEq)]
pub struct DemSpec {
    /// Grains.
    pub grains: Vec<Grain>,
    /// Shape of all grains.
    pub shape: Shape,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Lower end and length of the period per axis, m; none where the axis is not periodic.
    pub periods: [Option<(f64, f64)>; 3],
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Number of materials.
    pub materials: usize,
    /// Law of contact of all materials,
    pub contact: ContactLaw,
    /// but for these pairs.
    pub pairs: Vec<MaterialPair>,
    /// Film model.
    pub lubrication: Lubrication,
    /// Viscosity μ of the fluid, Pa s; used by the film only.
    pub viscosity: f64,
    /// Time integration.
    pub integrator: Integrator,
    /// Width of the neighbour list beyond the range of forces, m; a tenth of the mean diameter if
    /// absent. It changes the cost, never the result.
    pub skin: Option<f64>,
    /// What does the sub-steps.
    pub engine: Engine,
    /// How the bulk engine does its work.
    pub bulk: crate::bulk::Settings,
    /// Whether forces, gaps and impact speeds per grain are wanted; the general engine has them anyway.
    pub observations: bool,
    /// Whether an account of dissipated energy is kept ([`crate::general::energy`]); not by the bulk engine.
    pub energy: bool,
    /// Whether orientations are wanted: nothing depends on them. The general engine has them anyway.
    pub orientation: bool,
}

impl DemSpec {
    /// Grains and one law; no wall, gravity, film or period.
    #[must_use]
    pub fn new(grains: Vec<Grain>, contact: ContactLaw) -> Self {
        Self {
            grains,
            shape: Shape::Sphere,
            walls: Vec::new(),
            periods: [None; 3],
            gravity: [0.0; 3],
            materials: 1,
            contact,
            pairs: Vec::new(),
            lubrication: Lubrication::None,
            viscosity: 0.0,
            integrator: Integrator::default(),
            skin: None,
            engine: Engine::default(),
            bulk: crate::bulk::Settings::default(),
            observations: true,
            orientation: true,
            energy: false,
        }
    }

    /// Checks everything; the first fault found is returned.
    pub fn validate(&self) -> Result<(), SpecError> {
        let model =
            |model, quantity, value, allowed| Err(SpecError::Model { model, quantity, value, allowed });
        self.contact.validate()?;
        self.lubrication.validate()?;
        for (index, pair) in self.pairs.iter().enumerate() {
            pair.contact.validate()?;
            self.check_material("law", index, pair.between[0].max(pair.between[1]))?;
        }
        for (index, grain) in self.grains.iter().enumerate() {
            grain.validate(index)?;
            self.check_material("grain", index, grain.material)?;
        }
        let periodic = self.periods.map(|period| period.is_some());
        for (index, wall) in self.walls.iter().enumerate() {
            wall.validate(index, periodic)?;
            self.check_material("wall", index, wall.material)?;
        }
        if let Some(&value) = self.gravity.iter().find(|c| !c.is_finite()) {
            return model("gravity", "a component", value, "finite");
        }
        if self.lubrication.settings().is_some() && !(self.viscosity > 0.0 && self.viscosity.is_finite()) {
            return model(
                "lubrication",
                "viscosity",
                self.viscosity,
                "positive and finite; a dry scene takes form = \"none\"",
            );
        }
        if let Some(skin) = self.skin.filter(|skin| !(*skin > 0.0 && skin.is_finite())) {
            return model("neighbour list", "skin", skin, "positive and finite");
        }
        let hertz = |law: &ContactLaw| matches!(law, ContactLaw::HertzMindlin(_));
        let laws = || self.pairs.iter().map(|pair| &pair.contact).chain([&self.contact]);
        if self.shape == Shape::Disc && laws().any(hertz) {
            return Err(SpecError::Law(
                "hertz-mindlin is a law of spheres, and discs touch along a line; choose linear-spring-dashpot",
            ));
        }
        let implicit =
            self.lubrication.settings().is_some_and(|film| film.integration == FilmIntegration::Implicit);
        if self.integrator == Integrator::Rk3 && implicit {
            return Err(SpecError::Combination(
                "integrator rk3 takes no implicit lubrication; choose symplectic-euler, or integration = \"explicit\" with its bound on the sub-step",
            ));
        }
        let line = self.film().is_some_and(|film| film.shape == FilmShape::Line);
        if line && matches!(self.lubrication, Lubrication::Complement(_)) {
            return Err(SpecError::Combination(
                "lubrication form \"complement\" is measured for spheres (point films) only; take \"continuous\" for discs",
            ));
        }
        if let Some(reason) = crate::general::energy::prevents(self).filter(|_| self.energy) {
            return Err(SpecError::Combination(reason));
        }
        if self.engine == Engine::Bulk
            && let Some(reason) = crate::bulk::prevents(self)
        {
            return Err(SpecError::Engine(reason));
        }
        self.check_periods()
    }

    fn check_material(&self, owner: &'static str, index: usize, material: usize) -> Result<(), SpecError> {
        if material < self.materials {
            return Ok(());
        }
        Err(SpecError::Material { owner, index, material, last: self.materials.saturating_sub(1) })
    }

    fn check_periods(&self) -> Result<(), SpecError> {
        let pairs = self.grains.len() > 1 && self.grains.iter().any(|grain| grain.motion == Motion::Free);
        let least = if pairs { 2.0 * (2.0 * self.largest_radius() + self.range()) } else { 0.0 };
        for (axis, period) in self.periods.iter().enumerate() {
            let Some((start, length)) = *period else { continue };
            if !(start.is_finite() && length > 0.0 && length >= least && length.is_finite()) {
                return Err(SpecError::Period { axis, length, least });
            }
        }
        Ok(())
    }

    /// Radius of the largest grain, m.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max)
    }

    /// Largest gap at which a force acts, m: beyond it gaps are not watched.
    #[must_use]
    pub fn range(&self) -> f64 {
        let film = self.lubrication.settings().map_or(0.0, |film| film.cut_off * self.largest_radius());
        let law = self.pairs.iter().map(|pair| pair.contact.range()).fold(self.contact.range(), f64::max);
        film.max(law)
    }

    /// Skin of the neighbour list, m.
    #[must_use]
    pub fn skin(&self) -> f64 {
        let mean =
            self.grains.iter().map(|grain| grain.radius).sum::<f64>() / self.grains.len().max(1) as f64;
        self.skin.unwrap_or(0.2 * mean)
    }

    /// Laws of all pairs of materials.
    #[must_use]
    pub fn laws(&self) -> LawTable {
        let mut table = LawTable::new(self.materials, &self.contact);
        for pair in &self.pairs {
            table.set(pair.between[0], pair.between[1], &pair.contact);
        }
        table
    }

    /// Film model with its shape resolved, and its settings.
    #[must_use]
    pub fn film(&self) -> Option<FilmModel> {
        let settings = self.lubrication.settings()?;
        let by_shape = match self.shape {
            Shape::Sphere => FilmShape::Point,
            Shape::Disc => FilmShape::Line,
        };
        Some(FilmModel {
            shape: settings.film.unwrap_or(by_shape),
            roughness: settings.roughness,
            cut_off: settings.cut_off,
            continuous: matches!(self.lubrication, Lubrication::Continuous(_)),
            resolved_length: settings.resolved_length.unwrap_or(f64::INFINITY),
            viscosity: self.viscosity,
        })
    }
}
