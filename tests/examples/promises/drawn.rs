//! Scenes drawn at random, to count the promises of `--accuracy … --verify` that are kept and broken. What
//! is drawn for the count (docs/promises.md) is not for tuning: change nothing of what it rests on because
//! of it.

use std::f64::consts::PI;

use ::tests::random::Random;

/// A scene, what is measured in it and what is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// Kind of scene.
    pub(crate) kind: &'static str,
    /// Its numbers, for the table.
    pub(crate) numbers: String,
    /// The scene (TOML), without metrics' references.
    pub(crate) text: String,
    /// The metrics that were promised.
    pub(crate) metrics: Vec<&'static str>,
    /// Error asked for.
    pub(crate) target: f64,
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

/// A scene of which nothing is asked yet.
fn drawn(kind: &'static str, numbers: String, text: String, metrics: &[&'static str]) -> Drawn {
    Drawn { kind, numbers, text, metrics: metrics.to_vec(), target: 0.0 }
}

/// The scene of a seed.
pub(crate) fn scene(seed: u64) -> Drawn {
    let mut random = Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let target = random.one_of(&[0.02, 0.05, 0.1]);
    let kinds: [fn(&mut Random) -> Drawn; 10] =
        [axis, axis, disc, space, bounce, bounce, pair, lattice, discs, suspension];
    let draw = random.one_of(&kinds);
    Drawn { target, ..draw(&mut random) }
}

/// Density ratios that practitioners have: bubbles aside, light and heavy grains in a liquid.
fn density_ratio(random: &mut Random) -> f64 {
    let (light, heavy) = random.one_of(&[(0.3, 0.9), (1.1, 15.0), (1.1, 4.0)]);
    random.scale(light, heavy)
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

const SPEED: &str = "[[metrics]]\nname = \"speed\"\nkind = \"final\"\ncolumn = \"velocity_z[0]\"\n";
const ENERGY: &str = "[[metrics]]\nname = \"energy\"\nkind = \"mean\"\ncolumn = \"kinetic_energy\"\n";

/// End, gravity and box, lengths in D: what stands before the medium.
fn domain(until: f64, geometry: &str, upper: &[f64], diameter: f64, boundary: &str) -> String {
    let (zeros, cells): (Vec<f64>, Vec<u64>) =
        upper.iter().map(|length| (0.0, (8.0 * length).ceil() as u64)).unzip();
    let upper: Vec<f64> = upper.iter().map(|length| length * diameter).collect();
    format!(
        "until = {until:?}\ngravity = [0.0, 0.0, {:?}]\n[domain]\ngeometry = \"{geometry}\"\n\
         lower = {zeros:?}\nupper = {upper:?}\ncells = {cells:?}\nboundary = {{ {boundary} }}\n",
        -GRAVITY
    )
}

/// The same of a box of a width and a height: flat with these sides, or periodic in space.
fn standing(flat: bool, until: f64, [width, height]: [f64; 2], diameter: f64, sides: &str) -> String {
    if flat {
        let boundary = format!("x = \"{sides}\", z = \"no-slip\"");
        return domain(until, "plane", &[width, height], diameter, &boundary);
    }
    let boundary = "x = \"periodic\", y = \"periodic\", z = \"no-slip\"";
    domain(until, "space", &[width, width, height], diameter, boundary)
}

/// Medium and contact.
fn medium(diameter: f64, viscosity: f64, restitution: f64) -> String {
    format!(
        "[medium]\ndensity = {RHO:?}\nviscosity = {viscosity:?}\n[dem.contact]\n\
         law = \"linear-spring-dashpot\"\nrestitution = {restitution:?}\n\
         contact_time = {:?}\nfriction = 0.2\n",
        0.01 * (diameter / GRAVITY).sqrt()
    )
}

/// A grain, its centre in D.
fn grain(centre: [f64; 3], diameter: f64, rho_r: f64, more: &str) -> String {
    let position = centre.map(|x| x * diameter);
    format!(
        "[[grains]]\nposition = {position:?}\nradius = {:?}\ndensity = {:?}\n{more}",
        0.5 * diameter,
        rho_r * RHO
    )
}

/// Height of the centre of a grain that begins in a column of this length with this room behind it.
fn start(rho_r: f64, length: f64, behind: f64) -> f64 {
    if rho_r > 1.0 { length - behind - 0.5 } else { behind + 0.5 }
}

fn axis(random: &mut Random) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let (ar, rho_r, tube) = (random.scale(1.0, 5e4), density_ratio(random), random.scale(1.0, 6.0));
    let side = random.one_of(&["no-slip", "free-slip"]);
    let time = random.between(1.0, 6.0);
    let (behind, length) = column(random, ar, rho_r, time, [(1.0, 3.0), (1.0, 4.0)]);
    let boundary = format!("r_upper = \"{side}\", z = \"no-slip\"");
    let until = time * unit(rho_r, diameter);
    let text = domain(until, "axisymmetric", &[tube, length], diameter, &boundary)
        + &medium(diameter, viscosity(ar, rho_r, diameter), 0.9)
        + &grain([0.0, 0.0, start(rho_r, length, behind)], diameter, rho_r, "");
    drawn(
        "sphere in r-z",
        format!("Ar {ar:.3e}, ρ_r {rho_r:.2}, tube {tube:.2} D ({side}), t {time:.1}"),
        text + SPEED,
        &["speed"],
    )
}

fn disc(random: &mut Random) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let (ar, rho_r, width) = (random.scale(1.0, 5e4), density_ratio(random), random.between(2.0, 6.0));
    let time = random.between(1.0, 4.0);
    let (behind, length) = column(random, ar, rho_r, time, [(1.0, 3.0), (1.0, 4.0)]);
    let until = time * unit(rho_r, diameter);
    let text = domain(until, "plane", &[width, length], diameter, "x = \"no-slip\", z = \"no-slip\"")
        + &medium(diameter, viscosity(ar, rho_r, diameter), 0.9)
        + &grain([0.5 * width, 0.0, start(rho_r, length, behind)], diameter, rho_r, "");
    drawn(
        "disc in the plane",
        format!("Ar {ar:.3e}, ρ_r {rho_r:.2}, box {width:.2} D, t {time:.1}"),
        text + SPEED,
        &["speed"],
    )
}

fn space(random: &mut Random) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let (ar, rho_r, side) = (random.scale(1.0, 5e4), density_ratio(random), random.between(1.6, 3.0));
    let wall = random.one_of(&["no-slip", "periodic", "free-slip"]);
    let time = random.between(1.0, 3.0);
    let (behind, length) = column(random, ar, rho_r, time, [(1.0, 2.0), (1.0, 2.0)]);
    let place = [random.between(0.4, 0.6), random.between(0.4, 0.6)].map(|part| part * side);
    let boundary = format!("x = \"{wall}\", y = \"{wall}\", z = \"no-slip\"");
    let until = time * unit(rho_r, diameter);
    let text = domain(until, "space", &[side, side, length], diameter, &boundary)
        + &medium(diameter, viscosity(ar, rho_r, diameter), 0.9)
        + &grain([place[0], place[1], start(rho_r, length, behind)], diameter, rho_r, "");
    drawn(
        "sphere in space",
        format!("Ar {ar:.3e}, ρ_r {rho_r:.2}, box {side:.2} D ({wall}), t {time:.1}"),
        text + SPEED,
        &["speed"],
    )
}

fn bounce(random: &mut Random) -> Drawn {
    let diameter = random.scale(1e-3, 2e-2);
    let (ar, rho_r, way) = (random.scale(200.0, 5e4), random.scale(2.0, 15.0), random.between(1.0, 6.0));
    let (speed, _, time) = fall(ar, rho_r, way, 1e3);
    let stokes = (rho_r + 0.5) * speed * ar.sqrt() / 9.0;
    let (roughness, restitution) = (random.scale(5e-5, 2e-3), random.between(0.3, 1.0));
    let tube = random.between(2.0, 5.0);
    // Up again for half as long as the fall and two units more.
    let until = (1.5 * time + 2.0) * unit(rho_r, diameter);
    let boundary = "r_upper = \"free-slip\", z = \"no-slip\"";
    let text = domain(until, "axisymmetric", &[tube, way + 3.0], diameter, boundary)
        + &medium(diameter, viscosity(ar, rho_r, diameter), restitution)
        + &format!("[dem.lubrication]\nform = \"complement\"\nroughness = {roughness:?}\n")
        + &grain([0.0, 0.0, way + 0.5], diameter, rho_r, "");
    let metrics = "[[metrics]]\nname = \"restitution\"\nkind = \"restitution-at-gap\"\ngap = 0.1\n\
                   [[metrics]]\nname = \"apex\"\nkind = \"rebound-height\"\n";
    drawn(
        "bounce in r-z",
        format!("St {stokes:.0}, ρ_r {rho_r:.1}, η/R {roughness:.1e}, e {restitution:.2}, fall {way:.1} D"),
        text + metrics,
        &["restitution", "apex"],
    )
}

/// Two discs or spheres, one behind the other or side by side.
fn pair(random: &mut Random) -> Drawn {
    let diameter = random.scale(2e-4, 2e-2);
    let (ar, rho_r) = (random.scale(1.0, 5e3), random.scale(1.1, 8.0));
    let flat = random.unit() < 0.5;
    let (width, gap) = (random.between(3.0, 4.0), random.between(0.3, 0.9));
    let tandem = random.unit() < 0.5;
    let time = random.between(1.0, 2.5);
    let (behind, length) = column(random, ar, rho_r, time, [(1.0, 2.0), (1.0, 2.0)]);
    let middle = 0.5 * width;
    let length = if tandem { length + 1.0 + gap } else { length };
    let top = length - behind - 0.5;
    let apart = 0.5 * (1.0 + gap);
    let centres = if tandem {
        [[middle, middle, top], [middle + 0.05, middle, top - 1.0 - gap]]
    } else {
        [[middle - apart, middle, top], [middle + apart, middle, top]]
    };
    let until = time * unit(rho_r, diameter);
    let grains = centres.map(|[x, y, z]| grain([x, if flat { 0.0 } else { y }, z], diameter, rho_r, ""));
    let text = standing(flat, until, [width, length], diameter, "no-slip")
        + &medium(diameter, viscosity(ar, rho_r, diameter), 0.9)
        + &grains.concat();
    drawn(
        "pair",
        format!(
            "{}, {}, gap {gap:.2} D, Ar {ar:.3e}, ρ_r {rho_r:.2}, box {width:.2} D, t {time:.1}",
            if flat { "discs" } else { "spheres" },
            if tandem { "tandem" } else { "side by side" }
        ),
        text + ENERGY,
        &["energy"],
    )
}

/// Grains that are held in a periodic box, and a force that drives the fluid through.
fn held(random: &mut Random, solid: f64, reynolds: f64, axes: usize) -> (String, f64) {
    let diameter = random.scale(1e-4, 1e-2);
    let volume = if axes == 3 { PI / 6.0 } else { PI / 4.0 };
    let edge = (volume / solid).powf(1.0 / axes as f64);
    let viscosity = random.scale(1e-3, 1.0);
    let nu = viscosity / RHO;
    let time = random.between(0.3, 1.5);
    // Drag of a grain alone, made larger for its neighbours: the speed comes out near what was drawn.
    let speed = reynolds * nu / diameter;
    let hindered = (1.0 - solid).powi(-4);
    let force = 3.0 * PI * nu * speed * hindered * (1.0 + 0.15 * reynolds.powf(0.687))
        / diameter
        / diameter
        / edge.powi(axes as i32);
    let place =
        [edge * random.unit(), if axes == 3 { edge * random.unit() } else { 0.0 }, edge * random.unit()];
    let (geometry, boundary) = if axes == 3 {
        ("space", "x = \"periodic\", y = \"periodic\", z = \"periodic\"")
    } else {
        ("plane", "x = \"periodic\", z = \"periodic\"")
    };
    let text = domain(time * diameter * diameter / nu, geometry, &vec![edge; axes], diameter, boundary)
        .replace(&format!("gravity = [0.0, 0.0, {:?}]\n", -GRAVITY), "")
        + &format!(
            "[medium]\ndensity = {RHO:?}\nviscosity = {viscosity:?}\nbody_force = [{force:?}, 0.0, 0.0]\n"
        )
        + &grain(place, diameter, 1.0, "motion = \"fixed\"\n");
    (text, time)
}

fn lattice(random: &mut Random) -> Drawn {
    let (solid, reynolds) = (random.scale(0.03, 0.5), random.scale(1e-3, 60.0));
    let (text, time) = held(random, solid, reynolds, 3);
    drawn(
        "array of spheres",
        format!("c {solid:.3}, Re {reynolds:.2e}, t {time:.1}"),
        text,
        &["superficial_velocity_x"],
    )
}

fn discs(random: &mut Random) -> Drawn {
    let (solid, reynolds) = (random.scale(0.01, 0.5), random.scale(1e-3, 60.0));
    let (text, time) = held(random, solid, reynolds, 2);
    drawn(
        "array of discs",
        format!("c {solid:.3}, Re {reynolds:.2e}, t {time:.1}"),
        text,
        &["superficial_velocity_x"],
    )
}

/// Grains on a lattice that is shaken, which settle together.
fn suspension(random: &mut Random) -> Drawn {
    let diameter = random.scale(2e-4, 5e-3);
    let (ar, rho_r) = (random.scale(1.0, 2e3), random.scale(1.1, 8.0));
    let flat = random.unit() < 0.5;
    let (rows, spacing) = (if flat { 3 } else { 2 }, random.between(1.4, 1.9));
    let time = random.between(1.0, 2.5);
    let (_, way, _) = fall(ar, rho_r, f64::INFINITY, time);
    let (width, length) = (spacing * f64::from(rows), spacing * f64::from(rows) + 1.3 * way + 2.0);
    let bottom = length - 0.5 - spacing * f64::from(rows);
    let mut grains = String::new();
    let mut count = 0;
    for place in 0..rows * rows * if flat { 1 } else { rows } {
        let [i, j, k] = if flat {
            [place % rows, 0, place / rows]
        } else {
            [place % rows, place / rows % rows, place / rows / rows]
        };
        let mut shaken = |at: i32| spacing * (f64::from(at) + 0.5) + random.between(-0.15, 0.15);
        let centre = [shaken(i), if flat { 0.0 } else { shaken(j) }, bottom + shaken(k)];
        grains += &grain(centre, diameter, rho_r, "");
        count += 1;
    }
    let until = time * unit(rho_r, diameter);
    let text = standing(flat, until, [width, length], diameter, "periodic")
        + &medium(diameter, viscosity(ar, rho_r, diameter), 0.8)
        + &grains;
    drawn(
        "suspension",
        format!(
            "{count} {}, Ar {ar:.3e}, ρ_r {rho_r:.2}, spacing {spacing:.2} D, t {time:.1}",
            if flat { "discs" } else { "spheres" }
        ),
        text + ENERGY,
        &["energy"],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_draws_the_same_scene_and_all_kinds_are_drawn() {
        let mut kinds: Vec<&str> = Vec::new();
        for seed in 0..60 {
            let drawn = scene(seed);
            assert_eq!(drawn.text, scene(seed).text);
            kinds.push(drawn.kind);
        }
        kinds.sort_unstable();
        kinds.dedup();
        assert_eq!(kinds.len(), 8, "{kinds:?}");
    }

    #[test]
    fn a_sphere_falls_at_its_terminal_speed_in_the_end() {
        // Ar = 800: Re = 20.32 by Schiller & Naumann.
        let (speed, way, time) = fall(800.0, 4.0, f64::INFINITY, 40.0);
        assert!((speed * 800.0_f64.sqrt() - 20.32).abs() < 0.02, "{speed}");
        assert!(way < speed * time && way > 0.8 * speed * time);
    }
}
