//! Grains that leave the box through a face that is no wall: told when it happens, and at the end.

use bedload_scene::{CheckedScene, Domain};

use crate::grains::Grains;

/// Grains named one by one; the rest is counted.
const NAMED: usize = 5;

pub(crate) struct Outside {
    domain: Domain,
    /// What becomes of them.
    advice: &'static str,
    /// Whether each grain was outside when last looked.
    is_out: Vec<bool>,
    named: usize,
}

impl Outside {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let advice = if scene.scene.medium.is_some() {
            "out as a whole it keeps its velocity, and the fluid does not feel it"
        } else {
            "put a wall there, or make the box larger"
        };
        let (domain, is_out) = (scene.scene.domain.clone(), vec![false; scene.grains.len()]);
        Self { domain, advice, is_out, named: 0 }
    }

    /// Names grains that have left since the last look; `step` and `time` are of the window's end.
    pub(crate) fn look(&mut self, grains: &Grains, step: u64, time: f64) {
        for i in 0..grains.len() {
            let (x, v) = (grains.position[i], grains.velocity[i]);
            let out = !self.domain.holds(&x.into());
            if out && !self.is_out[i] {
                self.named += 1;
                if self.named <= NAMED {
                    protocol::say!(
                        "bedload-dem: warning: grain {i} left the box in window {step} (t = {time} s): it is \
                         at \
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
        let is_out: Vec<bool> = grains.position.iter().map(|x| !self.domain.holds(&(*x).into())).collect();
        let count = is_out.iter().filter(|out| **out).count();
        if count > 0 {
            protocol::say!(
                "bedload-dem: warning: {count} grain(s) are outside the box at the end, and not in grains.csv"
            );
        }
        is_out
    }
}
