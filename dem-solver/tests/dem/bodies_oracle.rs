//! Gaps between bodies of the plane against those of another library (parry2d: GJK where they are apart, EPA
//! where they overlap), which goes another way to them.
use crate::common::{Random, add_body, dem, law, spec};
use bedload_scene::Outline;
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::details::contact_support_map_support_map;
use parry2d_f64::shape::{Ball, ConvexPolygon, SupportMap};

struct Ellipse([f64; 2]);

impl SupportMap for Ellipse {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let [a, b] = self.0;
        let scaled = [a * direction.x, b * direction.y];
        let size = scaled[0].hypot(scaled[1]);
        Vector::new(a * scaled[0] / size, b * scaled[1] / size)
    }
}

/// A disc of a radius, or a body of an outline.
enum Form {
    Disc(f64),
    Body(Outline),
}

impl Form {
    fn any(random: &mut Random) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        match between(0.0, 4.0) as u32 {
            0 => Self::Disc(between(0.2, 0.6)),
            1 => Self::Body(Outline::Ellipse { semi_axes: [between(0.05, 0.8), between(0.05, 0.8)] }),
            2 => Self::Body(Outline::rectangle([between(0.1, 1.5), between(0.1, 1.5)])),
            _ => {
                // Points of an ellipse: convex whatever they are.
                let count = between(3.0, 12.0) as usize;
                let (a, b) = (between(0.3, 0.7), between(0.3, 0.7));
                let angles = (0..count)
                    .map(|k| 2.0 * std::f64::consts::PI * (k as f64 + between(-0.3, 0.3)) / count as f64);
                let vertices: Vec<[f64; 2]> = angles.map(|t| [a * t.cos(), b * t.sin()]).collect();
                Self::Body(Outline::polygon(&vertices).expect("convex"))
            }
        }
    }

    fn of_parry(&self) -> Box<dyn SupportMap> {
        match self {
            Self::Disc(radius) => Box::new(Ball::new(*radius)),
            Self::Body(Outline::Ellipse { semi_axes }) => Box::new(Ellipse(*semi_axes)),
            Self::Body(Outline::Polygon { vertices }) => {
                let points = vertices.iter().map(|[x, z]| Vector::new(*x, *z)).collect();
                Box::new(ConvexPolygon::from_convex_polyline_unmodified(points).expect("convex"))
            }
        }
    }
}

#[test]
fn gaps_are_those_of_gjk_and_epa() {
    let mut random = Random(7);
    let (mut apart, mut overlapping, mut worst) = (0, 0, [0.0f64; 2]);
    for _ in 0..20_000 {
        let forms = [Form::any(&mut random), Form::any(&mut random)];
        if forms.iter().all(|form| matches!(form, Form::Disc(_))) {
            continue;
        }
        let angles = [0, 1].map(|_| 6.0 * random.next());
        let places = [[0.0, 0.0], [1.6 * (random.next() - 0.5), 1.6 * (random.next() - 0.5)]];
        let poses = [0, 1].map(|k| Pose::new(Vector::new(places[k][0], places[k][1]), -angles[k]));
        let (one, other) = (forms[0].of_parry(), forms[1].of_parry());
        let found = contact_support_map_support_map(&poses[0].inv_mul(&poses[1]), &*one, &*other, 10.0);
        let expected = found.expect("within reach").dist;
        // Contacts are shallow.
        if expected < -0.01 {
            continue;
        }
        let mut set_up = spec(Vec::new(), law(1.0, 1.0));
        set_up.shape = dem_solver::Shape::Disc;
        for (k, form) in forms.iter().enumerate() {
            let position = [places[k][0], 0.0, places[k][1]];
            match form {
                Form::Disc(radius) => {
                    set_up.grains.push(dem_solver::Grain {
                        free: dem_solver::Freedom::PLANE,
                        ..dem_solver::Grain::new(position, *radius, 1.0)
                    });
                }
                Form::Body(outline) => drop(add_body(&mut set_up, outline.clone(), position, 1.0).position),
            }
            set_up.grains[k].orientation = [(0.5 * angles[k]).cos(), 0.0, (0.5 * angles[k]).sin(), 0.0];
        }
        let mut solver = dem(&set_up);
        solver.advance(1e-9, 1, &[]).expect("advances");
        let gap = solver.observations().gap_end[0];
        // EPA goes along smooth surfaces by chords, along polygons exactly.
        let smooth = !forms.iter().all(|form| matches!(form, Form::Body(Outline::Polygon { .. })));
        let worst = &mut worst[usize::from(smooth)];
        *worst = worst.max((gap - expected).abs());
        assert!(
            (gap - expected).abs() < if smooth { 1e-7 } else { 1e-12 },
            "{gap} beside {expected}: {places:?} {angles:?}"
        );
        if expected < 0.0 { overlapping += 1 } else { apart += 1 }
    }
    println!(
        "{apart} pairs apart, {overlapping} overlapping, largest difference of two polygons {:.1e}, of others {:.1e}",
        worst[0], worst[1]
    );
    assert!(apart > 2000 && overlapping > 150, "{apart} {overlapping}");
}
