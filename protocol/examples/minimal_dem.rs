//! A DEM on the contract alone: spheres that fall, touch the floor and carry the fluid's virtual mass.
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};
use protocol::{checkpoint, serve::Invitation};
use std::{array::from_fn, f64::consts::PI, path::Path};

type Done<T> = Result<T, SolverError>;
/// Radius, mass, motion, mean acceleration over the last window.
type Sphere = (f64, f64, Kinematics, [f64; 3]);

struct Spheres {
    gravity: [f64; 3],
    floor: f64,
    contact: [f64; 2], // spring, 1/s², and dashpot, 1/s, over the mass they move
    state: Vec<Sphere>,
    saved: Vec<Sphere>,
}

/// Grains one by one from `[[grains]]`; `restitution` and `contact_time` from `[dem.contact]`.
fn read(scene: &toml::Table) -> Spheres {
    let float = |value: &toml::Value| value.as_float().expect("a number with a decimal point");
    let vector = |value: &toml::Value| from_fn(|k| float(&value[k]));
    let mass =
        |grain: &toml::Value| float(&grain["density"]) * 4.0 / 3.0 * PI * float(&grain["radius"]).powi(3);
    let at_rest = |grain: &toml::Value| Kinematics::at_rest(vector(&grain["position"]));
    let moving = |grain: &toml::Value| Kinematics { velocity: vector(&grain["velocity"]), ..at_rest(grain) };
    let sphere = |grain: &toml::Value| (float(&grain["radius"]), mass(grain), moving(grain), [0.0; 3]);
    let state: Vec<Sphere> = scene["grains"].as_array().expect("grains").iter().map(sphere).collect();
    let floor = float(scene["domain"]["lower"].as_array().and_then(|lower| lower.last()).expect("a box"));
    let [e_n, t_c] = ["restitution", "contact_time"].map(|key| float(&scene["dem"]["contact"][key]));
    let contact = [(PI.powi(2) + e_n.ln().powi(2)) / t_c.powi(2), -2.0 * e_n.ln() / t_c];
    Spheres { gravity: vector(&scene["gravity"]), floor, contact, saved: state.clone(), state }
}

#[rustfmt::skip] // one line for what is one line
impl Participant for Spheres {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;
    fn grains(&self) -> usize { self.state.len() }
    fn advance(&mut self, window: &Window, fluid: &mut dyn Exchange<Loads, Kinematics>) -> Done<WindowReport> {
        let mut loads = Vec::new();
        fluid.receive(window, &mut |_, received| loads.extend_from_slice(received))?;
        let (h, mut header) = (window.dt / window.substeps as f64, window.header());
        (header.substeps, header.smallest_gap) = (window.substeps, f64::INFINITY);
        for (load, (radius, mass, grain, before)) in loads.iter().zip(&mut self.state) {
            let (start, inertia) = (grain.velocity, *mass + load.added_mass);
            let force = |k| *mass * self.gravity[k] + load.force[k] + load.added_mass * before[k];
            let failed = || SolverError::Failed("a load is not finite".into());
            (0..3).all(|k| force(k).is_finite()).then_some(()).ok_or_else(failed)?;
            grain.contact_force = [0.0; 3];
            for _ in 0..window.substeps {
                let spring = self.contact[0] * (*radius + self.floor - grain.position[2]);
                let touch = if spring > 0.0 { spring - self.contact[1] * grain.velocity[2] } else { 0.0 };
                let push = [0.0, 0.0, touch.max(0.0)];
                grain.velocity = from_fn(|k| grain.velocity[k] + h * (force(k) / inertia + push[k]));
                grain.position = from_fn(|k| grain.position[k] + h * grain.velocity[k]);
                grain.contact_force[2] += push[2] * inertia / window.substeps as f64;
                grain.gap = grain.position[2] - *radius - self.floor;
                header.smallest_gap = header.smallest_gap.min(grain.gap);
            }
            *before = from_fn(|k| (grain.velocity[k] - start[k]) / window.dt);
        }
        header.largest_overlap = (-header.smallest_gap).max(0.0);
        let motion: Vec<Kinematics> = self.state.iter().map(|sphere| sphere.2).collect();
        fluid.send(header, &mut |out| out.copy_from_slice(&motion))?;
        Ok(WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps: window.substeps })
    }
    fn save(&mut self) { self.saved.clone_from(&self.state); }
    fn restore(&mut self) { self.state.clone_from(&self.saved); }
    fn write_checkpoint(&self, folder: &Path) -> Done<()> { checkpoint::write(folder, "dem", "", &self.state) }
    fn read_checkpoint(&mut self, folder: &Path) -> Done<()> {
        checkpoint::read(folder, "dem", "").map(|state| self.state = state)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let invitation = Invitation::from_arguments(std::env::args())?;
    Ok(invitation.serve(&mut read(&std::fs::read_to_string(&invitation.scene)?.parse()?))?)
}
