//! Frames for Foxglove, Lichtblick and Rerun, made from the data messages by the recorder's thread.
//!
//! A frame is one message on each viewer channel. It is made when the window that it shows stands
//! for good (the next one begins), so a repeated window appears once; it is stamped with the end of
//! its window. Viewer channels are never needed for a replay.

use prost::Message;

use super::codec::{self, CodecError};
use super::manifest::Manifest;
use super::schema::foxglove::{
    Color, PackedElementField, PointCloud, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive,
    Vector3, packed_element_field::NumericType,
};
use super::schema::viewer::{Grains, Window};
use super::sequence::nanoseconds;
use super::topic::Topic;
use crate::message::{Header, Kinematics, Status};
use crate::participant::Role;

/// Spheres cost 140 bytes each: beyond this number of grains a frame has points only.
pub const MOST_SPHERES: usize = 2000;
/// Grains of which `viewer/grains` shows the numbers.
pub const MOST_PLOTTED: usize = 64;
/// Frames of a run whose length is known: twenty seconds of film at 30 per second.
pub const FRAMES: f64 = 600.0;
/// Windows per frame of a run whose length is not known.
pub const OPEN_RUN: u64 = 10;

const FRAME_ID: &str = "laboratory";
/// A window that ends this part of a period early is due: dt summed up is not exact.
const SLACK: f64 = 1e-6;
/// Fields of a point, 4 bytes each.
const POINT: [&str; 8] = ["x", "y", "z", "vx", "vy", "vz", "radius", "gap"];

/// Which windows become frames: [`FRAMES`] over the run, or every [`OPEN_RUN`]th where its end is not known.
/// A function of the window alone, so a log does not depend on the machine.
#[derive(Clone, Copy, Debug)]
enum Due {
    Windows { first: u64 },
    Period { start: f64, period: f64, next: f64 },
}

impl Due {
    fn new(manifest: &Manifest) -> Self {
        let (start, length) = (manifest.first_time, manifest.until - manifest.first_time);
        if length > 0.0 && length.is_finite() {
            return Self::Period { start, period: length / FRAMES, next: start };
        }
        Self::Windows { first: manifest.first_step }
    }

    fn is_due(&self, header: &Header) -> bool {
        match *self {
            Self::Windows { first } => header.step.saturating_sub(first).is_multiple_of(OPEN_RUN),
            Self::Period { period, next, .. } => header.time + header.dt >= next - SLACK * period,
        }
    }

    fn done(&mut self, header: &Header) {
        if let Self::Period { start, period, next } = self {
            let passed = ((header.time + header.dt - *start) / *period + SLACK).floor();
            *next = *start + (passed + 1.0) * *period;
        }
    }
}

/// Gathers the messages of a window and turns them into a frame.
pub(crate) struct Viewer {
    due: Due,
    radii: Vec<f64>,
    /// The window shown next, if it is due.
    pending: Option<Header>,
    grains: Vec<Kinematics>,
    fluid: Status,
    dem: Status,
}

impl Viewer {
    pub(crate) fn new(manifest: &Manifest) -> Self {
        Self {
            due: Due::new(manifest),
            radii: manifest.radii.clone(),
            pending: None,
            grains: Vec::new(),
            fluid: Status::default(),
            dem: Status::default(),
        }
    }

    /// Looks at a data message on its way to the file.
    pub(crate) fn watch(&mut self, topic: Topic, payload: &[u8]) -> Result<(), CodecError> {
        match topic {
            Topic::Kinematics => {
                let header = codec::decode_header(payload)?;
                self.pending = self.due.is_due(&header).then_some(header);
                if self.pending.is_some() {
                    self.grains = codec::decode_slice(payload)?.1;
                }
            }
            Topic::Status if self.pending.is_some() => {
                let (role, status): (u64, Status) = codec::decode(payload)?;
                let kept = if role == Role::Fluid as u64 { &mut self.fluid } else { &mut self.dem };
                *kept = status;
            }
            _ => {}
        }
        Ok(())
    }

    /// Writes the pending frame, if there is one: topic, step, time in ns, bytes.
    pub(crate) fn emit<E>(
        &mut self,
        mut write: impl FnMut(Topic, u64, u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some(header) = self.pending.take() else { return Ok(()) };
        self.due.done(&header);
        let time = nanoseconds(header.time + header.dt);
        let mut write = |topic, bytes: Vec<u8>| write(topic, header.step, time, &bytes);
        if self.grains.len() <= MOST_SPHERES {
            write(Topic::Scene, self.scene(time).encode_to_vec())?;
        }
        write(Topic::Points, self.cloud(time).encode_to_vec())?;
        write(Topic::Window, self.window(&header).encode_to_vec())?;
        write(Topic::Grains, self.plots(&header).encode_to_vec())
    }

    /// One entity with all grains as spheres, coloured by speed.
    fn scene(&self, time: u64) -> SceneUpdate {
        let fastest = largest_speed(&self.grains).max(f64::MIN_POSITIVE);
        let grains = self.grains.iter().zip(&self.radii);
        let entity = SceneEntity {
            timestamp: Some(timestamp(time)),
            frame_id: FRAME_ID.into(),
            id: "grains".into(),
            spheres: grains.map(|(grain, radius)| sphere(grain, *radius, fastest)).collect(),
            ..SceneEntity::default()
        };
        SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
    }

    fn cloud(&self, time: u64) -> PointCloud {
        let size = size_of::<f32>() as u32;
        let field = |(index, name): (u32, &str)| PackedElementField {
            name: name.into(),
            offset: size * index,
            r#type: NumericType::Float32.into(),
        };
        let point = |(grain, radius): (&Kinematics, &f64)| {
            let ([x, y, z], [vx, vy, vz]) = (grain.position, grain.velocity);
            [x, y, z, vx, vy, vz, *radius, grain.gap].map(|value| (value as f32).to_le_bytes())
        };
        PointCloud {
            timestamp: Some(timestamp(time)),
            frame_id: FRAME_ID.into(),
            pose: Some(pose([0.0; 3], [1.0, 0.0, 0.0, 0.0])),
            point_stride: size * POINT.len() as u32,
            fields: (0..).zip(POINT).map(field).collect(),
            data: self.grains.iter().zip(&self.radii).flat_map(point).flatten().collect(),
        }
    }

    fn window(&self, header: &Header) -> Window {
        let total: f64 = self.grains.iter().map(|grain| norm(grain.velocity)).sum();
        Window {
            time: header.time + header.dt,
            step: header.step as f64,
            attempt: header.attempt as f64,
            dt: header.dt,
            substeps: header.substeps as f64,
            smallest_gap: header.smallest_gap,
            largest_overlap: header.largest_overlap,
            fluid_dt_limit: self.fluid.dt_limit,
            fluid_residual: self.fluid.residual,
            fluid_solver_s: self.fluid.solver_s,
            fluid_exchange_s: self.fluid.exchange_s,
            dem_residual: self.dem.residual,
            dem_solver_s: self.dem.solver_s,
            dem_exchange_s: self.dem.exchange_s,
            mean_speed: total / self.grains.len().max(1) as f64,
            largest_speed: largest_speed(&self.grains),
        }
    }

    /// The first [`MOST_PLOTTED`] grains.
    fn plots(&self, header: &Header) -> Grains {
        let shown = &self.grains[..self.grains.len().min(MOST_PLOTTED)];
        let list = |value: fn(&Kinematics) -> f64| shown.iter().map(value).collect();
        Grains {
            time: header.time + header.dt,
            position_x: list(|grain| grain.position[0]),
            position_y: list(|grain| grain.position[1]),
            position_z: list(|grain| grain.position[2]),
            velocity_x: list(|grain| grain.velocity[0]),
            velocity_y: list(|grain| grain.velocity[1]),
            velocity_z: list(|grain| grain.velocity[2]),
            spin_x: list(|grain| grain.spin[0]),
            spin_y: list(|grain| grain.spin[1]),
            spin_z: list(|grain| grain.spin[2]),
            gap: list(|grain| grain.gap),
        }
    }
}

fn sphere(grain: &Kinematics, radius: f64, fastest: f64) -> SpherePrimitive {
    let heat = norm(grain.velocity) / fastest;
    SpherePrimitive {
        pose: Some(pose(grain.position, grain.orientation)),
        size: Some(vector([2.0 * radius; 3])),
        color: Some(Color { r: 0.2 + 0.7 * heat, g: 0.45, b: 0.9 - 0.7 * heat, a: 1.0 }),
    }
}

fn pose(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> Pose {
    Pose { position: Some(vector(position)), orientation: Some(Quaternion { x, y, z, w }) }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn timestamp(ns: u64) -> prost_types::Timestamp {
    let second = 1_000_000_000;
    prost_types::Timestamp { seconds: (ns / second) as i64, nanos: (ns % second) as i32 }
}

fn largest_speed(grains: &[Kinematics]) -> f64 {
    grains.iter().map(|grain| norm(grain.velocity)).fold(0.0, f64::max)
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(until: f64) -> Vec<u64> {
        let mut manifest = Manifest::new("", "", vec![1.0], 1e-3, until);
        manifest.first_step = 2;
        let mut viewer = Viewer::new(&manifest);
        let mut steps = Vec::new();
        for step in 2..22 {
            let header = Header { step, time: step as f64 * 0.1, dt: 0.1, ..Header::default() };
            let mut payload = Vec::new();
            codec::encode_slice(&header, &[Kinematics::default()], &mut payload).unwrap();
            viewer.watch(Topic::Kinematics, &payload).unwrap();
            viewer
                .emit(|topic, step, _, bytes| {
                    assert!(!bytes.is_empty());
                    if topic == Topic::Window {
                        steps.push(step);
                    }
                    Ok::<(), ()>(())
                })
                .unwrap();
        }
        steps
    }

    #[test]
    fn frames_depend_on_the_window_alone() {
        assert_eq!(frames(f64::INFINITY), [2, 12]);
        assert_eq!(frames(60.0), (2..22).collect::<Vec<_>>());
        assert_eq!(frames(600.0), [2, 9, 19]);
    }
}
