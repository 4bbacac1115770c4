//! Keys of the solvers' sections that rules of the coupler read or set: cheaper models, settings from the
//! charts. No other rule names one, and `tests/tests/pages/keys.rs` asks that each is in the solvers'
//! configuration, with these values: a key that is renamed there makes a test fail, not a rule.

use bedload_scene::CheckedScene;
use toml::Value;

/// Is momentum convected? By default it is.
pub const CONVECTION: &str = "fluid.time.convection";
/// The method of the immersed boundary.
pub const METHOD: &str = "fluid.method";
/// The default, which charts of the drag are of.
pub const CALIBRATED: &str = "calibrated";
/// Order of the time steps.
pub const TIME_SCHEME: &str = "fluid.time.scheme";
/// Two steps, one stage each.
pub const AB2: &str = "ab2";
/// Three stages, the default.
pub const RK3: &str = "rk3";
/// Time step of the fluid, s.
pub const FLUID_DT: &str = "fluid.time.dt";
/// Courant number of steps that follow the flow.
pub const CFL: &str = "fluid.time.cfl";
/// The law of contact.
pub const CONTACT: &str = "dem.contact";
/// Films between grains.
pub const LUBRICATION: &str = "dem.lubrication";
/// Their form.
pub const FILM: &str = "dem.lubrication.form";
/// What the grid does not resolve.
pub const COMPLEMENT: &str = "complement";
/// Height of their roughness over R.
pub const ROUGHNESS: &str = "dem.lubrication.roughness";
/// Where a scene with a fluid does not say.
pub const ROUGHNESS_BY_DEFAULT: f64 = 4e-4;
/// Springs and dashpots.
pub const LINEAR: &str = "linear-spring-dashpot";
/// How the grains' motion is integrated.
pub const INTEGRATOR: &str = "dem.integrator";
/// Sub-steps per contact.
pub const CONTACT_STEPS: &str = "dem.steps_per_contact";

/// All of them, with the values that rules name.
pub const ALL: [(&str, &[&str]); 11] = [
    (CONVECTION, &[]),
    (METHOD, &[CALIBRATED]),
    (TIME_SCHEME, &[AB2, RK3]),
    (FLUID_DT, &[]),
    (CFL, &[]),
    (CONTACT, &[]),
    (LUBRICATION, &[]),
    (FILM, &[COMPLEMENT]),
    (ROUGHNESS, &[]),
    (INTEGRATOR, &[]),
    (CONTACT_STEPS, &[]),
];

/// What the scene says at such a key.
pub fn look_up<'a>(scene: &'a CheckedScene, key: &str) -> Option<&'a Value> {
    let (section, path) = key.split_once('.')?;
    let section = if section == "fluid" { &scene.scene.fluid } else { &scene.scene.dem };
    let mut parts = path.split('.');
    let first = section.get(parts.next()?)?;
    parts.try_fold(first, |value, part| value.get(part))
}
