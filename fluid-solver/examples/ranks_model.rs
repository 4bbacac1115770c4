//! Time of a step by several ranks, from what `ranks_cost` measures: `cargo run --release -p
//! bedload-fluid-solver --example ranks_model -- NS_PER_CELL LATENCY_US GB_PER_S [FILE]` (docs/ranks.md, A
//! model of more ranks). Writes a figure, by default `docs/figures/ranks-model.svg`, and prints its numbers.
//!
//! RK3 with three projections and explicit viscosity; ranks share a periodic box in slabs along z.

use fluid_solver::division::blocks;
use kuva::plot::{LegendPosition, LinePlot};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use std::error::Error;

/// Most ranks.
const MOST: usize = 4096;

/// Cells along each axis for all ranks, and for each.
const STRONG: usize = 512;
const WEAK: usize = 64;

/// Projections of a step.
const PROJECTIONS: f64 = 3.0;

/// Planes that a rank sends to its neighbours in a step, and in how many messages.
const PLANES: f64 = 25.0;
const BESIDE: f64 = 13.0;

/// Measured: seconds for a cell and step, for a message, for a byte.
#[derive(Clone, Copy)]
struct Measured {
    cell: f64,
    message: f64,
    byte: f64,
}

/// Seconds of a step on the busiest rank: work, planes to the neighbours, edges of slabs, sums through
/// rank 0.
fn parts(measured: Measured, [nx, ny, nz]: [usize; 3], ranks: usize) -> [f64; 4] {
    let Measured { cell, message, byte } = measured;
    let (p, plane) = (ranks as f64, (nx * ny) as f64);
    let work = cell * plane * nz as f64 / p;
    if ranks == 1 {
        return [work, 0.0, 0.0, 0.0];
    }
    let beside = BESIDE * message + 8.0 * PLANES * plane * byte;
    let edges = 8.0 * 4.0 * plane * (p - 1.0) / p;
    let edges = PROJECTIONS * (2.0 * (p - 1.0) * message + edges * byte);
    let sums = PROJECTIONS * 5.0 * (p - 1.0) * message;
    [work, beside, edges, sums]
}

/// The same with sums along a tree: four messages for each of its levels.
fn by_tree(measured: Measured, cells: [usize; 3], ranks: usize) -> f64 {
    let [work, beside, edges, _] = parts(measured, cells, ranks);
    work + beside + edges + PROJECTIONS * 4.0 * (ranks as f64).log2() * measured.message
}

fn strong(_: usize) -> [usize; 3] {
    [STRONG; 3]
}

fn weak(ranks: usize) -> [usize; 3] {
    [WEAK, WEAK, WEAK * ranks]
}

fn number(arguments: &[String], at: usize, what: &str) -> Result<f64, String> {
    let text = arguments.get(at).ok_or(format!("{what} is missing"))?;
    text.parse()
        .ok()
        .filter(|number: &f64| *number > 0.0)
        .ok_or(format!("{what} is {text}: a positive number"))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let measured = Measured {
        cell: 1e-9 * number(&arguments, 0, "ns per cell and step")?,
        message: 1e-6 * number(&arguments, 1, "latency in µs")?,
        byte: 1e-9 / number(&arguments, 2, "bandwidth in GB/s")?,
    };
    let file = arguments.get(3).map_or("docs/figures/ranks-model.svg", String::as_str);
    let ranks: Vec<usize> = (0..=MOST.ilog2()).map(|power| 1 << power).collect();
    let line = |cells: fn(usize) -> [usize; 3], range: &dyn Fn(usize) -> bool, tree: bool| {
        let total = |ranks: usize| match tree {
            true => by_tree(measured, cells(ranks), ranks),
            false => parts(measured, cells(ranks), ranks).iter().sum(),
        };
        let wanted = ranks.iter().copied().filter(|ranks| range(*ranks));
        wanted.map(|ranks| (ranks as f64, 1e3 * total(ranks))).collect::<Vec<_>>()
    };
    let (most, all) = (blocks(STRONG), |_: usize| true);
    let lines = [
        ("512³ shared", "#0072B2", false, line(strong, &|ranks| ranks <= most, false)),
        (
            "512³ if blocks had a plane",
            "#0072B2",
            true,
            line(strong, &|ranks| ranks >= most && ranks <= STRONG, false),
        ),
        ("64³ for each rank", "#D55E00", false, line(weak, &all, false)),
        ("the same, sums along a tree", "#D55E00", true, line(weak, &all, true)),
    ];
    for (name, cells) in [("strong", strong as fn(usize) -> [usize; 3]), ("weak", weak)] {
        for ranks in ranks.iter().copied().filter(|ranks| name == "weak" || *ranks <= STRONG) {
            let [work, beside, edges, sums] =
                parts(measured, cells(ranks), ranks).map(|seconds| 1e3 * seconds);
            let total = work + beside + edges + sums;
            println!(
                "{name}, {ranks:>4} ranks: {total:>9.3} ms = work {work:.3} + neighbours {beside:.3} + edges \
                 {edges:.3} + sums {sums:.3}"
            );
        }
    }
    let draw = |(name, colour, dashed, points): (&str, &str, bool, Vec<(f64, f64)>)| {
        let line =
            LinePlot::new().with_data(points).with_color(colour).with_legend(name).with_stroke_width(2.0);
        Plot::Line(if dashed { line.with_dashed() } else { line })
    };
    let plots: Vec<Plot> = lines.into_iter().map(draw).collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_width(860.0)
        .with_height(420.0)
        .with_title("Time of a step by ranks, from measured costs")
        .with_x_label("ranks")
        .with_y_label("ms per step")
        .with_log_x()
        .with_log_y()
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_width(230.0)
        .with_font_family("system-ui, sans-serif")
        .with_title_size(16)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(13);
    std::fs::write(file, kuva::render_to_svg(plots, layout))?;
    println!("{file}");
    Ok(())
}
