//! Plots with kuva: lines and points over linear or logarithmic axes. The one file that names it.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
pub(super) use kuva::plot::scatter::MarkerShape as Shape;
use kuva::plot::{BandPlot, LegendPosition, LinePlot, ScatterPlot};
use kuva::render::annotations::ReferenceLine;
use kuva::render::figure::Figure;
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
use kuva::render::plots::Plot as Drawn;
use kuva::render_to_svg;
use protocol::printable::printable;

/// Colours that stay apart for colour-blind eyes (Okabe & Ito 2008).
const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];

/// Marker of each series: colour is never the only difference.
const SHAPES: [Shape; 7] = [
    Shape::Circle,
    Shape::Square,
    Shape::Triangle,
    Shape::Diamond,
    Shape::TriangleDown,
    Shape::Plus,
    Shape::Cross,
];

/// Grey of what was not measured here.
pub(super) const GREY: &str = "#444444";

pub(super) fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

pub(super) fn shape(number: usize) -> Shape {
    SHAPES[number % SHAPES.len()]
}

/// A point, in the units of the axes or of the picture.
pub(super) type Point = (f64, f64);

#[derive(Default)]
pub(super) struct Plot {
    pub(super) size: Point,
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
    /// Thin lines across.
    pub(super) rules: Vec<Rule>,
    /// Width of the legend: kuva's own guess is too narrow for Greek letters. None: there is no legend, as
    /// within a page that has its own.
    pub(super) legend: Option<f64>,
    /// Number of ticks along an axis without a legend, about.
    pub(super) ticks: usize,
}

#[derive(Default)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) log: bool,
    /// Ends; by default they follow from what is drawn.
    pub(super) range: Option<[f64; 2]>,
    /// How ticks are written.
    pub(super) format: Option<fn(f64) -> String>,
    /// Names at 0, 1, 2 … in place of numbers.
    pub(super) names: Vec<String>,
}

/// Points that share a look and a name.
#[derive(Clone)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) colour: &'static str,
    pub(super) points: Vec<Point>,
    pub(super) look: Look,
}

#[derive(Clone)]
pub(super) enum Look {
    Line {
        width: f64,
        dashed: bool,
    },
    /// Words that appear under the pointer, one for each point or none.
    Points {
        shape: Shape,
        size: f64,
        words: Vec<String>,
        bars: Bars,
    },
    /// A line in a band: half its width at each point.
    Band {
        half: Vec<f64>,
    },
    /// Filled rectangles: the points are their lower left and upper right corners in turn.
    Rectangles,
}

/// Half-lengths of bars, one for each point.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Bars {
    None,
    Upright(Vec<f64>),
    Level(Vec<f64>),
}

impl Bars {
    /// Those of the points that are kept.
    pub(super) fn of(self, kept: impl Fn(usize) -> bool) -> Self {
        let of = |bars: Vec<f64>| {
            bars.into_iter().enumerate().filter(|(number, _)| kept(*number)).map(|(_, bar)| bar).collect()
        };
        match self {
            Self::None => Self::None,
            Self::Upright(bars) => Self::Upright(of(bars)),
            Self::Level(bars) => Self::Level(of(bars)),
        }
    }
}

/// A straight line across the plot.
pub(super) enum Rule {
    Upright { at: f64, name: String },
    Level { at: f64 },
}

/// What was drawn, and where the axes lie in it.
pub(super) struct Picture {
    pub(super) svg: String,
    plane: ComputedLayout,
}

impl Picture {
    /// Place of a point in the picture.
    pub(super) fn place(&self, point: Point) -> Point {
        (self.plane.map_x(point.0), self.plane.map_y(point.1))
    }

    /// The picture without its outer tag.
    pub(super) fn inner(&self) -> &str {
        let (start, end) = (self.svg.find("<svg").unwrap_or(0), self.svg.rfind("</svg>").unwrap_or(0));
        self.svg.get(start..end).and_then(|svg| svg.split_once('>')).map_or("", |(_, inner)| inner)
    }
}

impl Plot {
    pub(super) fn draw(&self) -> Picture {
        let drawn: Vec<Drawn> =
            self.series.iter().flat_map(|series| series.drawn(self.legend.is_some())).collect();
        let layout = self.layout(&drawn);
        Picture {
            plane: ComputedLayout::from_layout(&layout),
            svg: printable(&render_to_svg(drawn, layout)).into_owned(),
        }
    }

    fn layout(&self, drawn: &[Drawn]) -> Layout {
        let mut layout = Layout::auto_from_plots(drawn)
            .with_width(self.size.0)
            .with_height(self.size.1)
            .with_x_label(self.x.label.as_str())
            .with_y_label(self.y.label.as_str())
            .with_font_family("system-ui, sans-serif")
            .with_label_size(15);
        layout = match self.legend {
            Some(width) => layout
                .with_title(self.title.as_str())
                .with_legend_position(LegendPosition::OutsideRightTop)
                .with_legend_width(width)
                .with_title_size(16)
                .with_tick_size(13)
                .with_body_size(13),
            None => layout.with_tick_size(14).with_ticks(self.ticks),
        };
        if self.x.log {
            layout = layout.with_log_x();
        }
        if self.y.log {
            layout = layout.with_log_y();
        }
        if let Some([least, largest]) = self.x.range {
            layout = layout.with_x_axis_min(least).with_x_axis_max(largest);
        }
        if let Some([least, largest]) = self.y.range {
            layout = layout.with_y_axis_min(least).with_y_axis_max(largest);
        }
        if let Some(format) = self.x.ticks() {
            layout = layout.with_x_tick_format(format);
        }
        if let Some(format) = self.y.ticks() {
            layout = layout.with_y_tick_format(format);
        }
        if !self.x.names.is_empty() {
            layout = layout.with_x_tick_step(1.0);
        }
        if !self.y.names.is_empty() {
            layout = layout.with_y_tick_step(1.0);
        }
        for rule in &self.rules {
            layout = layout.with_reference_line(match rule {
                Rule::Upright { at, name } => {
                    ReferenceLine::vertical(*at).with_color(GREY).with_label(name.as_str())
                }
                Rule::Level { at } => ReferenceLine::horizontal(*at).with_color("#999999"),
            });
        }
        layout
    }
}

/// Plots of one size beside and below each other, with one legend, as SVG.
pub(super) fn panels(title: &str, plots: &[Plot], across: usize) -> String {
    let drawn: Vec<Vec<Drawn>> =
        plots.iter().map(|plot| plot.series.iter().flat_map(|series| series.drawn(true)).collect()).collect();
    let layouts =
        plots.iter().zip(&drawn).map(|(plot, drawn)| plot.layout(drawn).with_title(plot.title.as_str()));
    let layouts = layouts.map(|layout| layout.with_title_size(13).with_body_size(11).with_show_grid(false));
    let size = plots.first().map_or((0.0, 0.0), |plot| plot.size);
    let figure = Figure::new(plots.len().div_ceil(across), across)
        .with_title(title)
        .with_title_size(16)
        .with_cell_size(size.0, size.1)
        .with_layouts(layouts.collect())
        .with_plots(drawn)
        .with_shared_legend_bottom();
    printable(&SvgBackend.render_scene(&figure.render())).into_owned()
}

impl Axis {
    fn ticks(&self) -> Option<TickFormat> {
        if self.names.is_empty() {
            return self.format.map(|format| TickFormat::Custom(Arc::new(format)));
        }
        let names = self.names.clone();
        let name = move |place: f64| {
            let whole = (place - place.round()).abs() < 1e-6 && place > -0.5;
            names.get(place.round() as usize).filter(|_| whole).cloned().unwrap_or_default()
        };
        Some(TickFormat::Custom(Arc::new(name)))
    }
}

impl Series {
    fn drawn(&self, named: bool) -> Vec<Drawn> {
        let points = self.points.iter().copied();
        let one = match &self.look {
            Look::Line { width, dashed } => {
                let line =
                    LinePlot::new().with_data(points).with_color(self.colour).with_stroke_width(*width);
                let line =
                    if named && !self.name.is_empty() { line.with_legend(self.name.as_str()) } else { line };
                Drawn::Line(if *dashed { line.with_dashed() } else { line })
            }
            Look::Band { half } => {
                let (x, y): (Vec<f64>, Vec<f64>) = points.clone().unzip();
                let edge = |sign: f64| y.iter().zip(half).map(move |(y, half)| y + sign * half);
                let band = BandPlot::new(x, edge(-1.0), edge(1.0)).with_color(self.colour).with_opacity(0.25);
                let line = Self { look: Look::Line { width: 1.6, dashed: false }, ..self.clone() };
                return [Drawn::Band(band)].into_iter().chain(line.drawn(named)).collect();
            }
            Look::Points { shape, size, words, bars } => {
                let plot = ScatterPlot::new().with_data(points).with_color(self.colour).with_size(*size);
                let plot = match bars {
                    Bars::None => plot,
                    Bars::Upright(bars) => plot.with_y_err(bars.iter().copied()),
                    Bars::Level(bars) => plot.with_x_err(bars.iter().copied()),
                };
                let plot = plot.with_marker(*shape);
                let plot = if self.name.is_empty() { plot } else { plot.with_legend(self.name.as_str()) };
                Drawn::Scatter(if words.is_empty() {
                    plot
                } else {
                    plot.with_tooltips().with_tooltip_labels(words.clone())
                })
            }
            Look::Rectangles => {
                // Of no points: kuva has no legend of areas.
                let key = ScatterPlot::new().with_color(self.colour).with_size(6.0);
                let key = Drawn::Scatter(key.with_marker(Shape::Square).with_legend(self.name.as_str()));
                let band = |[(left, low), (right, high)]: &[Point; 2]| {
                    let band = BandPlot::new([*left, *right], [*low, *low], [*high, *high]);
                    Drawn::Band(band.with_color(self.colour).with_opacity(1.0))
                };
                return self.points.as_chunks::<2>().0.iter().map(band).chain([key]).collect();
            }
        };
        vec![one]
    }
}
