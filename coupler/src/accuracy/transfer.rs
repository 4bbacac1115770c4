//! A setting of a chart, transferred to another scene.

use bedload_scene::CheckedScene;

use super::charted::Run;
use super::class::Class;
use crate::keys;
use crate::resolution::{self, fast};

/// Sections whose varied keys are transferred as they are.
const METHOD: [&str; 3] = ["fluid.", "dem.", "coupling."];

/// What is none the less not: the time step has a unit of its own, contacts and films are the material's.
const NOT_METHOD: [&str; 3] = [keys::FLUID_DT, keys::CONTACT, keys::LUBRICATION];

/// `KEY=VALUE` that give `scene` the setting of `run`.
pub(super) fn transferred(run: &Run, class: Class, scene: &CheckedScene) -> Vec<String> {
    let mut set = Vec::new();
    if let (Some(wanted), Some(_)) = (run.resolution, resolution::of(scene)) {
        set.extend(refined(scene, wanted));
    }
    if let Some(dt) = run.step.zip(class.time(scene)).map(|(step, time)| step * time) {
        set.push(format!("{}={dt:?}", keys::FLUID_DT));
    }
    let wanted = |text: &&String| {
        METHOD.iter().any(|section| text.starts_with(section))
            && !NOT_METHOD.iter().any(|key| is_at(text, key))
    };
    set.extend(run.set.iter().filter(wanted).cloned());
    set
}

/// Does `KEY=VALUE` set this key, or one in it?
fn is_at(text: &str, key: &str) -> bool {
    text.strip_prefix(key).is_some_and(|rest| rest.starts_with(['=', '.']))
}

/// `--set` of a grid with at least `wanted` cells per diameter: a little finer where whole and fast numbers
/// of cells ask for it.
fn refined(scene: &CheckedScene, wanted: f64) -> Vec<String> {
    let domain = &scene.scene.domain;
    let written = resolution::of(scene).unwrap_or(wanted);
    let diameter = scene.grains.iter().map(|grain| 2.0 * grain.radius).fold(f64::INFINITY, f64::min);
    let stretched = domain.stretching.map(|stretching| stretching.axis);
    let cells = domain.geometry.axes().iter().enumerate().map(|(axis, name)| {
        let extent = domain.upper[axis] - domain.lower[axis];
        let exact = match stretched {
            Some(stretched) if stretched == *name => domain.cells[axis] as f64 * wanted / written,
            _ => extent * wanted / diameter,
        };
        fast((exact - 1e-6).ceil() as u64)
    });
    resolution::set(&cells.collect::<Vec<_>>(), stretched.map(|_| diameter / wanted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::scene;

    #[test]
    fn grids_become_at_least_as_fine_and_fast() {
        assert_eq!([1, 7, 16, 97, 163, 4001].map(fast), [2, 8, 16, 100, 180, 4050]);
        let scene = scene(
            "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [3.1, 3.1, 7.0]\n\
                    cells = [10, 10, 20]\nboundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }\n\
                    [medium]\ndensity = 1.0\nviscosity = 1.0\n\
                    [[grains]]\nposition = [1.5, 1.5, 3.0]\nradius = 0.5\ndensity = 2.0\n",
        );
        assert_eq!(refined(&scene, 8.0), ["domain.cells=[30, 30, 60]"]);
    }
}
