//! Slabs and cells: parts of balls and lines in them.

use dem_solver::output::partition::{Grid, Partition, Slabs};
use dem_solver::{Shape, Vec3};

fn slabs(shape: Shape, period: Option<f64>) -> Partition {
    Partition::Slabs(Slabs { axis: 2, lower: 0.0, width: 0.3, count: 10, area: 2.0, period, shape })
}

fn total(partition: &Partition, x: f64) -> f64 {
    let mut sum = 0.0;
    partition.ball(&Vec3::new(0.5, 0.5, x), 0.4, |_, part| sum += part);
    sum
}

#[test]
fn parts_add_up_to_what_lies_inside() {
    for shape in [Shape::Sphere, Shape::Disc] {
        let walls = slabs(shape, None);
        assert!((total(&walls, 1.234) - 1.0).abs() < 1e-15);
        assert!((total(&walls, 0.0) - 0.5).abs() < 1e-15, "half of it is outside");
        assert!((total(&slabs(shape, Some(3.0)), 0.1) - 1.0).abs() < 1e-15, "the image has the rest");
    }
    // A unit cap of height 0.3/0.4: (2 − h)(1 + h)²/4 at h = −0.25
    let mut first = 0.0;
    slabs(Shape::Sphere, None).ball(&Vec3::new(0.0, 0.0, 0.4), 0.4, |slab, part| {
        if slab == 0 {
            first = part;
        }
    });
    assert!((first - 0.25 * 2.25 * 0.75f64.powi(2)).abs() < 1e-15, "{first}");
}

#[test]
fn lines_are_cut_at_the_edges() {
    let partition = slabs(Shape::Sphere, None);
    let mut parts = [0.0; 10];
    partition.line(&Vec3::new(0.0, 0.0, 0.9), &Vec3::new(1.0, 0.0, 0.15), |slab, part| parts[slab] += part);
    let expected = [0.2, 0.4, 0.4];
    for (part, expected) in parts.iter().zip(expected) {
        assert!((part - expected).abs() < 1e-14, "{parts:?}");
    }
    let mut level = 0.0;
    partition.line(&Vec3::new(0.0, 0.0, 0.5), &Vec3::new(1.0, 0.0, 0.5), |_, part| level += part);
    assert_eq!(level, 1.0);
}

/// Five cells along each edge of a box of 1 m.
fn whole(width: f64, periods: [Option<f64>; 3]) -> Grid {
    Grid { lower: [0.0; 3], spacing: [0.2; 3], cells: [5; 3], beyond: [[0; 2]; 3], width, periods }
}

/// What lies beside a grid of a part of the box gives it what it gives to these cells of the whole.
#[test]
fn a_part_of_the_grid_is_that_of_the_whole() {
    let periods = [Some(1.0), None, None];
    let part = Grid {
        lower: [0.4, 0.0, 0.2],
        cells: [2, 5, 1],
        beyond: [[2, 1], [0, 0], [1, 3]],
        ..whole(0.15, periods)
    };
    for x in [0.05, 0.35, 0.5, 0.95] {
        let shares = |grid: &Grid| {
            let mut parts = vec![0.0; grid.cells.iter().product()];
            let centre = Vec3::new(x, 0.45, 0.55);
            Partition::Grid(grid.clone()).ball(&centre, 0.1, |cell, part| parts[cell] += part);
            parts
        };
        let (all, few) = (shares(&whole(0.15, periods)), shares(&part));
        for (cell, share) in few.iter().enumerate() {
            let same = all[(5 + cell / 2) * 5 + 2 + cell % 2];
            assert!((share - same).abs() < 1e-15, "x = {x}, cell {cell}: {share} and {same}");
        }
    }
}

#[test]
fn the_grid_gives_everything_to_its_cells() {
    let grid = whole(0.3, [None; 3]);
    let partition = Partition::Grid(grid);
    assert_eq!(partition.count(), 125);
    assert!((total(&partition, 0.9) - 1.0).abs() < 1e-14);
    let mut sum = 0.0;
    partition.line(&Vec3::zeros(), &Vec3::new(1.0, 0.7, 0.2), |_, part| sum += part);
    assert!((sum - 1.0).abs() < 1e-14);
}

/// Over a period, which two images of a point share, every point gives the same: shifted by cells, a pattern
/// goes round.
#[test]
fn the_grid_goes_round_a_period() {
    let partition = Partition::Grid(whole(0.2, [Some(1.0), None, None]));
    let parts = |x: f64| {
        let mut parts = vec![0.0; 125];
        partition.ball(&Vec3::new(x, 0.5, 0.5), 0.1, |cell, part| parts[cell] += part);
        parts
    };
    let (inside, edge) = (parts(0.53), parts(0.93));
    assert!((edge.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    for (cell, part) in inside.iter().enumerate() {
        let around = cell / 5 * 5 + (cell % 5 + 2) % 5;
        assert!((edge[around] - part).abs() < 1e-14, "cell {cell}: {part} and {}", edge[around]);
    }
}

/// A Gaussian that is 0 at the middle of every cell lies in the nearest ones.
#[test]
fn a_narrow_gaussian_is_in_the_nearest_cell() {
    let grid = whole(1e-3, [None; 3]);
    let mut parts = Vec::new();
    Partition::Grid(grid).ball(&Vec3::new(0.95, 0.5, 0.45), 1e-3, |cell, part| parts.push((cell, part)));
    parts.retain(|(_, part)| *part != 0.0);
    assert_eq!(parts, [((2 * 5 + 2) * 5 + 4, 1.0)]);
}
