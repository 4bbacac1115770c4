//! Checks of a whole run, once, before anything is built.

use crate::bulk::requirements as bulk;
use crate::error::SpecError;
use crate::general::energy;
use crate::grain::Shape;
use crate::motion::Motion;
use crate::spec::{DemSpec, Engine, Integrator};

impl DemSpec {
    /// Checks everything; the first fault found is returned.
    pub fn validate(&self) -> Result<(), SpecError> {
        let model =
            |model, quantity, value, allowed| Err(SpecError::Model { model, quantity, value, allowed });
        self.contact.validate()?;
        if self.lubrication.settings().is_some() && !(self.viscosity > 0.0 && self.viscosity.is_finite()) {
            return model(
                "lubrication",
                "viscosity",
                self.viscosity,
                "positive and finite; a dry scene takes form = \"none\"",
            );
        }
        self.lubrication.validate()?;
        for (index, grain) in self.grains.iter().enumerate() {
            grain.validate(index)?;
        }
        let periodic = self.periods.map(|period| period.is_some());
        for (index, wall) in self.walls.iter().enumerate() {
            wall.validate(index, periodic)?;
        }
        if let Some(value) = self.gravity.extremes().flatten().find(|c| !c.is_finite()) {
            return model("gravity", "a component", value, "finite");
        }
        SpecError::unless_positive("neighbour list", &[("skin", self.skin.unwrap_or(1.0))])?;
        if self.integrator == Integrator::Rk3 && self.lubrication.settings().is_some() {
            return Err(SpecError::Combination(
                "integrator rk3 takes no lubrication, which is implicit; choose symplectic-euler or velocity-verlet",
            ));
        }
        if self.integrator == Integrator::Rk3 && self.walls.iter().any(|wall| wall.servo.is_some()) {
            return Err(SpecError::Combination(
                "integrator rk3 takes no wall that follows a pressure; choose symplectic-euler or velocity-verlet",
            ));
        }
        if self.lubrication.settings().is_some() && self.walls.iter().any(|wall| !wall.spin.is_zero()) {
            return Err(SpecError::Body {
                key: "dem.lubrication.form",
                why: "films at a wall that turns are not modelled; allowed: none",
                remedy: "write form = \"none\", or give the wall no spin",
            });
        }
        if let Some(grain) = self.grains.iter().position(|grain| {
            grain.wall.is_some_and(|w| w as usize >= self.walls.len() || grain.motion == Motion::Free)
        }) {
            let (quantity, value) = ("wall", f64::from(self.grains[grain].wall.unwrap_or_default()));
            let allowed = "the number of a wall, and the grain none that forces move";
            return Err(SpecError::Grain { grain, quantity, value, allowed });
        }
        if let Some(reason) = energy::prevents(self).filter(|_| self.energy) {
            return Err(SpecError::Combination(reason));
        }
        if self.has_bodies() {
            self.check_bodies()?;
        }
        if self.engine == Engine::Bulk
            && let Some(reason) = bulk::prevents(self)
        {
            return Err(SpecError::Engine(reason));
        }
        self.check_periods()
    }

    /// What holds for bodies that are not round.
    fn check_bodies(&self) -> Result<(), SpecError> {
        let refuse = |key, why, remedy| Err(SpecError::Body { key, why, remedy });
        if self.shape != Shape::Disc {
            let why = "bodies that are not round are bodies of the plane; spheres do not stand among them";
            return refuse("domain.geometry", why, "write geometry = \"plane\"");
        }
        let Some(law) = self.contact.linear() else {
            return refuse(
                "dem.contact.law",
                "bodies that are not round touch by springs: wan-turek is made for discs; allowed: \
                 linear-spring-dashpot",
                "write law = \"linear-spring-dashpot\"",
            );
        };
        if law.rolling.is_some() {
            return refuse(
                "dem.contact.rolling",
                "resists the rolling of round grains; bodies that are not round have corners for that",
                "leave the table out",
            );
        }
        if self.lubrication.settings().is_some() {
            return refuse(
                "dem.lubrication.form",
                "films between bodies that are not round are not modelled; the grid resolves what it can. \
                 Allowed: none",
                "write form = \"none\", or leave [dem.lubrication] out",
            );
        }
        if self.integrator == Integrator::Rk3 {
            return refuse(
                "dem.integrator",
                "is rk3, which does not know bodies that are not round; allowed: symplectic-euler, velocity-verlet",
                "choose one of the two",
            );
        }
        for (grain, body) in self.grains.iter().enumerate() {
            let Some(place) = body.outline else { continue };
            let bad = |quantity, value, allowed| Err(SpecError::Grain { grain, quantity, value, allowed });
            let Some(outline) = self.outlines.get(place as usize) else {
                return bad("the place of its outline", f64::from(place), "below the number of outlines");
            };
            let sizes = [outline.area(), outline.gyration(), outline.reach()];
            if let Some(&value) = sizes.iter().find(|size| !(**size > 0.0 && size.is_finite())) {
                return bad("a size of its outline", value, "positive and finite");
            }
            if (body.radius - outline.reach()).abs() > 1e-9 * body.radius {
                return bad("radius", body.radius, "the largest distance of its surface from its centre");
            }
            let [_, x, _, z] = body.orientation;
            if let Some(&value) = [x, z].iter().find(|value| value.abs() > 1e-9) {
                return bad("orientation about x or z", value, "zero: a body of the plane turns about y");
            }
            let turns = [body.free.rotation[0], body.free.rotation[2], body.free.translation[1]];
            if body.motion == Motion::Free && turns.contains(&true) {
                return bad(
                    "its freedom across the plane",
                    1.0,
                    "none: x, z and the spin about y are free at most",
                );
            }
        }
        let across = self.walls.iter().position(|wall| wall.normal[1] != 0.0);
        across.map_or(Ok(()), |wall| {
            let (quantity, value) = ("component of the normal along y", self.walls[wall].normal[1]);
            let allowed = "zero beside bodies of the plane that are not round";
            Err(SpecError::Wall { wall, quantity, value, allowed })
        })
    }

    fn check_periods(&self) -> Result<(), SpecError> {
        // The two largest: no pair reaches farther, and no grain farther towards its own image.
        let (mut largest, mut second) = (0.0_f64, 0.0_f64);
        for grain in &self.grains {
            second = second.max(grain.radius.min(largest));
            largest = largest.max(grain.radius);
        }
        let range = self.range();
        let least = match self.grains.iter().any(|grain| grain.motion == Motion::Free) {
            false => 0.0,
            true if self.grains.len() == 1 => 2.0 * largest + range,
            true => (2.0 * largest + range).max(2.0 * (largest + second + range)),
        };
        for (axis, period) in self.periods.iter().enumerate() {
            let Some((start, length)) = *period else { continue };
            if !(start.is_finite() && length > 0.0 && length >= least && length.is_finite()) {
                return Err(SpecError::Period { axis: ["x", "y", "z"][axis], length, least });
            }
        }
        Ok(())
    }
}
