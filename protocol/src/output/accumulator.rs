//! What a metric keeps from window to window, in constant memory.

use serde::{Deserialize, Serialize};

use super::Sample;
use super::line::Line;
use super::trajectory::Crossing;
use crate::scene::MetricKind;

/// Part of the run, at its end, over which "terminal" and "resting" are averaged.
const TAIL: f64 = 0.1;

/// What one metric keeps.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Accumulator {
    /// The grain's trajectory says it all.
    Trajectory,
    /// The first value, once it is known.
    First(Option<f64>),
    /// Mean over time from an instant on.
    Mean {
        /// Start, s.
        from: f64,
        /// Time averaged over so far, s.
        time: f64,
        /// Integral over that time.
        integral: f64,
    },
    /// Straight line over time.
    Line(Line),
    /// Speeds at a gap.
    Crossing(Crossing),
    /// Last value.
    Last(Option<f64>),
    /// Largest value.
    Largest(Option<f64>),
}

impl Accumulator {
    /// What a metric of this kind begins with; `until` is the end of the run, s.
    pub(super) fn of(kind: &MetricKind, until: f64) -> Self {
        let mean = |from| Accumulator::Mean { from, time: 0.0, integral: 0.0 };
        match kind {
            MetricKind::TerminalReynolds { .. } | MetricKind::RestingForceRatio { .. } => {
                mean((1.0 - TAIL) * until)
            }
            MetricKind::InitialAcceleration { .. }
            | MetricKind::DepositAspectRatio(_)
            | MetricKind::ColumnSolidFraction(_)
            | MetricKind::MobilisationTime { .. } => Accumulator::First(None),
            MetricKind::RestitutionAtGap { .. } => Accumulator::Crossing(Crossing::default()),
            MetricKind::Mean { from, .. } => mean(*from),
            MetricKind::HaffTime(span) | MetricKind::HaffMisfit(span) => {
                Accumulator::Line(Line::new(span.from, span.to))
            }
            MetricKind::Final { .. } => Accumulator::Last(None),
            MetricKind::Max { .. } => Accumulator::Largest(None),
            _ => Accumulator::Trajectory,
        }
    }

    /// Adds a value of a window; means weigh it with the part of the window after their start.
    pub(super) fn add(&mut self, value: f64, sample: &Sample) {
        match self {
            Self::First(first) => *first = first.or(Some(value)),
            Self::Mean { from, time, integral } => {
                let weight = (sample.time() - *from).clamp(0.0, sample.window.dt);
                // Outside its span not even a NaN counts.
                if weight > 0.0 {
                    *time += weight;
                    *integral += weight * value;
                }
            }
            Self::Line(line) => line.add(sample.time(), sample.window.dt, value),
            Self::Last(last) => *last = Some(value),
            Self::Largest(largest) => *largest = Some(largest.map_or(value, |kept| kept.max(value))),
            Self::Trajectory | Self::Crossing(_) => {}
        }
    }

    /// The number it stands for, or why there is none.
    pub(super) fn value(&self) -> Result<f64, String> {
        match self {
            Self::Mean { from, time, .. } if *time <= 0.0 => {
                Err(format!("the run ended before t = {from} s, where its mean begins"))
            }
            Self::Mean { time, integral, .. } => Ok(integral / time),
            Self::First(value) | Self::Last(value) | Self::Largest(value) => {
                value.ok_or_else(|| "no window was done".into())
            }
            Self::Trajectory | Self::Crossing(_) | Self::Line(_) => Err("is not a single number".into()),
        }
    }
}
