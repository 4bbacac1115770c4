//! Tables of sweeps: comma-separated, and no cell holds a comma, so that no reader needs quotes.

/// Text as a cell: one line without commas and quotes.
#[must_use]
pub fn cell(text: &str) -> String {
    let text = text.replace("\r\n", " ").replace(['\n', '\r', '\t'], " ").replace('"', "'");
    let inside = text.trim_start_matches(['[', '\'']).len() < text.len();
    // A list of numbers stays legible with blanks alone; prose gets a semicolon.
    if inside { text.replace(", ", " ").replace(',', " ") } else { text.replace(',', ";") }.trim().to_owned()
}

/// Header and rows of such a table; empty lines and lines that begin with `#` are passed over.
///
/// # Errors
/// What is wrong with the text: no header, or a row with another number of cells.
pub fn parse_csv(text: &str) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let split = |line: &str| -> Vec<String> { line.split(',').map(|cell| cell.trim().to_owned()).collect() };
    let header = split(lines.next().ok_or("holds no table")?);
    let rows: Vec<Vec<String>> = lines.map(split).collect();
    match rows.iter().position(|row| row.len() != header.len()) {
        Some(wrong) => {
            Err(format!("has {} cells in row {}, but {} columns", rows[wrong].len(), wrong + 1, header.len()))
        }
        None => Ok((header, rows)),
    }
}

/// Value at `x` on the lines between points with ascending abscissae; none outside.
pub(crate) fn interpolated(points: &[(f64, f64)], x: f64) -> Option<f64> {
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
