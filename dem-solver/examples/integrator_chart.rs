//! Speed against accuracy of the integrators:
//! `cargo run --release -p bedload-dem --example integrator_chart -- [FOLDER]` (docs/figures).
//!
//! Two spheres of acetate (e_n = 0.87, μ = 0.25, k_t/k_n = 0.2, no tangential dashpot) collide with sub-steps
//! of t_c/5 to t_c/200. Each error is the largest over 16 moments of the touch within a sub-step:
//! - restitution against that of the clipped law, relative;
//! - Ψ₂ against the converged solution of the model (`scenes/reference/oblique_linear_model.csv`), absolute;
//! - energy after a central collision without dissipation (e_n = 1) against that before, relative.
//!
//! Cost: CPU time per contact of a settled bed (`scenes/bench/packing.csv`) and sub-step, best of several
//! runs, times the sub-steps of a contact time. Writes `integrators.csv` and one figure per error.

use cpu_time::ProcessTime;
use dem_solver::{ContactLaw, Dem, DemSpec, Engine, Grain, Integrator, LinearSpringDashpot, Wall};
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LegendPosition, LinePlot, ScatterPlot};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

const T_C: f64 = 1e-5;
const RADIUS: f64 = 1.5e-3;
const PHASES: u32 = 16;
const STEPS: [u32; 13] = [5, 7, 10, 14, 20, 28, 40, 56, 80, 100, 120, 160, 200];

/// Added to each: with a whole number of sub-steps in a contact time errors of its beginning and end cancel.
const OFF: f64 = 0.4;

type Method = (&'static str, Integrator, Engine);

const METHODS: [Method; 4] = [
    ("symplectic Euler", Integrator::SymplecticEuler, Engine::General),
    ("symplectic Euler, bulk", Integrator::SymplecticEuler, Engine::Bulk),
    ("velocity Verlet", Integrator::VelocityVerlet, Engine::General),
    ("RK3", Integrator::Rk3, Engine::General),
];

/// What a collision at Ψ₁ leaves: restitution, Ψ₂, energy over that before.
fn collide(
    law: LinearSpringDashpot,
    psi1: f64,
    n: f64,
    phase: f64,
    method: Method,
) -> Result<[f64; 3], Box<dyn Error>> {
    // so slow that the line of centres does not turn
    let v_n = 4.7e-5;
    let apart = 0.5 * phase * v_n * T_C / n;
    let sphere = |side: f64| {
        let mut grain = Grain::new([side * (RADIUS + apart), 0.0, 0.0], RADIUS, 1319.0);
        grain.velocity = [-0.5 * side * v_n, 0.0, -0.5 * side * v_n * psi1];
        grain
    };
    let mut spec = DemSpec::new(vec![sphere(-1.0), sphere(1.0)], ContactLaw::LinearSpringDashpot(law));
    (spec.integrator, spec.engine) = (method.1, method.2);
    let mut dem = Dem::new(&spec)?;
    let before = dem.kinetic_energy();
    let steps = (1.6 * n).round();
    dem.advance(steps * T_C / n, steps as u32, &[])?;
    let g = &dem.grains;
    let relative = g.velocity[1] - g.velocity[0];
    let slip = -relative.z - RADIUS * (g.spin[0].y + g.spin[1].y);
    Ok([relative.x / v_n, slip / v_n, dem.kinetic_energy() / before])
}

/// Text of a file of the repository; `path` from its root.
fn repository_file(path: &str) -> Result<String, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}; run in a checkout", path.display()))
}

/// Ψ₁ and Ψ₂ of the capped law at k_t/k_n = 0.2.
fn reference() -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let table = repository_file("scenes/reference/oblique_linear_model.csv")?;
    let rows = table.lines().filter(|line| line.starts_with("0.200000,limited"));
    rows.map(|line| {
        let cell: Vec<&str> = line.split(',').collect();
        Ok((cell[2].parse()?, cell[3].parse()?))
    })
    .collect()
}

/// Errors of restitution, Ψ₂ and energy.
fn errors(n: f64, method: Method) -> Result<[f64; 3], Box<dyn Error>> {
    let mut acetate = LinearSpringDashpot::new(0.87, T_C, 0.25);
    acetate.damping_ratio = 0.0;
    let elastic = LinearSpringDashpot { restitution: 1.0, ..acetate };
    let e = acetate.restitution;
    let (mut worst, reference) = ([0.0f64; 3], reference()?);
    for phase in (0..PHASES).map(|k| (f64::from(k) + 0.5) / f64::from(PHASES)) {
        worst[0] = worst[0].max((collide(acetate, 0.0, n, phase, method)?[0] / e - 1.0).abs());
        worst[2] = worst[2].max((collide(elastic, 0.0, n, phase, method)?[2] - 1.0).abs());
        for &(psi1, psi2) in &reference {
            worst[1] = worst[1].max((collide(acetate, psi1, n, phase, method)?[1] - psi2).abs());
        }
    }
    Ok(worst)
}

/// CPU time per contact and sub-step in a settled bed of 1,000 spheres, ns.
fn cost(method: Method) -> Result<f64, Box<dyn Error>> {
    let text = repository_file("scenes/bench/packing.csv")?;
    let mut grains = Vec::new();
    for line in text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
        let value: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        grains.push(Grain::new([value[0], value[1], value[2]], value[3], 2500.0));
    }
    let mut spec =
        DemSpec::new(grains, ContactLaw::LinearSpringDashpot(LinearSpringDashpot::new(0.3, 1e-4, 0.25)));
    spec.gravity = [0.0, 0.0, -9.81].into();
    let wall = |point: [f64; 3], normal: [f64; 3]| Wall::new(point, normal);
    spec.walls = vec![
        wall([0.0; 3], [0.0, 0.0, 1.0]),
        wall([0.0; 3], [1.0, 0.0, 0.0]),
        wall([0.02, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        wall([0.0; 3], [0.0, 1.0, 0.0]),
        wall([0.0, 0.02, 0.0], [0.0, -1.0, 0.0]),
    ];
    (spec.integrator, spec.engine, spec.observations) = (method.1, method.2, false);
    let mut dem = Dem::new(&spec)?;
    dem.advance(600.0 * 2e-6, 600, &[])?;
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = ProcessTime::now();
        dem.advance(100.0 * 2e-6, 100, &[])?;
        let (spent, state) = (start.elapsed().as_secs_f64(), dem.save());
        let contacts = state.contacts.len() + state.wall_contacts.len();
        best = best.min(spent * 1e9 / (100 * contacts) as f64);
    }
    Ok(best)
}

/// A method and its error by cost.
type Curve = (&'static str, Vec<(f64, f64)>);

/// One line per method, error against cost.
fn draw(title: &str, lines: &[Curve]) -> String {
    const COLOURS: [&str; 4] = ["#0072B2", "#56B4E9", "#D55E00", "#009E73"];
    const MARKERS: [MarkerShape; 4] =
        [MarkerShape::Circle, MarkerShape::Diamond, MarkerShape::Square, MarkerShape::Triangle];
    let mut plots = Vec::new();
    for (k, (name, points)) in lines.iter().enumerate() {
        let line = LinePlot::new().with_data(points.clone()).with_color(COLOURS[k]).with_stroke_width(1.2);
        let dots = ScatterPlot::new().with_data(points.clone()).with_color(COLOURS[k]);
        plots.push(Plot::Line(line));
        plots.push(Plot::Scatter(dots.with_size(4.5).with_marker(MARKERS[k]).with_legend(*name)));
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_width(860.0)
        .with_height(420.0)
        .with_title(title)
        .with_x_label("CPU time per contact over a contact time, ns")
        .with_y_label("largest error")
        .with_log_x()
        .with_log_y()
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_width(230.0)
        .with_font_family("system-ui, sans-serif")
        .with_title_size(16)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(13);
    kuva::render_to_svg(plots, layout)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "docs/figures".to_owned());
    let mut table = String::from(
        "integrator,steps_per_contact,restitution_error,psi2_error,energy_error,ns_per_contact_step,\
         ns_per_contact_time\n",
    );
    let mut lines: [Vec<Curve>; 3] = [vec![], vec![], vec![]];
    for method in METHODS {
        let each = cost(method)?;
        lines.iter_mut().for_each(|of| of.push((method.0, Vec::new())));
        for n in STEPS {
            let n = f64::from(n) + OFF;
            let (errors, whole) = (errors(n, method)?, each * n);
            let [e, psi2, energy] = errors;
            let name = method.0.replace(',', "");
            writeln!(table, "{name},{n:.1},{e:.3e},{psi2:.3e},{energy:.3e},{each:.1},{whole:.0}")?;
            for (of, error) in lines.iter_mut().zip(errors) {
                if let Some((_, points)) = of.last_mut() {
                    // a logarithmic axis shows no zero: round-off stands for it
                    points.push((whole, error.max(1e-16)));
                }
            }
        }
    }
    print!("{table}");
    let folder = Path::new(&folder);
    std::fs::write(folder.join("integrators.csv"), &table)?;
    for (name, title, lines) in [
        ("restitution", "Restitution, e = 0.87", &lines[0]),
        ("psi2", "Oblique collision, Ψ₂", &lines[1]),
        ("energy", "Energy of an elastic collision", &lines[2]),
    ] {
        std::fs::write(folder.join(format!("integrators-{name}.svg")), draw(title, lines))?;
    }
    Ok(())
}
