//! Loads of a force that acts before the fluid knows the motion (docs/equations-immersed.md, section 4).
//!
//! With −G/dt the force per unit density that the grain would exert on the fluid at its predicted place, m_f
//! the mass of the fluid it displaces and ρ the fluid's density, the message carries
//! ```text
//! F = ρ G/dt − m_f g + virtual mass + displaced mass          (after Yu & Shao 2007)
//! ```
//! so that `m_p dU/dt = m_p g + F`: buoyancy is in F, weight is not. Why −m_f g is there along periodic axes
//! too: `docs/equations-immersed.md`.
//!
//! The part of a window's change of velocity that its message does not explain is the jump of a contact,
//! ΔU_c. The fluid gets it in its own window ([`super::calibrated::contact`]) and takes C_g m_f ΔU_c for it.
//! The next message takes that from the grain and gives back the virtual mass of the jump, both as momentum,
//! whatever the lengths of the two windows.

use super::grains::{Grains, Memory};
use super::virtual_mass::{self, ByGap};
use crate::grid::{Geometry, Grid};
use crate::immersed::body::{Motion, Shape, along_axes};
use crate::immersed::mask_model::MaskModel;
use crate::immersed::{Immersed, Wrench};
use crate::scene_grains;
use crate::step::Stepper;
use bedload_output::totals::part_below;
use bedload_scene::CheckedScene;
use protocol::message::Loads;

/// Largest mass, and inertia, that may act through the acceleration of the window before, over those of
/// density ρ_p − ρ/2, where it is positive and where it is negative: with a third of it discs were seen to
/// fail (docs/equations-immersed.md, section 4).
const MAX_LATE_RATIO: [f64; 2] = [1.0 / 16.0, 0.5];

/// Least ΔU_c that counts as a jump, over the larger of the speeds before and after, and over the change that
/// the message explains.
const LEAST_JUMP: [f64; 2] = [0.02, 1.5];

/// What is the same for all grains and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LoadsRule {
    /// Virtual mass coefficient C_v of a grain with nothing near it.
    virtual_mass: f64,
    /// Mean gravity of the window, m/s².
    gravity: [f64; 3],
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Number of axes of a grain: 3 for a sphere, 2 for a disc.
    dimensions: i32,
}

/// What the fluid knows about one grain in one window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Measured {
    /// −G/dt.
    pub(super) force: Wrench,
    /// Its change since the window before.
    change: [f64; 3],
    /// Acceleration and angular acceleration over the window before.
    pub(super) acceleration: Wrench,
    /// The part of a contact in it, ΔU_c over the length of the window before, and over that of this window,
    /// m/s².
    jump: [[f64; 3]; 2],
    /// Momentum that the fluid took of the jump, over m_f and the length of this window, m/s².
    taken: [f64; 3],
    /// Acceleration of the attempt before less that of the window before: what a DEM does not know when it
    /// adds added_mass A_prev. Zero in the first attempt at a window.
    pub(super) ahead: Wrench,
    /// Added to C_v by walls and neighbours. It has no part in the virtual inertia: a sphere that turns moves
    /// no ideal fluid.
    near: f64,
    /// The same in the window before, whose acceleration the DEM adds: with it the virtual masses of all
    /// windows cancel in the sum, however they change.
    near_before: f64,
    /// Added to C_v: what repeated windows need so that the first attempts do not overshoot. It drops out.
    pub(super) more: f64,
    /// ∫ β dV on the grid's nodes of each component, m³, where it is to count.
    volume: Option<[f64; 3]>,
    /// Change of the acceleration of the fluid as a whole since the window before, m/s².
    pub(super) drive: [f64; 3],
    /// The same along the axes along which the fluid moves the grain, which follows it there.
    pub(super) free_drive: [f64; 3],
    /// Does the grain move as the scene says, whatever the fluid does?
    led: bool,
    /// The part of its volume beyond faces of the box, if it is led: no fluid is displaced there.
    outside: f64,
    /// Is it the first window of a fluid at rest? Then the grain starts with C_v alone (Izard et al. 2014,
    /// eq. 20).
    starts: bool,
}

impl LoadsRule {
    /// The message about one grain.
    fn loads(&self, shape: &Shape, measured: &Measured) -> Loads {
        let rho = self.density;
        let mass = rho * shape.volume * (1.0 - measured.outside);
        let inertia = mass * shape.gyration;
        let coefficient = self.virtual_mass + measured.more;
        let mut loads = Loads {
            added_mass: (coefficient + measured.near) * mass,
            added_inertia: coefficient * inertia,
            ..Loads::default()
        };
        let (f, a, [in_that, in_this]) = (&measured.force, &measured.acceleration, &measured.jump);
        for c in 0..3 {
            loads.force[c] = -rho * f.force[c] - mass * self.gravity[c];
            loads.torque[c] = -rho * self.of_rotation(shape) * f.torque[c];
            // Virtual mass resists motion relative to the fluid, C_v m_f (A_f − A): the force measured has
            // A_f,prev − A_prev of that, and a DEM adds A_prev − A.
            loads.force[c] += loads.added_mass * (measured.drive[c] + measured.ahead.force[c])
                + (measured.near_before - measured.near) * mass * a.force[c]
                + (coefficient + measured.near_before) * mass * (in_this[c] - in_that[c])
                - mass * measured.taken[c];
            loads.torque[c] += loads.added_inertia * measured.ahead.torque[c];
        }
        if let Some(volumes) = measured.volume {
            self.displace(shape, volumes, measured, &mut loads);
        }
        loads
    }

    /// ΔU_c of a grain over a window of length `dt` in which it was sent what was `measured`.
    fn jump(&self, shape: &Shape, measured: &Measured, [before, now]: [&Motion; 2], dt: f64) -> [f64; 3] {
        let (loads, mass) = (self.loads(shape, measured), shape.density * shape.volume);
        let (mut jump, mut explained, mut speed) = ([0.0; 3], 0.0, 0.0);
        for (c, jump) in jump.iter_mut().enumerate() {
            let known = loads.added_mass * measured.acceleration.force[c];
            let push = mass * self.gravity[c] + loads.force[c] + known;
            let smooth = dt * push / (mass + loads.added_mass);
            let (u, v) = (before.velocity[c], now.velocity[c]);
            // What is locked keeps its velocity to the last bit, whatever pushes.
            *jump = if u == v { 0.0 } else { v - u - smooth };
            explained += smooth * smooth;
            speed += f64::max(u * u, v * v);
        }
        let size: f64 = jump.iter().map(|jump| jump * jump).sum();
        let [of_speed, of_explained] = LEAST_JUMP.map(|least| least * least);
        if size > of_speed * speed && size > of_explained * explained { jump } else { [0.0; 3] }
    }

    /// The torque on a grain over that on its mask, whose radius is that of translation: a sphere or disc
    /// that turns in Stokes flow bends the shear at its surface by the curvature alone and needs no larger
    /// one (docs/equations-immersed.md, section 8). The torque goes with R^d.
    fn of_rotation(&self, shape: &Shape) -> f64 {
        (shape.radius / shape.mask_radius).powi(self.dimensions)
    }

    /// How much more inertia the mask has in the torque than the grain's volume, less one, where its volume
    /// is `ratio` times as large: inertia goes with V^(1 + 2/d).
    fn swollen(&self, shape: &Shape, ratio: f64) -> f64 {
        self.of_rotation(shape) * ratio.powf(1.0 + 2.0 / f64::from(self.dimensions)) - 1.0
    }

    /// Puts the mass ρ(∫β dV − V), by which the mask differs from the grain, on the grain's side of the
    /// equation: as force, times the acceleration that is known, as far as the grain is heavy enough to bear
    /// a force that comes one window late, or is led and bears any; the rest, where it is positive, as mass.
    /// A DEM adds added_mass A_prev to the force, which belongs to C_v m_f alone, so that of this mass is
    /// taken off here.
    ///
    /// The mass of a message has no direction: it is the mean over the components that the grain
    /// moves along, and what differs from it acts through the acceleration that is known.
    fn displace(&self, shape: &Shape, volumes: [f64; 3], measured: &Measured, loads: &mut Loads) {
        let (a, ahead) = (&measured.acceleration, &measured.ahead);
        let filled = volumes.iter().filter(|v| **v > 0.0).count().max(1);
        let volume = volumes.iter().sum::<f64>() / filled as f64;
        let whole = (shape.volume * (1.0 - measured.outside)).max(f64::MIN_POSITIVE);
        let mass = self.density * (volume - whole);
        // of a grain that is cut the mask is no larger sphere
        let ratio = if measured.outside > 0.0 { 1.0 } else { volume / whole };
        let inertia = self.density * whole * shape.gyration * self.swollen(shape, ratio);
        let heavy = MAX_LATE_RATIO[usize::from(mass < 0.0)] * (shape.density / self.density - 0.5).max(0.0);
        let bears = if measured.led { f64::INFINITY } else { heavy };
        // Parts that go with the force and with the mass.
        let parts = |extra: f64, own: f64| {
            let late = (bears * own / extra.abs()).min(1.0);
            (late, if extra > 0.0 && !measured.starts { 1.0 - late } else { 0.0 })
        };
        let (late, now) = parts(mass, self.density * whole);
        let (late_spin, now_spin) = parts(inertia, self.density * whole * shape.gyration);
        loads.added_mass += now * mass;
        loads.added_inertia += now_spin * inertia;
        for (c, here) in volumes.into_iter().enumerate() {
            let uneven = if here > 0.0 { self.density * (here - volume) } else { 0.0 };
            // The mask held no jump.
            let known = a.force[c] - measured.jump[0][c] + ahead.force[c] + measured.free_drive[c];
            loads.force[c] -= now * mass * a.force[c] + (late * mass + (late + now) * uneven) * known;
            loads.torque[c] -=
                inertia * (now_spin * a.torque[c] + late_spin * (a.torque[c] + ahead.torque[c]));
        }
    }
}

/// Windows below this ν dt/Δx² are too short for viscosity: in them what a scene moves jumps.
const BRIEF: f64 = 0.01;

/// Windows above this ν dt/Δx² keep a force in cells that a grain at rest seals.
const SEALS: f64 = 0.1;

/// Way in a window, over Δx, below which a grain rests.
const AT_REST: f64 = 0.1;

/// Part of the volume of a grain beyond the faces of the box: exact across one face, of a polygon that of the
/// ellipse which reaches as far.
pub(super) fn outside<const D: usize>(grid: &Grid<D>, shape: &Shape, motion: &Motion) -> f64 {
    let (disc, at) = (grid.geometry == Geometry::Plane, along_axes::<D>(grid.geometry, motion.centre));
    let first = usize::from(grid.geometry == Geometry::Axisymmetric);
    let inside = (first..D).filter(|axis| !grid.periodic(*axis)).map(|axis| {
        let faces = &grid.axes[axis].faces;
        let direction = if axis == 0 { [1.0, 0.0] } else { [0.0, 1.0] };
        let outline = shape.outline.as_ref();
        let reach = outline.map_or(shape.radius, |outline| outline.reach_along(motion.angle, direction));
        let [below, above] = [at[axis] - faces[0], faces[faces.len() - 1] - at[axis]];
        part_below(below / reach, disc) + part_below(above / reach, disc) - 1.0
    });
    1.0 - inside.product::<f64>().clamp(0.0, 1.0)
}

/// Change of the velocity of a grain that is led.
fn led_jump(before: &Motion, now: &Motion) -> [f64; 3] {
    std::array::from_fn(|c| now.velocity[c] - before.velocity[c])
}

/// The loads of all grains.
pub struct GrainLoads {
    rule: LoadsRule,
    /// What walls and neighbours add to the virtual mass; none where all grains are fixed.
    by_gap: Option<ByGap>,
    /// Whether the mass counts by which the mask differs from the grain.
    displaced_mass: bool,
    /// Of each grain: the motions along x, y, z and about them that obey Newton's law.
    freedoms: Vec<[bool; 6]>,
    /// Whether forces of the window before are known: not at first, and not after a resume.
    follows: bool,
    pub(super) measured: Vec<Measured>,
    volumes: Vec<[f64; 3]>,
}

impl GrainLoads {
    /// For the grains of a scene in a fluid of density `density`, kg/m³.
    pub(super) fn new<const D: usize>(grid: &Grid<D>, scene: &CheckedScene, density: f64) -> Self {
        let dimensions = grid.geometry.grain_dimensions();
        let (shapes, free) = (scene_grains::shapes(scene), scene_grains::free(scene));
        let geometry = scene.scene.domain.geometry;
        let moves: Vec<_> = scene.grains.iter().map(|grain| !grain.stays(geometry)).collect();
        Self {
            rule: LoadsRule { virtual_mass: virtual_mass::ALONE, gravity: [0.0; 3], density, dimensions },
            by_gap: moves.contains(&true).then(|| ByGap::new(grid, &shapes, [free, moves])),
            displaced_mass: true,
            freedoms: scene_grains::freedoms(scene),
            follows: false,
            measured: vec![Measured::default(); shapes.len()],
            volumes: vec![[0.0; 3]; shapes.len()],
        }
    }

    /// With or without virtual mass, and the mass by which the mask differs from the grain. Points have the
    /// area of their body: with them there is no such mass.
    pub(super) fn with_parts(mut self, virtual_mass: bool, displaced_mass: bool) -> Self {
        self.displaced_mass = displaced_mass;
        if !virtual_mass {
            (self.rule.virtual_mass, self.by_gap) = (0.0, None);
        }
        self
    }

    /// Takes −G/dt of every grain, found at its predicted place.
    pub(super) fn set_forces(&mut self, forces: &[Wrench]) {
        for (m, force) in self.measured.iter_mut().zip(forces) {
            let change = |c| force.force[c] - m.force.force[c];
            m.change = if self.follows { std::array::from_fn(change) } else { [0.0; 3] };
            m.force = *force;
        }
        self.follows = true;
    }

    /// Largest change of a carried force times the step over the mass that has it, m/s, and the grain.
    pub(super) fn leak<const D: usize>(&self, grains: &Grains<D>) -> Option<(f64, usize)> {
        let shapes = grains.immersed.shapes().iter().zip(&self.measured).enumerate();
        let leak = |(grain, (shape, m)): (usize, (&Shape, &Measured))| {
            let change = m.change.iter().map(|change| change * change).sum::<f64>().sqrt();
            (change * grains.model.dt / shape.volume, grain)
        };
        shapes.map(leak).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Takes volumes, accelerations and what drives the fluid.
    pub(super) fn measure<const D: usize>(&mut self, fluid: &Stepper<D>, grains: &Grains<D>) {
        let memory = &grains.memory;
        if self.displaced_mass {
            grains.immersed.volumes(fluid.grid().geometry, &mut self.volumes);
        }
        self.rule.gravity = grains.gravity;
        let drive = memory.change_of_drive(fluid);
        for (grain, m) in self.measured.iter_mut().enumerate() {
            m.acceleration = memory.acceleration(grain);
            if memory.before_dt > 0.0 {
                let jump = memory.jumps[grain];
                m.jump = [memory.before_dt, grains.model.dt].map(|dt| jump.map(|jump| jump / dt));
                m.taken = memory.taken[grain].map(|taken| taken / grains.model.dt);
            }
            m.drive = drive;
            m.free_drive = std::array::from_fn(|c| if self.freedoms[grain][c] { drive[c] } else { 0.0 });
            m.led = self.freedoms[grain] == [false; 6];
            if m.led {
                let (shape, motion) = (&grains.immersed.shapes()[grain], &memory.motions[grain]);
                m.outside = outside(fluid.grid(), shape, motion);
            }
            m.starts = memory.before_dt == 0.0 && drive == [0.0; 3];
            m.volume = self.displaced_mass.then(|| self.volumes[grain]);
        }
    }

    /// What walls and neighbours add to the virtual mass in a window that begins with the motion known now,
    /// and what they added in the window before; where windows are `repeated`, each attempt's own virtual
    /// mass cancels.
    pub(super) fn measure_virtual_mass<const D: usize>(&mut self, grains: &Grains<D>, repeated: bool) {
        let Self { by_gap: Some(by_gap), measured, rule, .. } = self else { return };
        let Grains { immersed, memory, model, .. } = grains;
        let near = by_gap.excess(immersed.shapes(), rule.density, &memory.motions, model.dt);
        for (m, near) in measured.iter_mut().zip(near) {
            m.near_before = if repeated { *near } else { m.near };
            m.near = *near;
        }
    }

    /// Finds ΔU_c of the window of length `dt` whose motion came back, of grains that touch one other thing
    /// at most: what several contacts do to each other takes more windows than one.
    pub(super) fn find_jumps<const D: usize>(&self, grid: &Grid<D>, grains: &mut Grains<D>, dt: f64) {
        let brief = grains.model.viscosity * dt < BRIEF * grid.smallest_width().powi(2);
        let brief = brief && grid.geometry != Geometry::Plane;
        let Memory { motions, before, jumps, .. } = &mut grains.memory;
        let motions = before.iter().zip(motions);
        let known = self.measured.iter().zip(grains.immersed.shapes());
        for ((jump, (m, shape)), (before, now)) in jumps.iter_mut().zip(known).zip(motions) {
            // A grain that is out of the box holds no fluid.
            let holds = m.volume.is_none_or(|volume| volume.iter().any(|volume| *volume > 0.0));
            *jump = match (m.led, m.near > 0.0) {
                (true, _) if brief && holds => led_jump(before, now),
                (false, true) if holds => self.rule.jump(shape, m, [before, now], dt),
                _ => [0.0; 3],
            };
        }
        // The first rank alone knows what was sent.
        let ranks = grid.division.ranks();
        if !ranks.is_alone() {
            ranks.spread(jumps.as_flattened_mut());
        }
    }

    /// Part of the window at which each grain first touches something.
    pub(super) fn touches(&self) -> &[f64] {
        self.by_gap.as_ref().map_or(&[], ByGap::touches)
    }

    /// Time, s, until the first free grain touches something that it nears faster than `fast`, m/s, as they
    /// move now; `dt` if that is longer.
    pub(super) fn until_touch<const D: usize>(&mut self, grains: &Grains<D>, dt: f64, fast: f64) -> f64 {
        let Grains { immersed, memory, .. } = grains;
        match &mut self.by_gap {
            Some(by_gap) => by_gap.until_touch(immersed.shapes(), &memory.motions, dt, fast),
            None => dt,
        }
    }

    /// Opens the masks in films and where grains have come to rest, in a window that begins with `motions`
    /// and in which a force that they seal would stay; see [`ByGap::open_masks`] for `rests`.
    pub(super) fn open_masks<const D: usize>(
        &mut self,
        immersed: &mut Immersed<D>,
        model: &MaskModel,
        spacing: f64,
        motions: &[Motion],
        rests: (&mut [u8], bool),
    ) {
        let Some(by_gap) = &mut self.by_gap else { return };
        // A disc's mask is solid from half a cell inside on, and seals in any step.
        let viscous = model.viscosity / spacing;
        let seals = self.rule.dimensions == 2 || model.viscosity * model.dt > SEALS * spacing * spacing;
        let slow = if seals { (AT_REST * spacing / model.dt).min(viscous) } else { 0.0 };
        let shapes = immersed.shapes_mut();
        shapes.iter_mut().for_each(|shape| shape.patches.clear());
        if self.rule.dimensions == 3 {
            by_gap.open_films(shapes, motions, [viscous * model.dt / spacing, spacing]);
        }
        by_gap.open_masks(shapes, motions, [slow, spacing], rests);
    }

    /// Whether all free grains rest, one since `most` windows at most; `cell`: a cell in the step that is
    /// allowed, m/s.
    pub(super) fn have_come_to_rest<const D: usize>(&self, grains: &Grains<D>, most: u8, cell: f64) -> bool {
        let Some(by_gap) = &self.by_gap else { return false };
        let Memory { motions, rests, .. } = &grains.memory;
        rests.iter().any(|rests| (1..=most).contains(rests)) && by_gap.all_slow(motions, AT_REST * cell)
    }

    /// Finds the virtual masses of the window before.
    pub(super) fn resume<const D: usize>(&mut self, grains: &Grains<D>) {
        let Self { by_gap: Some(by_gap), measured, rule, .. } = self else { return };
        let memory = &grains.memory;
        let near = by_gap.excess(grains.immersed.shapes(), rule.density, &memory.before, memory.before_dt);
        measured.iter_mut().zip(near).for_each(|(m, near)| m.near = *near);
    }

    /// The message about each grain.
    pub(super) fn write(&self, shapes: &[Shape], out: &mut [Loads]) {
        for ((loads, shape), m) in out.iter_mut().zip(shapes).zip(&self.measured) {
            *loads = self.rule.loads(shape, m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape::round(1.0, 4.0, 3.0, 0.4);

    const RULE: LoadsRule =
        LoadsRule { virtual_mass: 0.5, gravity: [0.0, 0.0, -2.0], density: 1.0, dimensions: 3 };

    #[test]
    fn a_grain_at_rest_is_sent_its_buoyancy_and_its_virtual_mass() {
        let loads = RULE.loads(&SHAPE, &Measured::default());
        assert_eq!(loads.force, [0.0, 0.0, 6.0]);
        assert_eq!((loads.added_mass, loads.added_inertia), (0.5 * 3.0, 0.5 * (3.0 * 0.4)));
    }

    /// In repeated windows the virtual mass drops out: at A = A_k a DEM finds (m_p + m_a) A = … + m_a A_k,
    /// whatever A_prev it adds.
    #[test]
    fn virtual_mass_follows_the_attempts() {
        let (previous, attempt) = (0.25, -0.75);
        let ahead = Wrench { force: [0.0, 0.0, attempt - previous], torque: [0.0, attempt - previous, 0.0] };
        let plain = Measured::default();
        let (p, f) =
            (RULE.loads(&SHAPE, &plain), RULE.loads(&SHAPE, &Measured { ahead, more: 1.5, ..plain }));
        assert_eq!(f.added_mass, 2.0 * 3.0);
        let (force, torque) =
            (f.force[2] + f.added_mass * previous, f.torque[1] + f.added_inertia * previous);
        assert!((force - (p.force[2] + 2.0 * 3.0 * attempt)).abs() < 1e-14);
        assert!((torque - (p.torque[1] + 2.0 * 3.0 * 0.4 * attempt)).abs() < 1e-14);
    }

    /// (m_p + m_a) A = … + m_a A_prev, window by window, with virtual masses that change: what they add
    /// cancels in the sum over a contact, which begins and ends without acceleration.
    #[test]
    fn virtual_masses_that_change_cancel_in_the_sum() {
        let buoyant = 6.0;
        let (mut sum, mut before, mut near_before) = (0.0, 0.0, 0.0);
        for (near, a) in [(0.1, 0.0), (0.3, 5.0), (0.2, -1.0), (0.0, 0.0)] {
            let acceleration = Wrench { force: [0.0, 0.0, before], torque: [0.0; 3] };
            let loads =
                RULE.loads(&SHAPE, &Measured { acceleration, near, near_before, ..Measured::default() });
            sum += loads.force[2] - buoyant + loads.added_mass * (before - a);
            (before, near_before) = (a, near);
        }
        assert!(f64::abs(sum) < 1e-14, "{sum}");
    }

    /// The same in windows of changing length, of momentum: what a window's virtual mass took of a jump the
    /// next one gives back; what the fluid took is taken once, and no displaced mass.
    #[test]
    fn a_jump_is_paid_as_momentum_whatever_the_window() {
        let (mut sum, mut jumps, fluid) = (0.0, 0.0, 0.7);
        let (mut jump_before, mut dt_before, mut near_before) = (0.0, 1.0, 0.0);
        for (dt, near, jump) in
            [(1.0, 0.1, 0.0), (0.8, 0.3, 5.0), (0.3, 0.3, -1.0), (0.9, 0.2, 0.5), (0.4, 0.0, 0.0)]
        {
            let a = jump_before / dt_before;
            let measured = Measured {
                acceleration: Wrench { force: [0.0, 0.0, a], torque: [0.0; 3] },
                jump: [dt_before, dt].map(|dt| [0.0, 0.0, jump_before / dt]),
                taken: [0.0, 0.0, fluid * jump_before / dt],
                volume: Some([3.3; 3]),
                near,
                near_before,
                ..Measured::default()
            };
            let loads = RULE.loads(&SHAPE, &measured);
            sum += dt * (loads.force[2] - 6.0 + loads.added_mass * a) - loads.added_mass * jump;
            jumps += jump;
            (jump_before, dt_before, near_before) = (jump, dt, near);
        }
        assert!(f64::abs(sum + fluid * SHAPE.volume * jumps) < 1e-14, "{sum}");
    }

    /// A grain that moves as its message says has no jump; one that a wall throws back has that of the wall,
    /// and none along an axis that is locked.
    #[test]
    fn a_jump_is_what_the_message_does_not_explain() {
        let acceleration = Wrench { force: [0.0, 3.0, -1.0], torque: [0.0; 3] };
        let measured = Measured { acceleration, ..Measured::default() };
        let loads = RULE.loads(&SHAPE, &measured);
        let mass = SHAPE.density * SHAPE.volume;
        let (dt, before) = (0.1, Motion { velocity: [0.0, 0.0, -1.0], ..Motion::default() });
        let push = mass * RULE.gravity[2] + loads.force[2] - loads.added_mass;
        let explained = dt * push / (mass + loads.added_mass);
        let jump = |u: f64| {
            let now = Motion { velocity: [0.0, 0.0, u], ..before };
            RULE.jump(&SHAPE, &measured, [&before, &now], dt)
        };
        assert_eq!(jump(-1.0 + explained), [0.0; 3]);
        assert_eq!(jump(-1.0 + 2.0 * explained), [0.0; 3]);
        let thrown = jump(0.75);
        assert_eq!(thrown[..2], [0.0; 2]);
        assert!((thrown[2] - (1.75 - explained)).abs() < 1e-14, "{thrown:?}");
    }

    /// A DEM solves (m_p + m_a) a = m_p g + F + m_a A_prev. With A_prev = a the message must add ρ(∫β dV − V)
    /// a, component by component, to the grain's side, and nothing else: the part that is late as force, the
    /// rest as mass; all of it as force where the grain is heavy enough.
    #[test]
    fn displaced_mass_stands_on_the_grains_side() {
        let (a, volumes) = (0.25, [3.2, 3.3, 3.3]);
        let acceleration = Wrench { force: [0.0, 0.0, a], torque: [0.0; 3] };
        let plain = Measured { acceleration, ..Measured::default() };
        let filled = Measured { volume: Some(volumes), ..plain };
        let side =
            |density: f64, l: &Loads| (density * 3.0 + l.added_mass) * a - l.force[2] - l.added_mass * a;
        for (density, as_mass) in [(0.25, true), (1.0, true), (4.0, false)] {
            let shape = Shape { density, ..SHAPE };
            let (p, f) = (RULE.loads(&shape, &plain), RULE.loads(&shape, &filled));
            let added = side(density, &f) - side(density, &p);
            assert!((added - (volumes[2] - shape.volume) * a).abs() < 1e-14, "{density}: {added}");
            assert_eq!(f.added_mass > p.added_mass, as_mass, "{density}");
            assert!(f.added_inertia > p.added_inertia || density > 2.0, "{density}");
        }
    }
}
