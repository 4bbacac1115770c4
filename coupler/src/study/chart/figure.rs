//! The figure: error against CPU time, both logarithmic, with the Pareto front.

use std::sync::Arc;

use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LegendPosition, LinePlot, ScatterPlot};
use kuva::render::annotations::ReferenceLine;
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render_to_svg;

use super::config::Published;
use super::describe::{Names, percent};
use super::table::{FLOOR, Row, Table};
use crate::study::report::chart::{COLOURS, MARKERS};
use crate::study::report::page::{escape, number};

/// Grey of lines, and of what was not measured here.
const GREY: &str = "#444444";

/// Width and height of the plot, without the list of names below.
const SIZE: (f64, f64) = (900.0, 470.0);

/// Width of the legend.
const LEGEND: f64 = 230.0;

/// Height of a line of the list.
const LINE: f64 = 21.0;

/// Errors at which a line is drawn.
const TOLERANCES: [f64; 3] = [0.01, 0.02, 0.05];

/// At most so many colours; a key with more values has no colours.
const MOST_FAMILIES: usize = 6;

/// The figure, or nothing if no run has both a cost and an error.
pub(super) fn draw(
    table: &Table,
    names: &Names,
    title: &str,
    published: &[Published],
    seed: Option<&str>,
) -> Option<String> {
    let drawn: Vec<(usize, (f64, f64))> = (0..table.rows.len())
        .filter_map(|row| {
            table.rows[row].point().map(|(cost, error)| (row, (cost.max(1e-9), error.max(FLOOR))))
        })
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let place = |row: usize| drawn.iter().find(|(other, _)| *other == row).map(|(_, point)| *point);
    let front = table.front();
    let way: Vec<(f64, f64)> = front.iter().filter_map(|row| place(*row)).collect();
    let line = LinePlot::new().with_data(way.clone()).with_color(GREY).with_stroke_width(1.6);
    let mut plots = vec![Plot::Line(line.with_legend("Pareto front"))];
    plots.extend(families(table, names, &drawn));
    for point in published {
        plots.push(scatter(
            &[(point.cost, point.error)],
            &point.name,
            GREY,
            MarkerShape::Cross,
            6.5,
            vec![format!("published: {}; {}", point.name, point.source)],
        ));
    }
    let layout = layout(title, &plots, &drawn, published);
    let plane = ComputedLayout::from_layout(&layout);
    let at = |point: (f64, f64)| (plane.map_x(point.0), plane.map_y(point.1));
    let body = render_to_svg(plots, layout);
    let mut over = String::new();
    for (number, point) in way.iter().enumerate() {
        over += &tag(number + 1, at(*point));
    }
    let seed = seed.and_then(|label| table.rows.iter().position(|row| row.label == label));
    if let Some(point) = seed.and_then(place).map(at) {
        over += &ring(point);
    }
    Some(sheet(&body, &over, &listed(table, names, &front)))
}

/// What kuva drew, what is drawn over it, and lines of text below.
fn sheet(body: &str, over: &str, lines: &[String]) -> String {
    let (start, end) = (body.find("<svg").unwrap_or(0), body.rfind("</svg>").unwrap_or(body.len()));
    let inner = body.get(start..end).and_then(|svg| svg.split_once('>')).map_or("", |(_, inner)| inner);
    let height = SIZE.1 + LINE * lines.len() as f64 + 12.0;
    let text = |(place, line): (usize, &String)| {
        let y = SIZE.1 + LINE * (place as f64 + 0.6);
        format!("<text x=\"70\" y=\"{y:.1}\" font-size=\"14\">{line}</text>\n")
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height:.0}\" width=\"{width}\" \
         height=\"{height:.0}\" font-family=\"system-ui, sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{inner}\n{over}{}</svg>\n",
        lines.iter().enumerate().map(text).collect::<String>(),
        width = SIZE.0,
    )
}

/// A ring around the paper's own setting, its name on the side where there is more room.
fn ring((x, y): (f64, f64)) -> String {
    let (end, anchor) = if x > 0.35 * SIZE.0 { (x - 17.0, "end") } else { (x + 17.0, "start") };
    format!(
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"12\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.5\"/>\
         <text x=\"{end:.1}\" y=\"{:.1}\" font-size=\"13\" text-anchor=\"{anchor}\">the paper's own setting</text>\n",
        y + 4.5
    )
}

/// Number of a point of the front, below it to the left: the front falls to the right.
fn tag(number: usize, (x, y): (f64, f64)) -> String {
    format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"14\" font-weight=\"bold\" text-anchor=\"end\">{number}</text>\n",
        x - 8.0,
        y + 15.0
    )
}

/// The names of the front's points, as they are numbered.
fn listed(table: &Table, names: &Names, front: &[usize]) -> Vec<String> {
    let head = "<tspan font-weight=\"bold\">Pareto front, cheapest first</tspan>".to_owned();
    let line = |(place, row): (usize, &usize)| {
        let row = &table.rows[*row];
        let (cost, error) = row.point().unwrap_or_default();
        let name = escape(&names.of(row));
        format!(
            "<tspan font-weight=\"bold\">{}</tspan>  {name}: {} s, {}",
            place + 1,
            number(cost),
            percent(error)
        )
    };
    std::iter::once(head).chain(front.iter().enumerate().map(line)).collect()
}

/// Runs by the values of one key, if there is one with few; each with a name to hover.
fn families(table: &Table, names: &Names, drawn: &[(usize, (f64, f64))]) -> Vec<Plot> {
    let column = family(table);
    let mut values: Vec<&str> = Vec::new();
    for (row, _) in drawn {
        let value = column.map_or("", |column| table.rows[*row].values[column].as_str());
        if !values.contains(&value) {
            values.push(value);
        }
    }
    let plot = |(place, value): (usize, &&str)| {
        let of = |row: usize| column.map_or("", |column| table.rows[row].values[column].as_str()) == *value;
        let here: Vec<&(usize, (f64, f64))> = drawn.iter().filter(|(row, _)| of(*row)).collect();
        let points: Vec<(f64, f64)> = here.iter().map(|(_, point)| *point).collect();
        let titles = here.iter().map(|(row, _)| hover(&table.rows[*row], names)).collect();
        let name = match column {
            None => "runs".to_owned(),
            Some(column) => names.value(column, value),
        };
        let (colour, marker) = (COLOURS[place % COLOURS.len()], MARKERS[place % MARKERS.len()]);
        scatter(&points, &name, colour, marker, 6.0, titles)
    };
    values.iter().enumerate().map(plot).collect()
}

/// The key by which runs are coloured: words rather than numbers, and no ladder of resolution.
fn family(table: &Table) -> Option<usize> {
    let few = |column: &usize| {
        let mut values: Vec<&str> = table.rows.iter().map(|row| row.values[*column].as_str()).collect();
        values.sort_unstable();
        values.dedup();
        (2..=MOST_FAMILIES).contains(&values.len())
    };
    let wordy = |column: &usize| (0..table.rows.len()).any(|row| table.number(row, *column).is_none());
    let refines = |column: &usize| super::limit::refines(&table.keys[*column]).is_some();
    let fit: Vec<usize> = (0..table.keys.len()).filter(few).collect();
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

fn scatter(
    points: &[(f64, f64)],
    name: &str,
    colour: &str,
    marker: MarkerShape,
    size: f64,
    titles: Vec<String>,
) -> Plot {
    let plot = ScatterPlot::new().with_data(points.iter().copied()).with_color(colour).with_size(size);
    Plot::Scatter(plot.with_marker(marker).with_legend(name).with_tooltips().with_tooltip_labels(titles))
}

fn layout(title: &str, plots: &[Plot], drawn: &[(usize, (f64, f64))], published: &[Published]) -> Layout {
    let points = drawn.iter().map(|(_, point)| *point).chain(published.iter().map(|p| (p.cost, p.error)));
    let wide = (f64::INFINITY, 0.0_f64);
    let (x, y) = points.fold((wide, wide), |(x, y), point| {
        ((x.0.min(point.0), x.1.max(point.0)), (y.0.min(point.1), y.1.max(point.1)))
    });
    let mut layout = Layout::auto_from_plots(plots)
        .with_width(SIZE.0)
        .with_height(SIZE.1)
        .with_title(title)
        .with_x_label("CPU time / s")
        .with_y_label("relative error")
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_width(LEGEND)
        .with_font_family("system-ui, sans-serif")
        .with_title_size(16)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(13)
        .with_log_scale()
        .with_x_axis_min(x.0 / 1.6)
        .with_x_axis_max(x.1 * 1.6)
        .with_y_axis_min(y.0 / 1.6)
        .with_y_axis_max(y.1 * 1.6)
        .with_x_tick_format(TickFormat::Custom(Arc::new(number)))
        .with_y_tick_format(TickFormat::Custom(Arc::new(percent)));
    for tolerance in TOLERANCES.into_iter().filter(|tolerance| (y.0 / 1.6..y.1 * 1.6).contains(tolerance)) {
        layout = layout.with_reference_line(ReferenceLine::horizontal(tolerance).with_color("#999999"));
    }
    layout
}
