//! Grains that are made: groups, rough walls, insertions.

use super::check::{Check, finite, not_negative, positive};
use crate::domain::Geometry;
use crate::layout::MOST_GRAINS;
use crate::shared::Scene;
use crate::source::SceneSource;

pub(super) fn groups(scene: &Scene, source: &SceneSource) -> Check {
    let geometry = scene.domain.geometry;
    let rough: f64 = scene.rough_walls.iter().map(|wall| wall.count(geometry)).sum();
    let grouped = scene.groups.iter().map(|group| group.count as f64).sum::<f64>();
    let inserted = scene.insertions.iter().map(|insertion| insertion.count as f64).sum::<f64>();
    for (key, count) in [("groups", grouped), ("rough_walls", rough), ("insertions", inserted)] {
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

pub(super) fn rough_walls(scene: &Scene, source: &SceneSource) -> Check {
    for (index, wall) in scene.rough_walls.iter().enumerate() {
        let key = |name: &str| format!("rough_walls[{index}].{name}");
        positive(source, &key("radius"), wall.radius)?;
        positive(source, &key("density"), wall.density)?;
        positive(source, &key("spacing"), wall.spacing())?;
        finite(source, &key("lower"), &wall.lower)?;
        finite(source, &key("upper"), &wall.upper)?;
        spread(source, &key("radius_spread"), wall.radius_spread)?;
        if scene.domain.geometry == Geometry::Axisymmetric || !wall.is_flat(scene.domain.geometry) {
            return Err(source.error(
                &key("upper"),
                format!("{:?} and lower {:?} do not span a rectangle", wall.upper, wall.lower),
                "let the two corners agree along one axis and differ along the others (plane: differ along x or z alone)",
            ));
        }
    }
    Ok(())
}

pub(super) fn insertions(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for (index, insertion) in scene.insertions.iter().enumerate() {
        let key = |name: &str| format!("insertions[{index}].{name}");
        positive(source, &key("radius"), insertion.radius)?;
        positive(source, &key("density"), insertion.density)?;
        positive(source, &key("rate"), insertion.rate)?;
        not_negative(source, &key("start"), insertion.start)?;
        finite(source, &key("lower"), &insertion.lower)?;
        finite(source, &key("upper"), &insertion.upper)?;
        finite(source, &key("velocity"), &insertion.velocity)?;
        finite(source, &key("rise"), &insertion.rise)?;
        let shift = insertion.shift(f64::INFINITY);
        spread(source, &key("radius_spread"), insertion.radius_spread)?;
        if domain.geometry == Geometry::Axisymmetric || scene.medium.is_some() {
            return Err(source.error(
                &format!("insertions[{index}]"),
                "inserts grains into an axisymmetric scene or one with a fluid, which sees every grain from the start",
                "insert in a dry scene, and begin the other from its grains.csv with [[grain_files]]",
            ));
        }
        let width = 2.0 * insertion.radius * (1.0 + insertion.radius_spread);
        for axis in 0..domain.dimensions() {
            let c = domain.geometry.component(axis);
            if insertion.upper[c] - insertion.lower[c] < width {
                return Err(source.error(
                    &key("upper"),
                    format!("leaves no room for a grain of diameter {width}"),
                    "make the region larger than the largest grain",
                ));
            }
            let (low, high) =
                (insertion.lower[c] + shift[c].min(0.0), insertion.upper[c] + shift[c].max(0.0));
            if low < domain.lower[axis] || high > domain.upper[axis] {
                return Err(source.error(
                    &key("upper"),
                    format!(
                        "{:?} and lower {:?} reach outside the box, moving by {shift:?}",
                        insertion.upper, insertion.lower
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
