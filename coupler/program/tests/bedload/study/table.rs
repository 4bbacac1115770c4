//! Tables of studies, read back.

use study::kind::Kind;
use study::stability::classify::Class;
use study::table::{Row, Table};

#[test]
fn a_table_of_runs_that_set_different_keys_is_read_back() {
    let row = |label: &str, values: &[&str]| Row {
        label: label.to_owned(),
        values: values.iter().map(|value| (*value).to_owned()).collect(),
        measured: vec![Some(1.5)],
        repeats: 1,
        ..Row::default()
    };
    let rows = vec![row("one", &["0.8", "9.4"]), row("two", &[])];
    let table = Table { kind: Kind::Case, keys: Vec::new(), metrics: vec!["value_m".to_owned()], rows };
    let text = table.csv();
    assert_eq!(text.lines().count(), 3, "{text}");
    let labels: Vec<String> = Table::parse(&text).unwrap().rows.into_iter().map(|row| row.label).collect();
    assert_eq!(labels, ["one", "two"]);
}

#[test]
fn a_map_of_an_older_build_is_read_and_comes_back_with_its_growth_in_full() {
    let text = "form,nu_dt,verdict,growth,bound_margin,label,note,refused\n\
                a,0.024,failed,0.125,,a_0.024,grows,1\n";
    let table = Table::parse(text).unwrap();
    let row = &table.rows[0];
    assert_eq!((table.kind, table.keys.len(), row.class), (Kind::Stability, 2, Some(Class::Failed)));
    assert_eq!((row.growth, row.margin, row.refused, table.seconds()), (Some(0.125), None, true, None));
    let full = Table { rows: vec![Row { growth: Some(1.0 / 3.0), ..row.clone() }], ..table.clone() };
    assert_eq!(Table::parse(&full.csv()), Ok(full));
    assert!(Table::parse(&text.replace(",failed", ",broken")).unwrap_err().contains("row 1"));
    assert!(Table::parse("a,b\n").unwrap_err().contains("no column label"));
}
