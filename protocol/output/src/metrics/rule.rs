//! How a metric is measured: what it keeps, what a window adds to that, and what it comes to. Each file of
//! kinds makes the rules of its own.

use std::path::Path;

use super::accumulator::Accumulator;
use super::last::LastState;
use super::trajectory::{Passage, Trajectory};
use crate::planes::Record;
use crate::sample::Sample;
use bedload_scene::{CheckedScene, SceneError};

/// What a metric comes to: a value, perhaps with a remark, or why there is none.
pub(super) type Outcome = Result<(f64, Option<String>), String>;

/// A window as a metric sees it.
pub(super) struct Seen<'a> {
    pub(super) sample: &'a Sample<'a>,
    /// Row of `series.csv`.
    pub(super) row: &'a [f64],
    /// Of a metric about a grain.
    pub(super) grain: Option<&'a Moved>,
    /// The state after the window, of metrics that need it.
    pub(super) last: Option<&'a LastState>,
}

/// One grain over one window, with its trajectory before and after.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    pub(super) before: Trajectory,
    pub(super) after: Trajectory,
    pub(super) passage: Passage,
}

/// A run as a metric sees it at its end.
pub(super) struct End<'a> {
    /// Trajectory of its grain.
    pub(super) way: Option<&'a Trajectory>,
    pub(super) last: Option<&'a LastState>,
    /// Averages over planes, once they are read.
    pub(super) planes: Option<&'a Record>,
}

/// What a window adds to what is kept.
type Add = Box<dyn Fn(&Seen, &mut Accumulator) + Send + Sync>;
/// What has been kept comes to.
type Give = Box<dyn Fn(&Accumulator, &End) -> Outcome + Send + Sync>;
/// A table of the last state: name of the file and text.
type Leave = Box<dyn Fn(&LastState) -> Option<(&'static str, String)> + Send + Sync>;

/// How one metric is measured.
pub(super) struct Rule {
    pub(super) unit: String,
    /// What is kept at the start.
    pub(super) keeps: Accumulator,
    pub(super) add: Add,
    pub(super) give: Give,
    pub(super) leave: Option<Leave>,
}

impl Rule {
    pub(super) fn new(
        unit: &str,
        keeps: Accumulator,
        add: impl Fn(&Seen, &mut Accumulator) + Send + Sync + 'static,
        give: impl Fn(&Accumulator, &End) -> Outcome + Send + Sync + 'static,
    ) -> Self {
        Self { unit: unit.to_owned(), keeps, add: Box::new(add), give: Box::new(give), leave: None }
    }

    /// One that keeps nothing.
    pub(super) fn at_end(unit: &str, give: impl Fn(&End) -> Outcome + Send + Sync + 'static) -> Self {
        Self::new(unit, Accumulator::Trajectory, |_, _| {}, move |_, end| give(end))
    }

    /// Of a kind that no file of kinds has.
    pub(super) fn unknown() -> Self {
        Self::at_end("-", |_| Err("no rule says how it is measured".into()))
    }

    /// One of the last state of all grains, without a unit.
    pub(super) fn of_last(give: impl Fn(&LastState) -> Result<f64, String> + Send + Sync + 'static) -> Self {
        Self::at_end("-", move |end| plain(give(end.last()?)?))
    }

    /// The same, with a table that it leaves.
    pub(super) fn leaving(
        self,
        name: &'static str,
        text: impl Fn(&LastState) -> Option<String> + Send + Sync + 'static,
    ) -> Self {
        Self { leave: Some(Box::new(move |last| text(last).map(|text| (name, text)))), ..self }
    }
}

impl End<'_> {
    /// The last state, if a window was done.
    pub(super) fn last(&self) -> Result<&LastState, String> {
        let known = self.last.filter(|last| !last.kinematics.is_empty());
        known.ok_or_else(|| "no window was done since the start or the resumption".into())
    }
}

/// A value without a remark.
pub(super) fn plain(value: f64) -> Outcome {
    Ok((value, None))
}

/// Why there is no value, unless a condition is met.
pub(super) fn require(met: bool, otherwise: &str) -> Result<(), String> {
    if met { Ok(()) } else { Err(otherwise.to_owned()) }
}

/// A published table that metric `index` names, parsed; `columns` is what it should have.
pub(super) fn published<T>(
    scene: &CheckedScene,
    index: usize,
    file: &Path,
    columns: &str,
    parse: impl FnOnce(&str) -> Result<T, String>,
) -> Result<T, SceneError> {
    let name = file.display();
    let text = protocol::input_file::read_text(file).map_err(|error| format!("cannot read {name}: {error}"));
    text.and_then(|text| parse(&text).map_err(|what| format!("{name} {what}"))).map_err(|why| {
        let remedy =
            format!("name a CSV file with the columns {columns}; paths count from the scene's folder");
        scene.source.error(&format!("metrics[{index}].file"), why, &remedy)
    })
}
