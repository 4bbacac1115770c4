//! What a scene changes over time, by its keys.

use crate::checked::CheckedScene;
use crate::shared::Scene;
use bedload_over_time::OverTime;

/// A value of a scene that changes over time.
#[derive(Clone, Debug)]
pub struct Changing {
    /// Its key.
    pub key: String,
    /// Name of its columns: before the component, and behind it.
    pub name: [String; 2],
    /// Unit.
    pub unit: &'static str,
    /// The value; a number stands along x.
    pub value: OverTime<[f64; 3]>,
    /// Is it one number?
    pub scalar: bool,
}

/// What the scene changes over time, in the order of its keys.
pub fn changing(scene: &CheckedScene) -> Vec<Changing> {
    let Scene { gravity, domain, medium, walls, grains, .. } = &scene.scene;
    let mut all = Vec::new();
    let mut add = |key: String, name: [String; 2], unit, value: &OverTime<[f64; 3]>| {
        if value.varies() {
            all.push(Changing { key, name, unit, value: value.clone(), scalar: false });
        }
    };
    let plain = |name: &str| [name.to_owned(), String::new()];
    add("gravity".into(), plain("gravity"), "m/s^2", gravity);
    for (face, velocity) in domain.boundary.clone().velocities() {
        let name = plain(&format!("velocity_of_{face}"));
        add(format!("domain.boundary.{face}.velocity"), name, "m/s", velocity);
    }
    if let Some(medium) = medium {
        add("medium.body_force".into(), plain("body_force"), "m/s^2", &medium.body_force);
        let gradient = plain("pressure_gradient");
        add("medium.pressure_gradient".into(), gradient, "Pa/m", &medium.pressure_gradient);
    }
    for (index, wall) in walls.iter().enumerate() {
        for (part, unit, value) in [("velocity", "m/s", &wall.velocity), ("spin", "rad/s", &wall.spin)] {
            let name = [format!("wall_{part}"), format!("[{index}]")];
            add(format!("walls[{index}].{part}"), name, unit, value);
        }
    }
    for (index, grain) in grains.iter().enumerate().filter(|(_, grain)| grain.wall.is_none()) {
        let parts = [("velocity", "m/s", &grain.velocity), ("spin", "rad/s", &grain.spin)];
        for (part, unit, value) in parts {
            let name = [format!("prescribed_{part}"), format!("[{index}]")];
            add(format!("grains[{index}].{part}"), name, unit, value);
        }
    }
    let number = |key: String, name: [String; 2], unit, value: &OverTime<f64>| {
        let along_x = value.map(|value| [*value, 0.0, 0.0]);
        value.varies().then_some(Changing { key, name, unit, value: along_x, scalar: true })
    };
    for (index, wall) in walls.iter().enumerate() {
        if let Some(servo) = &wall.servo {
            let name = ["servo_pressure".to_owned(), format!("[{index}]")];
            all.extend(number(format!("walls[{index}].servo.pressure"), name, "Pa", &servo.pressure));
        }
    }
    if let Some(flow) = medium.as_ref().and_then(|medium| medium.flow_rate.as_ref()) {
        let key = "medium.flow_rate.mean_velocity".to_owned();
        all.extend(number(key, plain("mean_flow"), "m/s", &flow.mean_velocity));
    }
    all
}
