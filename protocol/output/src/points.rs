//! Two columns of a table in CSV.

/// The pairs of two columns of a CSV text with a header; lines that begin with `#` are remarks.
///
/// # Errors
/// What is missing: a column, or a number in one of them.
pub fn points(text: &str, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    let header: Vec<&str> = lines.next().unwrap_or("").split(',').map(str::trim).collect();
    let place = |name: &str| {
        let found = header.iter().position(|column| *column == name);
        found.ok_or_else(|| format!("has no column {name:?}; it has {}", header.join(", ")))
    };
    let (x, y) = (place(x)?, place(y)?);
    let point = |line: &str| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let cell = |place: usize| cells.get(place)?.parse::<f64>().ok();
        cell(x).zip(cell(y)).ok_or_else(|| format!("the line {line:?} lacks a number in a column asked for"))
    };
    lines.map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_points_are_read_by_column() {
        let text = "# remark\nSt, e,note\n10,0.03,a\n\n20, 0.17 ,b\n";
        assert_eq!(points(text, "St", "e"), Ok(vec![(10.0, 0.03), (20.0, 0.17)]));
        assert!(points(text, "St", "E").unwrap_err().contains("St, e, note"));
        assert!(points(text, "St", "note").unwrap_err().contains("10,0.03,a"));
    }
}
