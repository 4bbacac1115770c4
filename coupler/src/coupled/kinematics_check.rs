//! Positions, speeds and overlaps of a foreign DEM, computed by the coupler from the kinematics that the DEM
//! sends.
//!
//! Tests hold our own DEM to the same limits; a foreign one may report any number of sub-steps.

use std::collections::HashMap;

use bedload_scene::{CheckedScene, Motion, Wall};
use protocol::message::{Kinematics, Loads};
use protocol::participant::Window;

use crate::bounds::MOST_OVERLAP;
use crate::failure::Failure;
use crate::number::norm;

/// By how much a grain may move further than its speeds and its acceleration let it, of its radius: contacts
/// of the overlap that is allowed push it out.
const PUSH: f64 = MOST_OVERLAP;
/// Reserve on the way that the speeds at both ends of a window stand for: a contact within it may be faster.
const RESERVE: f64 = 2.0;

/// Checks the kinematics of a foreign DEM from window to window.
pub(super) struct KinematicsCheck {
    radii: Vec<f64>,
    masses: Vec<f64>,
    free: Vec<bool>,
    /// Bodies that are not round are not looked at for overlaps.
    round: Vec<bool>,
    walls: Vec<Wall>,
    periods: [Option<f64>; 3],
    gravity: f64,
    /// Places and velocities after the last window; empty where they are not known.
    last: Vec<([f64; 3], [f64; 3])>,
}

impl KinematicsCheck {
    /// Of a run from its start, or from a checkpoint: then the first window shows where the grains are.
    pub(super) fn new(scene: &CheckedScene, resumed: bool) -> Self {
        let (domain, grains) = (&scene.scene.domain, &scene.grains);
        let mut periods = [None; 3];
        for axis in (0..domain.dimensions()).filter(|axis| domain.is_periodic(*axis)) {
            periods[domain.geometry.component(axis)] = Some(domain.upper[axis] - domain.lower[axis]);
        }
        Self {
            radii: grains.iter().map(|grain| grain.radius).collect(),
            masses: grains.iter().map(bedload_scene::Grain::mass).collect(),
            free: grains.iter().map(|grain| grain.motion == Motion::Free).collect(),
            round: grains.iter().map(|grain| grain.shape.is_round()).collect(),
            walls: scene.contact_walls(),
            periods,
            gravity: norm(&scene.scene.gravity),
            last: if resumed {
                Vec::new()
            } else {
                grains.iter().map(|grain| (grain.position, grain.velocity)).collect()
            },
        }
    }

    /// Checks a window: no grain further than its speeds let it come, none in another.
    ///
    /// # Errors
    /// [`Failure::Run`] naming grain, window and both numbers.
    pub(super) fn window(
        &mut self,
        window: &Window,
        loads: &[Loads],
        motion: &[Kinematics],
        forced: &[String],
    ) -> Result<(), Failure> {
        self.moved(window, loads, motion)?;
        if !forced.iter().any(|name| name == "overlap") {
            self.overlaps(window, motion)?;
        }
        self.last.clear();
        self.last.extend(motion.iter().map(|grain| (grain.position, grain.velocity)));
        Ok(())
    }

    fn moved(&self, window: &Window, loads: &[Loads], motion: &[Kinematics]) -> Result<(), Failure> {
        for (grain, now) in motion.iter().enumerate().filter(|(grain, _)| self.free[*grain]) {
            let Some((from, before)) = self.last.get(grain).copied() else { return Ok(()) };
            let way = norm(&self.between(from, now.position));
            let speed = norm(&before).max(norm(&now.velocity));
            let pull = self.gravity + norm(&loads[grain].force) / self.masses[grain];
            let room = RESERVE * (speed + pull * window.dt) * window.dt + PUSH * self.radii[grain];
            if way > room {
                return Err(Failure::Run(format!(
                    "the dem solver moved grain {grain} by {way:.3e} m in window {} (t = {} s), where its speed, {speed:.3e} \
                     m/s at most at both ends, lets it move {room:.3e} m in {} s: its steps are too long, or it loses \
                     sub-steps; raise coupling.steps_per_contact, or mend the solver",
                    window.step, window.time, window.dt
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

    fn overlaps(&self, window: &Window, motion: &[Kinematics]) -> Result<(), Failure> {
        let deep = |grain: usize, overlap: f64, radius: f64, other: &str| {
            if overlap <= MOST_OVERLAP * radius {
                return Ok(());
            }
            Err(Failure::Run(format!(
                "bound overlap: grain {grain} lies {:.1} % of a radius deep in {other} after window {} (t = {} s), as the coupler \
                 finds from the places that the dem solver sent; at most {:.0} %: shorten the contact time, or --set \
                 'coupling.force=[\"overlap\"]'",
                100.0 * overlap / radius,
                window.step,
                window.time,
                100.0 * MOST_OVERLAP
            )))
        };
        let time = window.time + window.dt;
        for (grain, now) in
            motion.iter().enumerate().filter(|(grain, _)| self.free[*grain] && self.round[*grain])
        {
            for (number, wall) in
                self.walls.iter().enumerate().filter(|(_, wall)| wall.from <= time && time < wall.until)
            {
                let normal = norm(&wall.normal);
                let height: f64 = (0..3)
                    .map(|c| {
                        wall.normal[c] / normal * (now.position[c] - wall.point[c] - wall.velocity[c] * time)
                    })
                    .sum();
                deep(grain, self.radii[grain] - height, self.radii[grain], &format!("wall {number}"))?;
            }
        }
        let size = 2.0 * self.radii.iter().copied().fold(0.0, f64::max);
        let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (grain, now) in motion.iter().enumerate().filter(|(grain, _)| self.round[*grain]) {
            cells.entry(self.cell(now.position, size)).or_default().push(grain);
        }
        for (grain, now) in
            motion.iter().enumerate().filter(|(grain, _)| self.free[*grain] && self.round[*grain])
        {
            let near = [-1, 0, 1].map(|x| [-1, 0, 1].map(|y| [-1, 0, 1].map(|z| [x, y, z])));
            for step in near.as_flattened().as_flattened() {
                let place: [f64; 3] = std::array::from_fn(|c| now.position[c] + step[c] as f64 * size);
                for other in cells.get(&self.cell(place, size)).into_iter().flatten() {
                    if *other != grain {
                        let distance = norm(&self.between(now.position, motion[*other].position));
                        let (a, b) = (self.radii[grain], self.radii[*other]);
                        deep(grain, a + b - distance, a.min(b), &format!("grain {other}"))?;
                    }
                }
            }
        }
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::SceneSource;

    fn check() -> KinematicsCheck {
        let text = "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [8, 4, 4]\n\
                    boundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }\n\
                    [[grains]]\nposition = [1, 2, 2]\nradius = 0.5\ndensity = 2.0\n\
                    [[grains]]\nposition = [7, 2, 2]\nradius = 0.5\ndensity = 2.0\n";
        let scene =
            CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).expect("a scene");
        KinematicsCheck::new(&scene, false)
    }

    fn at(first: [f64; 3], speed: f64, second: [f64; 3]) -> [Kinematics; 2] {
        let grain = |position| Kinematics { position, velocity: [speed, 0.0, 0.0], ..Kinematics::default() };
        [grain(first), grain(second)]
    }

    fn checked(motion: &[Kinematics; 2]) -> Result<(), String> {
        let window = Window { step: 3, attempt: 0, time: 0.3, dt: 0.1, substeps: 10, output: false };
        check().window(&window, &[Loads::default(); 2], motion, &[]).map_err(|failure| failure.to_string())
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
        assert!(text.contains("grain 1"), "{text}");
        checked(&at([0.1, 2.0, 2.0], 10.0, [7.13, 2.0, 2.0])).expect("6 % of a radius");
    }
}
