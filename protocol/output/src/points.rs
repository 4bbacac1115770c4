//! Two columns of a table in CSV.

use bedload_scene::table::{Table, line, number};

/// The pairs of two columns of a CSV text with a header; lines that begin with `#` are remarks.
///
/// # Errors
/// What is missing: a column, or a number in one of them.
pub fn points(text: &str, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let table = Table::parse(text)?;
    let (x, y) = (table.need(x)?, table.need(y)?);
    let lacks = |row| format!("the line {:?} lacks a number in a column asked for", line(row));
    table.rows.iter().map(|row| number(row, x).zip(number(row, y)).ok_or_else(|| lacks(row))).collect()
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
    }
}
