//! Two columns of a table in CSV.

use bedload_scene::table::{Table, line, number};

/// The pairs of two columns of a CSV text with a header; lines that begin with `#` are remarks.
///
/// # Errors
/// What is missing: a column, or a number in one of them.
pub fn points(text: &str, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let table = Table::parse(text)?;
    table.refuse_odd()?;
    let (x, y) = (table.need(x)?, table.need(y)?);
    let lacks = |row| format!("the line {:?} lacks a number in a column asked for", line(row));
    table.rows.iter().map(|row| number(row, x).zip(number(row, y)).ok_or_else(|| lacks(row))).collect()
}

/// The same of a published table: it has a row, and all numbers are finite.
///
/// # Errors
/// What is missing.
pub fn published_points(text: &str, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let points = points(text, x, y)?;
    if points.is_empty() {
        return Err("has no row".to_owned());
    }
    match points.iter().find(|(x, y)| !(x.is_finite() && y.is_finite())) {
        Some((at, value)) => Err(format!("has {value} at {at}; allowed: finite numbers")),
        None => Ok(points),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_points_are_read_by_column() {
        let text = "# remark\nSt, e,note\n10,0.03,a\n\n20, 0.17 ,b\n";
        assert_eq!(points(text, "St", "e"), Ok(vec![(10.0, 0.03), (20.0, 0.17)]));
        assert!(points(text, "St", "E").unwrap_err().contains("`St`, `e`, `note`"));
        assert!(points(text, "St", "note").unwrap_err().contains("10,0.03,a"));
        assert!(points("a,b,b\n1,2,3\n", "a", "b").unwrap_err().contains("column 3"));
        assert!(points("a,b\n0,0,1,0\n", "a", "b").unwrap_err().contains("past the last column"));
        assert!(published_points("# none\na,b\n", "a", "b").unwrap_err().contains("no row"));
        assert!(published_points("a,b\n1,nan\n", "a", "b").unwrap_err().contains("NaN at 1"));
    }
}
