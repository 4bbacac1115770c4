//! The speeds of a scene before it runs: what it names, and what is to be expected of it.
//!
//! They differ on purpose. The bound `cfl` may refuse a run only for a speed that is certain
//! ([`named`]); the first step must bear the speed that the run may reach ([`expected`]).

use bedload_scene::speeds::{norm, start, volume};
use bedload_scene::{CheckedScene, Face, InitialVelocity, Medium, Motion, peak_of_sum};

/// Largest speed that the scene itself names, m/s: of grains and their surfaces, faces and the flow at the
/// start. Nothing is estimated, so that a bound on it refuses only what is certain.
pub(crate) fn named(scene: &CheckedScene) -> f64 {
    let domain = &scene.scene.domain;
    let until = scene.scene.until;
    let grains = scene.grains.iter();
    let grains = grains.map(|grain| grain.velocity.largest(until).max(grain.surface_speed(until)));
    let faces = (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis)).flat_map(|faces| {
        [faces.lower, Some(faces.upper)].into_iter().flatten().map(|face| face.velocity.largest(until))
    });
    // A flow that starts from another run is measured, not named: see `Plan::start`.
    grains.chain(faces).fold(start(scene), f64::max)
}

/// An estimate of the largest speed of a run, m/s, for its cost and its first step: walls, initial and
/// prescribed speeds, settling grains, driven flow. Later steps follow the flow itself.
pub(crate) fn expected(scene: &CheckedScene, medium: &Medium) -> f64 {
    let (nu, until) = (medium.kinematic_viscosity(), scene.scene.until);
    let domain = &scene.scene.domain;
    let extent = |a: usize| domain.upper[a] - domain.lower[a];
    let mut speed = match &medium.initial {
        InitialVelocity::Shear { rate, .. } => {
            rate.abs() * (0..domain.dimensions()).map(extent).fold(0.0, f64::max)
        }
        _ => start(scene),
    };
    for a in 0..domain.dimensions() {
        if let Some(faces) = domain.boundary(a) {
            let fastest = |f: &Face| domain.peak_over_mean(a, f) * f.velocity.largest(until);
            speed = faces.lower.iter().chain([&faces.upper]).fold(speed, |s, f| s.max(fastest(f)));
        }
    }
    if let Some(flow) = &medium.flow_rate {
        // The largest ratio of peak to mean of the common laminar profiles is that of a duct.
        speed = speed.max(2.25 * flow.mean_velocity.largest(until));
    }
    let gravity = scene.scene.largest_gravity();
    for grain in &scene.grains {
        speed = speed.max(grain.velocity.largest(until) + grain.surface_speed(until));
        if grain.motion == Motion::Free {
            let weight = (grain.density / medium.density - 1.0).abs() * gravity * 2.0 * grain.radius;
            let stokes = weight * 2.0 * grain.radius / (18.0 * nu);
            // Between Stokes and C_D = 0.4.
            let newton = (weight * 4.0 / 1.2).sqrt();
            if weight > 0.0 {
                speed = speed.max(1.0 / (1.0 / stokes + 1.0 / newton));
            }
        }
    }
    let free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let excess = free.map(|grain| (grain.density / medium.density - 1.0) * grain.volume()).sum::<f64>();
    let excess = excess / volume(scene);
    let drive: [f64; 3] = std::array::from_fn(|c| {
        let axis = (0..domain.dimensions()).find(|a| domain.geometry.component(*a) == c);
        // Where the flow rate is held, a mean pressure gradient balances what drives it.
        let held = medium.flow_rate.as_ref().map(|flow| flow.axis);
        if axis.is_some_and(|a| held == Some(domain.geometry.axes()[a])) {
            return 0.0;
        }
        // Free grains hold back, or drive, by their weight.
        let periodic = axis.is_some_and(|a| domain.is_periodic(a));
        let loaded = if periodic { 1.0 + excess } else { 0.0 };
        let gravity = scene.scene.gravity.map(|g| loaded * g[c]);
        let gradient = medium.pressure_gradient.map(|g| -g[c] / medium.density);
        peak_of_sum(&[medium.body_force.map(|f| f[c]), gravity, gradient], until)
    });
    let width = (0..domain.dimensions()).map(extent).fold(f64::INFINITY, f64::min);
    let drive = norm(&drive);
    speed.max((drive * width * width / (8.0 * nu)).min(drive * scene.scene.until))
}
