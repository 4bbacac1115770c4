//! Grains that leave the box through a face that is no wall: told when it happens, and at the end.

use bedload_scene::CheckedScene;

use crate::grains::Grains;
use crate::motion::Vec3;

/// Grains named one by one; the rest is counted.
const NAMED: usize = 5;

/// Watches for grains outside the box.
pub(crate) struct Outside {
    /// Lower and upper limit of each component; infinite where a face is periodic or there is none.
    limits: [(f64, f64); 3],
    /// Whether each grain was outside when last looked.
    is_out: Vec<bool>,
    named: usize,
}

impl Outside {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let domain = &scene.scene.domain;
        let mut limits = [(f64::NEG_INFINITY, f64::INFINITY); 3];
        for axis in (0..domain.dimensions()).filter(|axis| !domain.is_periodic(*axis)) {
            limits[domain.geometry.component(axis)] = (domain.lower[axis], domain.upper[axis]);
        }
        Self { limits, is_out: vec![false; scene.grains.len()], named: 0 }
    }

    fn is_inside(&self, x: &Vec3) -> bool {
        self.limits.iter().zip(x.iter()).all(|((lower, upper), x)| (lower..=upper).contains(&x))
    }

    /// Names grains that have left since the last look; `step` and `time` are of the window's end.
    pub(crate) fn look(&mut self, grains: &Grains, step: u64, time: f64) {
        for i in 0..grains.len() {
            let (x, v) = (grains.position[i], grains.velocity[i]);
            let out = !self.is_inside(&x);
            if out && !self.is_out[i] {
                self.named += 1;
                if self.named <= NAMED {
                    protocol::say!(
                        "bedload-dem: warning: grain {i} left the box in window {step} (t = {time} s): it is at \
                         {:?} m with {:?} m/s; put a wall there, or make the box larger",
                        <[f64; 3]>::from(x),
                        <[f64; 3]>::from(v)
                    );
                } else if self.named == NAMED + 1 {
                    protocol::say!("bedload-dem: warning: more grains leave; the end of the run counts them");
                }
            }
            self.is_out[i] = out;
        }
    }

    /// Says how many are outside.
    pub(crate) fn sum_up(&self) {
        let count = self.is_out.iter().filter(|out| **out).count();
        if count > 0 {
            protocol::say!("bedload-dem: warning: {count} grain(s) are outside the box at the end");
        }
    }
}
