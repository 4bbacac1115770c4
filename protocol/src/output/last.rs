//! Metrics of the last state of all grains: heaps and collisions.

use super::Sample;
use super::deposit::Heap;
use super::oblique::Oblique;
use crate::message::Kinematics;
use crate::scene::{CheckedScene, Column, Grain, Metric, MetricKind, Motion, SceneError};

/// The grains at t = 0 and after the last window.
#[derive(Clone, Debug)]
pub(super) struct LastState {
    grains: Vec<Grain>,
    kinematics: Vec<Kinematics>,
    floor: f64,
    /// Number of grains that are there from the start.
    present: usize,
    /// Reference table of each metric that has one, by the metric's name.
    oblique: Vec<(String, Oblique)>,
}

impl LastState {
    /// Nothing, unless a metric of the scene needs it.
    pub(super) fn new(scene: &CheckedScene) -> Result<Option<Self>, SceneError> {
        let mut oblique = Vec::new();
        let mut needed = false;
        for (index, metric) in scene.scene.metrics.iter().enumerate() {
            needed |= metric.kind.column().is_some() || matches!(metric.kind, MetricKind::HeapAngle(_));
            if let MetricKind::ObliqueError { file, select } = &metric.kind {
                let table = Oblique::read(file, select).map_err(|why| {
                    scene.source.error(
                        &format!("metrics[{index}].file"),
                        why,
                        "name a CSV file with the columns psi1 and psi2 and those of `select`",
                    )
                })?;
                oblique.push((metric.name.clone(), table));
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
            oblique,
        }))
    }

    /// Keeps the state after a window.
    pub(super) fn record(&mut self, sample: &Sample) {
        self.kinematics.clear();
        self.kinematics.extend_from_slice(sample.kinematics);
    }

    fn heap(&self, column: &Column) -> Heap {
        self.heap_about(column.centre, column.bin)
    }

    fn heap_about(&self, centre: f64, bin: f64) -> Heap {
        let there = |(index, (grain, motion)): &(usize, (&Grain, &Kinematics))| {
            grain.motion == Motion::Free && (*index < self.present || motion.is_there())
        };
        let all: Vec<[f64; 3]> = self
            .grains
            .iter()
            .zip(&self.kinematics)
            .enumerate()
            .filter(there)
            .map(|(_, (grain, motion))| {
                [motion.position[0] - centre, motion.position[2] - self.floor, grain.radius]
            })
            .collect();
        let mean = all.iter().map(|grain| grain[2]).sum::<f64>() / all.len().max(1) as f64;
        Heap::new(&all, if bin > 0.0 { bin } else { 3.0 * mean })
    }

    /// H₀ of the standing column, m.
    pub(super) fn standing_height(&self, column: &Column) -> f64 {
        self.heap(column).mean_height(column.half_length)
    }

    /// Value of one metric, or why there is none.
    pub(super) fn value(&self, metric: &Metric) -> Result<f64, String> {
        if self.kinematics.is_empty() {
            return Err("no window was done since the start or the resumption".into());
        }
        match &metric.kind {
            MetricKind::DepositRunOut(column) => {
                let length = self.heap(column).half_length().ok_or("there is no heap at its middle")?;
                Ok((length - column.half_length) / column.half_length)
            }
            MetricKind::DepositHeight(column) => Ok(self.heap(column).height() / column.half_length),
            MetricKind::HeapAngle(slope) => self.heap_about(slope.centre, slope.bin).angle(slope.between),
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
        tables.extend(heap.map(|column| ("deposit.csv", self.heap(column).table(column.half_length))));
        let slope = metrics.iter().find_map(|metric| match &metric.kind {
            MetricKind::HeapAngle(slope) => Some(self.heap_about(slope.centre, slope.bin)),
            _ => None,
        });
        tables.extend(slope.map(|heap| ("heap.csv", heap.table(heap.height()))));
        let curve =
            self.oblique.first().and_then(|(_, table)| table.table(&self.grains, &self.kinematics).ok());
        tables.extend(curve.map(|text| ("oblique.csv", text)));
        tables
    }
}
