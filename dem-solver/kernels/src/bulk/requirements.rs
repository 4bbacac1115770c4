//! Which scenes the engine takes, and which engine `auto` takes.

use crate::grain::Grain;
use crate::laws::table::PairLaw;
use crate::motion::Motion;
use crate::spec::{DemSpec, Engine, Integrator};

/// Number of grains from which the engine is chosen by itself.
const FROM: usize = 256;

/// Whether a checked spec is run by this engine.
#[must_use]
pub fn takes(spec: &DemSpec) -> bool {
    match spec.engine {
        Engine::Auto => spec.grains.len() >= FROM && prevents(spec).is_none(),
        asked => asked == Engine::Bulk,
    }
}

/// What keeps the engine from a checked spec; none if nothing does.
pub(crate) fn prevents(spec: &DemSpec) -> Option<String> {
    if let Some(i) = spec.grains.iter().position(|grain| grain.outline.is_some()) {
        return Some(format!("grain {i} is not round"));
    }
    let linear = matches!(spec.contact.pair(), PairLaw::Linear(_));
    let reasons = [
        (spec.grains.is_empty(), "there are no grains"),
        (spec.integrator != Integrator::SymplecticEuler, "the integrator is not symplectic-euler"),
        (spec.lubrication.settings().is_some(), "there is a lubrication film"),
        (spec.energy, "an account of energy is asked for"),
        (spec.split, "forces are asked for in each sub-step (observe.substeps)"),
        (spec.contact.rolling().is_some(), "there is a resistance to rolling"),
        (!linear, "the contact law is not linear-spring-dashpot with a contact time"),
    ];
    if let Some((_, reason)) = reasons.into_iter().find(|(holds, _)| *holds) {
        return Some(reason.to_owned());
    }
    if spec.walls.len() > usize::from(u16::MAX) {
        return Some(format!("there are {} walls", spec.walls.len()));
    }
    if let Some(w) = spec.walls.iter().position(|wall| wall.servo.is_some() || !wall.spin.is_zero()) {
        return Some(format!("wall {w} turns or follows a pressure"));
    }
    let only_turns = |grain: &Grain| {
        grain.motion == Motion::Free
            && grain.free.translation == [false; 3]
            && grain.free.rotation != [false; 3]
    };
    spec.grains.iter().position(only_turns).map(|i| format!("grain {i} may turn but not move"))
}
