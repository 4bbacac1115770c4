//! Positions, speeds, spins and overlaps of a foreign DEM, computed by the coupler from the kinematics that
//! the DEM sends.
//!
//! Tests hold our own DEM to the same limits; a foreign one may report any number of sub-steps.

use std::collections::HashMap;

use bedload_scene::{CheckedScene, Grain, Motion, Wall};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::Window;

use crate::bounds::MOST_OVERLAP;
use crate::failure::Failure;
use crate::number::norm;
use crate::solvers::{FAR, diagonal};

/// By how much a grain may move further than its speeds and its acceleration let it, of its radius: contacts
/// of the overlap that is allowed push it out.
const PUSH: f64 = MOST_OVERLAP;
/// Reserve on the way that the speeds at both ends of a window stand for: a contact within it may be faster.
const RESERVE: f64 = 2.0;

/// By how much more a DEM may find an overlap than it reports, of a radius: it may look before its last
/// sub-step.
const UNSEEN: f64 = 0.02;
/// A contact may turn a grain as fast as the fastest surface slides, times 5/2 for a sphere that is pushed at
/// its surface, for pushes of several.
const TURN: f64 = 10.0;
/// How many radii a window may move a grain by the force or speed that is reported beside its motion.
const RADII: f64 = 1e9;

/// What else may be behind a broken bound, which looks as too long a step does, and which nobody but a test
/// of the solver can tell.
pub(super) const DOUBT: &str = "; or the dem solver, which is not ours, does fewer sub-steps than it reports: `bedload \
                                conformance --physics` tests it";

/// What is known of a grain after a window.
#[derive(Clone, Copy)]
struct Last {
    position: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
    /// Can it have touched something in the next window?
    near: bool,
}

/// By how much a grain has moved otherwise than its velocity says, since the first window, m, in windows in
/// which it touched nothing; and how far that may be.
#[derive(Clone, Copy, Default)]
struct Drift {
    way: [f64; 3],
    room: f64,
}

/// Checks the kinematics of a foreign DEM from window to window.
pub(super) struct KinematicsCheck {
    radii: Vec<f64>,
    masses: Vec<f64>,
    free: Vec<bool>,
    /// Bodies that are not round are not looked at for overlaps.
    round: Vec<bool>,
    walls: Vec<Wall>,
    /// Largest speed of a wall, m/s.
    wall_speed: f64,
    periods: [Option<f64>; 3],
    gravity: f64,
    diagonal: f64,
    /// What the last window left; empty where that is not known.
    last: Vec<Last>,
    drifts: Vec<Drift>,
}

impl KinematicsCheck {
    /// Of a run from its start, or from a checkpoint: then the first window shows where the grains are.
    pub(super) fn new(scene: &CheckedScene, resumed: bool) -> Self {
        let (domain, grains) = (&scene.scene.domain, &scene.grains);
        let at_start = |grain: &Grain| Last {
            position: grain.position,
            velocity: grain.velocity.start(),
            spin: grain.spin.start(),
            near: true,
        };
        Self {
            radii: grains.iter().map(|grain| grain.radius).collect(),
            masses: grains.iter().map(Grain::mass).collect(),
            free: grains.iter().map(|grain| grain.motion == Motion::Free).collect(),
            round: grains.iter().map(|grain| grain.shape.is_round()).collect(),
            walls: scene.contact_walls(),
            wall_speed: scene.wall_speed(f64::INFINITY),
            periods: domain.periods().map(|period| period.map(|(_, length)| length)),
            gravity: scene.scene.largest_gravity(),
            diagonal: diagonal(scene),
            last: if resumed { Vec::new() } else { grains.iter().map(at_start).collect() },
            drifts: vec![Drift::default(); grains.len()],
        }
    }

    /// Checks a window: every field possible, no grain further than its speeds let it come, none in another.
    pub(super) fn window(
        &mut self,
        window: &Window,
        header: &Header,
        loads: &[Loads],
        motion: &[Kinematics],
        forced: &[String],
    ) -> Result<(), Failure> {
        self.fields(window, header, motion)?;
        let fastest = self.fastest(motion);
        let (near, deepest) = self.surroundings(window, motion, fastest);
        self.moved(window, loads, motion, &near)?;
        self.turned(window, loads, motion, fastest)?;
        if !forced.iter().any(|name| name == "overlap")
            && let Some(deepest) = deepest
        {
            deepest.judge(window, header, fastest)?;
        }
        self.last.clear();
        self.last.extend(motion.iter().zip(near).map(|(grain, near)| Last {
            position: grain.position,
            velocity: grain.velocity,
            spin: grain.spin,
            near,
        }));
        Ok(())
    }

    /// Speed of the fastest surface, of grains before and after the window, spins as they were before, and
    /// walls.
    fn fastest(&self, motion: &[Kinematics]) -> f64 {
        let before = self
            .last
            .iter()
            .zip(&self.radii)
            .map(|(last, radius)| norm(&last.velocity) + radius * norm(&last.spin));
        let now = motion.iter().map(|grain| norm(&grain.velocity));
        before.chain(now).fold(self.wall_speed, f64::max)
    }

    /// What is reported beside the motion must be possible.
    fn fields(&self, window: &Window, header: &Header, motion: &[Kinematics]) -> Result<(), Failure> {
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let (deep, far) = (-self.diagonal - 2.0 * largest, FAR * self.diagonal);
        let is_gap = |gap: f64| gap >= deep && (gap <= far || gap == f64::INFINITY);
        let refuse = |what: String, allowed: String| {
            let (step, time) = (window.step, window.time);
            Err(Failure::Run(format!(
                "the dem solver sent {what} in window {step} (t = {time} s); allowed: {allowed}"
            )))
        };
        let gaps = || format!("{deep:.3e} to {far:.3e} m, infinite where nothing is near");
        if !is_gap(header.smallest_gap) {
            return refuse(format!("smallest_gap = {:?}", header.smallest_gap), gaps());
        }
        for (number, grain) in motion.iter().enumerate() {
            if !is_gap(grain.gap) {
                return refuse(format!("gap = {:?} of grain {number}", grain.gap), gaps());
            }
            let speed = RADII * self.radii[number] / window.dt;
            let force = self.masses[number] * speed / window.dt;
            for (field, of) in
                [("contact_force", grain.contact_force), ("lubrication_force", grain.lubrication_force)]
            {
                if norm(&of) > force {
                    return refuse(format!("{field} = {of:?} of grain {number}"), format!("{force:.3e} N"));
                }
            }
            for (field, of) in [("impact_speed", grain.impact_speed), ("rebound_speed", grain.rebound_speed)]
            {
                // A DEM may send the grain's own speed along the contact: of either sign.
                if of.is_nan() || of.abs() > speed {
                    return refuse(
                        format!("{field} = {of:?} of grain {number}"),
                        format!("at most {speed:.3e} m/s"),
                    );
                }
            }
        }
        Ok(())
    }

    fn moved(
        &mut self,
        window: &Window,
        loads: &[Loads],
        motion: &[Kinematics],
        near: &[bool],
    ) -> Result<(), Failure> {
        for (grain, now) in motion.iter().enumerate().filter(|(grain, _)| self.free[*grain]) {
            let Some(last) = self.last.get(grain).copied() else { return Ok(()) };
            let way = self.between(last.position, now.position);
            let speed = norm(&last.velocity).max(norm(&now.velocity));
            let pull = self.pull(grain, loads);
            let room = RESERVE * (speed + pull * window.dt) * window.dt + PUSH * self.radii[grain];
            if norm(&way) > room {
                return Err(Failure::Run(format!(
                    "the dem solver moved grain {grain} by {:.3e} m in window {} (t = {} s), where its \
                     speed, {speed:.3e} m/s at most at both ends, lets it move {room:.3e} m in {} s: its \
                     steps are too long, or it loses sub-steps; raise coupling.steps_per_contact, or mend \
                     the solver",
                    norm(&way),
                    window.step,
                    window.time,
                    window.dt
                )));
            }
            if last.near || near[grain] {
                continue;
            }
            let drift = &mut self.drifts[grain];
            for (axis, way) in way.into_iter().enumerate() {
                drift.way[axis] += way - 0.5 * (last.velocity[axis] + now.velocity[axis]) * window.dt;
            }
            drift.room +=
                norm(&std::array::from_fn(|axis| now.velocity[axis] - last.velocity[axis])) * window.dt;
            if norm(&drift.way) > drift.room + PUSH * self.radii[grain] {
                return Err(Failure::Run(format!(
                    "the dem solver sent places of grain {grain} that are {:.3e} m apart from where its \
                     velocities lead it, by window {} (t = {} s), although it touched nothing: allowed are \
                     {:.3e} m; mend the solver, which does not move grains by the velocity that it sends",
                    norm(&drift.way),
                    window.step,
                    window.time,
                    drift.room + PUSH * self.radii[grain]
                )));
            }
        }
        Ok(())
    }

    /// Acceleration by gravity and fluid, m/s².
    fn pull(&self, grain: usize, loads: &[Loads]) -> f64 {
        self.gravity + norm(&loads[grain].force) / self.masses[grain]
    }

    /// A spin changes by the fluid's torque and by contacts, which turn no faster than surfaces slide.
    fn turned(
        &self,
        window: &Window,
        loads: &[Loads],
        motion: &[Kinematics],
        fastest: f64,
    ) -> Result<(), Failure> {
        for (grain, now) in
            motion.iter().enumerate().filter(|(grain, _)| self.free[*grain] && self.round[*grain])
        {
            let Some(last) = self.last.get(grain) else { return Ok(()) };
            let (radius, mass, dt) = (self.radii[grain], self.masses[grain], window.dt);
            let change = norm(&std::array::from_fn(|axis| now.spin[axis] - last.spin[axis]));
            // I is at least 2/5 m R².
            let torque = 2.5 * norm(&loads[grain].torque) / (mass * radius * radius);
            let slides = (fastest + self.pull(grain, loads) * dt) / radius;
            let room = RESERVE * torque * dt + TURN * slides + PUSH / dt;
            if change > room {
                return Err(Failure::Run(format!(
                    "the dem solver changed the spin of grain {grain} by {change:.3e} rad/s in window {} (t \
                     = {} s), where the fluid's torque and contacts as fast as the fastest surface can \
                     change it by {room:.3e} rad/s: mend the solver",
                    window.step, window.time
                )));
            }
        }
        Ok(())
    }

    /// From one place to another, the short way round.
    fn between(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let way = to[axis] - from[axis];
            self.periods[axis].map_or(way, |period| way - period * (way / period).round())
        })
    }

    /// Which grains have something within a radius of the largest, so that they can touch it in the window
    /// before or after; and the deepest overlap of a free grain, where any is.
    fn surroundings(
        &self,
        window: &Window,
        motion: &[Kinematics],
        fastest: f64,
    ) -> (Vec<bool>, Option<Overlap>) {
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        // Shapes that are not round, and windows that lead further, are not judged.
        let all = 2.0 * RESERVE * fastest * window.dt > largest || !self.round.iter().all(|round| *round);
        let mut near = vec![all; motion.len()];
        let mut deepest: Option<Overlap> = None;
        let mut take = |grain: usize, gap: f64, radius: f64, other: &dyn Fn() -> String| {
            near[grain] |= gap < largest;
            let part = -gap / radius;
            if part > 0.0 && deepest.as_ref().is_none_or(|deepest| part > deepest.overlap / deepest.radius) {
                deepest = Some(Overlap { grain, overlap: -gap, radius, other: other() });
            }
        };
        let time = window.time + window.dt;
        let round = || motion.iter().enumerate().filter(|(grain, _)| self.round[*grain]);
        for (grain, now) in round().filter(|(grain, _)| self.free[*grain]) {
            for (number, wall) in
                self.walls.iter().enumerate().filter(|(_, wall)| wall.from <= time && time < wall.until)
            {
                let [point, normal] = wall.at(time);
                let height: f64 = (0..3).map(|c| normal[c] * (now.position[c] - point[c])).sum();
                let radius = self.radii[grain];
                // Where a servo has moved the wall, the DEM alone knows.
                let gap = if wall.servo.is_some() { 0.0 } else { height - radius };
                take(grain, gap, radius, &|| format!("wall {number}"));
            }
        }
        let size = 3.0 * largest;
        let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (grain, now) in round() {
            cells.entry(self.cell(now.position, size)).or_default().push(grain);
        }
        for (grain, now) in round().filter(|(grain, _)| self.free[*grain]) {
            let around = [-1, 0, 1].map(|x| [-1, 0, 1].map(|y| [-1, 0, 1].map(|z| [x, y, z])));
            for step in around.as_flattened().as_flattened() {
                let place: [f64; 3] = std::array::from_fn(|c| now.position[c] + step[c] as f64 * size);
                for other in cells.get(&self.cell(place, size)).into_iter().flatten() {
                    if *other != grain {
                        let distance = norm(&self.between(now.position, motion[*other].position));
                        let (a, b) = (self.radii[grain], self.radii[*other]);
                        take(grain, distance - a - b, a.min(b), &|| format!("grain {other}"));
                    }
                }
            }
        }
        (near, deepest)
    }

    /// Cell of a place, `size` wide or a little wider where a period is to hold whole cells.
    fn cell(&self, place: [f64; 3], size: f64) -> [i64; 3] {
        std::array::from_fn(|axis| match self.periods[axis] {
            None => (place[axis] / size).floor() as i64,
            Some(period) => {
                let count = (period / size).floor().max(1.0);
                let cell = (place[axis] / period * count).floor() as i64;
                cell.rem_euclid(count as i64)
            }
        })
    }
}

/// How deep a grain lies in another, or in a wall.
struct Overlap {
    grain: usize,
    overlap: f64,
    /// Of the smaller of the two, m.
    radius: f64,
    other: String,
}

impl Overlap {
    /// Against the bound, and against what the DEM reports.
    fn judge(&self, window: &Window, header: &Header, fastest: f64) -> Result<(), Failure> {
        let Self { grain, overlap, radius, other } = self;
        let (step, time) = (window.step, window.time);
        if *overlap > MOST_OVERLAP * radius {
            return Err(Failure::Run(format!(
                "bound overlap: grain {grain} lies {:.1} % of a radius deep in {other} after window {step} \
                 (t = {time} s), as the coupler finds from the places that the dem solver sent; at most \
                 {:.0} %: shorten the contact time, or --set 'coupling.force=[\"overlap\"]'{DOUBT}",
                100.0 * overlap / radius,
                100.0 * MOST_OVERLAP
            )));
        }
        let room = UNSEEN * radius + RESERVE * fastest * window.dt / window.substeps.max(1) as f64;
        if *overlap <= header.largest_overlap + room {
            return Ok(());
        }
        Err(Failure::Run(format!(
            "the dem solver sent largest_overlap = {} in the header of window {step} (t = {time} s), where \
             grain {grain} lies {overlap:.3e} m deep in {other} by the places that it sent: mend the solver",
            header.largest_overlap
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::two_grains;

    fn check() -> KinematicsCheck {
        KinematicsCheck::new(&two_grains(), false)
    }

    fn at(first: [f64; 3], speed: f64, second: [f64; 3]) -> [Kinematics; 2] {
        let grain = |position| Kinematics { position, velocity: [speed, 0.0, 0.0], ..Kinematics::default() };
        [grain(first), grain(second)]
    }

    fn checked(motion: &[Kinematics; 2]) -> Result<(), String> {
        checked_with(&Header { largest_overlap: 0.05, ..Header::default() }, motion)
    }

    const WINDOW: Window = Window { step: 3, attempt: 0, time: 0.3, dt: 0.1, substeps: 10, output: false };

    fn checked_with(header: &Header, motion: &[Kinematics; 2]) -> Result<(), String> {
        let loads = [Loads::default(); 2];
        check().window(&WINDOW, header, &loads, motion, &[]).map_err(|failure| failure.to_string())
    }

    /// How many windows pass in which the first grain is where `place` says, at 0.2 m/s along x.
    fn passes(place: impl Fn(f64) -> f64) -> usize {
        let mut check = check();
        (1..100)
            .take_while(|step| {
                let motion = at([place(0.02 * f64::from(*step)), 2.0, 2.0], 0.2, [7.0, 2.0, 2.0]);
                let motion = [motion[0], Kinematics { velocity: [0.0; 3], ..motion[1] }];
                check.window(&WINDOW, &Header::default(), &[Loads::default(); 2], &motion, &[]).is_ok()
            })
            .count()
    }

    #[test]
    fn places_that_leave_the_velocity_behind_are_found_window_by_window() {
        assert_eq!(passes(|way| 1.0 + way), 99, "as it says");
        assert!(passes(|_| 1.0) < 5, "it stands");
        assert!(passes(|way| 1.0 + 1.9 * way) < 5, "nearly twice as far, which one window allows");
        assert!(passes(|way| 1.0 + 1.05 * way) < 60, "a twentieth too far");
    }

    #[test]
    fn a_spin_is_held_against_the_torque() {
        let spun = |spin: f64| {
            let [first, second] = at([1.1, 2.0, 2.0], 1.0, [7.0, 2.0, 2.0]);
            checked(&[Kinematics { spin: [0.0, spin, 0.0], ..first }, second])
        };
        spun(20.0).expect("as a contact at 1 m/s may do it");
        let text = spun(50.0).expect_err("without a torque");
        assert!(text.contains("spin of grain 0") && text.contains("window 3"), "{text}");
    }

    #[test]
    fn what_cannot_be_is_refused_by_its_field() {
        let good = at([1.1, 2.0, 2.0], 1.0, [7.0, 2.0, 2.0]);
        let with = |change: &dyn Fn(&mut Kinematics)| {
            let mut motion = good;
            change(&mut motion[1]);
            checked(&motion)
        };
        with(&|grain| grain.gap = f64::INFINITY).expect("nothing is near");
        for (field, change) in [
            (
                "gap = -inf of grain 1",
                &(|grain: &mut Kinematics| grain.gap = f64::NEG_INFINITY) as &dyn Fn(&mut Kinematics),
            ),
            ("gap = -1e300", &|grain: &mut Kinematics| grain.gap = -1e300),
            ("gap = 1e308", &|grain: &mut Kinematics| grain.gap = 1e308),
            ("contact_force = [", &|grain: &mut Kinematics| grain.contact_force[1] = 1e300),
            ("lubrication_force = [", &|grain: &mut Kinematics| grain.lubrication_force[1] = -1e300),
            ("impact_speed = -1e300", &|grain: &mut Kinematics| grain.impact_speed = -1e300),
            ("rebound_speed = 1e300", &|grain: &mut Kinematics| grain.rebound_speed = 1e300),
        ] {
            let text = with(change).expect_err(field);
            assert!(text.contains(field) && text.contains("window 3"), "{field}: {text}");
        }
        for smallest_gap in [f64::NEG_INFINITY, 1e308] {
            let text =
                checked_with(&Header { smallest_gap, ..Header::default() }, &good).expect_err("no gap");
            assert!(text.contains("smallest_gap = "), "{text}");
        }
        let deep = Overlap { grain: 0, overlap: 0.04, radius: 0.5, other: "grain 1".into() };
        deep.judge(&WINDOW, &Header { largest_overlap: 0.03, ..Header::default() }, 0.5)
            .expect("nearly seen");
        deep.judge(&WINDOW, &Header::default(), 10.0).expect("one sub-step may lead so deep");
        let text = deep.judge(&WINDOW, &Header::default(), 0.5).expect_err("8 % of a radius").to_string();
        assert!(text.contains("largest_overlap = 0"), "{text}");
    }

    #[test]
    fn a_grain_moves_no_further_than_its_speed() {
        checked(&at([1.1, 2.0, 2.0], 1.0, [7.0, 2.0, 2.0])).expect("as fast as it says");
        let text = checked(&at([2.0, 2.0, 2.0], 1.0, [7.0, 2.0, 2.0])).expect_err("ten times as far");
        assert!(text.contains("grain 0") && text.contains("window 3"), "{text}");
        // Round the period: from 7 to 0.05 is a short way.
        checked(&at([1.0, 2.0, 2.0], 5.0, [7.95, 2.0, 2.0])).expect("0.95 at 5 m/s, twice");
    }

    #[test]
    fn overlaps_are_found_among_grains_and_with_walls() {
        let text = checked(&at([1.0, 2.0, 0.4], 10.0, [7.0, 2.0, 2.0])).expect_err("in the floor");
        assert!(text.contains("bound overlap") && text.contains("wall"), "{text}");
        // Across the period: centres 0.9 apart.
        let text = checked(&at([0.1, 2.0, 2.0], 10.0, [7.2, 2.0, 2.0])).expect_err("in each other");
        assert!(text.contains("grain 1") && text.contains("fewer sub-steps"), "{text}");
        checked(&at([0.1, 2.0, 2.0], 10.0, [7.13, 2.0, 2.0])).expect("6 % of a radius");
    }
}
