//! The grids of a scene, each 1.5 times as fine as the one before, cells of the same shape.

use bedload_scene::CheckedScene;

use crate::accuracy::bounces;
use crate::keys;
use crate::resolution::{self, LEAST, fast, is_fast};

/// How many times finer each grid is.
const RATIO: f64 = 1.5;

/// D/Δx of the coarsest grid: the coarsest of the charts.
const COARSEST: f64 = 6.0;

/// Grids before the one that the scene or the chart names: two, and three make an order.
const BEFORE: i32 = 2;

/// Part by which a grid may be finer or coarser than it should be, where the numbers of cells fit better.
const LEEWAY: f64 = 0.1;

/// Its grids.
pub(super) struct Ladder<'a> {
    scene: &'a CheckedScene,
    /// How many times finer than the scene's the coarsest is.
    coarsest: f64,
    /// Those up to this one are run, whatever they cost: two, and that of the chart.
    pub(super) needed: usize,
    /// The coarsest that may be the run itself: that of the chart; the third where a rebound is measured,
    /// since where in its cell and window a sphere touches makes values swing by themselves.
    pub(super) least: usize,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rung {
    /// Cells along each axis.
    pub(super) cells: Vec<u64>,
    /// Width of its cells over those of the scene, the mean of all axes.
    pub(super) width: f64,
    /// How many times finer than the scene's it is along the axis where it is the least.
    least: f64,
    /// `KEY=VALUE` that give the scene this grid, and its step where it names one.
    pub(super) set: Vec<String>,
}

impl<'a> Ladder<'a> {
    /// Of a scene as written, or with the setting of its chart.
    pub(super) fn of(scene: &'a CheckedScene, charted: bool) -> Self {
        let written = resolution::of(scene);
        let before = match written {
            Some(written) => ((written / COARSEST).ln() / RATIO.ln() + 1e-9).floor() as i32,
            None => BEFORE,
        }
        .clamp(0, BEFORE);
        let coarsest = match written {
            Some(written) if !charted => COARSEST / written,
            _ => RATIO.powi(-before),
        };
        let chart = if charted { before as usize } else { 0 };
        let swings = if bounces(scene) { BEFORE as usize } else { 0 };
        let mut ladder = Self { scene, coarsest, needed: chart.max(1), least: chart.max(swings) };
        // Numbers of cells that fit may be too few.
        while !charted && written.is_some_and(|written| written * ladder.rung(0).least < LEAST) {
            ladder.coarsest *= 1.0 + 0.5 * LEEWAY;
        }
        ladder
    }

    /// Grid `place`, from the coarsest on.
    pub(super) fn rung(&self, place: usize) -> Rung {
        let domain = &self.scene.scene.domain;
        let stretched = domain.stretching.map(|stretching| stretching.axis);
        let is_stretched = |axis: usize| stretched == Some(domain.geometry.axes()[axis]);
        let written: Vec<f64> = domain.cells.iter().map(|count| *count as f64).collect();
        let (finer, cells) = fitting(&written, is_stretched, self.coarsest * RATIO.powi(place as i32));
        let mut set = resolution::set(&cells, domain.stretching.map(|stretching| stretching.spacing / finer));
        if let Some(dt) = keys::look_up(self.scene, keys::FLUID_DT).and_then(toml::Value::as_float) {
            set.push(format!("{}={:?}", keys::FLUID_DT, dt / finer));
        }
        let finer: Vec<f64> =
            cells.iter().zip(&written).map(|(count, written)| *count as f64 / written).collect();
        let width = finer.iter().product::<f64>().powf(-1.0 / written.len() as f64);
        let least = finer.iter().copied().fold(f64::INFINITY, f64::min);
        Rung { cells, width, least, set }
    }
}

/// Fast numbers of cells, about `wanted` times as many along each axis as are `written`: how many times they
/// are, and the numbers.
///
/// From the axis with the fewest cells, whose numbers stand the farthest apart: that one of its numbers with
/// which the cells change their shape the least. A stretched axis has no shape to keep.
fn fitting(written: &[f64], is_stretched: impl Fn(usize) -> bool, wanted: f64) -> (f64, Vec<u64>) {
    let even = |axis: &usize| !is_stretched(*axis);
    let fewest = (0..written.len()).filter(even).min_by(|a, b| written[*a].total_cmp(&written[*b]));
    let exact = fewest.map_or(1.0, |axis| written[axis]) * wanted;
    let around = (exact * (1.0 - LEEWAY)).ceil() as u64..=(exact * (1.0 + LEEWAY)) as u64;
    let fit = |count: u64| {
        let finer = fewest.map_or(wanted, |axis| count as f64 / written[axis]);
        let all: Vec<u64> = written
            .iter()
            .enumerate()
            .map(|(axis, cells)| if is_stretched(axis) { up(cells * finer) } else { nearest(cells * finer) })
            .collect();
        let off = |axis: usize| (all[axis] as f64 / (written[axis] * finer)).ln().abs();
        let misfit = (0..written.len()).filter(even).map(off).fold(0.0, f64::max);
        (misfit + (finer / wanted).ln().abs(), finer, all)
    };
    let numbers = around.filter(is_fast).chain([nearest(exact)]);
    let best = numbers.map(fit).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(|| (1.0, Vec::new()), |(_, finer, all)| (finer, all))
}

/// The least fast number of at least so many cells.
fn up(cells: f64) -> u64 {
    fast((cells - 1e-6).ceil().max(1.0) as u64)
}

fn nearest(cells: f64) -> u64 {
    let above = up(cells);
    let below = (2..=cells as u64).rev().find(is_fast).unwrap_or(above);
    if above as f64 / cells < cells / below as f64 { above } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes;

    fn scene(more: &str, cells: &str, upper: &str) -> CheckedScene {
        test_scenes::scene(format!(
            "until = 1.0\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, 0.0]\nupper = {upper}\n\
             cells = {cells}\nboundary = {{ r_upper = \"free-slip\", z = \"free-slip\" }}\n\
             [medium]\ndensity = 1.0\nviscosity = 1.0\n{more}"
        ))
    }

    const GRAIN: &str = "[[grains]]\nposition = [0.0, 0.0, 5.0]\nradius = 0.5\ndensity = 2.0\n";

    #[test]
    fn grids_are_about_one_and_a_half_times_as_fine_with_cells_of_one_shape() {
        let scene = scene(&format!("{GRAIN}[fluid.time]\ndt = 0.01\n"), "[24, 75]", "[3.1, 9.7]");
        let ladder = Ladder::of(&scene, false);
        let rungs: Vec<Rung> = (0..5).map(|place| ladder.rung(place)).collect();
        let written = resolution::of(&scene).unwrap();
        for (place, rung) in rungs.iter().enumerate() {
            let finer = CheckedScene::new(scene.source.clone().with_overrides(&rung.set).unwrap()).unwrap();
            let (wide, tall) = (finer.scene.domain.spacing(0), finer.scene.domain.spacing(1));
            assert!((wide / tall).ln().abs() < 0.06, "{rung:?}: {wide} {tall}");
            let wanted = COARSEST * RATIO.powi(place as i32);
            let got = written / rung.width;
            assert!(got > 0.88 * wanted && got < 1.12 * wanted, "{rung:?}: {got} for {wanted}");
            let dt = keys::look_up(&finer, keys::FLUID_DT).and_then(toml::Value::as_float).unwrap();
            assert!((dt / (0.01 * rung.width) - 1.0).abs() < 0.04, "{dt}");
        }
        assert!(rungs.windows(2).all(|pair| pair[1].width < pair[0].width / 1.25), "{rungs:?}");
        assert_eq!(ladder.least, 0);
    }

    #[test]
    fn the_grid_of_a_chart_is_one_of_them_and_the_coarsest_that_may_serve() {
        for (cells, least) in [("[18, 60]", 0), ("[30, 100]", 1), ("[48, 160]", 2), ("[96, 320]", 2)] {
            let scene = scene(GRAIN, cells, "[3.0, 10.0]");
            let ladder = Ladder::of(&scene, true);
            assert_eq!(ladder.least, least, "{cells}");
            let rung = ladder.rung(least);
            assert_eq!(rung.set, [format!("domain.cells={cells}")]);
            assert!((rung.width - 1.0).abs() < 1e-12);
        }
        // Without a grain what the scene names is the third.
        let scene = scene("", "[48, 160]", "[3.0, 10.0]");
        assert_eq!(Ladder::of(&scene, false).rung(2).cells, [48, 160]);
    }

    #[test]
    fn the_coarsest_is_never_coarser_than_what_is_run() {
        for tenths in 11..60 {
            let upper = format!("[{}, {}]", 0.1 * f64::from(tenths), 7.3 + 0.13 * f64::from(tenths));
            let scene = scene(GRAIN, "[24, 80]", &upper);
            let rung = Ladder::of(&scene, false).rung(0);
            let coarse = CheckedScene::new(scene.source.with_overrides(&rung.set).unwrap()).unwrap();
            let cells = resolution::of(&coarse).unwrap();
            assert!((LEAST..1.4 * LEAST).contains(&cells), "{upper}: {cells}");
        }
    }

    #[test]
    fn numbers_of_cells_are_near_and_fast() {
        assert_eq!([4.8, 6.9, 22.0, 28.0, 97.0].map(nearest), [4, 6, 24, 30, 96]);
        assert_eq!([5.0, 6.9, 22.0, 28.0, 97.0].map(up), [6, 8, 24, 30, 100]);
    }
}
