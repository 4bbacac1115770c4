//! Metrics: numbers for `summary.json`, accumulated window by window in constant memory.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::accumulator::Accumulator;
use super::bounce::Surroundings;
use super::course::Course;
use super::haff::haff;
use super::last::LastState;
use super::outcome::{Outcome, plain};
use super::shields::bed;
use super::subject::{Subject, View, norm};
use super::trajectory::Trajectory;
use crate::columns::{Columns, Sample, Sides};
use crate::planes::{Bed, Record};
use crate::summary::MetricValue;
use bedload_scene::{CheckedScene, Metric, MetricKind, Motion, SceneError};

/// Everything that the metrics have kept: belongs into a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MetricsState {
    /// One per grain that a metric is about, in the order of [`Metrics`].
    pub trajectories: Vec<Trajectory>,
    /// One per metric of the scene.
    pub accumulators: Vec<Accumulator>,
}

/// The metrics of a scene.
#[derive(Clone, Debug)]
pub struct Metrics {
    metrics: Vec<Metric>,
    /// Place of each metric's subject; place and unit of each metric's column.
    subject_of: Vec<Option<usize>>,
    column_of: Vec<Option<(usize, String)>>,
    subjects: Vec<Subject>,
    surroundings: Surroundings,
    /// The free grains, and what their Shields number needs.
    free: Vec<usize>,
    bed: Bed,
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
        let mut built = Self {
            metrics: scene.scene.metrics.clone(),
            subject_of: Vec::new(),
            column_of: Vec::new(),
            subjects: Vec::new(),
            surroundings: Surroundings {
                medium: scene.scene.medium.as_ref().map(|medium| (medium.density, medium.viscosity)),
                gravity: norm(&scene.scene.gravity),
            },
            free: (0..scene.grains.len()).filter(|i| scene.grains[*i].motion == Motion::Free).collect(),
            bed: bed(scene),
            last: LastState::new(scene)?,
            planes: None,
            state: MetricsState::default(),
        };
        for (index, metric) in scene.scene.metrics.iter().enumerate() {
            let column = find_column(&metric.kind, columns);
            if let Err(name) = &column
                && sees_all(scene, sides)
            {
                return Err(unknown_column(scene, columns, index, name));
            }
            built.column_of.push(column.unwrap_or(None));
            let subject = metric.kind.grain().map(|grain| built.subject(scene, grain));
            built.subject_of.push(subject);
            let accumulator = match &metric.kind {
                MetricKind::SeriesDifference { file, .. } => {
                    Accumulator::Course(Course::read(file).map_err(|why| {
                        scene.source.error(
                            &format!("metrics[{index}].file"),
                            why,
                            "name a CSV file with the columns t and value; paths count from the scene's folder",
                        )
                    })?)
                }
                kind => Accumulator::of(kind, scene.scene.until),
            };
            built.state.accumulators.push(accumulator);
        }
        Ok(built)
    }

    /// Place of the subject of a grain, made where it is new.
    fn subject(&mut self, scene: &CheckedScene, grain: usize) -> usize {
        if let Some(place) = self.subjects.iter().position(|subject| subject.grain == grain) {
            return place;
        }
        let subject = Subject::new(scene, grain);
        self.state.trajectories.push(Trajectory::new(subject.speed(&scene.grains[grain].velocity)));
        self.subjects.push(subject);
        self.subjects.len() - 1
    }

    /// Adds an accepted window; `row` is what [`Columns::fill`] made of it.
    pub fn record(&mut self, sample: &Sample, row: &[f64]) {
        // One grain after the other: its metrics see its trajectory before and after the window.
        for (place, subject) in self.subjects.iter().enumerate() {
            let Some(passage) = subject.passage(sample) else { continue };
            let before = self.state.trajectories[place];
            self.state.trajectories[place].record(&passage);
            let after = &self.state.trajectories[place];
            for (index, metric) in self.metrics.iter().enumerate() {
                if self.subject_of[index] != Some(place) {
                    continue;
                }
                let accumulator = &mut self.state.accumulators[index];
                let view = View {
                    subject,
                    gravity: self.surroundings.gravity,
                    before: &before,
                    after,
                    passage: &passage,
                };
                view.record(&metric.kind, accumulator, sample);
            }
        }
        if let Some(last) = &mut self.last {
            last.record(sample);
            for (metric, accumulator) in self.metrics.iter().zip(&mut self.state.accumulators) {
                if matches!(accumulator, Accumulator::First(None))
                    && let Some(column) = metric.kind.column()
                    && sample.time() >= column.release
                {
                    let solid = matches!(metric.kind, MetricKind::ColumnSolidFraction(_));
                    let aspect = || last.standing_height(&column) / column.half_length;
                    accumulator.add(if solid { last.solid_fraction(&column) } else { aspect() }, sample);
                }
            }
        }
        for (metric, accumulator) in self.metrics.iter().zip(&mut self.state.accumulators) {
            if let MetricKind::MobilisationTime { speed, share } = &metric.kind {
                let moves = |grain: &&usize| {
                    sample.kinematics.get(**grain).is_some_and(|motion| norm(&motion.velocity) >= *speed)
                };
                let moving = self.free.iter().filter(moves).count();
                if moving > 0 && moving as f64 >= share * self.free.len() as f64 {
                    accumulator.add(sample.time(), sample);
                }
            }
        }
        for (accumulator, column) in self.state.accumulators.iter_mut().zip(&self.column_of) {
            if let Some((place, _)) = column {
                let value = row[*place];
                // Haff's law is a straight line in E^(−1/2).
                let line = matches!(accumulator, Accumulator::Line(_));
                accumulator.add(if line { value.sqrt().recip() } else { value }, sample);
            }
        }
    }

    /// All that decides the final values, for a checkpoint.
    #[must_use]
    pub fn state(&self) -> &MetricsState {
        &self.state
    }

    /// Goes on from a checkpoint. A mean over the end of the run starts anew where `until` has
    /// changed since.
    ///
    /// # Errors
    /// If the state is of other metrics.
    pub fn restore(&mut self, state: MetricsState) -> Result<(), String> {
        let fits = state.trajectories.len() == self.state.trajectories.len()
            && state.accumulators.len() == self.state.accumulators.len()
            && state
                .accumulators
                .iter()
                .zip(&self.state.accumulators)
                .all(|(new, old)| std::mem::discriminant(new) == std::mem::discriminant(old));
        if !fits {
            return Err("the checkpoint is of other metrics; leave [[metrics]] as they were".into());
        }
        let fresh = std::mem::replace(&mut self.state, state);
        for (kept, fresh) in self.state.accumulators.iter_mut().zip(fresh.accumulators) {
            if let (Accumulator::Mean { from: old, .. }, Accumulator::Mean { from: new, .. }) =
                (&*kept, &fresh)
                && old != new
            {
                *kept = fresh;
            }
        }
        Ok(())
    }

    /// Tables that belong to metrics of the last state: name of the file and text.
    #[must_use]
    pub fn tables(&self) -> Vec<(&'static str, String)> {
        self.last.as_ref().map_or_else(Vec::new, |last| last.tables(&self.metrics))
    }

    /// Takes the averages over planes that the run has left.
    pub(crate) fn read_planes(&mut self, record: Record) {
        self.planes = Some(record);
    }

    /// The values so far, by name.
    #[must_use]
    pub fn finish(&self) -> BTreeMap<String, MetricValue> {
        let value = |index: usize| {
            let metric = &self.metrics[index];
            let (reference, source) = (metric.reference, metric.source.clone());
            let unit = match self.metrics[index].kind {
                MetricKind::MeanFluidVelocity { .. }
                | MetricKind::MeanGrainVelocity { .. }
                | MetricKind::VelocityDifference { .. } => "m/s",
                MetricKind::MobilisationTime { .. } => "s",
                _ => self.column_of[index].as_ref().map_or("-", |(_, unit)| unit),
            };
            match self.value(index) {
                Ok((value, note)) => {
                    let mut measured = MetricValue::measured(value, unit, reference, source);
                    measured.note = measured.note.or(note.map(str::to_owned));
                    measured
                }
                Err(note) => MetricValue::missing(note, unit, reference, source),
            }
        };
        (0..self.metrics.len()).map(|index| (self.metrics[index].name.clone(), value(index))).collect()
    }

    /// A value, perhaps with a remark, or why there is none.
    fn value(&self, index: usize) -> Outcome {
        let accumulator = &self.state.accumulators[index];
        match &self.metrics[index].kind {
            MetricKind::Mean { column, .. }
            | MetricKind::Deviation { column, .. }
            | MetricKind::Final { column }
            | MetricKind::Max { column, .. }
            | MetricKind::SeriesDifference { column, .. }
            | MetricKind::Frequency { column, .. } => {
                if self.column_of[index].is_none() {
                    return Err(format!("this run has no column `{column}`"));
                }
                let part = "of the part of the table that the run reached";
                let whole = !matches!(accumulator, Accumulator::Course(course) if !course.is_whole());
                Ok((accumulator.value()?, (!whole).then_some(part)))
            }
            MetricKind::HaffTime(_) | MetricKind::HaffMisfit(_) => {
                haff(&self.metrics[index].kind, accumulator)
            }
            MetricKind::DepositAspectRatio(column) | MetricKind::ColumnSolidFraction(column) => plain(
                accumulator.value().map_err(|_| format!("the run ended before t = {} s", column.release))?,
            ),
            MetricKind::DepositRunOut(_)
            | MetricKind::DepositHeight(_)
            | MetricKind::DepositProfileDifference(_)
            | MetricKind::HeapAngle(_)
            | MetricKind::ObliqueError { .. } => {
                let last = self.last.as_ref().ok_or("the last state was not kept")?;
                plain(last.value(&self.metrics[index])?)
            }
            MetricKind::JanssenFit { .. }
            | MetricKind::JanssenDirect { .. }
            | MetricKind::PlateauPressure { .. } => {
                Err("is measured by bedload-dem at the end of a dry run with [observe.profile]".into())
            }
            MetricKind::VelocityDifference { .. } | MetricKind::WakeLength { .. } => {
                Err("is measured by bedload-fluid at the end of a run without free grains".into())
            }
            kind @ (MetricKind::MeanFluidVelocity { .. }
            | MetricKind::MeanGrainVelocity { .. }
            | MetricKind::Shields { .. }) => {
                let planes = self.planes.as_ref().ok_or("this run has no fluid of its own to average")?;
                plain(planes.value(kind, &self.bed)?)
            }
            MetricKind::MobilisationTime { .. } => {
                plain(accumulator.value().map_err(|_| "so many grains never moved so fast")?)
            }
            kind => {
                let place = self.subject_of[index].ok_or("is about no grain")?;
                let way = &self.state.trajectories[place];
                if way.windows == 0 {
                    return Err("the motion of the grain was not observed".into());
                }
                self.surroundings.value(kind, accumulator, &self.subjects[place], way)
            }
        }
    }
}

fn find_column(kind: &MetricKind, columns: &Columns) -> Result<Option<(usize, String)>, String> {
    match kind {
        MetricKind::Mean { column, .. }
        | MetricKind::Deviation { column, .. }
        | MetricKind::Final { column }
        | MetricKind::Max { column, .. }
        | MetricKind::SeriesDifference { column, .. } => {
            let found = columns.find(column).map(|(place, unit)| Some((place, unit.to_owned())));
            found.ok_or_else(|| column.clone())
        }
        MetricKind::Frequency { column, .. } => {
            let found = columns.find(column).map(|(place, _)| Some((place, "1/s".to_owned())));
            found.ok_or_else(|| column.clone())
        }
        MetricKind::HaffTime(_) | MetricKind::HaffMisfit(_) => {
            let found = columns.find("kinetic_energy").map(|(place, _)| Some((place, "s".to_owned())));
            found.ok_or_else(|| "kinetic_energy".into())
        }
        _ => Ok(None),
    }
}

/// Does the run see everything that the scene has?
fn sees_all(scene: &CheckedScene, sides: Sides) -> bool {
    let loads = sides.loads || scene.scene.medium.is_none() || scene.grains.is_empty();
    let contact = sides.contact || !scene.has_free_grains();
    loads && contact
}

fn unknown_column(scene: &CheckedScene, columns: &Columns, index: usize, name: &str) -> SceneError {
    scene.source.error(
        &format!("metrics[{index}].column"),
        format!("is `{name}`; the columns of this run are {}", columns.names().join(", ")),
        "name one of them; grains need a place in observe.grains to have columns",
    )
}
