//! Tables of studies, `chart.csv` and `stability.csv`: one row per run, its value of each varied key first.
//! No cell holds a comma, so that no reader needs quotes.

/// A run as a row.
pub trait Record: Sized {
    /// Its value of each varied key.
    fn values(&self) -> &[String];

    /// The cells behind these.
    fn cells(&self) -> Vec<String>;

    /// A row from its cells.
    ///
    /// # Errors
    /// What does not fit.
    fn parse(values: Vec<String>, cells: &[String]) -> Result<Self, String>;
}

/// All runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<R> {
    /// Headers of the varied keys.
    pub keys: Vec<String>,
    /// Headers of the columns behind them.
    pub columns: Vec<String>,
    /// The runs.
    pub rows: Vec<R>,
}

impl<R: Record> Table<R> {
    /// The text of the file.
    #[must_use]
    pub fn csv(&self) -> String {
        let header = self.keys.iter().chain(&self.columns).map(|name| cell(name)).collect();
        let row = |row: &R| row.values().iter().cloned().chain(row.cells()).map(|text| cell(&text)).collect();
        write(std::iter::once(header).chain(self.rows.iter().map(row)))
    }

    /// Reads the text of a file whose `columns` follow those of the keys.
    ///
    /// # Errors
    /// The columns, or the row that does not fit.
    pub fn parse(text: &str, columns: &[String]) -> Result<Self, String> {
        let (header, rows) = parse_csv(text)?;
        let keys = header.strip_suffix(columns);
        let keys = keys.ok_or_else(|| format!("does not end in the columns {}", columns.join(",")))?.to_vec();
        let row = |(number, cells): (usize, Vec<String>)| {
            let (values, rest) = cells.split_at(keys.len());
            R::parse(values.to_vec(), rest)
                .map_err(|what| format!("row {} is no run, it {what}: {}", number + 1, cells.join(",")))
        };
        let rows = rows.into_iter().enumerate().map(row).collect::<Result<_, _>>()?;
        Ok(Self { keys, columns: columns.to_vec(), rows })
    }
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
#[must_use]
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
///
/// # Errors
/// What is wrong with the text: no header, or a row with another number of cells.
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
mod tests {
    use super::*;

    #[test]
    fn cells_hold_no_commas_and_come_back_as_they_were() {
        let cells = ["[16, 16, 24]", "it broke, twice\nat \"0.3\"", "0.35", ""].map(cell);
        assert_eq!(cells, ["[16 16 24]", "it broke; twice at '0.3'", "0.35", ""]);
        let (header, rows) = parse_csv(&format!("# made here\na,b,c,d\n{}\n", cells.join(","))).unwrap();
        assert_eq!((header.len(), rows), (4, vec![cells.to_vec()]));
        assert!(parse_csv("a,b\n1,2\n1,2,3\n").unwrap_err().contains("3 cells in row 2"));
        assert!(parse_csv("# nothing\n").is_err());
    }
}
