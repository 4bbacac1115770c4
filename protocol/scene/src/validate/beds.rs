//! Grains that are made: groups, rough walls, insertions.

use super::check::{Check, finite, not_negative, positive};
use super::missing;
use crate::domain::Geometry;
use crate::grains::{Freedom, Grain, Group};
use crate::insertions::Insertion;
use crate::layout::too_many;
use crate::rough_walls::RoughWall;
use crate::shared::Scene;
use crate::source::SceneSource;
use bedload_over_time::OverTime;

pub(super) fn groups(scene: &Scene, source: &SceneSource) -> Check {
    let geometry = scene.domain.geometry;
    let rough: f64 = scene.rough_walls.iter().map(|wall| wall.count(geometry)).sum();
    let grouped = scene.groups.iter().map(|group| group.count as f64).sum::<f64>();
    let inserted = scene.insertions.iter().map(|insertion| insertion.count as f64).sum::<f64>();
    let mut all = scene.grains.len() as f64;
    for (key, count) in [("groups", grouped), ("rough_walls", rough), ("insertions", inserted)] {
        all += count;
        let why = too_many(all);
        source.refuse_if(
            count > 0.0 && why.is_some(),
            key,
            why.unwrap_or_default(),
            "ask for fewer grains",
        )?;
    }
    for (index, group) in scene.groups.iter().enumerate() {
        let key = |name: &str| format!("groups[{index}].{name}");
        let Group { radius, radius_spread, density, lower, upper, .. } = group;
        let bed = Bed { key: &key, source, corners: [lower, upper], radius: *radius, spread: *radius_spread };
        bed.check(*density)?;
        not_negative(source, &key("velocity_deviation"), group.velocity_deviation)?;
        let (motion, locked) = (group.motion, group.locked.clone());
        let grain = Grain { motion, locked, ..Grain::at(*lower, *radius, *density) };
        let moves = |freedom: &Freedom| grain.is_free(*freedom, scene.domain.geometry);
        source.refuse_if(
            group.velocity_deviation > 0.0 && ![Freedom::X, Freedom::Y, Freedom::Z].iter().any(moves),
            &key("velocity_deviation"),
            format_args!("is {}, but these grains are held along every axis", group.velocity_deviation),
            "leave it out, or leave out `motion` and `locked`",
        )?;
        let flat = scene.domain.geometry == Geometry::Plane;
        (0..3).filter(|axis| !(flat && *axis == 1)).try_for_each(|axis| bed.room(axis))?;
        source.refuse_if(
            scene.domain.geometry == Geometry::Axisymmetric,
            &format!("groups[{index}]"),
            "an axisymmetric scene has its grains on the axis",
            "write them out in [[grains]], or use geometry = \"space\"",
        )?;
    }
    Ok(())
}

pub(super) fn rough_walls(scene: &Scene, source: &SceneSource) -> Check {
    for (index, wall) in scene.rough_walls.iter().enumerate() {
        let key = |name: &str| format!("rough_walls[{index}].{name}");
        let RoughWall { radius, radius_spread, density, lower, upper, .. } = wall;
        let bed = Bed { key: &key, source, corners: [lower, upper], radius: *radius, spread: *radius_spread };
        bed.check(*density)?;
        positive(source, &key("spacing"), wall.spacing())?;
        if let Some(number) = wall.wall {
            let with = scene.walls.get(number);
            source.refuse_if(
                with.is_none_or(|wall| !wall.spin.is_zero()),
                &key("wall"),
                format_args!("is {number}; allowed: the number of a wall that does not turn, from 0"),
                "name one of [[walls]] without `spin`, or leave it out: then the layer stays",
            )?;
            source.refuse_if(
                with.is_some_and(|wall| wall.from > 0.0 || wall.until.is_finite()),
                &key("wall"),
                format_args!("is {number}, which has `from` or `until`: grains are there all the time"),
                "give the wall without them to the layer",
            )?;
        }
        source.refuse_if(
            scene.domain.geometry == Geometry::Axisymmetric || !wall.is_flat(scene.domain.geometry),
            &key("upper"),
            format_args!("{upper:?} and lower {lower:?} do not span a rectangle"),
            "let the two corners agree along one axis and differ along the others (plane: differ along x or z \
             alone)",
        )?;
        if let Some(axis) = wall.meets_itself(&scene.domain) {
            return Err(source.error(
                &key("upper"),
                format!(
                    "{upper:?} is a period of {} from lower: the last grains would lie on the images of the first",
                    ["x", "y", "z"][axis]
                ),
                "end it a spacing before the face",
            ));
        }
    }
    Ok(())
}

pub(super) fn insertions(scene: &Scene, source: &SceneSource) -> Check {
    let domain = &scene.domain;
    for (index, insertion) in scene.insertions.iter().enumerate() {
        let key = |name: &str| format!("insertions[{index}].{name}");
        let Insertion { radius, radius_spread, density, lower, upper, .. } = insertion;
        let bed = Bed { key: &key, source, corners: [lower, upper], radius: *radius, spread: *radius_spread };
        bed.check(*density)?;
        positive(source, &key("rate"), insertion.rate)?;
        not_negative(source, &key("start"), insertion.start)?;
        finite(source, &key("velocity"), &insertion.velocity)?;
        finite(source, &key("rise"), &insertion.rise)?;
        for (name, value) in [("velocity", insertion.velocity), ("rise", insertion.rise)] {
            missing::along_axis(&OverTime::Constant(value), domain.geometry, &key(name), source)?;
        }
        let shift = insertion.shift(f64::INFINITY);
        source.refuse_if(
            domain.geometry == Geometry::Axisymmetric || scene.medium.is_some(),
            &format!("insertions[{index}]"),
            "inserts grains into an axisymmetric scene or one with a fluid, which sees every grain from the start",
            "insert in a dry scene, and begin the other from its grains.csv with [[grain_files]]",
        )?;
        for axis in 0..domain.dimensions() {
            let c = domain.geometry.component(axis);
            bed.room(c)?;
            let (low, high) = (lower[c] + shift[c].min(0.0), upper[c] + shift[c].max(0.0));
            source.refuse_if(
                low < domain.lower[axis] || high > domain.upper[axis],
                &key("upper"),
                format_args!("{upper:?} and lower {lower:?} reach outside the box, moving by {shift:?}"),
                "keep the region in the box, or enlarge [domain]",
            )?;
        }
    }
    Ok(())
}

/// What groups, rough walls and insertions have in common.
struct Bed<'a> {
    key: &'a dyn Fn(&str) -> String,
    source: &'a SceneSource,
    corners: [&'a [f64; 3]; 2],
    radius: f64,
    spread: f64,
}

impl Bed<'_> {
    fn check(&self, density: f64) -> Check {
        let (key, source) = (self.key, self.source);
        positive(source, &key("radius"), self.radius)?;
        positive(source, &key("density"), density)?;
        finite(source, &key("lower"), self.corners[0])?;
        finite(source, &key("upper"), self.corners[1])?;
        source.refuse_if(
            !(0.0..1.0).contains(&self.spread),
            &key("radius_spread"),
            format_args!("is {}; allowed: 0 ≤ spread < 1", self.spread),
            "a spread of 1 or more makes a radius ≤ 0",
        )
    }

    /// The largest grain fits in along a component.
    fn room(&self, c: usize) -> Check {
        let width = 2.0 * self.radius * (1.0 + self.spread);
        self.source.refuse_if(
            self.corners[1][c] - self.corners[0][c] < width,
            &(self.key)("upper"),
            format_args!("leaves no room for a grain of diameter {width}"),
            "make the region larger than the largest grain",
        )
    }
}
