//! Values that a scene gives as functions of time: a constant, a table, a sine.
//!
//! A value is a function of time alone, so that a run keeps no state of it: what goes on from a checkpoint or
//! is repeated finds the same bits. Means and integrals have closed forms, so that a path is exact and an
//! impulse complete whatever the step.

mod quantity;
mod written;

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use quantity::{Quantity, length};

/// Steps in the time that the fastest change needs for the largest value: a hundred in a period of a sine.
const STEPS: f64 = 16.0;

/// Steps in a period of a sine. docs/decisions/time-step.md
const OF_PERIOD: f64 = 100.0;

/// A number or a vector that may change over time.
///
/// ```
/// use bedload_over_time::OverTime;
///
/// let ramp = OverTime::table(vec![(1.0, 0.0), (3.0, 4.0)]);
/// assert_eq!([0.0, 2.0, 9.0].map(|t| ramp.at(t)), [0.0, 2.0, 4.0]);
/// assert_eq!(ramp.mean(0.0, 4.0), 2.0);
/// assert_eq!(ramp.largest(2.0), 2.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum OverTime<T> {
    /// The same at all times.
    Constant(T),
    /// Linear between rows, constant outside.
    Table(Arc<Table<T>>),
    /// offset + amplitude · sin(2π frequency t + phase).
    Sine(Arc<Sine<T>>),
}

/// Rows of time, s, and value.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<T> {
    rows: Vec<(f64, T)>,
    /// Integral from the first row to each.
    path: Vec<T>,
    file: Option<PathBuf>,
}

/// offset + amplitude · sin(2π frequency t + phase).
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Sine<T> {
    /// Amplitude.
    pub amplitude: T,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Phase at t = 0, rad.
    pub phase: f64,
    /// Mean value.
    pub offset: T,
}

impl<T: Quantity> Default for OverTime<T> {
    fn default() -> Self {
        Self::Constant(T::ZERO)
    }
}

impl<T> From<T> for OverTime<T> {
    fn from(value: T) -> Self {
        Self::Constant(value)
    }
}

/// A constant equals a value over time that is that constant.
impl<T: PartialEq> PartialEq<T> for OverTime<T> {
    fn eq(&self, value: &T) -> bool {
        matches!(self, Self::Constant(own) if own == value)
    }
}

impl<T: Quantity> OverTime<T> {
    /// A table of its rows, times ascending.
    pub fn table(rows: Vec<(f64, T)>) -> Self {
        Self::Table(Arc::new(Table::new(rows, None)))
    }

    /// A sine.
    pub fn sine(sine: Sine<T>) -> Self {
        Self::Sine(Arc::new(sine))
    }

    /// The constant that it is, if it is one.
    pub fn constant(&self) -> Option<T> {
        if let Self::Constant(value) = self { Some(*value) } else { None }
    }

    /// Whether it changes, or may.
    pub fn varies(&self) -> bool {
        self.constant().is_none()
    }

    /// Time after which a table keeps its value, s; 0 of anything else.
    pub fn last_change(&self) -> f64 {
        self.rows().last().map_or(0.0, |(time, _)| time)
    }

    /// The value at time `t`, s.
    pub fn at(&self, t: f64) -> T {
        match self {
            Self::Constant(value) => *value,
            Self::Table(table) => table.at(t),
            Self::Sine(sine) => sine.offset.plus(sine.angle(t).sin(), &sine.amplitude),
        }
    }

    /// The value at t = 0.
    pub fn start(&self) -> T {
        self.at(0.0)
    }

    /// The mean from `from` to `to`, s.
    pub fn mean(&self, from: f64, to: f64) -> T {
        match self {
            Self::Constant(value) => *value,
            Self::Table(table) => table.mean(from, to),
            Self::Sine(sine) => {
                // cos a − cos b over b − a, without the difference of near numbers
                let half = 0.5 * (to - from) * TAU * sine.frequency;
                let spread = if half == 0.0 { 1.0 } else { half.sin() / half };
                sine.offset.plus(sine.angle(0.5 * (from + to)).sin() * spread, &sine.amplitude)
            }
        }
    }

    /// The integral from 0 to `t`, s.
    pub fn integral(&self, t: f64) -> T {
        match self {
            Self::Table(table) => table.integral(t).plus(-1.0, &table.integral(0.0)),
            other => T::ZERO.plus(t, &other.mean(0.0, t)),
        }
    }

    /// ∫ (value − mean) (to − t) dt between two times, s: where the value is an acceleration, how far a path
    /// leads that of its mean, m.
    pub fn lead(&self, from: f64, to: f64) -> T {
        match self {
            Self::Constant(_) => T::ZERO,
            Self::Table(table) => table.lead(from, to),
            Self::Sine(sine) => {
                // the sine is odd about the middle but for its mean
                let half = 0.5 * (to - from) * TAU * sine.frequency;
                let odd =
                    if half < 1e-3 { half / 3.0 } else { (half.sin() - half * half.cos()) / (half * half) };
                let middle = sine.angle(0.5 * (from + to)).cos();
                T::ZERO.plus(-0.5 * (to - from).powi(2) * middle * odd, &sine.amplitude)
            }
        }
    }

    /// What is linear in the value, such as a component: the same function of time of `of`(value).
    pub fn map<U: Quantity>(&self, of: impl Fn(&T) -> U) -> OverTime<U> {
        match self {
            Self::Constant(value) => OverTime::Constant(of(value)),
            Self::Table(table) => {
                let rows = table.rows.iter().map(|(t, value)| (*t, of(value))).collect();
                OverTime::Table(Arc::new(Table::new(rows, table.file.clone())))
            }
            Self::Sine(sine) => OverTime::sine(Sine {
                amplitude: of(&sine.amplitude),
                frequency: sine.frequency,
                phase: sine.phase,
                offset: of(&sine.offset),
            }),
        }
    }

    /// The values between which it moves: all rows, or the ends of a swing.
    pub fn extremes(&self) -> impl Iterator<Item = T> + '_ {
        let (ends, rows): ([Option<T>; 2], &[(f64, T)]) = match self {
            Self::Constant(value) => ([Some(*value), None], &[]),
            Self::Table(table) => ([None; 2], &table.rows),
            Self::Sine(sine) => ([-1.0, 1.0].map(|way| Some(sine.offset.plus(way, &sine.amplitude))), &[]),
        };
        ends.into_iter().flatten().chain(rows.iter().map(|(_, value)| *value))
    }

    /// Whether all its values are zero.
    pub fn is_zero(&self) -> bool {
        self.extremes().all(|value| value == T::ZERO)
    }

    /// The lowest and the highest value of each component from 0 to `until`, s; of a sine those of its whole
    /// period.
    pub fn range(&self, until: f64) -> [T; 2] {
        let mut values = self.values(until);
        let first = values.next().unwrap_or(T::ZERO);
        values.fold([first; 2], |[mut low, mut high], value| {
            let ends = low.numbers_mut().iter_mut().zip(high.numbers_mut());
            for ((low, high), value) in ends.zip(value.numbers()) {
                (*low, *high) = (low.min(*value), high.max(*value));
            }
            [low, high]
        })
    }

    /// The value of each component that is largest in size from 0 to `until`, s.
    pub fn peak(&self, until: f64) -> T {
        let [low, mut peak] = self.range(until);
        for (peak, low) in peak.numbers_mut().iter_mut().zip(low.numbers()) {
            *peak = larger(*peak, *low);
        }
        peak
    }

    /// The longest value from 0 to `until`, s; of a sine that of its whole period.
    pub fn longest(&self, until: f64) -> T {
        let longer = |a: T, b: T| if length(&b) > length(&a) { b } else { a };
        self.values(until).fold(T::ZERO, longer)
    }

    /// Its length.
    pub fn largest(&self, until: f64) -> f64 {
        length(&self.longest(until))
    }

    /// The values between which it moves from 0 to `until`, s.
    fn values(&self, until: f64) -> impl Iterator<Item = T> + '_ {
        let table = matches!(self, Self::Table(_));
        let between = self.rows().filter(move |(t, _)| (0.0..=until).contains(t)).map(|(_, value)| value);
        let ends = [0.0, until].into_iter().filter(move |_| table).map(|t| self.at(t));
        ends.chain(between).chain(self.extremes().filter(move |_| !table))
    }

    /// Rows of a table.
    fn rows(&self) -> impl Iterator<Item = (f64, T)> + '_ {
        let rows: &[(f64, T)] = if let Self::Table(table) = self { &table.rows } else { &[] };
        rows.iter().copied()
    }

    /// Largest length of its rate of change from 0 to `until`, s.
    pub fn fastest(&self, until: f64) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::Table(table) => {
                let slopes = table.slopes_from(0.0).filter(|(from, _)| *from < until);
                slopes.map(|(_, slope)| slope).fold(0.0, f64::max)
            }
            Self::Sine(sine) => TAU * sine.frequency * length(&sine.amplitude),
        }
    }

    /// The longest step from `t` on, s, that resolves the change: a hundredth of a period, or, where a table
    /// changes, a sixteenth of the time in which it would go from zero to its largest value. A step may reach
    /// a row from which on the table changes faster, and no farther than such a part of what follows.
    pub fn longest_step(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) => f64::INFINITY,
            Self::Sine(sine) if length(&sine.amplitude) == 0.0 => f64::INFINITY,
            Self::Sine(sine) => 1.0 / (OF_PERIOD * sine.frequency),
            Self::Table(table) => {
                let largest = table.rows.iter().map(|(_, value)| length(value)).fold(0.0, f64::max);
                let mut longest = f64::INFINITY;
                for (from, slope) in table.slopes_from(t) {
                    if from - t >= longest {
                        break;
                    }
                    if slope > 0.0 {
                        longest = longest.min((largest / (STEPS * slope)).max(from - t));
                    }
                }
                longest
            }
        }
    }
}

impl OverTime<[f64; 3]> {
    /// Whether all its values lie along one line, to round-off: an angular velocity about an axis that keeps
    /// its direction.
    pub fn is_along_one_line(&self) -> bool {
        let axis = self.longest(f64::INFINITY);
        let size = axis.iter().map(|w| w * w).sum::<f64>();
        self.extremes().all(|w| cross(&w, &axis).iter().all(|across| across.abs() <= 1e-12 * size))
    }

    /// `v` turned from 0 to `t`, s, at this angular velocity, rad/s: exact where its axis stays the same.
    pub fn turn(&self, v: &[f64; 3], t: f64) -> [f64; 3] {
        let turned = self.integral(t);
        let angle = length(&turned);
        if angle == 0.0 {
            return *v;
        }
        // v cos θ + k × v sin θ + k (k·v)(1 − cos θ), Rodrigues (1840)
        let axis = turned.map(|part| part / angle);
        let (across, along) = (cross(&axis, v), (0..3).map(|c| axis[c] * v[c]).sum::<f64>());
        let (sin, cos) = angle.sin_cos();
        std::array::from_fn(|c| v[c] * cos + across[c] * sin + axis[c] * along * (1.0 - cos))
    }
}

/// a × b.
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
}

/// The value of a sum that is largest in size from 0 to `until`, s: exact for tables; amplitudes of sines are
/// added to it.
pub fn peak_of_sum(terms: &[OverTime<f64>], until: f64) -> f64 {
    let (mut swing, mut times) = (0.0, vec![0.0, until]);
    for term in terms {
        times.extend(term.rows().map(|(t, _)| t).filter(|t| (0.0..=until).contains(t)));
        swing += if let OverTime::Sine(sine) = term { sine.amplitude.abs() } else { 0.0 };
    }
    let middle =
        |term: &OverTime<f64>, t| if let OverTime::Sine(sine) = term { sine.offset } else { term.at(t) };
    let sums = times.into_iter().map(|t| terms.iter().map(|term| middle(term, t)).sum());
    let peak = sums.fold(0.0, larger);
    peak + swing.copysign(peak)
}

/// The one that is larger in size.
fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}

impl<T: Quantity> Sine<T> {
    fn angle(&self, t: f64) -> f64 {
        TAU * self.frequency * t + self.phase
    }
}

impl<T: Quantity> Table<T> {
    /// Rows with ascending times, and the file that they are read from; of a file that is still to be read
    /// there are none.
    pub fn new(rows: Vec<(f64, T)>, file: Option<PathBuf>) -> Self {
        let mut way = T::ZERO;
        let steps = rows.windows(2).map(|pair| {
            let half = 0.5 * (pair[1].0 - pair[0].0);
            way = way.plus(half, &pair[0].1).plus(half, &pair[1].1);
            way
        });
        let path = rows.first().map(|_| T::ZERO).into_iter().chain(steps).collect();
        Self { rows, path, file }
    }

    /// Rows of time, s, and value.
    pub fn rows(&self) -> &[(f64, T)] {
        &self.rows
    }

    /// The file that they are read from.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The integral from the first row to `t`.
    fn integral(&self, t: f64) -> T {
        let last = self.before(t).saturating_sub(1);
        let Some((from, value)) = self.rows.get(last) else { return T::ZERO };
        let half = 0.5 * (t - from);
        self.path[last].plus(half, value).plus(half, &self.at(t))
    }

    /// Number of rows up to `t`.
    fn before(&self, t: f64) -> usize {
        self.rows.partition_point(|(time, _)| *time <= t)
    }

    fn at(&self, t: f64) -> T {
        let next = self.before(t);
        match (next.checked_sub(1).map(|last| &self.rows[last]), self.rows.get(next)) {
            (Some((from, a)), Some((to, b))) => {
                // equal rows make a constant to the last bit
                a.plus((t - from) / (to - from), &b.plus(-1.0, a))
            }
            (Some((_, value)), None) | (None, Some((_, value))) => *value,
            (None, None) => T::ZERO,
        }
    }

    /// Trapezia between the rows on the way; the middle where there are none.
    fn mean(&self, from: f64, to: f64) -> T {
        let (first, last) = (self.before(from), self.before(to));
        if first >= last {
            return self.at(0.5 * (from + to));
        }
        let (mut sum, mut at) = (T::ZERO, (from, self.at(from)));
        for row in self.rows[first..last].iter().copied().chain([(to, self.at(to))]) {
            let half = 0.5 * (row.0 - at.0);
            sum = sum.plus(half, &at.1).plus(half, &row.1);
            at = row;
        }
        T::ZERO.plus(1.0 / (to - from), &sum)
    }

    /// [`OverTime::lead`] over the linear parts between the rows on the way.
    fn lead(&self, from: f64, to: f64) -> T {
        let middle = 0.5 * (from + to);
        let (mut sum, mut at) = (T::ZERO, (from, self.at(from)));
        let rows = self.rows[self.before(from)..self.before(to).max(self.before(from))].iter().copied();
        for row in rows.chain([(to, self.at(to))]) {
            let (width, arm) = (row.0 - at.0, middle - 0.5 * (at.0 + row.0));
            let (mean, slope) = (0.5 * width * arm, width * width / 12.0);
            sum = sum.plus(mean + slope, &at.1).plus(mean - slope, &row.1);
            at = row;
        }
        sum
    }

    /// Start and slope of each part that ends after `t`.
    fn slopes_from(&self, t: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.rows[self.before(t).saturating_sub(1)..].windows(2).map(|pair| {
            let ((from, a), (to, b)) = (&pair[0], &pair[1]);
            (*from, length(&b.plus(-1.0, a)) / (to - from))
        })
    }
}
