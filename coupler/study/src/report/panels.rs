//! The pictures of a page: vorticity around a grain, and the grains, at some of the times at which files were
//! written.

use bedload_scene::{CheckedScene, Geometry};

use super::player::spread;
use super::run_files::{RunFiles, column};
use crate::page::{Value, context};
use crate::pictures::{Frame, GrainSheet, Quantity, Shape, Slice, sheet, sheet_of_grains};
use crate::table::interpolated;
use coupler::failure::Failure;
use coupler::number::number;

/// Pictures in a panel.
const MOST_PICTURES: usize = 24;
const MOST_GRAIN_PICTURES: usize = 12;

/// A picture of vorticity shows this far around the grain's centre, in D: sideways, down and up (the wake),
/// as figure 6 of Izard et al. (2014) does.
const REACH: [f64; 3] = [1.6, 1.0, 2.2];

/// Most grains of a scene whose first one is shown in particular.
const FEW: usize = 8;

/// Vorticity around the first grain; nothing if the run left no fields, has no grain, or many.
pub(super) fn vorticity(run: &RunFiles) -> Result<Option<Value>, Failure> {
    let Some(scene) = &run.scene else { return Ok(None) };
    let grain = run.grains().first().copied().unwrap_or(0);
    let few = scene.grains.len() <= FEW;
    let Some(radius) = scene.grains.get(grain).filter(|_| few).map(|grain| grain.radius) else {
        return Ok(None);
    };
    let shape = Shape::of(&run.summary, Some(scene));
    let plane = |time: f64| {
        let position = position(run, scene, grain, time)[1];
        (run.summary.size.geometry == Geometry::Space).then_some(Slice { axis: 1, position })
    };
    let with_field: Vec<_> = run.instants.iter().filter(|instant| instant.has_fluid()).collect();
    let (mut frames, mut faults) = (Vec::new(), Vec::new());
    for number in spread(with_field.len(), MOST_PICTURES) {
        match Frame::read(with_field[number], &plane, Quantity::VORTICITY, shape) {
            Ok(frame) => frames.push(frame),
            Err(fault) => faults.push(fault),
        }
    }
    let [aside, down, up] = REACH.map(|reach| reach * 2.0 * radius);
    for frame in &mut frames {
        let at = position(run, scene, grain, frame.time);
        frame.view = ((at[0] - aside, at[2] - down), (at[0] + aside, at[2] + up));
    }
    let (time, unit) = if run.scales.by_gravity { (" √(D/g)", "√(g/D)") } else { (" s", "1/s") };
    let caption = |frame: &Frame| format!("t = {}{time}", number(frame.time / run.scales.time));
    let captions: Vec<String> = frames.iter().map(caption).collect();
    let pictures = sheet(&frames, &captions, (1.0 / run.scales.time, unit))?;
    let mirror = if shape.mirrored { ", mirrored about the axis with its sign" } else { "" };
    let (count, total) = (frames.len(), with_field.len());
    let about = format!("Vorticity about y{mirror}. {count} of {total} field files.");
    Ok((pictures.is_some() || !faults.is_empty()).then(|| context! { pictures, about, faults }))
}

/// Position of a grain at `time` from the series, between its rows, the first of which is the scene's own at
/// t = 0; components that have no column are those of the scene.
fn position(run: &RunFiles, scene: &CheckedScene, grain: usize, time: f64) -> [f64; 3] {
    let mut at = scene.grains.get(grain).map_or([0.0; 3], |grain| grain.position);
    let times = run.series.time();
    for (axis, at) in at.iter_mut().enumerate() {
        if let Some(column) = run.series.column(&column("position", axis, grain)) {
            let rows = times.iter().copied().zip(column.iter().copied());
            let known: Vec<(f64, f64)> = std::iter::once((0.0, *at)).chain(rows).collect();
            let last = known.last().map_or(0.0, |(last, _)| *last);
            *at = interpolated(&known, time.min(last)).unwrap_or(*at);
        }
    }
    at
}

/// The grains, coloured by speed.
pub(super) fn grains(run: &RunFiles) -> Result<Option<Value>, Failure> {
    let files = &run.grain_files;
    let chosen = spread(files.len(), MOST_GRAIN_PICTURES);
    let chosen: Vec<_> = chosen.into_iter().map(|number| files[number].clone()).collect();
    let GrainSheet { pictures, cut, faults } = sheet_of_grains(&chosen)?;
    let cut = cut.map(|plane| format!(" Spheres are cut by the plane y = {} m.", number(plane.position)));
    let about = format!(
        "Coloured by speed, to scale; held grains are grey, single ones far away are left out.{} {} of {} files \
         of grains.",
        cut.unwrap_or_default(),
        chosen.len() - faults.len(),
        files.len()
    );
    Ok((pictures.is_some() || !faults.is_empty()).then(|| context! { pictures, about, faults }))
}
