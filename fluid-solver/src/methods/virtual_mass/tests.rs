use super::rest::OPEN;
use super::*;
use crate::axis::AxisSpec;
use crate::grid::GridSpec;

fn grid(boundary: Boundary<3>) -> Grid<3> {
    let axis = AxisSpec::Uniform { start: 0.0, end: 10.0, cells: 8 };
    let spec = GridSpec {
        geometry: Geometry::Space,
        axes: [axis.clone(), axis.clone(), axis],
        boundaries: [[Boundary::Periodic; 2], [Boundary::Periodic; 2], [boundary; 2]],
    };
    Grid::new(&spec).expect("a grid")
}

fn sphere(radius: f64, density: f64) -> Shape {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    Shape::round(radius, density, volume, 0.4 * radius * radius)
}

/// What is not free is fixed.
fn by_gap_of(wall: Boundary<3>, shapes: &[Shape], free: Vec<bool>) -> ByGap {
    ByGap::new(&grid(wall), shapes, [free.clone(), free])
}

fn at(centre: [f64; 3]) -> Motion {
    Motion { centre, ..Motion::default() }
}

/// With the masses of the messages, equal and opposite impulses J give the speeds that the whole matrix of
/// masses gives: (m₁ + L₁) ΔU₁ − M ΔU₂ = J, −M ΔU₁ + (m₂ + L₂) ΔU₂ = −J.
#[test]
fn unequal_grains_get_the_speeds_of_the_pair() {
    let density = 1.3;
    for (one, two, gap) in [
        (sphere(1.0, 3.0), sphere(1.0, 3.0), 0.0),
        (sphere(1.0, 3.0), sphere(0.9, 2.0), 0.0),
        (sphere(1.0, 8.0), sphere(0.95, 8.0), 0.05),
        (sphere(1.0, 0.1), sphere(1.0, 0.2), 0.0),
    ] {
        let [c_one, c_two] = of_a_pair(3, density, [&one, &two], [true; 2], gap);
        let (a, b) = (beside(3, one.radius, two.radius, gap), beside(3, two.radius, one.radius, gap));
        let matrix = nalgebra::Matrix2::new(
            (one.density + density * a.own) * one.volume,
            -density * one.volume * a.mutual,
            -density * one.volume * a.mutual,
            (two.density + density * b.own) * two.volume,
        );
        let exact = matrix.try_inverse().expect("a mass matrix") * nalgebra::Vector2::new(1.0, -1.0);
        let speed = |shape: &Shape, c: f64| 1.0 / ((shape.density + density * c) * shape.volume);
        let wall = images::touching_a_wall(3);
        if c_one < wall && c_two < wall {
            assert!((speed(&one, c_one) / exact[0] - 1.0).abs() < 1e-3, "{c_one} {c_two}");
            assert!((speed(&two, c_two) / -exact[1] - 1.0).abs() < 1e-3, "{c_one} {c_two}");
        } else {
            assert!(c_one.max(c_two) <= wall + 1e-9);
            assert!((speed(&one, c_one) + speed(&two, c_two)) / (exact[0] - exact[1]) < 1.2);
        }
    }
}

#[test]
fn walls_neighbours_and_periodic_images_are_found() {
    let shapes = [sphere(1.0, 2.0), sphere(1.0, 2.0), sphere(1.0, 2.0), sphere(1.0, 2.0)];
    // 0 and 1 touch across the periodic face, 2 touches the floor, 3 is alone.
    let motions = [at([0.5, 5.0, 5.0]), at([8.5, 5.0, 5.0]), at([5.0, 2.0, 1.0]), at([5.0, 7.0, 5.0])];
    let contact = at_a_wall(3, 1.0, 0.0) - 0.5;
    let mut by_gap = by_gap_of(Boundary::WALL, &shapes, vec![true; 4]);
    let excess = by_gap.excess(&shapes, 1.0, &motions, 0.5).to_vec();
    for (grain, expected) in [contact, contact, contact, 0.0].into_iter().enumerate() {
        assert!((excess[grain] - expected).abs() < 1e-12, "grain {grain}: {excess:?}");
    }
    // A held neighbour takes the value of a pair of which one moves, and no mass itself.
    let mut by_gap = by_gap_of(Boundary::Outflow, &shapes, vec![true, false, true, true]);
    let excess = by_gap.excess(&shapes, 1.0, &motions, 0.5);
    assert!((excess[0] - (beside(3, 1.0, 1.0, 0.0).own - 0.5)).abs() < 1e-12);
    assert_eq!(&excess[1..], [0.0; 3]);
}

/// Of walls and neighbours that a free grain nears fast enough, the first.
#[test]
fn a_touch_is_foreseen() {
    let shapes = [sphere(1.0, 2.0), sphere(1.0, 2.0)];
    let mut by_gap = by_gap_of(Boundary::WALL, &shapes, vec![true, false]);
    let mut until = |place: [f64; 3], velocity: [f64; 3]| {
        let motions = [Motion { velocity, ..at(place) }, at([5.0, 5.0, 5.0])];
        by_gap.until_touch(&shapes, &motions, 2.0, 0.1)
    };
    assert!((until([2.0, 2.0, 1.5], [0.0, 0.0, -0.5]) - 1.0).abs() < 1e-12, "the floor");
    assert!((until([5.0, 5.0, 2.7], [0.0, 0.0, 0.6]) - 0.5).abs() < 1e-9, "a neighbour");
    for (place, velocity, why) in [
        ([2.0, 2.0, 1.5], [0.0, 0.0, -0.2], "later"),
        ([2.0, 2.0, 1.1], [0.0, 0.0, -0.06], "slow"),
        ([2.0, 2.0, 1.1], [0.3, 0.0, 0.4], "away"),
        ([2.0, 2.0, 0.9], [0.0, 0.0, -0.5], "in contact"),
    ] {
        assert_eq!(until(place, velocity), 2.0, "{why}");
    }
}

/// Masks are open where grains touch the floor or each other, towards it, for the first windows of rest.
#[test]
fn masks_open_where_grains_have_come_to_rest() {
    let mut shapes = [(); 3].map(|()| sphere(1.0, 2.0));
    let mut by_gap = by_gap_of(Boundary::WALL, &shapes, vec![true, false, true]);
    // One on the floor; one, fixed, above it; one that passes by it.
    let motions = |speed: f64| {
        let passes = Motion { velocity: [speed, 0.0, 0.0], ..at([4.99, 2.0, 2.99]) };
        [at([3.0, 2.0, 0.999]), at([3.0, 2.0, 2.99]), passes]
    };
    let mut rests = [0; 3];
    let mut open = |now: &[Motion], slow: f64| {
        shapes.iter_mut().for_each(|shape| shape.patches.clear());
        by_gap.open_masks(&mut shapes, now, [slow, 0.1], (&mut rests, true));
        shapes.each_ref().map(|shape| shape.patches.iter().map(|patch| patch.normal).collect::<Vec<_>>())
    };
    let up = |normal: &[f64; 3]| (normal[2] - 1.0).abs() < 1e-9;
    for window in 0..40 {
        let [floor, fixed, passes] = open(&motions(0.2), 0.1);
        assert!(passes.is_empty());
        assert_eq!((floor.len(), fixed.len()), if window < OPEN { (2, 1) } else { (0, 0) });
        if window < OPEN {
            assert_eq!(floor[0], [0.0, 0.0, -1.0]);
            assert!(up(&floor[1]) && up(&fixed[0].map(|n| -n)));
        }
    }
    // What comes to rest on others opens both.
    let [floor, fixed, passes] = open(&motions(0.05), 0.1);
    assert_eq!((floor.len(), fixed.len(), passes.len()), (0, 1, 1));
    assert!((fixed[0][0] - 1.0).abs() < 1e-9 && (passes[0][0] + 1.0).abs() < 1e-9);
    assert!(open(&motions(0.05), 0.0).iter().all(Vec::is_empty), "short steps need none");
    // What hovers a little keeps its count, what has left and comes back begins anew.
    let above = |gap: f64| [at([3.0, 2.0, 1.0 + gap]), at([3.0, 2.0, 3.5]), at([5.0, 5.0, 5.0])];
    assert!(open(&above(0.005), 0.1)[0].is_empty() && open(&above(-0.001), 0.1)[0].is_empty());
    assert!(open(&above(0.02), 0.1)[0].is_empty());
    assert_eq!(open(&above(-0.001), 0.1)[0].len(), 1);
    // What began at rest has sealed nothing.
    rests = [u8::MAX; 3];
    shapes.iter_mut().for_each(|shape| shape.patches.clear());
    by_gap.open_masks(&mut shapes, &above(-0.001), [0.1, 0.1], (&mut rests, true));
    assert!(shapes[0].patches.is_empty());
}

/// In films below a cell masks of what moves are open to each other and to walls, the less far around the
/// wider the film; a wall that slips is a plane of symmetry.
#[test]
fn masks_are_open_in_films() {
    let mut shapes = [(); 2].map(|()| sphere(1.0, 2.0));
    let mut open = |wall: Boundary<3>, [below, gap]: [f64; 2]| {
        let mut by_gap = by_gap_of(wall, &shapes, vec![true, false]);
        shapes.iter_mut().for_each(|shape| shape.patches.clear());
        let motions = [at([3.0, 2.0, 1.0 + below]), at([3.0, 2.0, 3.0 + below + gap])];
        by_gap.open_films(&mut shapes, &motions, [2.0, 0.1]);
        shapes.each_ref().map(|shape| shape.patches.clone())
    };
    let [lower, upper] = open(Boundary::WALL, [0.5, 0.05]);
    assert_eq!((lower.len(), upper.len()), (1, 1));
    assert!((lower[0].normal[2] - 1.0).abs() < 1e-9 && (upper[0].normal[2] + 1.0).abs() < 1e-9);
    assert_eq!(lower[0].most, 34.0);
    assert!((lower[0].radius.powi(2) - 0.05).abs() < 1e-9, "{}", lower[0].radius);
    let mut at_gap = |gap: f64| open(Boundary::WALL, [0.5, gap])[0].clone();
    assert!((at_gap(-0.01)[0].radius.powi(2) - 0.1).abs() < 1e-9);
    assert!(at_gap(0.11).is_empty() && at_gap(-0.11).is_empty(), "none where there is no film");
    let [wall, _] = open(Boundary::WALL, [0.05, 0.5]);
    assert_eq!((wall.len(), wall[0].normal), (1, [0.0, 0.0, -1.0]));
    assert!((wall[0].radius.powi(2) - 0.1).abs() < 1e-9, "{}", wall[0].radius);
    // The image is as far again, and as round.
    let [slips, _] = open(Boundary::FreeSlip, [0.025, 0.5]);
    assert!((slips[0].radius.powi(2) - 0.05).abs() < 1e-9, "{}", slips[0].radius);
    let mut shapes = [(); 2].map(|()| sphere(1.0, 2.0));
    let mut fixed = by_gap_of(Boundary::WALL, &shapes, vec![false; 2]);
    fixed.open_films(&mut shapes, &[at([3.0, 2.0, 1.05]), at([3.0, 2.0, 3.1])], [2.0, 0.1]);
    assert_eq!(shapes[0].patches, [], "what is fixed is sealed");
}

/// Three in a row: the one in the middle has two contacts and counts as held for the others.
#[test]
fn a_crowd_has_the_value_of_grains_alone() {
    let shapes = [(); 3].map(|()| sphere(1.0, 2.0));
    let motions = [at([3.0, 5.0, 5.0]), at([5.0, 5.0, 5.0]), at([7.05, 5.0, 5.0])];
    let mut by_gap = by_gap_of(Boundary::WALL, &shapes, vec![true; 3]);
    let excess = by_gap.excess(&shapes, 1.0, &motions, 0.5);
    let beside_a_held_one = |gap| beside(3, 1.0, 1.0, gap).own - ALONE;
    assert!((excess[0] - beside_a_held_one(0.0)).abs() < 1e-12, "{excess:?}");
    assert_eq!(excess[1], 0.0);
    assert!((excess[2] - beside_a_held_one(0.05)).abs() < 1e-12, "{excess:?}");
}

/// The smallest gap of the window counts, so that a grain which overlaps keeps the value of a touching one.
#[test]
fn the_value_is_constant_during_a_contact() {
    let shapes = [sphere(1.0, 2.0)];
    let mut by_gap = by_gap_of(Boundary::WALL, &shapes, vec![true]);
    let mut excess = |now: f64, then: f64| {
        let dt = 0.5;
        let velocity = [0.0, 0.0, (then - now) / dt];
        by_gap.excess(&shapes, 1.0, &[Motion { velocity, ..at([5.0, 5.0, now]) }], dt)[0]
    };
    let contact = at_a_wall(3, 1.0, 0.0) - 0.5;
    assert_eq!(excess(1.2, 0.99), contact);
    assert_eq!(excess(0.98, 0.99), contact);
    assert_eq!(excess(0.999, 1.2), contact);
    assert!(excess(1.2, 1.1) < contact && excess(1.2, 1.1) > 0.0);
    assert_eq!(excess(3.0, 2.5), 0.0);
}

/// All pairs within reach, and no other, in boxes of few and of many cells.
#[test]
fn pairs_are_those_of_a_plain_search() {
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for radius in [0.2, 0.5, 1.1] {
        let shapes: Vec<Shape> = (0..80).map(|_| sphere(radius * (0.5 + 0.5 * random()), 2.0)).collect();
        let place =
            |random: &mut dyn FnMut() -> f64| [30.0 * random() - 10.0, 10.0 * random(), 10.0 * random()];
        let motions: Vec<Motion> = shapes.iter().map(|_| at(place(&mut random))).collect();
        let mut found = Vec::new();
        let mut neighbours = Neighbours::new(&grid(Boundary::WALL), &shapes, REACH);
        neighbours.each_pair(&shapes, &motions, &motions, |i, j, _| found.push((i, j)));
        found.sort_unstable();
        let mut expected = Vec::new();
        for i in 0..shapes.len() {
            for j in i + 1..shapes.len() {
                let d: f64 = (0..3)
                    .map(|c| {
                        let d = motions[i].centre[c] - motions[j].centre[c];
                        let d = if c < 2 { d - 10.0 * (d / 10.0).round() } else { d };
                        d * d
                    })
                    .sum();
                let gap = d.sqrt() - shapes[i].radius - shapes[j].radius;
                if gap < REACH * shapes[i].radius.min(shapes[j].radius) {
                    expected.push((i, j));
                }
            }
        }
        assert_eq!(found, expected, "radius {radius}");
    }
}
