//! Grains as structure of arrays, and how they answer to a force.

use crate::grain::{Grain, Shape};
use crate::motion::{Motion, Vec3};
use crate::periods::Periods;
use crate::report::GrainLoad;
use bedload_outline::Outline;
use nalgebra::{Quaternion, UnitQuaternion};

/// All grains; index = grain. Laboratory frame.
#[derive(Clone, Debug, Default)]
pub struct Grains {
    /// Centres, m; inside the period along periodic axes between windows.
    pub position: Vec<Vec3>,
    /// How often each centre has been put back into the period, per axis: add `image` × period to
    /// unroll the path.
    pub image: Vec<[i32; 3]>,
    /// Velocities, m/s.
    pub velocity: Vec<Vec3>,
    /// Orientations, body to laboratory.
    pub orientation: Vec<UnitQuaternion<f64>>,
    /// Angular velocities, rad/s.
    pub spin: Vec<Vec3>,
    /// Mean acceleration over the last window, contact included (A_prev), m/s².
    pub acceleration: Vec<Vec3>,
    /// Mean angular acceleration over the last window, rad/s².
    pub spin_acceleration: Vec<Vec3>,
    /// Radii, m; of bodies that are not round the largest distance of the surface from the centre.
    pub radius: Vec<f64>,
    /// Half of the least widths, m; the radii of what is round.
    pub half_width: Vec<f64>,
    /// Outlines of bodies that are not round, by their places in [`crate::DemSpec::outlines`].
    pub outline: Vec<Option<u32>>,
    /// Masses, kg (per unit length for discs).
    pub mass: Vec<f64>,
    /// Moments of inertia, kg m².
    pub inertia: Vec<f64>,
    /// Who moves the grain.
    pub motion: Vec<Motion>,
    /// 1 along axes that the grain may move along, 0 else.
    pub translation: Vec<Vec3>,
    /// 1 about axes that the grain may turn about, 0 else.
    pub rotation: Vec<Vec3>,
}

/// Does the same with every array of two sets of grains.
macro_rules! for_each_array {
    ($a:ident, $b:ident, |$x:ident, $y:ident| $what:expr) => {
        for_each_array!($a, $b, |$x, $y| $what; position image velocity orientation spin acceleration
            spin_acceleration radius half_width outline mass inertia motion translation rotation)
    };
    ($a:ident, $b:ident, |$x:ident, $y:ident| $what:expr; $($field:ident)*) => {
        $({ let ($x, $y) = (&mut $a.$field, &mut $b.$field); $what; })*
    };
}

impl Grains {
    /// Fills the arrays; locked components of the initial motion become zero.
    #[must_use]
    pub fn new(list: &[Grain], shape: Shape, outlines: &[Outline]) -> Self {
        let mut grains = Self::default();
        for grain in list {
            let (translation, rotation) = match grain.motion {
                Motion::Free => (grain.free.translation(), grain.free.rotation()),
                _ => (Vec3::zeros(), Vec3::zeros()),
            };
            let (velocity, spin) = match &grain.motion {
                Motion::Free => (
                    translation.component_mul(&Vec3::from(grain.velocity)),
                    rotation.component_mul(&Vec3::from(grain.spin)),
                ),
                other => other.velocity_at(0.0),
            };
            let [w, x, y, z] = grain.orientation;
            let (mass, inertia) = grain.mass_and_inertia(shape, outlines);
            grains.position.push(grain.position.into());
            grains.velocity.push(velocity);
            grains.orientation.push(UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)));
            grains.spin.push(spin);
            grains.radius.push(grain.radius);
            let outline = grain.outline.and_then(|place| outlines.get(place as usize));
            grains.half_width.push(outline.map_or(grain.radius, |outline| 0.5 * outline.thickness()));
            grains.outline.push(grain.outline);
            grains.mass.push(mass);
            grains.inertia.push(inertia);
            grains.motion.push(grain.motion.clone());
            grains.translation.push(translation);
            grains.rotation.push(rotation);
        }
        grains.image = vec![[0; 3]; list.len()];
        grains.acceleration = vec![Vec3::zeros(); list.len()];
        grains.spin_acceleration = vec![Vec3::zeros(); list.len()];
        grains
    }

    /// Appends others.
    pub fn append(&mut self, mut others: Self) {
        for_each_array!(self, others, |to, from| to.append(from));
    }

    /// Forgets all but the first `count`.
    pub fn truncate(&mut self, count: usize) {
        let mut none = Self::default();
        for_each_array!(self, none, |array, _none| array.truncate(count));
    }

    /// Puts all centres back into the period.
    pub(crate) fn wrap(&mut self, periods: &Periods) {
        self.position.iter_mut().zip(&mut self.image).for_each(|(x, image)| periods.wrap(x, image));
    }

    /// Number of grains.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Whether grain `i` is a sphere or a disc.
    #[inline(always)]
    #[must_use]
    pub fn is_round(&self, i: usize) -> bool {
        self.outline[i].is_none()
    }

    /// Whether grain `i` never moves.
    #[must_use]
    pub fn is_fixed(&self, i: usize) -> bool {
        !self.responds(i) && matches!(self.motion[i], Motion::Free | Motion::Fixed)
    }

    /// Whether forces can move or turn grain `i`.
    #[must_use]
    pub fn responds(&self, i: usize) -> bool {
        self.translation[i] != Vec3::zeros() || self.rotation[i] != Vec3::zeros()
    }
}

/// What stays constant over a window: inverse masses with the virtual mass, and the acceleration by
/// gravity, fluid and virtual mass.
///
/// (m_p + m_a) dU/dt = m_p g + F + m_a A_prev + F_contact + F_lubrication (Schwarz, Kempe & Fröhlich 2015),
/// likewise for the spin with the virtual inertia. F is the whole force of the fluid, buoyancy
/// included.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// 1/(m_p + m_a) along free axes, 0 along locked ones, 1/kg.
    pub inverse_mass: Vec<Vec3>,
    /// 1/(I_p + I_a) about free axes, 1/(kg m²).
    pub inverse_inertia: Vec<Vec3>,
    /// 1/(m_p + m_a) for m*, 0 for a grain that nothing moves, 1/kg.
    pub contact_inverse_mass: Vec<f64>,
    /// (m_p g + F + m_a A_prev)/(m_p + m_a) along free axes, m/s².
    pub acceleration: Vec<Vec3>,
    /// (T + I_a dω/dt_prev)/(I_p + I_a) about free axes, rad/s².
    pub spin_acceleration: Vec<Vec3>,
    /// g in it, m/s².
    gravity: Vec3,
}

impl Response {
    /// The response under these loads; none at all is a dry run.
    #[must_use]
    pub fn new(grains: &Grains, gravity: &Vec3, loads: &[GrainLoad]) -> Self {
        let mut response = Self::default();
        response.set(grains, gravity, loads);
        response
    }

    /// Room for `n` grains; what it then says of new ones is nothing.
    pub(crate) fn resize(&mut self, n: usize) {
        let Self { inverse_mass, inverse_inertia, acceleration, spin_acceleration, .. } = self;
        for vectors in [inverse_mass, inverse_inertia, acceleration, spin_acceleration] {
            vectors.resize(n, Vec3::zeros());
        }
        self.contact_inverse_mass.resize(n, 0.0);
    }

    /// Takes the loads of a window; no load at all is a dry run.
    pub fn set(&mut self, grains: &Grains, gravity: &Vec3, loads: &[GrainLoad]) {
        self.resize(grains.len());
        self.gravity = *gravity;
        for i in 0..grains.len() {
            let load = loads.get(i).copied().unwrap_or_default();
            let inverse = 1.0 / (grains.mass[i] + load.added_mass);
            let inverse_turn = 1.0 / (grains.inertia[i] + load.added_inertia);
            let force = gravity * grains.mass[i] + load.force + grains.acceleration[i] * load.added_mass;
            let torque = load.torque + grains.spin_acceleration[i] * load.added_inertia;
            let moves = grains.translation[i] != Vec3::zeros();
            self.inverse_mass[i] = grains.translation[i] * inverse;
            self.inverse_inertia[i] = grains.rotation[i] * inverse_turn;
            self.contact_inverse_mass[i] = if moves { inverse } else { 0.0 };
            self.acceleration[i] = self.inverse_mass[i].component_mul(&force);
            self.spin_acceleration[i] = self.inverse_inertia[i].component_mul(&torque);
        }
    }

    /// Puts `gravity` in the place of what was taken before.
    pub(crate) fn set_gravity(&mut self, grains: &Grains, gravity: Vec3) {
        let change = gravity - std::mem::replace(&mut self.gravity, gravity);
        for i in 0..grains.len() {
            let gained = self.fall(grains, i, &change);
            self.acceleration[i] += gained;
        }
    }

    /// Acceleration of grain `i` by `gravity`, m/s².
    #[inline(always)]
    pub(crate) fn fall(&self, grains: &Grains, i: usize, gravity: &Vec3) -> Vec3 {
        self.inverse_mass[i].component_mul(gravity) * grains.mass[i]
    }

    /// m* of grain `i` against grain `j`, or against a wall; grains that only turn count with their own
    /// masses.
    #[inline(always)]
    #[must_use]
    pub fn effective_mass(&self, grains: &Grains, i: usize, j: Option<usize>) -> f64 {
        let of = &self.contact_inverse_mass;
        let inverse = j.map_or(of[i], |j| of[i] + of[j]);
        if inverse > 0.0 {
            return 1.0 / inverse;
        }
        let mass = grains.mass[i];
        j.map_or(mass, |j| mass * grains.mass[j] / (mass + grains.mass[j]))
    }
}
