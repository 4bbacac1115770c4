//! `series.csv`: a header row, then one row per recorded instant, `t` first.
//!
//! Numbers have the fewest digits that read back to the same bits.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::error::OutputError;

/// Rows reach the disk after this long at the latest, so that a killed run loses little.
const FLUSH_PERIOD: Duration = Duration::from_secs(1);

/// An instant within this part of the period of an instant to be recorded counts as it.
const EARLY: f64 = 1e-9;

/// Writes `series.csv` row by row.
#[derive(Debug)]
pub struct SeriesWriter {
    path: PathBuf,
    file: BufWriter<File>,
    /// Time between rows, s; 0: every row.
    every: f64,
    /// Number of the period of the last row.
    last: i64,
    flushed: Instant,
}

impl SeriesWriter {
    /// Starts a new file with its header row.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn create(path: &Path, names: &[String], every: f64) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(OutputError::file("write", path))?;
        let mut writer = Self::over(path, file, every, 0);
        header(names)
            .and_then(|line| writer.file.write_all(&line))
            .map_err(OutputError::file("write", path))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Goes on with an existing file at `time`: rows after it, of windows that the checkpoint does
    /// not know, and a torn last row are cut off.
    ///
    /// # Errors
    /// [`OutputError::Content`] if the file has other columns; [`OutputError::File`].
    pub fn resume(path: &Path, names: &[String], every: f64, time: f64) -> Result<Self, OutputError> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)
            .map_err(OutputError::file("resume", path))?;
        let (length, last) = kept(&file, names, time).map_err(OutputError::file("read", path))?;
        let Some(length) = length else {
            return Err(OutputError::Content {
                path: path.to_owned(),
                what: "its columns are not those of this run: leave [observe] as it was, or start anew \
                       without --resume"
                    .into(),
            });
        };
        let cut = |file: &mut File| {
            file.set_len(length)?;
            file.seek(SeekFrom::Start(length))
        };
        cut(&mut file).map_err(OutputError::file("resume", path))?;
        let last = last.map_or(0, |time| period(time, every));
        Ok(Self::over(path, file, every, last))
    }

    fn over(path: &Path, file: File, every: f64, last: i64) -> Self {
        Self { path: path.to_owned(), file: BufWriter::new(file), every, last, flushed: Instant::now() }
    }

    /// Adds a row, `t` first, if one is due at that time; says whether it was.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn record(&mut self, row: &[f64]) -> Result<bool, OutputError> {
        if self.every > 0.0 {
            let now = period(row[0], self.every);
            if now <= self.last {
                return Ok(false);
            }
            self.last = now;
        }
        self.write_row(row).map_err(OutputError::file("write", &self.path))?;
        if self.flushed.elapsed() >= FLUSH_PERIOD {
            self.flush()?;
        }
        Ok(true)
    }

    fn write_row(&mut self, row: &[f64]) -> std::io::Result<()> {
        for (place, value) in row.iter().enumerate() {
            if place > 0 {
                self.file.write_all(b",")?;
            }
            write_number(&mut self.file, *value)?;
        }
        self.file.write_all(b"\n")
    }

    /// Hands every row to the system: before a checkpoint and at the end.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.flushed = Instant::now();
        self.file.flush().map_err(OutputError::file("write", &self.path))
    }
}

/// Shortest digits that read back alike; whole numbers without a point, very large and very small
/// ones with an exponent.
fn write_number(out: &mut impl Write, value: f64) -> std::io::Result<()> {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e16).contains(&size) {
        write!(out, "{value:e}")
    } else {
        write!(out, "{value}")
    }
}

/// Number of the period that `time` lies in.
fn period(time: f64, every: f64) -> i64 {
    if every > 0.0 { (time / every + EARLY).floor() as i64 } else { 0 }
}

/// The first line, with its end.
fn header(names: &[String]) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(names)?;
    writer.into_inner().map_err(|error| error.into_error())
}

/// Bytes that hold the header and the whole rows up to `time`, and the time of the last of these;
/// no length if the header is another.
fn kept(file: &File, names: &[String], time: f64) -> std::io::Result<(Option<u64>, Option<f64>)> {
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    reader.read_until(b'\n', &mut line)?;
    if line != header(names)? {
        return Ok((None, None));
    }
    let (mut length, mut last) = (line.len() as u64, None);
    loop {
        line.clear();
        reader.read_until(b'\n', &mut line)?;
        let whole = line.strip_suffix(b"\n").and_then(|row| std::str::from_utf8(row).ok());
        let Some(t) = whole.and_then(|row| row.split(',').next()?.parse::<f64>().ok()) else { break };
        if t > time * (1.0 + EARLY) {
            break;
        }
        length += line.len() as u64;
        last = Some(t);
    }
    Ok((Some(length), last))
}

/// A `series.csv` read back, column by column.
///
/// ```
/// let series = bedload_output::Series::parse("t,height\n0,1\n0.5,0.8\n")?;
/// assert_eq!(series.time(), [0.0, 0.5]);
/// assert_eq!(series.column("height"), Some(&[1.0, 0.8][..]));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Series {
    /// Reads a file; a torn last row is left out, an empty cell is NaN.
    ///
    /// # Errors
    /// [`OutputError`] with the line that does not fit.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let text = std::fs::read_to_string(path).map_err(OutputError::file("read", path))?;
        Self::parse(&text).map_err(|what| OutputError::Content { path: path.to_owned(), what })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// Line and cell that do not fit.
    pub fn parse(text: &str) -> Result<Self, String> {
        // A row without its end was being written when the run was killed.
        let whole = text.rfind('\n').map_or(text, |end| &text[..=end]);
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(whole.as_bytes());
        let header = reader.headers().map_err(|error| error.to_string())?;
        let names: Vec<String> = header.iter().map(str::to_owned).collect();
        if names.is_empty() {
            return Err("the file is empty; a header row was expected".into());
        }
        let mut columns = vec![Vec::new(); names.len()];
        let mut row = csv::StringRecord::new();
        while reader.read_record(&mut row).map_err(|error| error.to_string())? {
            let line = row.position().map_or(0, csv::Position::line);
            if row.len() != names.len() {
                return Err(format!("line {line} has {} cells; the header has {}", row.len(), names.len()));
            }
            for (column, cell) in columns.iter_mut().zip(&row) {
                let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
                column.push(value.map_err(|_| format!("line {line}: `{cell}` is not a number"))?);
            }
        }
        Ok(Self { names, columns })
    }

    /// Names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// A column by name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let place = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[place])
    }

    /// The times.
    #[must_use]
    pub fn time(&self) -> &[f64] {
        self.column("t").unwrap_or(&[])
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Has it no row?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
