//! Grains that are made: groups, layers, pours.

use super::check::{Check, finite, not_negative, positive};
use crate::scene::domain::Geometry;
use crate::scene::shared::Scene;
use crate::scene::source::SceneSource;

/// More grains than this do not fit the exchange.
const MOST_GRAINS: usize = 1 << 26;

pub(super) fn groups(scene: &Scene, source: &SceneSource) -> Check {
    let geometry = scene.domain.geometry;
    let layered: f64 = scene.layers.iter().map(|layer| layer.count(geometry)).sum();
    let grouped = scene.groups.iter().map(|group| group.count as f64).sum::<f64>();
    let poured = scene.pours.iter().map(|pour| pour.count as f64).sum::<f64>();
    for (key, count) in [("groups", grouped), ("layers", layered), ("pours", poured)] {
        if count + scene.grains.len() as f64 > MOST_GRAINS as f64 {
            return Err(source.error(
                key,
                format!("asks for more than {MOST_GRAINS} grains"),
                "ask for fewer grains",
            ));
        }
    }
    for (index, group) in scene.groups.iter().enumerate() {
        let key = |name: &str| format!("groups[{index}].{name}");
        positive(source, &key("radius"), group.radius)?;
        positive(source, &key("density"), group.density)?;
        finite(source, &key("lower"), &group.lower)?;
        finite(source, &key("upper"), &group.upper)?;
        spread(source, &key("radius_spread"), group.radius_spread)?;
        not_negative(source, &key("velocity_deviation"), group.velocity_deviation)?;
        let width = 2.0 * group.radius * (1.0 + group.radius_spread);
        let flat = scene.domain.geometry == Geometry::Plane;
        if (0..3).any(|axis| !(flat && axis == 1) && group.upper[axis] - group.lower[axis] < width) {
            return Err(source.error(
                &key("upper"),
                format!("leaves no room for a grain of diameter {width}"),
                "make the region larger than the largest grain",
            ));
        }
        if scene.domain.geometry == Geometry::Axisymmetric {
            return Err(source.error(
                &format!("groups[{index}]"),
                "an axisymmetric scene has its grains on the axis".to_owned(),
                "write them out in [[grains]], or use geometry = \"space\"",
            ));
        }
    }
    Ok(())
}

pub(super) fn layers(scene: &Scene, source: &SceneSource) -> Check {
    for (index, layer) in scene.layers.iter().enumerate() {
        let key = |name: &str| format!("layers[{index}].{name}");
        positive(source, &key("radius"), layer.radius)?;
        positive(source, &key("density"), layer.density)?;
        positive(source, &key("spacing"), layer.spacing())?;
        finite(source, &key("lower"), &layer.lower)?;
        finite(source, &key("upper"), &layer.upper)?;
        spread(source, &key("radius_spread"), layer.radius_spread)?;
        if scene.domain.geometry == Geometry::Axisymmetric || !layer.is_flat(scene.domain.geometry) {
            return Err(source.error(
                &key("upper"),
                format!("{:?} and lower {:?} do not span a rectangle", layer.upper, layer.lower),
                "let the two corners agree along one axis and differ along the others (plane: differ along x or z alone)",
            ));
        }
    }
    Ok(())
}

pub(super) fn pours(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for (index, pour) in scene.pours.iter().enumerate() {
        let key = |name: &str| format!("pours[{index}].{name}");
        positive(source, &key("radius"), pour.radius)?;
        positive(source, &key("density"), pour.density)?;
        positive(source, &key("rate"), pour.rate)?;
        not_negative(source, &key("start"), pour.start)?;
        finite(source, &key("lower"), &pour.lower)?;
        finite(source, &key("upper"), &pour.upper)?;
        finite(source, &key("velocity"), &pour.velocity)?;
        finite(source, &key("rise"), &pour.rise)?;
        let shift = pour.shift(f64::INFINITY);
        spread(source, &key("radius_spread"), pour.radius_spread)?;
        if domain.geometry == Geometry::Axisymmetric || scene.medium.is_some() {
            return Err(source.error(
                &format!("pours[{index}]"),
                "pours grains into an axisymmetric scene or one with a fluid, which sees every grain from the start",
                "pour in a dry scene, and begin the other from its grains.csv with [[grain_files]]",
            ));
        }
        let width = 2.0 * pour.radius * (1.0 + pour.radius_spread);
        for axis in 0..domain.dimensions() {
            let c = domain.geometry.component(axis);
            if pour.upper[c] - pour.lower[c] < width {
                return Err(source.error(
                    &key("upper"),
                    format!("leaves no room for a grain of diameter {width}"),
                    "make the region larger than the largest grain",
                ));
            }
            let (low, high) = (pour.lower[c] + shift[c].min(0.0), pour.upper[c] + shift[c].max(0.0));
            if low < domain.lower[axis] || high > domain.upper[axis] {
                return Err(source.error(
                    &key("upper"),
                    format!(
                        "{:?} and lower {:?} reach outside the box, moving by {shift:?}",
                        pour.upper, pour.lower
                    ),
                    "keep the region in the box, or enlarge [domain]",
                ));
            }
        }
    }
    Ok(())
}

fn spread(source: &SceneSource, key: &str, spread: f64) -> Check {
    if (0.0..1.0).contains(&spread) {
        return Ok(());
    }
    Err(source.error(
        key,
        format!("is {spread}; allowed: 0 ≤ spread < 1"),
        "a spread of 1 or more makes a radius ≤ 0",
    ))
}
