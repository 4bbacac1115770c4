//! Everything that watches a run, fed once per accepted window.

use protocol::message::Kinematics;
use serde::{Deserialize, Serialize};

use crate::columns::Columns;
use crate::error::OutputError;
use crate::file::atomic_write;
use crate::folder::OutputFolder;
use crate::metrics::{Metrics, MetricsState};
use crate::planes::Record;
use crate::sample::{Sample, Sides};
use crate::series::{SeriesMark, SeriesWriter};
use crate::summary::{Summary, Tally};
use bedload_scene::{CheckedScene, ObservedPlanes, SceneError};

/// Series, metrics and counts of a run.
pub struct Observer {
    columns: Columns,
    series: SeriesWriter,
    metrics: Metrics,
    tally: Tally,
    has_fluid: bool,
    planes: Option<ObservedPlanes>,
    folder: OutputFolder,
}

/// What an [`Observer`] needs to go on: belongs into a checkpoint. Holds no infinity and no NaN
/// unless a solver sent one.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ObserverState {
    /// Of the metrics.
    pub metrics: MetricsState,
    /// Counts.
    pub tally: Tally,
    /// How far `series.csv` goes.
    pub series: SeriesMark,
    /// Of the columns with means: values at the end of the last window.
    pub ends: Vec<f64>,
}

impl Observer {
    /// Refuses what a run that sees these `sides` would refuse at its start.
    ///
    /// # Errors
    /// If a metric names an unknown column.
    pub fn check(scene: &CheckedScene, sides: Sides) -> Result<(), SceneError> {
        Metrics::new(scene, &Columns::new(scene, sides), sides).map(drop)
    }

    /// Watches a new run: starts `series.csv`.
    ///
    /// # Errors
    /// [`OutputError::Scene`] if a metric names an unknown column; [`OutputError::File`].
    pub fn create(folder: &OutputFolder, scene: &CheckedScene, sides: Sides) -> Result<Self, OutputError> {
        Self::begin(folder, scene, sides, None)
    }

    /// Watches a run that goes on from a checkpoint: rows of `series.csv` after it are cut off. `last`: the
    /// motion of all grains there, for a run that may end without another window.
    ///
    /// # Errors
    /// As [`Observer::create`], and [`OutputError::Content`] if the state does not fit the scene.
    pub fn resume(
        folder: &OutputFolder,
        scene: &CheckedScene,
        sides: Sides,
        state: ObserverState,
        last: Option<&[Kinematics]>,
    ) -> Result<Self, OutputError> {
        let mut observer = Self::begin(folder, scene, sides, Some(state))?;
        observer.metrics.restore_last(last.unwrap_or_default());
        Ok(observer)
    }

    fn begin(
        folder: &OutputFolder,
        scene: &CheckedScene,
        sides: Sides,
        state: Option<ObserverState>,
    ) -> Result<Self, OutputError> {
        let mut columns = Columns::new(scene, sides);
        let mut ends = Vec::new();
        let mut metrics = Metrics::new(scene, &columns, sides).map_err(Box::new)?;
        let (path, names, every) = (folder.series(), columns.names(), scene.scene.observe.every);
        let (series, tally) = match state {
            None => (SeriesWriter::create(&path, names, every)?, Tally::default()),
            Some(state) => {
                let wrong = |what| OutputError::Content { path: folder.checkpoint(), what };
                metrics.restore(state.metrics, state.tally.simulated).map_err(wrong)?;
                ends = state.ends;
                (SeriesWriter::resume(&path, names, every, &state.series)?, state.tally)
            }
        };
        columns.resume(ends);
        let (planes, folder) = (scene.scene.observe.planes.clone(), folder.clone());
        Ok(Self { columns, series, metrics, tally, has_fluid: sides.loads, planes, folder })
    }

    /// Takes an accepted window, once, in order.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn record(&mut self, sample: &Sample) -> Result<(), OutputError> {
        let row = self.columns.fill(sample);
        self.metrics.record(sample, row);
        self.tally.record(sample.window, sample.header.substeps);
        self.series.record(row).map(drop)
    }

    /// The state for a checkpoint, after every row has been put on the disk.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn state(&mut self) -> Result<ObserverState, OutputError> {
        let series = self.series.mark()?;
        let (metrics, ends) = (self.metrics.state().clone(), self.columns.ends().to_vec());
        Ok(ObserverState { metrics, tally: self.tally, series, ends })
    }

    /// Value of a column after the last window.
    pub fn latest(&self, column: &str) -> Option<f64> {
        self.columns.latest(column)
    }

    /// Counts so far.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Ends the series and fills `time` and `metrics` of the summary. `contact_time`: shortest
    /// duration of a contact, s, infinite where nothing can touch.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn finish(&mut self, summary: &mut Summary, contact_time: f64) -> Result<(), OutputError> {
        self.series.flush()?;
        summary.time = self.tally.time(self.has_fluid, contact_time);
        if let Some(asked) = &self.planes {
            let record = Record::read(&self.folder.fields(), asked, self.tally.simulated)?;
            if let Some(table) = record.table() {
                atomic_write(&self.folder.planes(), table.as_bytes())?;
            }
            for t in &asked.at {
                if let Some(sample) = record.nearest(*t) {
                    self.folder.write_field(&format!("at_{t}.csv"), sample.to_string().as_bytes())?;
                }
            }
            self.metrics.read_planes(record);
        }
        summary.metrics = self.metrics.finish();
        for (name, text) in self.metrics.tables() {
            self.folder.write(name, text.as_bytes())?;
        }
        Ok(())
    }
}
