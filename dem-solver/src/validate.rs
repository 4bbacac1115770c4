//! Checks of a whole run, once, before anything is built.

use crate::bulk::requirements as bulk;
use crate::error::SpecError;
use crate::general::energy;
use crate::grain::Shape;
use crate::laws::table::ContactLaw;
use crate::lubrication::settings::LubricationIntegration;
use crate::motion::Motion;
use crate::spec::{DemSpec, Engine, Integrator};

impl DemSpec {
    /// Checks everything; the first fault found is returned.
    pub fn validate(&self) -> Result<(), SpecError> {
        let model =
            |model, quantity, value, allowed| Err(SpecError::Model { model, quantity, value, allowed });
        self.contact.validate()?;
        self.lubrication.validate()?;
        for (index, pair) in self.pairs.iter().enumerate() {
            pair.contact.validate()?;
            self.check_material("law", index, pair.between[0].max(pair.between[1]))?;
        }
        for (index, grain) in self.grains.iter().enumerate() {
            grain.validate(index)?;
            self.check_material("grain", index, grain.material)?;
        }
        let periodic = self.periods.map(|period| period.is_some());
        for (index, wall) in self.walls.iter().enumerate() {
            wall.validate(index, periodic)?;
            self.check_material("wall", index, wall.material)?;
        }
        if let Some(&value) = self.gravity.iter().find(|c| !c.is_finite()) {
            return model("gravity", "a component", value, "finite");
        }
        if self.lubrication.settings().is_some() && !(self.viscosity > 0.0 && self.viscosity.is_finite()) {
            return model(
                "lubrication",
                "viscosity",
                self.viscosity,
                "positive and finite; a dry scene takes form = \"none\"",
            );
        }
        SpecError::unless_positive("neighbour list", &[("skin", self.skin.unwrap_or(1.0))])?;
        let hertz = |law: &ContactLaw| matches!(law, ContactLaw::HertzMindlin(_));
        let laws = || self.pairs.iter().map(|pair| &pair.contact).chain([&self.contact]);
        if self.shape == Shape::Disc && laws().any(hertz) {
            return Err(SpecError::Law(
                "hertz-mindlin is a law of spheres, and discs touch along a line; choose linear-spring-dashpot",
            ));
        }
        let implicit = self
            .lubrication
            .settings()
            .is_some_and(|settings| settings.integration == LubricationIntegration::Implicit);
        if self.integrator == Integrator::Rk3 && implicit {
            return Err(SpecError::Combination(
                "integrator rk3 takes no implicit lubrication; choose symplectic-euler, or integration = \"explicit\" with its bound on the sub-step",
            ));
        }
        if let Some(reason) = energy::prevents(self).filter(|_| self.energy) {
            return Err(SpecError::Combination(reason));
        }
        if self.engine == Engine::Bulk
            && let Some(reason) = bulk::prevents(self)
        {
            return Err(SpecError::Engine(reason));
        }
        self.check_periods()
    }

    fn check_material(&self, owner: &'static str, index: usize, material: usize) -> Result<(), SpecError> {
        if material < self.materials {
            return Ok(());
        }
        Err(SpecError::Material { owner, index, material, last: self.materials.saturating_sub(1) })
    }

    fn check_periods(&self) -> Result<(), SpecError> {
        let pairs = self.grains.len() > 1 && self.grains.iter().any(|grain| grain.motion == Motion::Free);
        let least = if pairs { 2.0 * (2.0 * self.largest_radius() + self.range()) } else { 0.0 };
        for (axis, period) in self.periods.iter().enumerate() {
            let Some((start, length)) = *period else { continue };
            if !(start.is_finite() && length > 0.0 && length >= least && length.is_finite()) {
                return Err(SpecError::Period { axis, length, least });
            }
        }
        Ok(())
    }
}
