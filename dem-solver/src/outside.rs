//! Grains that leave the box through a face that is no wall: told when it happens, and at the end.

use bedload_scene::CheckedScene;

use crate::grains::Grains;
use crate::motion::Vec3;

/// Grains named one by one; the rest is counted.
const NAMED: usize = 5;

/// Watches for grains outside the box.
pub(crate) struct Outside {
    /// Lower and upper limit of each component; infinite where a face is periodic or there is none.
    limits: [[f64; 2]; 3],
    /// What becomes of them.
    advice: &'static str,
    /// Whether each grain was outside when last looked.
    is_out: Vec<bool>,
    named: usize,
}

impl Outside {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let limits = scene.scene.domain.limits();
        let advice = if scene.scene.medium.is_some() {
            "out as a whole it keeps its velocity, and the fluid does not feel it"
        } else {
            "put a wall there, or make the box larger"
        };
        Self { limits, advice, is_out: vec![false; scene.grains.len()], named: 0 }
    }

    fn is_inside(&self, x: &Vec3) -> bool {
        self.limits.iter().zip(x.iter()).all(|([lower, upper], x)| (lower..=upper).contains(&x))
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
                         {:?} m with {:?} m/s; {}",
                        <[f64; 3]>::from(x),
                        <[f64; 3]>::from(v),
                        self.advice
                    );
                } else if self.named == NAMED + 1 {
                    protocol::say!("bedload-dem: warning: more grains leave; the end of the run counts them");
                }
            }
            self.is_out[i] = out;
        }
    }

    /// Whether each grain is outside at the end; says how many are.
    pub(crate) fn sum_up(&self, grains: &Grains) -> Vec<bool> {
        let is_out: Vec<bool> = grains.position.iter().map(|x| !self.is_inside(x)).collect();
        let count = is_out.iter().filter(|out| **out).count();
        if count > 0 {
            protocol::say!(
                "bedload-dem: warning: {count} grain(s) are outside the box at the end, and not in grains.csv"
            );
        }
        is_out
    }
}
