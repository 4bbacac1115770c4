//! What contacts take out of the motion, told apart: dashpots along the normal and the tangent, sliding.
//!
//! Together with the kinetic energy, the energy of the springs ([`crate::Dem::elastic_energy`]) and that of
//! gravity the sum is constant but for the error of the sub-step: an account that each part of the law
//! must settle by its own formula.
//!
//! - Dashpots: −F_d·v over both halves of each kick, v the mean of the velocities before and after it: the
//!   work that they really did in the discrete motion.
//! - Sliding: the slip Δp that cutting the spring back takes from it, times the mean of the spring's force
//!   before and after, ½ k_t (δ + δ′)·Δp, and the work of the tangential dashpot meanwhile: the cut leaves a
//!   spring that bears what the dashpot does not, so that only their sum is that of the friction.
//! - A contact that ends: F_n reaches zero before the overlap does, and the normal spring then gives what
//!   is left to its own dashpot; what is left in the tangential spring counts as sliding. Half of the last
//!   step's part is in the kicks already, hence ½ k δ δ′ with the values before and after it.
//!   So are contacts with a wall that vanishes.
//!
//! Kept by the general engine for linear contacts only, and only where asked for. Work of walls and grains
//! that are moved from outside is no part of it.

use crate::general::contact::{Frame, Partners};
use crate::grains::Grains;
use crate::laws::coefficients::LinearPair;
use crate::motion::Vec3;
use crate::report::Dissipated;
use crate::spec::{DemSpec, Integrator};

/// What keeps a checked spec from having an account; none if nothing does.
pub(crate) fn prevents(spec: &DemSpec) -> Option<&'static str> {
    let reason = if spec.contact.linear().is_none_or(|law| law.rolling.is_some()) {
        "an account of energy knows linear-spring-dashpot without rolling only; leave observe.energy out"
    } else if spec.has_bodies() {
        "an account of energy knows discs and spheres only; leave observe.energy out"
    } else if spec.integrator == Integrator::Rk3 {
        "an account of energy needs symplectic-euler or velocity-verlet; leave observe.energy out"
    } else if spec.lubrication.settings().is_some() {
        "an account of energy knows no lubrication; leave observe.energy out"
    } else {
        return None;
    };
    Some(reason)
}

/// The dashpots of one contact at one evaluation.
#[derive(Clone, Copy, Debug)]
struct Dashpots {
    partners: Partners,
    normal: Vec3,
    arms: (f64, f64),
    /// Force on the first partner along the normal, N.
    along: f64,
    /// Force on it in the contact plane, N.
    across: Vec3,
    slides: bool,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Account {
    pub(crate) lost: Dissipated,
    dashpots: Vec<Dashpots>,
    before: (Vec<Vec3>, Vec<Vec3>),
}

impl Account {
    /// Begins an evaluation of all contacts.
    pub(crate) fn clear(&mut self) {
        self.dashpots.clear();
    }

    /// Takes a contact that was evaluated: δ_t before, turned into the present plane, slip and growth of the
    /// gap in the step, m; δ_t after, m; the force on the first partner, and its tangential part, N.
    pub(crate) fn enter(
        &mut self,
        frame: &Frame,
        law: &LinearPair,
        (carried, slip, opened): (Vec3, Vec3, f64),
        spring: Vec3,
        (force, tangential): (Vec3, Vec3),
    ) {
        let (normal, gap) = (frame.near.normal, frame.near.gap);
        let (k_n, k_t) = (frame.mass * law.stiffness, frame.mass * law.tangential_stiffness);
        if force == Vec3::zeros() {
            if !frame.begins {
                self.lost.normal += 0.5 * k_n * gap * (gap - opened);
                self.lost.sliding += 0.5 * k_t * carried.dot(&(carried + slip));
            }
            return;
        }
        let cut = carried + slip - spring;
        self.lost.sliding += 0.5 * k_t * (carried + spring).dot(&cut);
        self.dashpots.push(Dashpots {
            partners: frame.near.partners,
            normal,
            arms: frame.arms,
            along: (force - tangential).dot(&normal) + k_n * gap,
            across: tangential + spring * k_t,
            slides: cut.norm_squared() > 1e-24 * spring.norm_squared(),
        });
    }

    /// Keeps the velocities before a kick.
    pub(crate) fn before_kick(&mut self, grains: &Grains) {
        self.before.0.clone_from(&grains.velocity);
        self.before.1.clone_from(&grains.spin);
    }

    /// Work of the dashpots in a kick of `h` that is just done.
    pub(crate) fn after_kick(&mut self, h: f64, grains: &Grains) {
        for dashpots in &self.dashpots {
            for (velocity, spin) in [(&self.before.0, &self.before.1), (&grains.velocity, &grains.spin)] {
                let relative = dashpots.partners.relative(velocity, spin);
                let slip = relative.slip(&dashpots.normal, dashpots.arms);
                self.lost.normal -= 0.5 * h * dashpots.along * relative.velocity.dot(&dashpots.normal);
                let across = 0.5 * h * dashpots.across.dot(&slip);
                *(if dashpots.slides { &mut self.lost.sliding } else { &mut self.lost.tangential }) -= across;
            }
        }
    }
}
