//! Reads the files: little-endian, `UInt64` lengths. What is not of this form is refused.

/// Header and data of a file with appended raw data.
#[derive(Clone, Copy, Debug)]
pub struct Appended<'a> {
    /// The XML before the data.
    pub(super) header: &'a str,
    data: &'a [u8],
}

/// An array as the header names it.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Its name.
    pub name: &'a str,
    /// Numbers per point or cell.
    pub components: usize,
    kind: &'a str,
    offset: usize,
}

impl<'a> Appended<'a> {
    /// Splits the bytes of a file of this `kind`, such as `PolyData`.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn parse(bytes: &'a [u8], kind: &str) -> Result<Self, String> {
        let (header, data) = split(bytes)?;
        let kind = format!("type=\"{kind}\"");
        for needed in [kind.as_str(), "byte_order=\"LittleEndian\"", "header_type=\"UInt64\""] {
            if !header.contains(needed) {
                return Err(format!("its header lacks {needed}"));
            }
        }
        Ok(Self { header, data })
    }

    /// Time, s; not a number if the file has none.
    pub fn time(&self) -> f64 {
        let text = self.header.split_once("Name=\"TimeValue\"").and_then(|(_, rest)| rest.split_once('>'));
        let text = text.and_then(|(_, rest)| rest.split_once('<')).map_or("", |(text, _)| text.trim());
        text.parse().unwrap_or(f64::NAN)
    }

    /// Floats of an array.
    ///
    /// # Errors
    /// If it holds others, or lies beyond the end of the file.
    pub fn real(&self, entry: &Entry) -> Result<Vec<f64>, String> {
        Ok(self.words(entry, "Float64")?.iter().map(|word| f64::from_le_bytes(*word)).collect())
    }

    /// Whole numbers of an array.
    ///
    /// # Errors
    /// If it holds others, or lies beyond the end of the file.
    pub fn whole(&self, entry: &Entry) -> Result<Vec<i64>, String> {
        Ok(self.words(entry, "Int64")?.iter().map(|word| i64::from_le_bytes(*word)).collect())
    }

    /// The array of that name.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(&self, name: &str) -> Result<Entry<'a>, String> {
        let found = entries(self.header)?.into_iter().find(|entry| entry.name == name);
        found.ok_or_else(|| format!("it has no array {name}"))
    }

    fn words(&self, entry: &Entry, kind: &str) -> Result<&'a [[u8; 8]], String> {
        if entry.kind != kind {
            return Err(format!("array {} is not {kind}", entry.name));
        }
        let torn = || format!("array {} lies beyond the end of the file", entry.name);
        let length = self.data.get(entry.offset..).and_then(|rest| rest.first_chunk::<8>());
        let length = usize::try_from(u64::from_le_bytes(*length.ok_or_else(torn)?)).map_err(|_| torn())?;
        let bytes = self.data.get(entry.offset + 8..).and_then(|rest| rest.get(..length));
        Ok(bytes.ok_or_else(torn)?.as_chunks::<8>().0)
    }
}

/// The appended arrays of (a part of) a header.
pub(super) fn entries(header: &str) -> Result<Vec<Entry<'_>>, String> {
    let tags = header.split("<DataArray ").skip(1).filter_map(|rest| rest.split('>').next());
    tags.filter(|tag| attribute(tag, "format") == Some("appended"))
        .map(|tag| {
            let name = attribute(tag, "Name").ok_or("an array has no name")?;
            let number = |key: &str| attribute(tag, key).and_then(|text| text.parse().ok());
            let offset = number("offset").ok_or(format!("array {name} has no offset"))?;
            let kind = attribute(tag, "type").unwrap_or("");
            Ok(Entry { name, components: number("NumberOfComponents").unwrap_or(1), kind, offset })
        })
        .collect()
}

/// Header as text, and the appended bytes.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let mark = b"<AppendedData encoding=\"raw\">";
    let at = bytes.windows(mark.len()).position(|window| window == mark);
    let at = at.ok_or("it is no VTK file with appended raw data")?;
    let header = std::str::from_utf8(&bytes[..at]).map_err(|_| "its header is not text")?;
    let rest = &bytes[at + mark.len()..];
    let start = rest.iter().position(|byte| *byte == b'_').ok_or("its data do not begin with `_`")?;
    Ok((header, &rest[start + 1..]))
}

/// Text of an attribute of a tag.
pub(super) fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    // The space keeps `Name` apart from `FileName`.
    let tag = tag
        .split_once(&format!("{name}=\""))
        .filter(|(before, _)| before.is_empty() || before.ends_with(' '))?;
    tag.1.split('"').next()
}
