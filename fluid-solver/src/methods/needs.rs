//! What the method of a scene keeps in memory.

use super::calibrated::advection;
use super::calibrated::calibration::ForceTransport;
use super::method::Method;
use crate::config::Choices;
use bedload_scene::{CheckedScene, Motion};
use protocol::scheme::Scheme;

/// What a method keeps in memory for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needs {
    /// Whether there is a force that is carried from step to step, a field for each component.
    pub force: bool,
    /// How that force goes with the grains, where it does.
    pub transport: Option<ForceTransport>,
    /// Whether viscosity feels the change of that force in the same step.
    pub local_solve: bool,
    /// Whether the mask ratios of the grains are kept until the grains move.
    pub mask_ratios: bool,
    /// Whether bodies hold points.
    pub points: bool,
    /// Whether convection is refined near grains.
    pub near_convection: bool,
    /// Whether the jumps of contacts go to the fluid in their own window.
    pub jumps: bool,
}

impl Needs {
    /// Of a scene.
    pub fn of(scene: &CheckedScene, choices: &Choices, scheme: Scheme) -> Self {
        let fixed = scene.grains.iter().all(|grain| grain.stays(scene.scene.domain.geometry));
        let grains = !scene.grains.is_empty();
        let transport = match choices.method {
            Method::Calibrated => advection::transport(scene, &choices.calibration, scheme),
            Method::Izard2014 | Method::FictitiousDomain => None,
        };
        Self {
            force: grains && choices.method != Method::Izard2014,
            transport,
            local_solve: transport.is_some()
                && !choices.calibration.without_local_solve
                && (choices.calibration.force_transport == ForceTransport::Advected
                    || advection::has_pores(scene)),
            mask_ratios: choices.method != Method::FictitiousDomain && (transport.is_some() || fixed),
            near_convection: grains
                && choices.method == Method::Calibrated
                && choices.time.convection
                && !choices.calibration.plain_convection,
            points: grains && choices.method == Method::FictitiousDomain,
            // In repeated windows the attempts would have to agree on what is a contact.
            jumps: choices.method == Method::Calibrated
                && scheme != Scheme::Iterated
                && !choices.calibration.without_virtual_mass
                && scene.grains.iter().any(|grain| grain.motion == Motion::Free || grain.velocity.varies()),
        }
    }
}
