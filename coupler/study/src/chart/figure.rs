//! The figure: error against CPU time, or against a varied key; both logarithmic, with the Pareto front.

use super::describe::Names;
use crate::page::{context, render};
use crate::plot::{Axis, Bars, GREY, Look, Plot, Point, Rule, Series, Shape, colour, shape};
use crate::section::Section;
use crate::table::{FLOOR, Row, Table};
use coupler::failure::Failure;
use coupler::number::{number, percent};

/// Width and height of the plot; `templates/chart.svg` has them, too, and the list of names below.
const SIZE: (f64, f64) = (900.0, 470.0);

/// Width of the legend.
const LEGEND: f64 = 230.0;

/// Errors at which a line is drawn.
const TOLERANCES: [f64; 3] = [0.01, 0.02, 0.05];

/// At most so many colours; a key with more values has no colours.
const MOST_FAMILIES: usize = 7;

/// The figure, or nothing if no run has both a cost and an error.
pub(super) fn draw(
    table: &Table,
    names: &Names,
    title: &str,
    chart: &Section,
) -> Result<Option<String>, Failure> {
    if let Some(over) = table.keys.iter().position(|key| *key == chart.x) {
        return over_key(table, names, title, over).map(Some);
    }
    let (published, baseline) = (&chart.published, chart.baseline.as_deref());
    let drawn: Vec<Run> = (0..table.rows.len())
        .filter_map(|row| {
            table.rows[row].point().map(|(cost, error)| (row, (cost.max(1e-9), error.max(FLOOR))))
        })
        .collect();
    if drawn.is_empty() {
        return Ok(None);
    }
    let place = |row: usize| drawn.iter().find(|(other, _)| *other == row).map(|(_, point)| *point);
    let front = table.front();
    let way: Vec<Point> = front.iter().filter_map(|row| place(*row)).collect();
    let mut series = vec![Series {
        name: "Pareto front".to_owned(),
        colour: GREY,
        points: way.clone(),
        look: Look::Line { width: 1.6, dashed: false },
    }];
    series.extend(families(table, names, &drawn, None));
    series.extend(published.iter().map(|point| Series {
        name: point.name.clone(),
        colour: GREY,
        points: vec![(point.cost, point.error)],
        look: Look::Points {
            shape: Shape::Cross,
            size: 6.5,
            words: vec![format!("published: {}; {}", point.name, point.source)],
            bars: Bars::None,
        },
    }));
    let picture = plot(title, "CPU time / s", series).draw();
    let baseline = baseline.and_then(|label| table.rows.iter().position(|row| row.label == label));
    let named = |row: &usize| {
        let (cost, error) = table.rows[*row].point().unwrap_or_default();
        context! { name => names.of(&table.rows[*row]), cost, error }
    };
    // What kuva drew; points of the front, numbered; a ring where the paper's own setting is; the runs of the
    // front, listed below.
    let shown = context! {
        inner => picture.inner(),
        way => way.iter().map(|point| picture.place(*point)).collect::<Vec<_>>(),
        ring => baseline.and_then(place).map(|point| picture.place(point)),
        front => front.iter().map(named).collect::<Vec<_>>(),
    };
    render("chart.svg", shown).map(Some)
}

/// The figure with the values of a key in place of the cost, runs of one family joined.
fn over_key(table: &Table, names: &Names, title: &str, over: usize) -> Result<String, Failure> {
    let point = |row: usize| {
        let error = table.rows[row].point()?.1;
        Some((row, (table.number(row, over)?, error.max(FLOOR))))
    };
    let drawn: Vec<Run> = (0..table.rows.len()).filter_map(point).collect();
    let mut series = families(table, names, &drawn, Some(over));
    let joined = |of: &Series| {
        let mut points = of.points.clone();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let look = Look::Line { width: 1.0, dashed: false };
        Series { name: String::new(), colour: of.colour, points, look }
    };
    let mut lines: Vec<Series> = series.iter().map(joined).collect();
    lines.append(&mut series);
    let picture = plot(title, &names.all()[over], lines).draw();
    let none = [0.0; 0];
    render(
        "chart.svg",
        context! { inner => picture.inner(), way => none, ring => None::<Point>, front => none },
    )
}

/// A row that is drawn, with its cost and error.
type Run = (usize, Point);

/// Runs by the values of one key, if there is one with few; each with a name to hover.
fn families(table: &Table, names: &Names, drawn: &[Run], over: Option<usize>) -> Vec<Series> {
    let column = family(table, over);
    let value_of = |row: usize| column.map_or("", |column| table.rows[row].values[column].as_str());
    let mut values: Vec<&str> = Vec::new();
    for (row, _) in drawn {
        if !values.contains(&value_of(*row)) {
            values.push(value_of(*row));
        }
    }
    let series = |(place, value): (usize, &&str)| {
        let here: Vec<&Run> = drawn.iter().filter(|(row, _)| value_of(*row) == *value).collect();
        let words = here.iter().map(|(row, _)| hover(&table.rows[*row], names)).collect();
        Series {
            name: column.map_or("runs".to_owned(), |column| names.value(column, value)),
            colour: colour(place),
            points: here.iter().map(|(_, point)| *point).collect(),
            look: Look::Points { shape: shape(place), size: 6.0, words, bars: Bars::None },
        }
    };
    values.iter().enumerate().map(series).collect()
}

/// The key by which runs are coloured: words rather than numbers, and no refinement of resolution.
fn family(table: &Table, over: Option<usize>) -> Option<usize> {
    let few = |column: &usize| {
        let mut values: Vec<&str> = table.rows.iter().map(|row| row.values[*column].as_str()).collect();
        values.sort_unstable();
        values.dedup();
        (2..=MOST_FAMILIES).contains(&values.len())
    };
    let wordy = |column: &usize| (0..table.rows.len()).any(|row| table.number(row, *column).is_none());
    let refines = |column: &usize| super::limit::refines(&table.keys[*column]).is_some();
    let fit: Vec<usize> = (0..table.keys.len()).filter(|column| Some(*column) != over).filter(few).collect();
    let word = fit.iter().copied().find(|column| wordy(column) && !refines(column));
    word.or(fit.iter().copied().find(|column| !refines(column)))
        .or(fit.first().copied().filter(|_| fit.len() > 1))
}

/// What a point says when the mouse rests on it.
fn hover(row: &Row, names: &Names) -> String {
    let (cost, error) = row.point().unwrap_or_default();
    let note = if row.note.is_empty() { String::new() } else { format!("\n{}", row.note) };
    let keys = names.lines(row).join("\n");
    format!("{keys}\nCPU {} s\nerror {}{note}", number(cost), percent(error))
}

fn plot(title: &str, along: &str, series: Vec<Series>) -> Plot {
    let wide = (f64::INFINITY, 0.0_f64);
    let (x, y) = series.iter().flat_map(|series| &series.points).fold((wide, wide), |(x, y), point| {
        ((x.0.min(point.0), x.1.max(point.0)), (y.0.min(point.1), y.1.max(point.1)))
    });
    let axis = |label: &str, ends: Point, format| Axis {
        label: label.to_owned(),
        log: true,
        range: Some([ends.0 / 1.6, ends.1 * 1.6]),
        format: Some(format),
        names: Vec::new(),
    };
    let shown = |tolerance: &f64| (y.0 / 1.6..y.1 * 1.6).contains(tolerance);
    Plot {
        size: SIZE,
        title: title.to_owned(),
        x: axis(along, x, number),
        y: axis("relative error", y, percent),
        series,
        rules: TOLERANCES.into_iter().filter(shown).map(|at| Rule::Level { at }).collect(),
        legend: Some(LEGEND),
        ticks: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::chart as table;

    #[test]
    fn over_a_key_runs_of_one_family_are_joined_and_there_is_no_front() {
        let table = table(&[(16.0, "a", 4.0, 0.01), (8.0, "a", 1.0, 0.04), (8.0, "b", 2.0, 0.02)]);
        let vary = "[[vary]]\nkey = \"resolution\"\nname = \"D/Δx\"\nvalues = [8, 16]\n\
                    [[vary]]\nname = \"method\"\nvalues = []\n";
        let cost: Section = toml::from_str(vary).unwrap();
        let over: Section = toml::from_str(&format!("x = \"resolution\"\n{vary}")).unwrap();
        let [cost, over] = [cost, over].map(|chart| {
            draw(&table, &Names::new(&chart, &table), "title", &chart).unwrap().expect("a figure")
        });
        assert!(cost.contains("Pareto") && cost.contains("CPU time"));
        assert!(over.contains("D/Δx") && !over.contains("Pareto") && !over.contains("CPU time / s"));
        assert!(over.contains(">a<") && over.contains(">b<"), "{over}");
    }
}
