//! Cheaper models of a scene: no more than it needs.
//!
//! Each rule looks at a scene and proposes a change that costs less, where its error can be stated
//! beforehand and is small. `bedload check` prints them; `bedload check SCENE --cheaper NAME` prints the
//! changed scene. A change that the solvers refuse, or that costs no less, is not proposed.
//!
//! | file | proposes |
//! |---|---|
//! | `axis` | r–z in place of space, for one sphere on the axis of its box |
//! | `plane` | the plane in place of space, for a flow without grains that is the same all along y |
//! | `dry` | no fluid, where the grains' inertia rules |
//! | `substeps` | one sub-step where nothing can touch |
//! | `coarser` | grid and step that the chart of this class of scenes has for 2 % |
//! | `change` | a change of a scene's text |

mod axis;
mod change;
mod coarser;
mod dry;
mod plane;
mod substeps;

use bedload_program::RunOptions;
use bedload_scene::Scene;

use crate::failure::Failure;
use crate::number::Short;
use crate::number::norm;
use crate::prepare::Prepared;
use bedload_scene::speeds::drive;
pub(crate) use change::Change;

/// Largest error that is worth proposing.
const WORTH: f64 = 0.02;
/// What costs no less than this part of the scene is not worth an error.
const CHEAP: f64 = 0.67;

/// A rule's answer to a scene.
struct Idea {
    /// As `--cheaper` takes it.
    name: &'static str,
    /// What is done, in words.
    what: &'static str,
    change: Change,
    /// Expected, relative.
    error: f64,
    /// How many times less it costs at most, where the plans do not say.
    saving: Option<f64>,
    /// Of which quantity, and why so much.
    why: String,
}

/// A cheaper model of a scene.
pub(crate) struct Proposal {
    idea: Idea,
    /// How many times less the run is estimated to cost.
    saving: f64,
    /// The changed scene (TOML).
    scene: String,
}

impl Proposal {
    /// One line for `check`.
    pub(crate) fn line(&self) -> String {
        let Idea { name, what, error, why, .. } = &self.idea;
        let error = if *error > 0.0 {
            format!("error {} % expected", Short(100.0 * error))
        } else {
            "without error".into()
        };
        format!(
            "{name}: {what}: {} times cheaper by estimate, {error} ({why}); --cheaper {name} prints the \
             scene",
            Short(self.saving)
        )
    }
}

/// Every proposal for a scene that was read with `options`, the cheapest first.
pub(crate) fn all(prepared: &Prepared, options: &RunOptions) -> Vec<Proposal> {
    let rules = [axis::idea, plane::idea, dry::idea, substeps::idea, coarser::idea];
    let ideas = rules.into_iter().filter_map(|rule| rule(prepared)).filter(|idea| idea.error <= WORTH);
    let mut proposals: Vec<Proposal> = ideas.filter_map(|idea| worked_out(idea, prepared, options)).collect();
    proposals.sort_by(|a, b| b.saving.total_cmp(&a.saving));
    proposals
}

/// The scene of proposal `name`.
pub(crate) fn cheaper(prepared: &Prepared, options: &RunOptions, name: &str) -> Result<String, Failure> {
    let proposals = all(prepared, options);
    let names: Vec<&str> = proposals.iter().map(|proposal| proposal.idea.name).collect();
    let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    match proposals.into_iter().find(|proposal| proposal.idea.name == name) {
        Some(proposal) => Ok(proposal.scene),
        None => Err(Failure::Input(format!(
            "--cheaper {name}: no such proposal for {}; there are: {there} (bedload check prints them)",
            options.scene.display()
        ))),
    }
}

/// Prepares the changed scene and compares the costs; nothing where it is refused or no cheaper.
fn worked_out(idea: Idea, prepared: &Prepared, options: &RunOptions) -> Option<Proposal> {
    let text = prepared.scene.source.text_for_any_folder();
    let (scene, changed) = idea.change.prepared(&text, options)?;
    changed.refuse_broken().ok()?;
    let by_plans = (changed.plan.cost > 0.0).then(|| prepared.plan.cost / changed.plan.cost);
    let saving = idea.saving.or(by_plans)?;
    let least = if idea.error > 0.0 { 1.0 / CHEAP } else { 1.0 };
    (saving > least).then_some(Proposal { idea, saving, scene })
}

/// Do two coordinates agree but for rounding, on the scale of `size`?
fn same(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= 1e-9 * size
}

/// Does a face move or let fluid in, or is a flow rate held?
fn is_driven_at_faces(scene: &Scene) -> bool {
    let faces = (0..scene.domain.dimensions()).filter_map(|axis| scene.domain.boundary(axis));
    let moves = faces.flat_map(|b| [b.lower, Some(b.upper)]).flatten().any(|f| !f.velocity.is_zero());
    moves || scene.medium.as_ref().is_some_and(|medium| medium.flow_rate.is_some())
}
