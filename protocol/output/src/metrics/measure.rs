//! Metrics: numbers for `summary.json`, accumulated window by window in constant memory.

use std::collections::BTreeMap;

use protocol::message::Kinematics;
use serde::{Deserialize, Serialize};

use super::accumulator::Accumulator;
use super::last::LastState;
use super::rule::{End, Moved, Rule, Seen};
use super::subject::Subject;
use super::trajectory::Trajectory;
use super::{bounce, column, end, heap, oblique};
use crate::columns::Columns;
use crate::planes::Record;
use crate::sample::{Sample, Sides};
use crate::summary::MetricValue;
use bedload_scene::{CheckedScene, Metric, MetricKind, SceneError};

/// Everything that the metrics have kept: belongs into a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MetricsState {
    /// One per grain that a metric is about, in the order of [`Metrics`].
    pub trajectories: Vec<Trajectory>,
    /// One per metric of the scene.
    pub accumulators: Vec<Accumulator>,
}

/// The metrics of a scene.
pub struct Metrics {
    metrics: Vec<Metric>,
    rules: Vec<Rule>,
    /// Place of each metric's subject.
    subject_of: Vec<Option<usize>>,
    subjects: Vec<Subject>,
    /// What each subject did in the last window, if it was observed.
    moved: Vec<Option<Moved>>,
    /// For metrics of the last state of all grains.
    last: Option<LastState>,
    /// For metrics of averages over planes, once they are read.
    planes: Option<Record>,
    state: MetricsState,
}

impl Metrics {
    /// Metrics of `scene` as a run with these `columns` and `sides` sees it.
    ///
    /// # Errors
    /// If a column does not exist although the run sees all there is.
    pub fn new(scene: &CheckedScene, columns: &Columns, sides: Sides) -> Result<Self, SceneError> {
        let metrics = scene.scene.metrics.clone();
        let rules = (0..metrics.len()).map(|index| rule(scene, index, columns, sides));
        let rules = rules.collect::<Result<Vec<Rule>, SceneError>>()?;
        let mut subjects: Vec<Subject> = Vec::new();
        let mut place = |metric: &Metric| {
            let subject = Subject::of(scene, &metric.kind)?;
            let known = subjects.iter().position(|known| known.grain == subject.grain);
            Some(known.unwrap_or_else(|| {
                subjects.push(subject);
                subjects.len() - 1
            }))
        };
        let subject_of = metrics.iter().map(&mut place).collect();
        let start =
            |subject: &Subject| Trajectory::new(subject.speed(&scene.grains[subject.grain].velocity.start()));
        let state = MetricsState {
            trajectories: subjects.iter().map(start).collect(),
            accumulators: rules.iter().map(|rule| rule.keeps.clone()).collect(),
        };
        let last = rules.iter().any(|rule| rule.leave.is_some()).then(|| LastState::new(scene));
        let moved = vec![None; subjects.len()];
        Ok(Self { metrics, rules, subject_of, subjects, moved, last, planes: None, state })
    }

    /// Adds an accepted window; `row` is what [`Columns::fill`] made of it.
    pub fn record(&mut self, sample: &Sample, row: &[f64]) {
        for ((subject, way), moved) in
            self.subjects.iter().zip(&mut self.state.trajectories).zip(&mut self.moved)
        {
            *moved = subject.passage(sample).map(|passage| {
                let before = *way;
                way.record(&passage);
                Moved { before, after: *way, passage }
            });
        }
        if let Some(last) = &mut self.last {
            last.record(sample);
        }
        let last = self.last.as_ref();
        for ((rule, kept), place) in self.rules.iter().zip(&mut self.state.accumulators).zip(&self.subject_of)
        {
            let grain = place.and_then(|place| self.moved[place].as_ref());
            (rule.add)(&Seen { sample, row, grain, last }, kept);
        }
    }

    /// All that decides the final values, for a checkpoint.
    pub fn state(&self) -> &MetricsState {
        &self.state
    }

    /// Goes on from a checkpoint at time `reached`, s. A mean over the end of the run starts anew where
    /// `until` has changed since; there is none where it should have begun before.
    ///
    /// # Errors
    /// If the state is of other metrics.
    pub fn restore(&mut self, state: MetricsState, reached: f64) -> Result<(), String> {
        let kinds = |state: &MetricsState| {
            let kinds: Vec<_> = state.accumulators.iter().map(std::mem::discriminant).collect();
            (state.trajectories.len(), kinds)
        };
        if kinds(&state) != kinds(&self.state) {
            return Err("the checkpoint is of other metrics; leave [[metrics]] as they were".into());
        }
        let fresh = std::mem::replace(&mut self.state, state);
        for (kept, fresh) in self.state.accumulators.iter_mut().zip(fresh.accumulators) {
            if let (Accumulator::Mean { from, time, integral, .. }, Accumulator::Mean { from: new, .. }) =
                (kept, fresh)
                && *from != new
            {
                (*from, *integral) = (new, 0.0);
                *time = if reached > new { f64::NEG_INFINITY } else { 0.0 };
            }
        }
        Ok(())
    }

    /// Takes the last motion of all grains from a checkpoint.
    pub(crate) fn restore_last(&mut self, motion: &[Kinematics]) {
        if let Some(last) = &mut self.last {
            motion.clone_into(&mut last.kinematics);
        }
    }

    /// Tables that belong to metrics of the last state: name of the file and text. One of each name, of the
    /// first metric that leaves it.
    pub fn tables(&self) -> Vec<(&'static str, String)> {
        let Some(last) = self.last.as_ref().filter(|last| !last.kinematics.is_empty()) else {
            return Vec::new();
        };
        let mut tables: Vec<(&'static str, String)> = Vec::new();
        for (name, text) in self.rules.iter().filter_map(|rule| rule.leave.as_ref()?(last)) {
            if tables.iter().all(|(known, _)| *known != name) {
                tables.push((name, text));
            }
        }
        tables
    }

    /// Takes the averages over planes that the run has left.
    pub(crate) fn read_planes(&mut self, record: Record) {
        self.planes = Some(record);
    }

    /// The values so far, by name.
    pub fn finish(&self) -> BTreeMap<String, MetricValue> {
        let value = |(index, metric): (usize, &Metric)| {
            let (rule, kept) = (&self.rules[index], &self.state.accumulators[index]);
            let way = self.subject_of[index].map(|place| &self.state.trajectories[place]);
            let end = End { way, last: self.last.as_ref(), planes: self.planes.as_ref() };
            let value = MetricValue::of(metric, &rule.unit, (rule.give)(kept, &end));
            (metric.name.clone(), MetricValue { standard_error: kept.standard_error(), ..value })
        };
        self.metrics.iter().enumerate().map(value).collect()
    }
}

/// The rule of metric `index` of the scene, in a run with these columns that sees these sides.
fn rule(scene: &CheckedScene, index: usize, columns: &Columns, sides: Sides) -> Result<Rule, SceneError> {
    let kind = &scene.scene.metrics[index].kind;
    match kind {
        MetricKind::ObliqueError { file, select } => oblique::rule(scene, index, file, select),
        MetricKind::HeapAngle(slope) => heap::slope(scene, index, *slope),
        _ if kind.column().is_some() => heap::rule(scene, index),
        _ => match bounce::rule(scene, kind).or_else(|| end::rule(scene, kind)) {
            Some(rule) => Ok(rule),
            None => column::rule(scene, index, columns, sides),
        },
    }
}
