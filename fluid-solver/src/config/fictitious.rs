//! What the fictitious-domain method asks of a scene.

use super::{Choices, FluidSection, ForceTransport, MaskRadius};
use bedload_scene::{CheckedScene, Geometry, SceneError};
use protocol::facts::LoadsForm;
use protocol::scheme::Scheme;

impl FluidSection {
    /// Refuses what the fictitious-domain method cannot do.
    pub(super) fn check_fictitious(
        &self,
        scene: &CheckedScene,
        choices: &Choices,
        scheme: Scheme,
    ) -> Result<(), SceneError> {
        let (source, domain) = (&scene.source, &scene.scene.domain);
        let refuse = |key: &str, what: String, remedy: &str| Err(source.error(key, what, remedy));
        if domain.geometry != Geometry::Plane {
            return refuse(
                "fluid.immersed.method",
                "is \"fictitious-domain\", which is for discs in the plane".into(),
                "take method = \"carried\", or domain.geometry = \"plane\"",
            );
        }
        let (x, z) = (domain.spacing(0), domain.spacing(1));
        if domain.stretching.is_some() || (x / z - 1.0).abs() > 1e-9 {
            return refuse(
                "domain.cells",
                format!(
                    "makes cells of {x} m by {z} m; the fictitious-domain method needs equal cells, square ones"
                ),
                "choose cells so that (upper − lower)/cells is the same along x and z, without domain.stretching",
            );
        }
        for (key, given) in [
            ("mask", self.immersed.mask.is_some()),
            ("width", self.immersed.width.is_some()),
            ("mask_radius", self.immersed.mask_radius != MaskRadius::Auto),
            ("force_transport", self.immersed.force_transport != ForceTransport::Auto),
            ("viscous_sweeps", self.immersed.viscous_sweeps.is_some()),
        ] {
            if given {
                return refuse(
                    &format!("fluid.immersed.{key}"),
                    "has no meaning with method = \"fictitious-domain\", which has points and no mask".into(),
                    "remove it, or take method = \"carried\"",
                );
            }
        }
        if self.loads.displaced_mass.is_some() {
            return refuse(
                "fluid.loads.displaced_mass",
                "has no meaning with method = \"fictitious-domain\", whose points have the area of their body".into(),
                "remove it, or take method = \"carried\"",
            );
        }
        if choices.form != LoadsForm::YuShaoFixedPoint {
            return refuse(
                "fluid.loads.form",
                format!("is {}; the fictitious-domain method takes yu-shao-fixed-point", choices.form),
                "remove it, or take method = \"carried\"",
            );
        }
        if !scheme.carries(choices.form, true) {
            return refuse(
                "coupling.scheme",
                format!("is {scheme}, which the fictitious-domain method cannot follow"),
                "take coupling.scheme = \"semi-implicit\" or \"overlapped\"",
            );
        }
        let spacing = x.min(z);
        if let Some(grain) = scene.grains.iter().position(|grain| grain.thickness() < 4.0 * spacing) {
            let across = scene.grains[grain].thickness();
            return refuse(
                "domain.cells",
                format!(
                    "makes grain {grain} {:.1} cells across; the fictitious-domain method needs 4",
                    across / spacing
                ),
                &format!("give more cells: {} m each, or less", 0.25 * across),
            );
        }
        Ok(())
    }
}
