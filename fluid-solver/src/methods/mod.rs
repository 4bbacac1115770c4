//! The methods of the immersed boundary, `fluid.method`: each in a file or folder, behind one trait.
//!
//! | method | file | force on the fluid | loads on the grains |
//! |---|---|---|---|
//! | `calibrated` | `calibrated/` | λ in cells, carried on, in a mask of known permeability | ρ G/dt − m_f g |
//! | `izard-2014` | `izard2014.rs` | α (U − u)/dt, anew in each step (Izard et al. 2014) | −ρ ρ_p/(ρ_p − ρ) ∫ f dV |
//! | `fictitious-domain` | `fictitious/` | λ at points of the bodies (Yu & Shao 2007) | ρ G/dt − m_f g |
//!
//! [`immersed_boundary`] is the trait, [`grains`] the state of the grains that all methods share, [`loads`]
//! the loads of the first and the last method, `limits` the form in which a method tells the coupler which
//! grains are too light. Masks and integrals over grains are in [`crate::immersed`].

pub mod beyond;
pub mod calibrated;
pub mod fictitious;
pub mod grains;
pub mod immersed_boundary;
pub mod izard2014;
mod limits;
pub mod loads;
pub mod method;
pub mod needs;
pub mod virtual_mass;

use crate::config::Choices;
use crate::grid::Grid;
use crate::immersed::Immersed;
use crate::immersed::mask_model::MaskModel;
use crate::scene_grains;
use bedload_scene::{CheckedScene, Medium};
use calibrated::Calibrated;
use fictitious::FictitiousDomain;
use grains::Grains;
use immersed_boundary::ImmersedBoundary;
use izard2014::Izard2014;
use loads::GrainLoads;
use method::Method;
use needs::Needs;
use protocol::facts::SolverBound;
use protocol::scheme::{Iterations, Scheme};

/// The method of a scene and its grains, on `grid`, with windows of `dt` (s) at first.
pub(crate) fn build<const D: usize>(
    scene: &CheckedScene,
    medium: &Medium,
    choices: &Choices,
    scheme: Scheme,
    grid: &Grid<D>,
    dt: f64,
) -> (Box<dyn ImmersedBoundary<D>>, Grains<D>) {
    let needs = Needs::of(scene, choices, scheme);
    let model = MaskModel { dt, ..choices.method.mask(grid.geometry, medium.kinematic_viscosity()) };
    let immersed = Immersed::new(grid, scene_grains::shapes(scene), needs.mask_ratios);
    let mut grains = Grains::new(immersed, model, scene_grains::motions(scene), needs.force.then_some(grid));
    let loads = |displaced_mass: bool| {
        let parts = choices.calibration;
        GrainLoads::new(grid, scene, medium.density)
            .with_parts(!parts.without_virtual_mass, displaced_mass && !parts.without_displaced_mass)
    };
    let method: Box<dyn ImmersedBoundary<D>> = match choices.method {
        Method::Calibrated => {
            Box::new(Calibrated::new(scene, medium, choices, scheme, &needs, grid, &mut grains, loads(true)))
        }
        Method::Izard2014 => Box::new(Izard2014::new(scene, medium.density)),
        Method::FictitiousDomain => {
            Box::new(FictitiousDomain::new(grid, grains.immersed.shapes(), loads(false)))
        }
    };
    (method, grains)
}

/// The bounds of the method of a scene, on a grid with the smallest spacing `spacing`, m.
pub(crate) fn bounds(
    scene: &CheckedScene,
    medium: &Medium,
    method: Method,
    iterations: &Iterations,
    spacing: f64,
) -> Vec<SolverBound> {
    let viscous = medium.kinematic_viscosity() / spacing.powi(2);
    let mut bounds = match method {
        Method::Calibrated => {
            // Where most windows are not repeated the limit is that of such windows.
            let repeated = if iterations.repeat_above == 0.0 { &limits::REPEATED } else { &limits::ONCE };
            let remedy = "use coupling.scheme = \"iterated\", heavier grains, or a smaller dt";
            limits::density_ratio(scene, medium, &limits::ONCE, Some(repeated), remedy)
        }
        Method::Izard2014 => izard2014::bounds(scene, medium, viscous),
        Method::FictitiousDomain => {
            let remedy = "use fluid.method = \"calibrated\", which can repeat windows, heavier grains, or a \
                          smaller dt";
            limits::density_ratio(scene, medium, &limits::FICTITIOUS, None, remedy)
        }
    };
    if method != Method::Izard2014 {
        bounds.extend(limits::dense_bed(scene, viscous));
    }
    bounds
}
