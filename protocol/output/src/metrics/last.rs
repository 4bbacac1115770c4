//! Metrics of the last state of all grains: heaps and collisions.

use super::deposit::{Heap, Surface};
use super::oblique::Oblique;
use super::touching::{Ball, largest_cluster};
use crate::columns::Sample;
use crate::points::points;
use bedload_scene::{
    CheckedScene, Column, Grain, HeapEnd, HeapReference, HeapSlope, Metric, MetricKind, Motion, SceneError,
};
use protocol::message::Kinematics;

/// The grains at t = 0 and after the last window.
#[derive(Clone, Debug)]
pub(super) struct LastState {
    grains: Vec<Grain>,
    kinematics: Vec<Kinematics>,
    floor: f64,
    /// Number of grains that are there from the start.
    present: usize,
    /// Length of the box along y, if it is periodic there, m.
    period: Option<f64>,
    /// Length of the box along y, if there is such an axis, m.
    depth: Option<f64>,
    /// Reference table of each metric that has one, by the metric's name.
    oblique: Vec<(String, Oblique)>,
    /// The same of published profiles.
    profiles: Vec<(String, Surface)>,
}

/// A published profile, in units of L₀.
fn published(reference: &HeapReference) -> Result<Surface, String> {
    let path = reference.file.display();
    let text = std::fs::read_to_string(&reference.file);
    let text = text.map_err(|error| format!("cannot read {path}: {error}"))?;
    let points = points(&text, "x_over_half_length", "height_over_half_length");
    let points = points.map_err(|what| format!("{path} {what}"))?;
    if points.len() < 2 {
        return Err(format!("{path} has {} points; two are needed", points.len()));
    }
    Ok(Surface::new(points.into_iter()))
}

impl LastState {
    /// Nothing, unless a metric of the scene needs it.
    pub(super) fn new(scene: &CheckedScene) -> Result<Option<Self>, SceneError> {
        let (mut oblique, mut profiles) = (Vec::new(), Vec::new());
        let mut needed = false;
        for (index, metric) in scene.scene.metrics.iter().enumerate() {
            needed |= metric.kind.column().is_some() || matches!(metric.kind, MetricKind::HeapAngle(_));
            if let MetricKind::ObliqueError { file, select } = &metric.kind {
                let table = Oblique::read(file, select).map_err(|why| {
                    scene.source.error(
                        &format!("metrics[{index}].file"),
                        why,
                        "name a CSV file with the columns psi1 and psi2 and those of `select`; paths count from the scene's folder",
                    )
                })?;
                oblique.push((metric.name.clone(), table));
            }
            if let MetricKind::DepositProfileDifference(reference) = &metric.kind {
                let surface = published(reference).map_err(|why| {
                    scene.source.error(
                        &format!("metrics[{index}].file"),
                        why,
                        "name a CSV file with the columns x_over_half_length and height_over_half_length; paths count from the \
                         scene's folder",
                    )
                })?;
                profiles.push((metric.name.clone(), surface));
            }
        }
        if !needed && oblique.is_empty() {
            return Ok(None);
        }
        let floor = scene.scene.domain.lower.last().copied().unwrap_or(0.0);
        Ok(Some(Self {
            grains: scene.grains.clone(),
            kinematics: Vec::new(),
            floor,
            present: scene.present(),
            period: length_along_y(scene).filter(|(_, periodic)| *periodic).map(|(length, _)| length),
            depth: length_along_y(scene).map(|(length, _)| length),
            oblique,
            profiles,
        }))
    }

    /// Keeps the state after a window.
    pub(super) fn record(&mut self, sample: &Sample) {
        self.kinematics.clear();
        self.kinematics.extend_from_slice(sample.kinematics);
    }

    /// The free grains that are there.
    fn balls(&self) -> Vec<Ball> {
        let there = |(index, (grain, motion)): &(usize, (&Grain, &Kinematics))| {
            grain.motion == Motion::Free && (*index < self.present || motion.is_there())
        };
        let all = self.grains.iter().zip(&self.kinematics).enumerate().filter(there);
        all.map(|(_, (grain, motion))| (motion.position, grain.radius)).collect()
    }

    fn heap(&self, column: &Column) -> Heap {
        let mut balls = self.balls();
        let mean = balls.iter().map(|(_, radius)| radius).sum::<f64>() / balls.len().max(1) as f64;
        if column.end == HeapEnd::Contact {
            let mut belongs = largest_cluster(&balls, self.period).into_iter();
            balls.retain(|_| belongs.next() == Some(true));
        }
        let floor = column.floor.unwrap_or(self.floor);
        let place = |(x, radius): &Ball| [x[0] - column.centre, x[2] - floor, *radius];
        let grains: Vec<[f64; 3]> = balls.iter().map(place).collect();
        Heap::new(&grains, if column.bin > 0.0 { column.bin } else { 3.0 * mean })
    }

    /// The heap whose slope is asked for.
    fn slope(&self, slope: &HeapSlope) -> Heap {
        let (centre, bin, end) = (slope.centre, slope.bin, HeapEnd::Gap);
        self.heap(&Column { half_length: 1.0, centre, release: 0.0, bin, end, floor: None })
    }

    /// L∞ of the heap as `column` says where it ends, m.
    fn half_length(&self, column: &Column) -> Option<f64> {
        match column.end {
            HeapEnd::Gap => self.heap(column).half_length(),
            HeapEnd::Contact | HeapEnd::Outermost => self.heap(column).outermost(),
        }
    }

    /// H₀ of the standing column, m.
    pub(super) fn standing_height(&self, column: &Column) -> f64 {
        self.heap(column).mean_height(column.half_length)
    }

    /// Part of the standing column that grains fill, between a tenth and four fifths of its height; it is
    /// as wide as its outermost grains, and as deep as the box (a disc fills its area).
    pub(super) fn solid_fraction(&self, column: &Column) -> f64 {
        let floor = column.floor.unwrap_or(self.floor);
        let balls = self.balls();
        let height = self.standing_height(column);
        let [low, high] = [0.1, 0.8].map(|part| floor + part * height);
        let edge = |side: f64| balls.iter().map(|(x, r)| side * x[0] + r).fold(f64::NEG_INFINITY, f64::max);
        let solid: f64 = balls.iter().map(|(x, r)| slab(*r, low - x[2], high - x[2], self.depth)).sum();
        solid / ((edge(1.0) + edge(-1.0)) * self.depth.unwrap_or(1.0) * (high - low))
    }

    /// Value of one metric, or why there is none.
    pub(super) fn value(&self, metric: &Metric) -> Result<f64, String> {
        if self.kinematics.is_empty() {
            return Err("no window was done since the start or the resumption".into());
        }
        match &metric.kind {
            MetricKind::DepositRunOut(column) => {
                let length = self.half_length(column).ok_or("there is no heap at its middle")?;
                Ok((length - column.half_length) / column.half_length)
            }
            MetricKind::DepositHeight(column) => Ok(self.heap(column).height() / column.half_length),
            MetricKind::DepositProfileDifference(reference) => {
                let (_, published) =
                    self.profiles.iter().find(|(known, _)| *known == metric.name).ok_or("has no table")?;
                Ok(self.heap(&reference.column()).surface(reference.half_length).difference(published))
            }
            MetricKind::HeapAngle(slope) => self.slope(slope).angle(slope.between),
            MetricKind::ObliqueError { .. } => {
                let (_, table) = self.oblique(&metric.name)?;
                table.largest_error(&self.grains, &self.kinematics)
            }
            _ => Err("is not about the last state".into()),
        }
    }

    fn oblique(&self, name: &str) -> Result<&(String, Oblique), String> {
        self.oblique.iter().find(|(known, _)| known == name).ok_or_else(|| "has no table".into())
    }

    /// One table per kind of metric, of its first metric.
    pub(super) fn tables(&self, metrics: &[Metric]) -> Vec<(&'static str, String)> {
        if self.kinematics.is_empty() {
            return Vec::new();
        }
        let heap = metrics.iter().find_map(|metric| metric.kind.column());
        let mut tables: Vec<(&'static str, String)> = Vec::new();
        tables.extend(heap.map(|column| ("deposit.csv", self.heap(&column).table(column.half_length))));
        let slope = metrics.iter().find_map(|metric| match &metric.kind {
            MetricKind::HeapAngle(slope) => Some(self.slope(slope)),
            _ => None,
        });
        tables.extend(slope.map(|heap| ("heap.csv", heap.table(heap.height()))));
        let curve =
            self.oblique.first().and_then(|(_, table)| table.table(&self.grains, &self.kinematics).ok());
        tables.extend(curve.map(|text| ("oblique.csv", text)));
        tables
    }
}

/// Length of the box along y, m, and whether it is periodic there.
fn length_along_y(scene: &CheckedScene) -> Option<(f64, bool)> {
    let domain = &scene.scene.domain;
    let axis = (0..domain.dimensions()).find(|axis| domain.geometry.component(*axis) == 1)?;
    Some((domain.upper[axis] - domain.lower[axis], domain.is_periodic(axis)))
}

/// Volume of a sphere of radius `r` between the heights `low` and `high` above its centre, m³; without a
/// `depth` the area of a disc, m².
fn slab(r: f64, low: f64, high: f64, depth: Option<f64>) -> f64 {
    let below = |h: f64| {
        let h = h.clamp(-r, r);
        match depth {
            Some(_) => std::f64::consts::PI * (r * r * h - h.powi(3) / 3.0),
            None => h * (r * r - h * h).max(0.0).sqrt() + r * r * (h / r).asin(),
        }
    };
    below(high) - below(low)
}

#[cfg(test)]
mod tests {
    use super::slab;
    use std::f64::consts::PI;

    #[test]
    fn slabs_add_up_to_the_whole() {
        for (depth, whole) in [(Some(1.0), 4.0 / 3.0 * PI * 8.0), (None, PI * 4.0)] {
            assert!((slab(2.0, -9.0, 9.0, depth) - whole).abs() < 1e-12);
            assert!((slab(2.0, 0.0, 9.0, depth) - 0.5 * whole).abs() < 1e-12);
            let parts = slab(2.0, -2.0, 0.7, depth) + slab(2.0, 0.7, 2.0, depth);
            assert!((parts - whole).abs() < 1e-12);
            assert_eq!(slab(2.0, 3.0, 4.0, depth), 0.0);
        }
    }
}
