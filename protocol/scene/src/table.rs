//! Tables in CSV as others write them: a header row, blanks about cells, remarks behind `#`, empty lines.

use csv::{ReaderBuilder, StringRecord, Trim};

/// A table as text. Rows may be shorter or longer than the header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Line of the header, counted from 1; 0 where there is none.
    pub header_line: u64,
    /// The rows; each knows its line.
    pub rows: Vec<StringRecord>,
}

impl Table {
    /// Reads the text of a file; one without a header has no columns.
    ///
    /// # Errors
    /// What the `csv` crate says.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut reader = ReaderBuilder::new();
        let reader = reader.comment(Some(b'#')).trim(Trim::All).flexible(true).has_headers(false);
        let rows = reader.from_reader(text.as_bytes()).into_records();
        let mut rows = rows.collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
        // The reader says where the remarks and empty lines before a row begin.
        let lines: Vec<&str> = text.lines().collect();
        for row in &mut rows {
            let Some(mut position) = row.position().cloned() else { continue };
            let mut line = position.line();
            let passed = |line: u64| {
                let text = usize::try_from(line).ok().and_then(|line| lines.get(line - 1));
                text.is_some_and(|text| text.is_empty() || text.starts_with('#'))
            };
            while passed(line) {
                line += 1;
            }
            position.set_line(line);
            row.set_position(Some(position));
        }
        let mut rows = rows.into_iter().filter(|row| row.iter().any(|cell| !cell.is_empty()));
        let header = rows.next().unwrap_or_default();
        let header_line = header.position().map_or(0, csv::Position::line);
        let columns = header.iter().map(str::to_owned).collect();
        Ok(Self { columns, header_line, rows: rows.collect() })
    }

    /// Refuses two columns of one name and cells past the last column.
    ///
    /// # Errors
    /// Line and place of the first such.
    pub fn refuse_odd(&self) -> Result<(), String> {
        for (index, name) in self.columns.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            if let Some(first) = self.columns[..index].iter().position(|other| other == name) {
                return Err(format!(
                    "{}: column {} `{name}` has the name of column {}: rename or remove one of the two",
                    self.header_line,
                    index + 1,
                    first + 1
                ));
            }
        }
        let last = self.columns.len();
        for row in &self.rows {
            let line = row.position().map_or(0, csv::Position::line);
            if let Some(place) = (last..row.len()).find(|place| !row[*place].is_empty()) {
                return Err(format!(
                    "{line}: `{}` in column {} is past the last column, {last}: remove the cell, or name its \
                     column in the header",
                    &row[place],
                    place + 1
                ));
            }
        }
        Ok(())
    }

    /// Place of a column.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// Place of a column that must be there.
    ///
    /// # Errors
    /// Which column is missing, and which there are.
    pub fn need(&self, name: &str) -> Result<usize, String> {
        self.find(name).ok_or_else(|| match &self.columns[..] {
            [] => format!("is empty: there is no column `{name}`"),
            columns => format!("has no column `{name}`; it has `{}`", columns.join("`, `")),
        })
    }
}

/// A cell as a number.
pub fn number(row: &StringRecord, column: usize) -> Option<f64> {
    row.get(column)?.parse().ok()
}

/// A row as a line of text, for messages.
pub fn line(row: &StringRecord) -> String {
    row.iter().collect::<Vec<_>>().join(",")
}
