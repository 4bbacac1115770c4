//! What a metric keeps from window to window, in constant memory.

use serde::{Deserialize, Serialize};

use super::course::Course;
use super::line::Line;
use super::stationary::Stationary;
use super::trajectory::Crossing;
use crate::sample::{Sample, When};

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
        /// Time averaged over so far, s; −∞ where the run went on from later than the start.
        time: f64,
        /// Integral over that time.
        integral: f64,
        /// How the value goes on from window to window.
        between: Between,
    },
    /// Mean over the time in which the value is stationary.
    Stationary {
        /// The value over time.
        series: Stationary,
        /// How it goes on from window to window.
        between: Between,
    },
    /// Standard deviation over time from an instant on.
    Deviation {
        /// Start, s.
        from: f64,
        /// Time so far, s.
        time: f64,
        /// Mean over that time.
        mean: f64,
        /// Integral of the squared distance from it.
        square: f64,
        /// How the value goes on from window to window.
        between: Between,
    },
    /// Straight line over time.
    Line(Line),
    /// Speeds at a gap.
    Crossing(Crossing),
    /// Last value.
    Last(Option<f64>),
    /// Largest value from an instant on.
    Largest {
        /// Start, s.
        from: f64,
        /// The value.
        value: Option<f64>,
    },
    /// Upward passages of a level from an instant on.
    Passages(Passages),
    /// Difference from a published course.
    Course(Course),
}

impl Accumulator {
    /// A mean from an instant on, s.
    pub(super) fn mean(from: f64, when: When) -> Self {
        Self::Mean { from, time: 0.0, integral: 0.0, between: Between::of(when) }
    }

    /// A mean over the time in which the value is stationary.
    pub(super) fn stationary(when: When) -> Self {
        Self::Stationary { series: Stationary::new(), between: Between::of(when) }
    }

    /// A standard deviation from an instant on, s.
    pub(super) fn deviation(from: f64, when: When) -> Self {
        Self::Deviation { from, time: 0.0, mean: 0.0, square: 0.0, between: Between::of(when) }
    }

    /// Adds a value of a window; means weigh it with the part of the window after their start.
    pub(super) fn add(&mut self, value: f64, sample: &Sample) {
        match self {
            Self::First(first) => *first = first.or(Some(value)),
            Self::Mean { from, time, integral, between } => {
                if let Some((weight, start)) = between.part(*from, value, sample) {
                    *time += weight;
                    *integral += weight * 0.5 * (start + value);
                }
            }
            Self::Stationary { series, between } => {
                if let Some((weight, start)) = between.part(f64::NEG_INFINITY, value, sample) {
                    series.add(sample.window.time, weight, 0.5 * (start + value));
                }
            }
            Self::Deviation { from, time, mean, square, between } => {
                if let Some((weight, start)) = between.part(*from, value, sample) {
                    // A value of the whole window counts once.
                    let parts =
                        if start == value { &[(1.0, value)][..] } else { &[(0.5, start), (0.5, value)] };
                    for (part, value) in parts {
                        deviate((time, mean, square), part * weight, *value);
                    }
                }
            }
            Self::Line(line) => line.add(sample.time(), sample.window.dt, value),
            Self::Last(last) => *last = Some(value),
            Self::Largest { from, value: largest } if sample.time() >= *from => {
                *largest = Some(largest.map_or(value, |kept| kept.max(value)));
            }
            Self::Passages(passages) => passages.add(sample.time(), value),
            Self::Course(course) => course.add(sample.time(), value),
            Self::Largest { .. } => {}
            Self::Trajectory | Self::Crossing(_) => {}
        }
    }

    /// Standard error of its value, if it has one.
    pub(super) fn standard_error(&self) -> Option<f64> {
        match self {
            Self::Stationary { series, .. } => series.estimate().ok().map(|found| found.error),
            _ => None,
        }
    }

    /// The number it stands for, or why there is none.
    pub(super) fn value(&self) -> Result<f64, String> {
        match self {
            Self::Mean { from, time, .. } if *time == f64::NEG_INFINITY => Err(format!(
                "the run was resumed with another end after t = {from} s, where its mean begins: run it on to a \
                 later end, or as a whole"
            )),
            Self::Mean { from, time, .. } if *time <= 0.0 => {
                Err(format!("the run ended before t = {from} s, where its mean begins"))
            }
            Self::Mean { time, integral, .. } => Ok(integral / time),
            Self::Deviation { from, time, .. } if *time <= 0.0 => {
                Err(format!("the run ended before t = {from} s, where its deviation begins"))
            }
            Self::Deviation { time, square, .. } => Ok((square / time).sqrt()),
            Self::First(value) | Self::Last(value) => value.ok_or_else(|| "no window was done".into()),
            Self::Largest { from, value } => {
                value.ok_or_else(|| format!("the run ended before t = {from} s, where its search begins"))
            }
            Self::Passages(passages) => passages.frequency(),
            Self::Course(course) => course.value(),
            Self::Stationary { series, .. } => series.estimate().map(|found| found.mean),
            Self::Trajectory | Self::Crossing(_) | Self::Line(_) => Err("is not a single number".into()),
        }
    }
}

/// How a value goes on from window to window, as integrals over time need it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Between {
    /// It is of whole windows.
    Windows,
    /// It is of their ends, with a straight line between them: the value at the last one, once it is known.
    Ends(Option<f64>),
}

impl Between {
    fn of(when: When) -> Self {
        match when {
            When::Window => Self::Windows,
            When::End => Self::Ends(None),
        }
    }

    /// The part of a window after `from`, s, and the value at its start, where `value` is the window's; none
    /// before it, where not even a NaN counts. What stood at the start of the first window, or of one after a
    /// NaN, is not known: there the value is taken for the whole of it.
    fn part(&mut self, from: f64, value: f64, sample: &Sample) -> Option<(f64, f64)> {
        let weight = (sample.time() - from).clamp(0.0, sample.window.dt);
        let start = match self {
            Self::Windows => value,
            Self::Ends(before) => {
                let rise = before.replace(value).map(|before| value - before);
                value - rise.filter(|rise| rise.is_finite()).unwrap_or(0.0) * (weight / sample.window.dt)
            }
        };
        (weight > 0.0).then_some((weight, start))
    }
}

/// Adds a value of a certain weight to a mean and the squares about it (West 1979, Commun. ACM 22, 532).
fn deviate((time, mean, square): (&mut f64, &mut f64, &mut f64), weight: f64, value: f64) {
    *time += weight;
    let away = value - *mean;
    *mean += away * weight / *time;
    *square += weight * away * (value - *mean);
}

/// Upward passages of a level: the times of the first and the last, to second order in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Passages {
    /// Start, s.
    from: f64,
    /// The level.
    level: f64,
    /// Time and value of the window before.
    before: Option<(f64, f64)>,
    first: Option<f64>,
    last: f64,
    count: u64,
}

impl Passages {
    pub(super) fn of(from: f64, level: f64) -> Self {
        Self { from, level, ..Self::default() }
    }

    fn add(&mut self, time: f64, value: f64) {
        if time <= self.from {
            return;
        }
        if let Some((t, v)) = self.before.replace((time, value))
            && v < self.level
            && value >= self.level
        {
            self.last = t + (time - t) * (self.level - v) / (value - v);
            self.first = self.first.or(Some(self.last));
            self.count += 1;
        }
    }

    fn frequency(&self) -> Result<f64, String> {
        match self.first {
            Some(first) if self.count > 1 => Ok((self.count - 1) as f64 / (self.last - first)),
            _ => Err(format!("passed {} upwards {} times: a period needs two", self.level, self.count)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_of_a_sine_about_a_large_mean_is_its_amplitude_over_the_root_of_two() {
        let (mut time, mut mean, mut square) = (0.0, 0.0, 0.0);
        for k in 0..1000 {
            let value = 1e6 + 0.3 * (std::f64::consts::TAU * f64::from(k) / 1000.0).sin();
            deviate((&mut time, &mut mean, &mut square), 0.011, value);
        }
        assert!(((square / time).sqrt() / (0.3 / 2f64.sqrt()) - 1.0).abs() < 1e-6);
        assert!((mean / 1e6 - 1.0).abs() < 1e-12);
    }

    /// sin(2π 3 t) + 0.2 in windows of 0.011 s: 3 Hz, to the square of 3 Hz × 0.011 s.
    #[test]
    fn frequency_of_a_sine_is_its_own() {
        let mut passages = Passages { from: 0.5, level: 0.1, ..Passages::default() };
        for k in 1..400 {
            let t = 0.011 * f64::from(k);
            passages.add(t, (std::f64::consts::TAU * 3.0 * t).sin() + 0.2);
        }
        let frequency = passages.frequency().expect("many periods");
        assert!((frequency / 3.0 - 1.0).abs() < 1e-3, "{frequency}");
        assert!(passages.first.is_some_and(|first| first > 0.5));
        assert!(Passages::default().frequency().is_err());
    }
}
