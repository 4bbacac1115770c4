//! Scenes drawn at random, to count the promises of `--accuracy` that are kept and broken. What is drawn for
//! the count (docs/promises.md) is not for tuning: change nothing of the charts because of it.

use std::f64::consts::PI;

use crate::random::Random;

/// A scene, what is measured in it and what is asked for.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Kind of scene.
    pub kind: &'static str,
    /// Its numbers, for the table.
    pub numbers: String,
    /// The scene (TOML), without metrics' references.
    pub text: String,
    /// The metrics that were promised.
    pub metrics: Vec<&'static str>,
    /// Error asked for.
    pub target: f64,
    /// How many times finer the grids are that it is compared with.
    pub finer: Vec<f64>,
}

/// Fluid of the drawn scenes: water's density, m/s².
const RHO: f64 = 1000.0;
const GRAVITY: f64 = 9.81;

/// A sphere that falls or rises from rest (Schiller & Naumann 1935, virtual mass ½): largest speed and time
/// after a way in units of D and (D/|ρ_r − 1| g)^½.
fn fall(ar: f64, rho_r: f64, way: f64, until: f64) -> (f64, f64, f64) {
    let (mut t, mut v, mut x) = (0.0, 0.0, 0.0);
    let dt = 2e-3;
    let nu = ar.powf(-0.5);
    while t < until && x < way {
        let re = (v / nu).max(1e-9);
        let drag = 18.0 * nu * v * (1.0 + 0.15 * f64::powf(re, 0.687));
        // Per volume and ρ |ρ_r − 1| g.
        let rate = (1.0 - drag) / (rho_r + 0.5) * (rho_r - 1.0).abs();
        // Implicit in the drag, which is stiff at small Ar.
        let stiff = 18.0 * nu * (1.0 + 0.15 * f64::powf(re, 0.687)) / (rho_r + 0.5) * (rho_r - 1.0).abs();
        v += dt * rate / (1.0 + dt * stiff);
        x += dt * v;
        t += dt;
    }
    (v, x, t)
}

/// The scene of a seed.
#[must_use]
pub fn scene(seed: u64) -> Drawn {
    let mut random = Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let target = random.one_of(&[0.02, 0.05, 0.1]);
    match random.one_of(&["axis", "axis", "space", "bounce", "lattice"]) {
        "axis" => axis(&mut random, target),
        "space" => space(&mut random, target),
        "bounce" => bounce(&mut random, target),
        _ => lattice(&mut random, target),
    }
}

/// Viscosity, Pa s, for an Archimedes number.
fn viscosity(ar: f64, rho_r: f64, diameter: f64) -> f64 {
    RHO * ((rho_r - 1.0).abs() * GRAVITY * diameter.powi(3) / ar).sqrt()
}

/// (D/|ρ_r − 1| g)^½, s.
fn unit(rho_r: f64, diameter: f64) -> f64 {
    (diameter / ((rho_r - 1.0).abs() * GRAVITY)).sqrt()
}

/// Room behind a sphere and length of the column in which it settles for `time`, in D, within ranges of the
/// room behind and of that left in front.
fn column(random: &mut Random, ar: f64, rho_r: f64, time: f64, rooms: [(f64, f64); 2]) -> (f64, f64) {
    let (_, way, _) = fall(ar, rho_r, f64::INFINITY, time);
    let [behind, front] = rooms.map(|(low, high)| random.between(low, high));
    (behind, behind + 1.0 + 1.3 * way + front)
}

fn axis(random: &mut Random, target: f64) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let ar = random.scale(2.0, 6e4);
    let (light, heavy) = random.one_of(&[(0.4, 0.9), (1.1, 12.0), (1.6, 8.0)]);
    let rho_r = random.scale(light, heavy);
    let tube = random.scale(0.9, 25.0);
    let side = random.one_of(&["no-slip", "free-slip"]);
    let time = random.between(1.0, 10.0);
    let (behind, length) = column(random, ar, rho_r, time, [(1.0, 4.0), (1.0, 6.0)]);
    let start = if rho_r > 1.0 { length - behind - 0.5 } else { behind + 0.5 };
    let cells = [(8.0 * tube).ceil(), (8.0 * length).ceil()];
    let text = format!(
        "until = {:?}\ngravity = [0.0, 0.0, {:?}]\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, \
         0.0]\nupper = [{:?}, {:?}]\n\
         cells = [{}, {}]\nboundary = {{ r_upper = \"{side}\", z = \"no-slip\" }}\n{}",
        time * unit(rho_r, diameter),
        -GRAVITY,
        tube * diameter,
        length * diameter,
        cells[0],
        cells[1],
        sphere([0.0, 0.0, start * diameter], diameter, rho_r, viscosity(ar, rho_r, diameter))
    );
    Drawn {
        kind: "settles in r-z",
        numbers: format!("Ar {ar:.3e}, ρ_r {rho_r:.2}, tube {tube:.2} D ({side}), t {time:.1}"),
        text: text + SPEED,
        metrics: vec!["speed"],
        target,
        finer: vec![2.0, 3.0],
    }
}

const SPEED: &str = "[[metrics]]\nname = \"speed\"\nkind = \"final\"\ncolumn = \"velocity_z[0]\"\n";

/// Medium, sphere and contact.
fn sphere(position: [f64; 3], diameter: f64, rho_r: f64, viscosity: f64) -> String {
    format!(
        "[medium]\ndensity = {RHO:?}\nviscosity = {viscosity:?}\n[[grains]]\nposition = {position:?}\nradius \
         = {:?}\ndensity = {:?}\n\
         [dem.contact]\nlaw = \"linear-spring-dashpot\"\nrestitution = 0.9\ncontact_time = {:?}\nfriction = 0.2\n",
        0.5 * diameter,
        rho_r * RHO,
        0.01 * (diameter / GRAVITY).sqrt()
    )
}

fn space(random: &mut Random, target: f64) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let ar = random.scale(2.0, 3e4);
    let (light, heavy) = random.one_of(&[(1.1, 12.0), (1.6, 8.0)]);
    let rho_r = random.scale(light, heavy);
    let side = random.between(1.6, 5.0);
    let wall = random.one_of(&["no-slip", "periodic", "free-slip"]);
    let time = random.between(1.0, 4.0);
    let (behind, length) = column(random, ar, rho_r, time, [(1.2, 2.5), (2.0, 3.0)]);
    let place = [random.between(0.4, 0.6), random.between(0.4, 0.6)].map(|part| part * side * diameter);
    let cells = [side, side, length].map(|edge| (8.0 * edge).ceil() as u64);
    let text = format!(
        "until = {:?}\ngravity = [0.0, 0.0, {:?}]\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\n\
         upper = [{:?}, {:?}, {:?}]\n\
         cells = {cells:?}\nboundary = {{ x = \"{wall}\", y = \"{wall}\", z = \"no-slip\" }}\n{}",
        time * unit(rho_r, diameter),
        -GRAVITY,
        side * diameter,
        side * diameter,
        length * diameter,
        sphere(
            [place[0], place[1], (length - behind - 0.5) * diameter],
            diameter,
            rho_r,
            viscosity(ar, rho_r, diameter)
        )
    );
    Drawn {
        kind: "settles in space",
        numbers: format!("Ar {ar:.3e}, ρ_r {rho_r:.2}, box {side:.2} D ({wall}), t {time:.1}"),
        text: text + SPEED,
        metrics: vec!["speed"],
        target,
        finer: vec![1.5, 2.0],
    }
}

fn bounce(random: &mut Random, target: f64) -> Drawn {
    let diameter = random.scale(1e-3, 2e-2);
    let rho_r = random.scale(2.0, 14.0);
    let ar = random.scale(200.0, 1e6);
    let way = random.between(2.0, 9.0);
    let (speed, _, time) = fall(ar, rho_r, way, 1e3);
    let stokes = (rho_r + 0.5) * speed * ar.sqrt() / 9.0;
    let roughness = random.scale(5e-5, 2e-3);
    let restitution = random.between(0.8, 1.0);
    let length = way + 3.0;
    // Up again for half as long as the fall and two units more.
    let text = format!(
        "until = {:?}\ngravity = [0.0, 0.0, {:?}]\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, \
         0.0]\nupper = [{:?}, {:?}]\n\
         cells = [40, {}]\nboundary = {{ r_upper = \"free-slip\", z = \"no-slip\" }}\n{}[dem.lubrication]\n\
         roughness = {roughness:?}\n",
        (2.0 * time + 2.0) * unit(rho_r, diameter),
        -GRAVITY,
        5.0 * diameter,
        length * diameter,
        (8.0 * length).ceil(),
        sphere([0.0, 0.0, (way + 0.5) * diameter], diameter, rho_r, viscosity(ar, rho_r, diameter))
            .replace("restitution = 0.9", &format!("restitution = {restitution:?}"))
    );
    let metrics = "[[metrics]]\nname = \"restitution\"\nkind = \"restitution-at-gap\"\ngap = 0.1\n\
                   [[metrics]]\nname = \"apex\"\nkind = \"rebound-height\"\n";
    Drawn {
        kind: "bounces in r-z",
        numbers: format!(
            "St {stokes:.0}, ρ_r {rho_r:.1}, η/R {roughness:.1e}, e {restitution:.2}, fall {way:.1} D"
        ),
        text: text + metrics,
        metrics: vec!["restitution", "apex"],
        target,
        finer: vec![2.0, 3.0],
    }
}

fn lattice(random: &mut Random, target: f64) -> Drawn {
    let diameter = random.scale(1e-4, 1e-2);
    let solid = random.scale(0.01, 0.5);
    let reynolds = random.scale(1e-3, 60.0);
    let edge = diameter * (PI / 6.0 / solid).cbrt();
    let viscosity = random.scale(1e-3, 1.0);
    let nu = viscosity / RHO;
    let time = random.between(0.3, 1.5);
    // Drag of a sphere alone, made larger for its neighbours: the speed comes out near what was drawn.
    let speed = reynolds * nu / diameter;
    let hindered = (1.0 - solid).powi(-4);
    let force =
        3.0 * PI * nu * diameter * speed * hindered * (1.0 + 0.15 * reynolds.powf(0.687)) / edge.powi(3);
    let place: [f64; 3] = std::array::from_fn(|_| edge * random.unit());
    let cells = (8.0 * edge / diameter).ceil().max(8.0) as u64;
    let text = format!(
        "until = {:?}\n[domain]\ngeometry = \"space\"\nlower = [0.0, 0.0, 0.0]\nupper = [{edge:?}, {edge:?}, \
         {edge:?}]\ncells = [{cells}, {cells}, {cells}]\n\
         boundary = {{ x = \"periodic\", y = \"periodic\", z = \"periodic\" }}\n[medium]\ndensity = {RHO:?}\n\
         viscosity = {viscosity:?}\n\
         body_force = [{force:?}, 0.0, 0.0]\n[[grains]]\nposition = {place:?}\nradius = {:?}\ndensity = \
         {RHO:?}\nmotion = \"fixed\"\n",
        time * diameter * diameter / nu,
        0.5 * diameter
    );
    Drawn {
        kind: "held in a lattice",
        numbers: format!("c {solid:.3}, Re {reynolds:.2e}, t {time:.1}"),
        text,
        metrics: vec!["superficial_velocity_x"],
        target,
        finer: vec![1.5, 2.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_draws_the_same_scene_and_all_kinds_are_drawn() {
        let mut kinds: Vec<&str> = Vec::new();
        for seed in 0..40 {
            let drawn = scene(seed);
            assert_eq!(drawn.text, scene(seed).text);
            kinds.push(drawn.kind);
        }
        kinds.sort_unstable();
        kinds.dedup();
        assert_eq!(kinds.len(), 4, "{kinds:?}");
    }

    #[test]
    fn a_sphere_falls_at_its_terminal_speed_in_the_end() {
        // Ar = 800: Re = 20.32 by Schiller & Naumann.
        let (speed, way, time) = fall(800.0, 4.0, f64::INFINITY, 40.0);
        assert!((speed * 800.0_f64.sqrt() - 20.32).abs() < 0.02, "{speed}");
        assert!(way < speed * time && way > 0.8 * speed * time);
    }
}
