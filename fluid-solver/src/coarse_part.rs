//! Grains that reach where the cells of a stretched axis grow: told once, when it happens.

use bedload_scene::{CheckedScene, Geometry};
use fluid_kernels::immersed::body::Motion;

/// Part of the end of the even cells by which rounding may carry a grain past it.
const ROUNDING: f64 = 1e-9;

/// The part of a stretched axis that is for the fluid alone.
pub(crate) struct CoarsePart {
    /// Laboratory component along which cells grow.
    component: usize,
    /// Where they begin to, m.
    from: f64,
    radii: Vec<f64>,
}

impl CoarsePart {
    /// None where no grain can get there.
    pub(crate) fn of(scene: &CheckedScene) -> Option<Self> {
        let domain = &scene.scene.domain;
        let stretching = domain.stretching.filter(|_| !scene.grains.is_empty())?;
        let axis = domain.geometry.axes().iter().position(|axis| *axis == stretching.axis)?;
        let component = domain.geometry.component(axis);
        // The grains of an axisymmetric scene stay on the axis.
        let along_axis = domain.geometry != Geometry::Axisymmetric || component == 2;
        let radii = scene.grains.iter().map(|grain| grain.radius).collect();
        along_axis.then_some(Self { component, from: stretching.uniform_to, radii })
    }

    /// Whether a grain reaches there at `time`, s; names the first that does.
    pub(crate) fn is_reached(&self, motions: &[Motion], time: f64) -> bool {
        let end = self.from + ROUNDING * self.from.abs();
        let far = |(motion, radius): (&Motion, &f64)| motion.centre[self.component] + radius > end;
        let Some(grain) = motions.iter().zip(&self.radii).position(far) else { return false };
        protocol::say!(
            "bedload-fluid: warning: grain {grain} reaches past domain.stretching.uniform_to = {} m by t = \
             {time} s: cells grow there, and forces on it go wrong; let the even cells hold the way of every \
             grain",
            self.from
        );
        true
    }
}
