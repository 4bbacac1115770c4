//! `series.csv`: a header row, then one row per recorded instant, `t` first.
//!
//! Numbers have the fewest digits that read back to the same bits.

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use protocol::new_file::{Digested, OwnFile, is_at, new_file};
use serde::{Deserialize, Serialize};

use crate::error::OutputError;

/// Rows reach the disk after this long at the latest, so that a killed run loses little.
const FLUSH_PERIOD: Duration = Duration::from_secs(1);

/// An instant within this part of the period of an instant to be recorded counts as it.
const EARLY: f64 = 1e-9;

/// How far `series.csv` was written at a checkpoint: by which a file that was cut or altered since is known.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeriesMark {
    /// Bytes, header included.
    pub bytes: u64,
    /// Rows.
    pub rows: u64,
    /// SHA-256 of these bytes.
    pub digest: [u8; 32],
    /// Number of the period of the last row.
    last: i64,
}

/// Writes `series.csv` row by row.
#[derive(Debug)]
pub struct SeriesWriter {
    path: PathBuf,
    file: BufWriter<Digested<OwnFile>>,
    rows: u64,
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
        let file = new_file(path).map_err(OutputError::file("write", path))?;
        let mut writer = Self::over(path, Digested::new(OwnFile::new(file, 0)), every, (0, 0));
        header(names)
            .and_then(|line| writer.file.write_all(&line))
            .map_err(OutputError::file("write", path))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Goes on with an existing file from the mark of a checkpoint: what was written after it is cut off.
    ///
    /// # Errors
    /// [`OutputError::Content`] if the file has other columns, or does not begin with what stood there at the
    /// mark; [`OutputError::File`].
    pub fn resume(path: &Path, names: &[String], every: f64, mark: &SeriesMark) -> Result<Self, OutputError> {
        let file = File::options().read(true).write(true).open(path);
        let mut file = file.map_err(OutputError::file("resume", path))?;
        let wrong = |what: String| OutputError::Content { path: path.to_owned(), what };
        let first = header(names).map_err(OutputError::file("read", path))?;
        let written = digested(&mut file, mark.bytes, &first)
            .map_err(OutputError::file("read", path))?
            .ok_or_else(|| {
                let remedy = "leave [observe] as it was, or start anew without --resume";
                wrong(format!("its columns are not those of this run: {remedy}"))
            })?;
        if written.length < mark.bytes || written.digest() != mark.digest {
            let found = if written.length < mark.bytes { "is shorter" } else { "has another text" };
            return Err(wrong(format!(
                "{found} than at the checkpoint, where it had {} rows in {} bytes: somebody altered it; put \
                 back the file as the run left it, or start anew without --resume",
                mark.rows, mark.bytes
            )));
        }
        file.set_len(mark.bytes)
            .and_then(|()| file.seek(SeekFrom::Start(mark.bytes)))
            .map_err(OutputError::file("resume", path))?;
        let written = written.going_to(OwnFile::new(file, mark.bytes));
        Ok(Self::over(path, written, every, (mark.rows, mark.last)))
    }

    fn over(path: &Path, file: Digested<OwnFile>, every: f64, (rows, last): (u64, i64)) -> Self {
        let (path, file) = (path.to_owned(), BufWriter::new(file));
        Self { path, file, rows, every, last, flushed: Instant::now() }
    }

    /// Adds a row, `t` first, if one is due at that time; says whether it was.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn record(&mut self, row: &[f64]) -> Result<bool, OutputError> {
        if self.every > 0.0 {
            let now = (row[0] / self.every + EARLY).floor() as i64;
            if now <= self.last {
                return Ok(false);
            }
            self.last = now;
        }
        self.write_row(row).map_err(OutputError::file("write", &self.path))?;
        self.rows += 1;
        if self.flushed.elapsed() >= FLUSH_PERIOD {
            self.flush()?;
        }
        Ok(true)
    }

    fn write_row(&mut self, row: &[f64]) -> io::Result<()> {
        for (place, value) in row.iter().enumerate() {
            if place > 0 {
                self.file.write_all(b",")?;
            }
            write_number(&mut self.file, *value)?;
        }
        self.file.write_all(b"\n")
    }

    /// Hands every row to the system.
    ///
    /// # Errors
    /// [`OutputError::File`]; [`OutputError::Gone`] if the file is not where it was.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.flushed = Instant::now();
        self.file.flush().map_err(OutputError::file("write", &self.path))?;
        if is_at(self.file.get_ref().to.file(), &self.path) {
            Ok(())
        } else {
            Err(OutputError::Gone(self.path.clone()))
        }
    }

    /// Puts every row on the disk, before a checkpoint, and says how far the file goes.
    ///
    /// # Errors
    /// As [`SeriesWriter::flush`].
    pub fn mark(&mut self) -> Result<SeriesMark, OutputError> {
        self.flush()?;
        let written = self.file.get_ref();
        written.to.file().sync_data().map_err(OutputError::file("write", &self.path))?;
        let (bytes, digest) = (written.length, written.digest());
        Ok(SeriesMark { bytes, rows: self.rows, digest, last: self.last })
    }
}

/// Shortest digits that read back alike; whole numbers without a point, very large and very small
/// ones with an exponent.
fn write_number(out: &mut impl Write, value: f64) -> io::Result<()> {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e16).contains(&size) {
        write!(out, "{value:e}")
    } else {
        write!(out, "{value}")
    }
}

/// The first line, with its end.
fn header(names: &[String]) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(names)?;
    writer.into_inner().map_err(|error| error.into_error())
}

/// The first `bytes` of a file, digested; none where they do not begin with `first`.
fn digested(file: &mut File, bytes: u64, first: &[u8]) -> io::Result<Option<Digested<io::Sink>>> {
    let mut reader = file.take(bytes);
    let mut begin = vec![0; first.len()];
    if reader.read_exact(&mut begin).is_err() || begin != first {
        return Ok(None);
    }
    let mut digested = Digested::new(io::sink());
    digested.write_all(&begin)?;
    io::copy(&mut reader, &mut digested)?;
    Ok(Some(digested))
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
        let text = protocol::input_file::read_text(path).map_err(OutputError::file("read", path))?;
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
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let place = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[place])
    }

    /// The times.
    pub fn time(&self) -> &[f64] {
        self.column("t").unwrap_or(&[])
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Has it no row?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
