//! One time step as a list of stages, planned before it begins.
//!
//! What a stage need not do stands here as data: an engine that does several parts of the step in one
//! sweep over its planes takes the correction of the stage before into its predictor, and the
//! divergence into predictor or viscosity.

use crate::scheme::{Options, Scheme, Stage, Viscous};

/// Most stages of a scheme.
const MAX_STAGES: usize = 3;

/// One projection: ∇²φ = ∇·u*/duration, u = u* − duration ∇φ, p += φ − viscosity ∇·u*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureUpdate {
    /// Time over which φ acts, s.
    pub(crate) duration: f64,
    /// What multiplies ∇·u* in the pressure, m²/s: ½ ν where viscosity is implicit, else 0.
    pub(crate) viscosity: f64,
}

/// One stage: its coefficients, and what of it is done elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedStage {
    /// Number of the stage, from 0.
    pub(crate) number: usize,
    /// γ, ζ and α.
    pub(crate) coefficients: Stage,
    /// Length of the whole step, s.
    pub(crate) dt: f64,
    /// Whether the halos must be filled before the predictor: neither a projection nor the engine did.
    pub(crate) fills_halos: bool,
    /// The projection of the stage before, of which the predictor's sweep does the correction.
    pub(crate) corrects: Option<PressureUpdate>,
    /// Whether a later stage or step reads N.
    pub(crate) keeps_n: bool,
    /// Whether the terms near grains are computed before it, from a velocity that is complete.
    pub(crate) refreshes_near: bool,
    /// The projection that ends the stage; none where the caller projects.
    pub(crate) projection: Option<PressureUpdate>,
    /// Whether the divergence of that projection is done in the sweep of predictor or viscosity.
    pub(crate) fuses_divergence: bool,
    /// Whether its correction is left to the predictor of the next stage.
    pub(crate) defers_correction: bool,
}

impl PlannedStage {
    /// Length of the stage, 2 α dt, s.
    pub(crate) fn length(&self) -> f64 {
        2.0 * self.coefficients.alpha * self.dt
    }

    /// α ν dt: half of what viscosity `nu` does in the stage, m².
    pub(crate) fn diffusion(&self, nu: f64) -> f64 {
        self.coefficients.alpha * nu * self.dt
    }
}

/// What the engine and the boundaries let a plan put in one sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sweeps {
    /// Every part by itself; halos are filled before each predictor that follows no projection.
    Apart,
    /// Every part by itself; the engine fills halos as it goes.
    ApartFilled,
    /// Parts of neighbouring stages together; the engine fills halos as it goes.
    Fused,
}

/// Who ends the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LastProjection {
    /// The plan.
    Planned,
    /// The caller, who may change the velocity before.
    LeftToCaller,
}

/// The stages of one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPlan {
    stages: [PlannedStage; MAX_STAGES],
    count: usize,
    /// The projection that is left to the caller.
    pub(crate) left: Option<PressureUpdate>,
}

impl StepPlan {
    /// Plans a step of length `dt` (s) after one of length `previous` (zero: there was none). `near`: with
    /// terms near grains. The second of three stages takes those of the first: with the third one's own they
    /// are of second order all the same, as 3/4 of its weight at 2/3 of the step is 1/2.
    pub(crate) fn new<const D: usize>(
        options: &Options<D>,
        [dt, previous]: [f64; 2],
        sweeps: Sweeps,
        near: bool,
        end: LastProjection,
    ) -> Self {
        let (scheme, count) = (options.scheme, options.scheme.stages());
        let fused = sweeps == Sweeps::Fused;
        let nu = if options.viscous == Viscous::Implicit { options.viscosity } else { 0.0 };
        let update = |stage: Stage| {
            let part = 2.0 * stage.alpha;
            PressureUpdate { duration: part * dt, viscosity: nu * stage.alpha / part }
        };
        let refreshes = |number: usize| near && number != 1;
        let planned = |number: usize| {
            let coefficients = scheme.stage(number, dt, previous);
            let last = number + 1 == count;
            let projects = !last || end == LastProjection::Planned;
            PlannedStage {
                number,
                coefficients,
                dt,
                fills_halos: sweeps == Sweeps::Apart && number == 0,
                refreshes_near: refreshes(number),
                corrects: None,
                keeps_n: !last || scheme == Scheme::AdamsBashforth2,
                projection: projects.then(|| update(coefficients)),
                fuses_divergence: fused && projects,
                defers_correction: fused && projects && !last && !refreshes(number + 1),
            }
        };
        let mut stages = std::array::from_fn(|number| planned(number.min(count - 1)));
        for number in 1..count {
            stages[number].corrects =
                stages[number - 1].projection.filter(|_| stages[number - 1].defers_correction);
        }
        let left = (end == LastProjection::LeftToCaller).then(|| update(stages[count - 1].coefficients));
        Self { stages, count, left }
    }

    pub(crate) fn stages(&self) -> &[PlannedStage] {
        &self.stages[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVERY: Scheme = Scheme::RungeKutta3;
    const CHEAP: Scheme = Scheme::AdamsBashforth2;

    fn plan(scheme: Scheme, sweeps: Sweeps, near: bool, end: LastProjection) -> StepPlan {
        let options = Options {
            viscosity: 0.1,
            scheme,
            viscous: Viscous::Implicit,
            convection: true,
            body_force: [0.0; 3],
        };
        StepPlan::new(&options, [0.5, 0.0], sweeps, near, end)
    }

    /// Whatever is fused: every scheme projects over the length of the step in all, each projection is
    /// corrected once, and what the caller is left with is the last one.
    #[test]
    fn every_projection_is_done_once() {
        for (scheme, count) in [(EVERY, 3), (CHEAP, 1)] {
            let ways =
                [Sweeps::Apart, Sweeps::ApartFilled, Sweeps::Fused].map(|way| [(way, false), (way, true)]);
            for (sweeps, near) in ways.into_iter().flatten() {
                for end in [LastProjection::Planned, LastProjection::LeftToCaller] {
                    let plan = plan(scheme, sweeps, near, end);
                    let of_stages = plan.stages().iter().filter_map(|stage| stage.projection);
                    let updates: Vec<_> = of_stages.chain(plan.left).collect();
                    assert_eq!(updates.len(), count, "{scheme:?} {sweeps:?} {end:?}");
                    let total: f64 = updates.iter().map(|update| update.duration).sum();
                    assert!((total - 0.5).abs() < 1e-15, "{scheme:?}: {total}");
                    let deferred = plan.stages().iter().filter(|stage| stage.defers_correction).count();
                    let taken = plan.stages().iter().filter(|stage| stage.corrects.is_some()).count();
                    assert_eq!(deferred, taken, "{scheme:?} {sweeps:?} {end:?}");
                    assert!(sweeps == Sweeps::Fused || deferred == 0);
                    // What is computed from a velocity finds it complete.
                    let complete = |stage: &PlannedStage| !stage.refreshes_near || stage.corrects.is_none();
                    assert!(plan.stages().iter().all(complete), "{scheme:?} {sweeps:?} {end:?}");
                    assert_eq!(plan.stages().iter().any(|stage| stage.refreshes_near), near);
                }
            }
        }
    }

    #[test]
    fn halos_are_filled_where_nothing_else_does() {
        let fills = |scheme, sweeps| {
            let plan = plan(scheme, sweeps, false, LastProjection::Planned);
            plan.stages().iter().map(|stage| stage.fills_halos).collect::<Vec<_>>()
        };
        assert_eq!(fills(EVERY, Sweeps::Apart), [true, false, false]);
        assert_eq!(fills(CHEAP, Sweeps::Apart), [true]);
        assert_eq!(fills(EVERY, Sweeps::Fused), [false; 3]);
    }
}
