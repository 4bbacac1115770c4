//! The form of every grain that is written out: what its shape needs is there and makes a body.

use crate::domain::Geometry;
use crate::error::{Check, SceneError};
use crate::grains::{Grain, Shape};
use crate::shared::Scene;
use crate::source::SceneSource;
use bedload_outline::Outline;

/// Gives every written grain its shape in this geometry and its radius.
pub(crate) fn settle(scene: &mut Scene, source: &SceneSource) -> Check {
    let geometry = scene.domain.geometry;
    for (index, grain) in scene.grains.iter_mut().enumerate() {
        let form = Form { key: &|name| format!("grains[{index}].{name}"), source };
        form.refuse_foreign_keys(grain)?;
        form.fits(grain, geometry)?;
        form.size(grain)?;
    }
    Ok(())
}

struct Form<'a> {
    key: &'a dyn Fn(&str) -> String,
    source: &'a SceneSource,
}

impl Form<'_> {
    fn error(&self, name: &str, message: impl Into<String>, remedy: &str) -> SceneError {
        self.source.error(&(self.key)(name), message, remedy)
    }

    /// A key that another shape has.
    fn refuse_foreign_keys(&self, grain: &Grain) -> Check {
        let keys = [
            ("sides", grain.sides.is_some(), Shape::Rectangle),
            ("semi_axes", grain.semi_axes.is_some(), Shape::Ellipse),
            ("vertices", !grain.vertices.is_empty(), Shape::Polygon),
        ];
        for (name, given, shape) in keys {
            if given && grain.shape != shape {
                let (is, needs) = (name_of(grain.shape), name_of(shape));
                let message = format!("is given, but the grain is a {is}; only a {needs} has it");
                let remedy = format!("write shape = \"{needs}\", or remove the key");
                return Err(self.error(name, message, &remedy));
            }
        }
        Ok(())
    }

    /// Discs and outlines in the plane, spheres elsewhere: nothing that was written is changed in silence.
    fn fits(&self, grain: &mut Grain, geometry: Geometry) -> Check {
        let plane = geometry == Geometry::Plane;
        if plane && grain.shape == Shape::Sphere {
            // The text is parsed only where the word stands in it.
            if self.source.text.contains("\"sphere\"") && self.source.has(&(self.key)("shape")) {
                return Err(self.error(
                    "shape",
                    "is a sphere, but bodies of geometry = \"plane\" are cylinders of unit depth across it",
                    "write \"disc\" (or leave the key out), or choose geometry = \"space\" or \"axisymmetric\"",
                ));
            }
            grain.shape = Shape::Disc;
        }
        if !plane && grain.shape != Shape::Sphere {
            let is = name_of(grain.shape);
            return Err(self.error(
                "shape",
                format!("is a {is}, a body of the plane; allowed in this geometry: \"sphere\""),
                &format!("choose geometry = \"plane\" for a {is}, or leave the key out for spheres"),
            ));
        }
        Ok(())
    }

    /// Sizes are positive, vertices make a convex body; the radius of a body that is not round is its reach.
    fn size(&self, grain: &mut Grain) -> Check {
        match grain.shape {
            Shape::Sphere | Shape::Disc => {
                // A NaN that was written is a value, and refused as one.
                if grain.radius.is_nan() && !self.source.has(&(self.key)("radius")) {
                    return Err(self.error("radius", "missing field `radius`", "add the key, m"));
                }
                return Ok(());
            }
            Shape::Rectangle => self.two("sides", grain.sides)?,
            Shape::Ellipse => self.two("semi_axes", grain.semi_axes)?,
            Shape::Polygon if grain.vertices.is_empty() => {
                let message = "missing field `vertices`";
                return Err(self.error("vertices", message, "add [[x, z], …] in order, m"));
            }
            Shape::Polygon => {
                let told = |(message, remedy): (String, _)| self.error("vertices", message, remedy);
                Outline::polygon(&grain.vertices).map_err(told)?;
            }
        }
        let turn = [grain.orientation[1], grain.orientation[3]];
        if turn.iter().any(|part| part.abs() > 1e-9) {
            let what = format!("{:?} turns the body out of the plane", grain.orientation);
            return Err(self.error("orientation", what, "turn it about y alone: (cos ½θ, 0, sin ½θ, 0)"));
        }
        let reach = grain.outline().map_or(f64::NAN, |outline| outline.reach());
        // A scene that was written out with every value has it.
        if (grain.radius - reach).abs() > 1e-9 * reach {
            let message = format!("is {}, but a {} has no radius", grain.radius, name_of(grain.shape));
            let remedy = format!("remove the key; its size follows from {}", size_key(grain.shape));
            return Err(self.error("radius", message, &remedy));
        }
        grain.radius = reach;
        Ok(())
    }

    /// Two sizes, both positive.
    fn two(&self, name: &str, values: Option<[f64; 2]>) -> Check {
        let Some(values) = values else {
            return Err(self.error(name, format!("missing field `{name}`"), "add [along x, along z], m"));
        };
        if values.iter().all(|value| value.is_finite() && *value > 0.0) {
            return Ok(());
        }
        let message = format!("is {values:?}; allowed: two finite numbers > 0");
        Err(self.error(name, message, "give the sizes of a body with an area"))
    }
}

fn name_of(shape: Shape) -> &'static str {
    match shape {
        Shape::Sphere => "sphere",
        Shape::Disc => "disc",
        Shape::Rectangle => "rectangle",
        Shape::Ellipse => "ellipse",
        Shape::Polygon => "polygon",
    }
}

fn size_key(shape: Shape) -> &'static str {
    match shape {
        Shape::Rectangle => "`sides`",
        Shape::Ellipse => "`semi_axes`",
        _ => "`vertices`",
    }
}
