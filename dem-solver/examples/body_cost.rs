//! What contacts of bodies that are not round cost: `cargo run --release -p bedload-dem --example body_cost`.
//!
//! Pairs of bodies that lie on each other, each pair far from the others, in windows of 1,000 sub-steps; beside it one
//! query of contact of the same two bodies by parry2d.

use bedload_scene::Outline;
use dem_solver::{ContactLaw, Dem, DemSpec, Freedom, Grain, LinearSpringDashpot, Shape, SpecError};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::details::contact_support_map_support_map;
use parry2d_f64::shape::{ConvexPolygon, SupportMap};
use std::hint::black_box;
use std::time::Instant;

const PAIRS: usize = 50;

/// Pairs held together by an overlap of 1e-4 along z.
fn pairs(outlines: Option<[Outline; 2]>) -> DemSpec {
    let law = LinearSpringDashpot::new(0.8, 1e-3, 0.3);
    let mut spec = DemSpec::new(Vec::new(), ContactLaw::LinearSpringDashpot(law));
    spec.shape = Shape::Disc;
    for k in 0..PAIRS {
        for (side, at) in [(0, -1.0), (1, 1.0)] {
            let height =
                outlines.as_ref().map_or(0.5, |outlines| outlines[side].support([0.0, -at])[1].abs());
            let position = [5.0 * k as f64, 0.0, at * (height - 5e-5)];
            match &outlines {
                Some(outlines) => {
                    spec.add_body(outlines[side].clone(), position, 1.0);
                }
                None => spec.grains.push(Grain { free: Freedom::PLANE, ..Grain::new(position, 0.5, 1.0) }),
            }
            spec.grains[2 * k + side].free.translation = [false; 3];
            spec.grains[2 * k + side].free.rotation = [false, true, false];
        }
    }
    spec
}

fn measure(name: &str, outlines: Option<[Outline; 2]>) -> Result<(), SpecError> {
    let mut dem = Dem::new(&pairs(outlines))?;
    let (mut best, mut contacts) = (f64::INFINITY, 0);
    for _ in 0..40 {
        let start = Instant::now();
        if let Ok(report) = dem.advance(2e-2, 1000, &[]) {
            contacts = report.contacts;
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    let cost = best * 1e9 / 1000.0 / PAIRS as f64;
    println!("{name:32} {cost:8.1} ns per pair and sub-step, {contacts} points in {PAIRS} pairs");
    Ok(())
}

struct Ellipse([f64; 2]);

impl SupportMap for Ellipse {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let [a, b] = self.0;
        let scaled = [a * direction.x, b * direction.y];
        let size = scaled[0].hypot(scaled[1]);
        Vector::new(a * scaled[0] / size, b * scaled[1] / size)
    }
}

fn parry(name: &str, one: &dyn SupportMap, other: &dyn SupportMap, heights: f64) {
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        for k in 0..1000 {
            let pose = Pose::new(Vector::new(1e-6 * f64::from(k), heights - 1e-4), 0.0);
            black_box(contact_support_map_support_map(black_box(&pose), one, other, 1.0));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{name:32} {:8.1} ns per query (parry2d)", best * 1e6);
}

fn main() -> Result<(), SpecError> {
    let rectangle = || Outline::rectangle([1.0, 0.6]);
    let ellipse = || Outline::Ellipse { semi_axes: [0.5, 0.3] };
    measure("two discs", None)?;
    measure("two rectangles", Some([rectangle(), rectangle()]))?;
    measure("rectangle and ellipse", Some([rectangle(), ellipse()]))?;
    measure("two ellipses", Some([ellipse(), ellipse()]))?;
    let corners = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]].map(|[x, z]| Vector::new(x, z));
    if let Some(polygon) = ConvexPolygon::from_convex_polyline_unmodified(corners.to_vec()) {
        parry("two rectangles", &polygon, &polygon, 0.6);
    }
    let ellipse = Ellipse([0.5, 0.3]);
    parry("two ellipses", &ellipse, &ellipse, 0.6);
    Ok(())
}
