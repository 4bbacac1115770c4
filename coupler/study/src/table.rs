//! The table of a study, `chart.csv`, `stability.csv` or `case.csv`: one row per run, its value of each
//! varied key first. No cell holds a comma, so that no reader needs quotes. Results have all their digits,
//! and every row says which build made it on which machine.

use std::path::Path;

use serde::Serialize;

use super::folder::{content, read};
use super::kind::Kind;
use super::stability::classify::Class;
use coupler::failure::Failure;
use coupler::number::rounded;

/// Stands in the lists below for the columns of the metrics: `value` for one, `value_NAME` for several.
const VALUES: &str = "value";

/// Columns behind those of the varied keys.
fn columns(kind: Kind) -> Vec<&'static str> {
    let names = match kind {
        Kind::Chart => {
            "cpu_s,wall_s,error,pareto,label,value,cpu_s_min,cpu_s_max,wall_s_min,wall_s_max,repeats,beside,\
             note,commit,machine"
        }
        Kind::Stability => "verdict,growth,bound_margin,label,note,refused,cpu_s,wall_s,commit,machine",
        Kind::Case => "label,value,cpu_s,wall_s,note,commit,machine",
    };
    names.split(',').collect()
}

/// Is this the name of a column of the table of any kind, varied keys aside?
pub(super) fn is_column(name: &str) -> bool {
    Kind::ALL.into_iter().any(|kind| columns(kind).contains(&name))
}

/// Digits of a time.
const TIME: usize = 5;

/// Smaller errors are alike: they are drawn here, and none is on the front for being the smaller one.
pub(super) const FLOOR: f64 = 1e-6;

/// Least, median and largest of repeated timings, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Least.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of some timings; none of none.
    pub(super) fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let median = 0.5 * (values.get(count.checked_sub(1)? / 2)? + values.get(count / 2)?);
        Some(Self { min: values[0], median, max: values[count - 1] })
    }
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Its value of each varied key, as text.
    pub values: Vec<String>,
    /// Its name, also of its folder.
    pub label: String,
    /// CPU time of fluid, DEM and coupler, s.
    pub cpu: Option<Spread>,
    /// Wall time, s.
    pub wall: Option<Spread>,
    /// Relative error; the largest of them where there are several metrics.
    pub error: Option<f64>,
    /// Is no other run both as cheap and as exact?
    pub pareto: bool,
    /// Value of each metric.
    pub measured: Vec<Option<f64>>,
    /// Times it was made.
    pub repeats: usize,
    /// Runs that shared the machine with it, at most.
    pub beside: usize,
    /// Its class in a map.
    pub class: Option<Class>,
    /// Growth of the alternation, 1/window; none where it is not known.
    pub growth: Option<f64>,
    /// Margin of the bound in its plan: below 1 it is broken; none where it does not apply.
    pub margin: Option<f64>,
    /// Does `bedload check` refuse it, by the bound of the map?
    pub refused: bool,
    /// Why there is no value, or what to know about it.
    pub note: String,
    /// Commit of the build that made it; empty where an older build did.
    pub commit: String,
    /// Machine: model of its processor.
    pub machine: String,
}

/// The runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Kind of the study.
    pub kind: Kind,
    /// Headers of the varied keys.
    pub keys: Vec<String>,
    /// Headers of the values.
    pub metrics: Vec<String>,
    /// The runs.
    pub rows: Vec<Row>,
}

/// Headers of the values of these metrics.
pub(super) fn value_columns(kind: Kind, metrics: &[&str]) -> Vec<String> {
    let one = metrics.len() == 1 && kind == Kind::Chart;
    metrics.iter().map(|name| if one { VALUES.to_owned() } else { format!("{VALUES}_{name}") }).collect()
}

impl Table {
    /// The text of the file.
    pub fn csv(&self) -> String {
        let fixed = columns(self.kind);
        let expand = |name: &&str| match *name {
            VALUES => self.metrics.clone(),
            name => vec![name.to_owned()],
        };
        let header = self.keys.iter().cloned().chain(fixed.iter().flat_map(expand));
        let row = |row: &Row| -> Vec<String> {
            let fixed = fixed.iter().flat_map(|name| row.cells(name));
            let varied = row.values.iter().take(self.keys.len()).cloned();
            varied.chain(fixed).map(|text| cell(&text)).collect()
        };
        let header = header.map(|name| cell(&name)).collect();
        write(std::iter::once(header).chain(self.rows.iter().map(row)))
    }

    /// Reads the text of a file. Columns that older builds did not write may be missing.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (header, rows) = parse_csv(text)?;
        let has = |name: &str| header.iter().any(|column| column == name);
        let kind = match (has("verdict"), has("pareto")) {
            (true, _) => Kind::Stability,
            (_, true) => Kind::Chart,
            _ => Kind::Case,
        };
        let is_value = |name: &str| name == VALUES || name.starts_with("value_");
        let is_fixed = |name: &&String| columns(kind).contains(&name.as_str()) || is_value(name);
        if !has("label") {
            return Err(format!("has no column label; it has {}", header.join(",")));
        }
        let first = header.iter().position(|name| is_fixed(&name)).unwrap_or(0);
        if let Some(name) = header[first..].iter().find(|name| !is_fixed(name)) {
            let allowed = columns(kind).join(",");
            return Err(format!("has an unknown column {name}; behind the varied keys stand {allowed}"));
        }
        let keys = header[..first].to_vec();
        let metrics = header.iter().filter(|name| is_value(name)).cloned().collect();
        let row = |(number, cells): (usize, Vec<String>)| {
            let mut row = Row { values: cells[..first].to_vec(), repeats: 1, ..Row::default() };
            let read = |(name, text): (&String, &String)| row.read(name, text);
            let wrong = |what| format!("row {} is no run, it {what}: {}", number + 1, cells.join(","));
            header[first..].iter().zip(&cells[first..]).try_for_each(read).map_err(wrong)?;
            Ok(row)
        };
        let rows = rows.into_iter().enumerate().map(row).collect::<Result<_, String>>()?;
        Ok(Self { kind, keys, metrics, rows })
    }

    /// The table of a file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        Self::parse(&read(path)?).map_err(content(path))
    }

    /// Time that making the table takes, s: the wall times of its runs, as far as they are known.
    pub fn seconds(&self) -> Option<f64> {
        let of = |row: &Row| Some(row.wall?.median * row.repeats.max(1) as f64);
        self.rows.iter().map(of).sum()
    }

    /// Marks the rows that no other beats in both cost and error.
    pub(crate) fn mark_front(&mut self) {
        let floored = |row: &Row| row.point().map(|(cost, error)| (cost, error.max(FLOOR)));
        let points: Vec<Option<(f64, f64)>> = self.rows.iter().map(floored).collect();
        for (row, point) in self.rows.iter_mut().zip(&points) {
            let beaten = |(cost, error): (f64, f64)| {
                let mut others = points.iter().flatten();
                others.any(|(c, e)| *c <= cost && *e <= error && (*c < cost || *e < error))
            };
            row.pareto = point.is_some_and(|point| !beaten(point));
        }
    }

    /// Rows of the front, cheapest first.
    pub(crate) fn front(&self) -> Vec<usize> {
        let mut front: Vec<usize> = (0..self.rows.len()).filter(|row| self.rows[*row].pareto).collect();
        let cost = |row: &usize| self.rows[*row].cpu.map_or(f64::INFINITY, |cpu| cpu.median);
        front.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        front
    }

    /// The cheapest run whose error is at most `tolerance`.
    pub(crate) fn cheapest(&self, tolerance: f64) -> Option<usize> {
        let within = |row: &usize| self.rows[*row].error.is_some_and(|error| error <= tolerance);
        self.front().into_iter().find(within)
    }

    /// A number in a row, if there is one.
    pub(crate) fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.rows[row].values[column].parse().ok().filter(|value: &f64| value.is_finite())
    }
}

impl Row {
    /// Cost and error, where both are known.
    pub(crate) fn point(&self) -> Option<(f64, f64)> {
        Some((self.cpu?.median, self.error.filter(|error| error.is_finite())?))
    }

    /// Says one thing more, once.
    pub(crate) fn add_note(&mut self, what: &str) {
        if !self.note.contains(what) {
            let joint = if self.note.is_empty() { "" } else { "; " };
            self.note += &format!("{joint}{what}");
        }
    }

    /// Its values of all keys but those of the columns `x` and `y`: the panel of the map that it is in.
    pub(crate) fn panel(&self, x: usize, y: usize) -> String {
        let others = self.values.iter().enumerate().filter(|(column, _)| *column != x && *column != y);
        let parts = others.map(|(_, value)| value.as_str()).filter(|value| !value.is_empty());
        parts.collect::<Vec<_>>().join(" · ")
    }

    /// What stands in a column, or in those of the values.
    fn cells(&self, column: &str) -> Vec<String> {
        let time = |spread: Option<Spread>, of: fn(&Spread) -> f64| {
            full(spread.as_ref().map(of).map(|time| rounded(time, TIME)))
        };
        let flag = |set: bool| u8::from(set).to_string();
        let text = match column {
            VALUES => return self.measured.iter().map(|value| full(*value)).collect(),
            "cpu_s" => time(self.cpu, |s| s.median),
            "cpu_s_min" => time(self.cpu, |s| s.min),
            "cpu_s_max" => time(self.cpu, |s| s.max),
            "wall_s" => time(self.wall, |s| s.median),
            "wall_s_min" => time(self.wall, |s| s.min),
            "wall_s_max" => time(self.wall, |s| s.max),
            "error" => full(self.error),
            "pareto" => flag(self.pareto),
            "label" => self.label.clone(),
            "repeats" => self.repeats.to_string(),
            "beside" => self.beside.to_string(),
            "verdict" => self.class.map_or_else(String::new, |class| class.to_string()),
            "growth" => full(self.growth),
            "bound_margin" => full(self.margin),
            "refused" => flag(self.refused),
            "note" => self.note.clone(),
            "commit" => self.commit.clone(),
            "machine" => self.machine.clone(),
            _ => String::new(),
        };
        vec![text]
    }

    /// Takes what stands in a column.
    fn read(&mut self, column: &str, text: &str) -> Result<(), String> {
        let count = || text.parse().map_err(|_| format!("has {text:?} where a count belongs"));
        let set = |spread: &mut Option<Spread>, part: fn(&mut Spread) -> &mut f64| -> Result<(), String> {
            if let Some(time) = number(text)? {
                *part(spread.get_or_insert(Spread { min: time, median: time, max: time })) = time;
            }
            Ok(())
        };
        match column {
            "cpu_s" => set(&mut self.cpu, |s| &mut s.median)?,
            "cpu_s_min" => set(&mut self.cpu, |s| &mut s.min)?,
            "cpu_s_max" => set(&mut self.cpu, |s| &mut s.max)?,
            "wall_s" => set(&mut self.wall, |s| &mut s.median)?,
            "wall_s_min" => set(&mut self.wall, |s| &mut s.min)?,
            "wall_s_max" => set(&mut self.wall, |s| &mut s.max)?,
            "error" => self.error = number(text)?,
            "pareto" => self.pareto = flag(text)?,
            "label" => self.label = text.to_owned(),
            "repeats" => self.repeats = count()?,
            "beside" => self.beside = count()?,
            "verdict" => {
                self.class = Some(Class::parse(text).ok_or_else(|| format!("has no class {text:?}"))?)
            }
            "growth" => self.growth = number(text)?,
            "bound_margin" => self.margin = number(text)?,
            "refused" => self.refused = flag(text)?,
            "note" => self.note = text.to_owned(),
            "commit" => self.commit = text.to_owned(),
            "machine" => self.machine = text.to_owned(),
            _ => self.measured.push(number(text)?),
        }
        Ok(())
    }
}

/// A number with all its digits; nothing where there is none.
fn full(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// Items by a key, groups and items in order of appearance.
pub(super) fn grouped<T, K: PartialEq>(items: &[T], key: impl Fn(&T) -> K) -> Vec<(K, Vec<&T>)> {
    let mut groups: Vec<(K, Vec<&T>)> = Vec::new();
    for item in items {
        let key = key(item);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(item),
            None => groups.push((key, vec![item])),
        }
    }
    groups
}

/// A number of a cell; none of an empty one.
pub(super) fn number(text: &str) -> Result<Option<f64>, String> {
    match text {
        "" => Ok(None),
        text => text.parse().map(Some).map_err(|_| format!("has {text:?} where a number belongs")),
    }
}

/// A flag of a cell, 0 or 1.
pub(super) fn flag(text: &str) -> Result<bool, String> {
    match text {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(format!("has {text:?} where 0 or 1 belongs")),
    }
}

/// Text as a cell: one line without commas and quotes.
pub(crate) fn cell(text: &str) -> String {
    let text = text.replace("\r\n", " ").replace(['\n', '\r', '\t'], " ").replace('"', "'");
    let inside = text.trim_start_matches(['[', '\'']).len() < text.len();
    // A list of numbers stays legible with blanks alone; prose gets a semicolon.
    if inside { text.replace(", ", " ").replace(',', " ") } else { text.replace(',', ";") }.trim().to_owned()
}

/// Lines of cells as text; nothing can go wrong in memory.
fn write(lines: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in lines {
        let _ = writer.write_record(&line);
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// Header and rows of such a table; empty lines and lines that begin with `#` are passed over.
pub(crate) fn parse_csv(text: &str) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    let table = bedload_scene::table::Table::parse(text)?;
    if table.columns.is_empty() {
        return Err("holds no table".to_owned());
    }
    let cells = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
    let (header, lines): (_, Vec<Vec<String>>) = (table.columns, table.rows.iter().map(cells).collect());
    match lines.iter().position(|row| row.len() != header.len()) {
        Some(wrong) => {
            let (cells, columns) = (lines[wrong].len(), header.len());
            Err(format!("has {cells} cells in row {}, but {columns} columns", wrong + 1))
        }
        None => Ok((header, lines)),
    }
}

/// (value − reference)/|reference|, or the difference itself where the reference is 0.
pub(super) fn error(value: f64, reference: f64) -> f64 {
    (value - reference) / if reference == 0.0 { 1.0 } else { reference.abs() }
}

/// Value at `x` on the lines between points with ascending abscissae; none outside.
pub(super) fn interpolated(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = points.partition_point(|(other, _)| *other < x);
    let (right, left) = (points.get(after)?, points.get(after.saturating_sub(1))?);
    if right.0 == x {
        return Some(right.1);
    }
    (after > 0).then(|| left.1 + (right.1 - left.1) * (x - left.0) / (right.0 - left.0))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A chart of one numeric key and a family, from cost and error (and value) of each run.
    pub(crate) fn chart(points: &[(f64, &str, f64, f64)]) -> Table {
        let row = |(key, family, cost, error): &(f64, &str, f64, f64)| Row {
            values: vec![key.to_string(), (*family).to_owned()],
            label: format!("{family}-{key}"),
            cpu: Spread::of(vec![*cost]),
            wall: Spread::of(vec![*cost]),
            error: Some(*error),
            measured: vec![Some(1.0 + error)],
            repeats: 1,
            ..Row::default()
        };
        let mut table = Table {
            kind: Kind::Chart,
            keys: vec!["resolution".to_owned(), "method".to_owned()],
            metrics: value_columns(Kind::Chart, &["m"]),
            rows: points.iter().map(row).collect(),
        };
        table.mark_front();
        table
    }

    #[test]
    fn cells_hold_no_commas_and_come_back_as_they_were() {
        let cells = ["[16, 16, 24]", "it broke, twice\nat \"0.3\"", "0.35", ""].map(cell);
        assert_eq!(cells, ["[16 16 24]", "it broke; twice at '0.3'", "0.35", ""]);
        let (header, rows) = parse_csv(&format!("# made here\na,b,c,d\n{}\n", cells.join(","))).unwrap();
        assert_eq!((header.len(), rows), (4, vec![cells.to_vec()]));
        assert!(parse_csv("a,b\n1,2\n1,2,3\n").unwrap_err().contains("3 cells in row 2"));
        assert!(parse_csv("# nothing\n").is_err());
    }

    #[test]
    fn the_front_is_what_nothing_beats_in_both() {
        let mut table = chart(&[
            (8.0, "a", 1.0, 0.04),
            (16.0, "a", 4.0, 0.01),
            (8.0, "b", 0.5, 0.04),  // beats the first
            (16.0, "b", 8.0, 0.01), // beaten by the second
            (32.0, "b", 9.0, 0.001),
        ]);
        assert_eq!(table.front(), [2, 1, 4]);
        assert_eq!([0.05, 0.02, 0.01, 1e-4].map(|t| table.cheapest(t)), [Some(2), Some(1), Some(1), None]);
        table.rows[4].error = Some(1e-9);
        table.rows[3].error = Some(1e-8);
        table.mark_front();
        assert_eq!(table.front(), [2, 1, 3], "neither has an error to speak of, and it is cheaper");
        table.rows[3].error = Some(0.01);
        table.rows[4].error = None;
        table.rows[1].error = Some(f64::NAN);
        table.mark_front();
        assert_eq!(table.front(), [2, 3], "a run without an error is on no front");
    }

    #[test]
    fn the_table_comes_back_from_its_file() {
        let mut before = chart(&[(8.0, "a", 1.25, 0.0400001), (16.0, "b", 4.0, 0.01)]);
        before.rows[1].error = None;
        before.rows[1].cpu = None;
        before.rows[1].wall = None;
        before.rows[1].measured = vec![None];
        before.rows[1].note = "it broke; at once".to_owned();
        before.rows[0].error = Some(0.04);
        before.mark_front();
        let text = before.csv();
        assert!(
            text.starts_with("resolution,method,cpu_s,wall_s,error,pareto,label,value,cpu_s_min,"),
            "{text}"
        );
        assert!(text.contains("\n8,a,1.25,1.25,0.04,1,a-8,1.0400001,1.25,"), "{text}");
        let parse = Table::parse;
        assert_eq!(parse(&text), Ok(before));
        assert!(parse(&text.replace("wall_s,", "wall,")).is_err());
        assert!(parse(&text.replace("1.25,1.25", "x,1.25")).is_err());
    }

    #[test]
    fn a_spread_has_a_median() {
        let spread = Spread::of(vec![3.0, 1.0, 2.0]).unwrap();
        assert_eq!((spread.min, spread.median, spread.max), (1.0, 2.0, 3.0));
        assert_eq!(Spread::of(vec![1.0, 2.0]).map(|spread| spread.median), Some(1.5));
        assert_eq!(Spread::of(Vec::new()), None);
    }
}
