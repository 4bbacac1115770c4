//! Outlines against sums over small squares and many points.

use std::f64::consts::PI;

use bedload_outline::Outline;

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length([x, z]: [f64; 2]) -> f64 {
    x.hypot(z)
}

fn shapes() -> Vec<Outline> {
    let five = [[0.3, -0.4], [0.9, 0.1], [0.5, 0.8], [-0.2, 0.7], [-0.5, 0.0]];
    vec![
        Outline::rectangle([1.0, 0.4]),
        Outline::polygon(&five).unwrap(),
        Outline::Ellipse { semi_axes: [0.5, 0.2] },
        Outline::Ellipse { semi_axes: [0.3, 0.6] },
    ]
}

#[test]
fn area_centre_and_inertia_are_those_of_a_sum_over_small_squares() {
    for outline in shapes() {
        let (h, mut area, mut first, mut second) = (2e-3, 0.0, [0.0; 2], 0.0);
        for i in -500..500 {
            for j in -500..500 {
                let p = [(f64::from(i) + 0.5) * h, (f64::from(j) + 0.5) * h];
                if outline.distance(p).0 < 0.0 {
                    area += h * h;
                    first = [first[0] + p[0] * h * h, first[1] + p[1] * h * h];
                    second += (p[0] * p[0] + p[1] * p[1]) * h * h;
                }
            }
        }
        assert!((outline.area() / area - 1.0).abs() < 5e-3, "{outline:?}");
        assert!(length(first) < 1e-3 * area, "{outline:?}: {first:?}");
        assert!((outline.gyration() / (second / area) - 1.0).abs() < 5e-3, "{outline:?}");
    }
    assert!((Outline::rectangle([2.0, 1.0]).gyration() - 5.0 / 12.0).abs() < 1e-15);
    assert!((Outline::rectangle([2.0, 1.0]).thickness() - 1.0).abs() < 1e-15);
}

#[test]
fn the_distance_is_that_of_the_nearest_of_many_points() {
    for outline in shapes() {
        let surface: Vec<[f64; 2]> = match &outline {
            Outline::Ellipse { semi_axes: [a, b] } => {
                (0..20_000).map(|k| f64::from(k) * PI / 1e4).map(|t| [a * t.cos(), b * t.sin()]).collect()
            }
            Outline::Polygon { vertices } => vertices
                .iter()
                .zip(vertices.iter().cycle().skip(1))
                .flat_map(|(p, q)| {
                    (0..4_000).map(move |k| {
                        let part = f64::from(k) / 4e3;
                        [p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])]
                    })
                })
                .collect(),
        };
        for i in -12..=12 {
            for j in -12..=12 {
                let p = [0.09 * f64::from(i), 0.07 * f64::from(j)];
                let nearest = surface.iter().map(|q| length(minus(p, *q))).fold(f64::INFINITY, f64::min);
                let (distance, normal) = outline.distance(p);
                assert!((distance.abs() - nearest).abs() < 3e-4, "{outline:?} {p:?}: {distance}, {nearest}");
                assert!((length(normal) - 1.0).abs() < 1e-12);
                // Along the normal it grows.
                let e = 1e-4;
                let further = outline.distance([p[0] + e * normal[0], p[1] + e * normal[1]]).0;
                assert!(((further - distance) / e - 1.0).abs() < 2e-2, "{outline:?} {p:?}");
            }
        }
    }
}

#[test]
fn vertices_that_make_no_body_are_told() {
    let told = |v: &[[f64; 2]], what: &str| {
        let (message, _) = Outline::polygon(v).unwrap_err();
        assert!(message.contains(what), "{message} is not: {what}");
    };
    told(&[[0.0, 0.0], [1.0, 0.0]], "has 2 of them");
    told(&[[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]], "[2] is [NaN");
    told(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "no area");
    told(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "[1] and the next one coincide");
    told(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], "cross");
    told(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]], "not convex");
    // A star of five points turns twice.
    let star: Vec<[f64; 2]> =
        (0..5).map(|k| 4.0 * PI * f64::from(k) / 5.0).map(|a| [a.cos(), a.sin()]).collect();
    told(&star, "cross");
    // Either way of turning is the same body.
    let one = Outline::polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap();
    let other = Outline::polygon(&[[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]).unwrap();
    assert!((one.area() - other.area()).abs() < 1e-15 && (one.area() - 0.5).abs() < 1e-15);
}
