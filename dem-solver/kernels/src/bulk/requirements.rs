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
    if spec.grains.is_empty() {
        return Some("there are no grains".to_owned());
    }
    if let Some(i) = spec.grains.iter().position(|grain| grain.outline.is_some()) {
        return Some(format!("grain {i} is not round"));
    }
    if spec.integrator != Integrator::SymplecticEuler {
        return Some("the integrator is not symplectic-euler".to_owned());
    }
    if spec.lubrication.settings().is_some() {
        return Some("there is a lubrication film".to_owned());
    }
    if spec.energy {
        return Some("an account of energy is asked for".to_owned());
    }
    if spec.split {
        return Some("forces are asked for in each sub-step (observe.substeps)".to_owned());
    }
    if spec.contact.rolling().is_some() {
        return Some("there is a resistance to rolling".to_owned());
    }
    if !matches!(spec.contact.pair(), PairLaw::Linear(_)) {
        return Some("the contact law is not linear-spring-dashpot with a contact time".to_owned());
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
