//! Which scenes the engine takes, and which engine `auto` takes.

use crate::bulk::materials;
use crate::grain::Grain;
use crate::motion::Motion;
use crate::spec::{DemSpec, Engine, Integrator};

/// Number of grains from which the engine is chosen by itself.
pub(crate) const FROM: usize = 256;

/// An engine, and why it was taken.
pub(crate) struct Choice {
    pub(crate) engine: Engine,
    pub(crate) why: String,
}

/// The engine of a checked spec.
pub(crate) fn choice(spec: &DemSpec) -> Choice {
    let (engine, why) = match spec.engine {
        Engine::Auto => match spec.grains.len() {
            few if few < FROM => (Engine::General, format!("the number of grains, {few}, is below {FROM}")),
            many => match prevents(spec) {
                Some(why) => (Engine::General, why),
                None => (Engine::Bulk, format!("there are {many} grains in linear contact")),
            },
        },
        asked => (asked, "the scene asks for it".to_owned()),
    };
    Choice { engine, why }
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
    let laws = spec.laws();
    let used = materials::used(&spec.grains);
    if used.len() > materials::MOST {
        return Some(format!("grains have {} materials, more than {}", used.len(), materials::MOST));
    }
    if laws.any_rolling() {
        return Some("there is a resistance to rolling".to_owned());
    }
    let linear = |a: &usize, b: usize| laws.linear(*a, b).is_some();
    if !used.iter().all(|a| used.iter().all(|b| linear(a, *b))) {
        return Some("the contact law is not linear-spring-dashpot with a contact time".to_owned());
    }
    if materials::between(&used, &laws).is_none() {
        return Some("contact laws differ in sliding or in the lever arm".to_owned());
    }
    if let Some(w) = spec.walls.iter().position(|wall| !used.iter().all(|a| linear(a, wall.material))) {
        return Some(format!("the contact law of wall {w} is not linear-spring-dashpot with a contact time"));
    }
    if let Some(w) =
        spec.walls.iter().position(|wall| materials::at_wall(&used, wall.material, &laws).is_none())
    {
        return Some(format!("contact laws of wall {w} differ in sliding or in the lever arm"));
    }
    if spec.walls.len() > usize::from(u16::MAX) {
        return Some(format!("there are {} walls", spec.walls.len()));
    }
    let only_turns = |grain: &Grain| {
        grain.motion == Motion::Free
            && grain.free.translation == [false; 3]
            && grain.free.rotation != [false; 3]
    };
    spec.grains.iter().position(only_turns).map(|i| format!("grain {i} may turn but not move"))
}
