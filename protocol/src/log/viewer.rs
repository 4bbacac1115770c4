//! Frames for Foxglove, Lichtblick and Rerun, made from the data messages by the recorder's thread.
//!
//! A frame is one message on each viewer channel. It is made when the window that it shows stands
//! for good (the next one begins), so a repeated window appears once; it is stamped with the end of
//! its window. Viewer channels are never needed for a replay.

use super::codec::{self, CodecError};
use super::manifest::Manifest;
use super::proto::Proto;
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

const FRAME_ID: &[u8] = b"laboratory";
const FLOAT32: u64 = 7;
/// A window that ends this part of a period early is due: dt summed up is not exact.
const SLACK: f64 = 1e-6;
/// Fields of a point, 4 bytes each.
const POINT: [&str; 8] = ["x", "y", "z", "vx", "vy", "vz", "radius", "gap"];

/// How many windows become frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Decimation {
    /// [`FRAMES`] over the run, or every [`OPEN_RUN`]th window where its end is not known.
    #[default]
    Auto,
    /// No viewer channels.
    Off,
    /// Every n-th window, counted from the first.
    Windows(u64),
    /// One frame per so many simulated seconds.
    Period(f64),
}

/// Which windows are due: a function of the window alone, so a log does not depend on the machine.
#[derive(Clone, Copy, Debug)]
enum Due {
    Never,
    Windows { first: u64, every: u64 },
    Period { start: f64, period: f64, next: f64 },
}

impl Due {
    fn new(decimation: Decimation, manifest: &Manifest) -> Self {
        let start = manifest.first_time;
        let windows = |every: u64| Self::Windows { first: manifest.first_step, every: every.max(1) };
        match decimation {
            Decimation::Off => Self::Never,
            Decimation::Windows(every) => windows(every),
            Decimation::Period(period) if period > 0.0 => Self::Period { start, period, next: start },
            Decimation::Period(_) => windows(1),
            Decimation::Auto if manifest.until.is_finite() && manifest.until > start => {
                let period = (manifest.until - start) / FRAMES;
                Self::Period { start, period, next: start }
            }
            Decimation::Auto => windows(OPEN_RUN),
        }
    }

    fn is_due(&self, header: &Header) -> bool {
        match *self {
            Self::Never => false,
            Self::Windows { first, every } => header.step.saturating_sub(first).is_multiple_of(every),
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
    /// Serialised message, reused.
    bytes: Vec<u8>,
    points: Vec<u8>,
}

impl Viewer {
    pub(crate) fn new(decimation: Decimation, manifest: &Manifest) -> Self {
        Self {
            due: Due::new(decimation, manifest),
            radii: manifest.radii.clone(),
            pending: None,
            grains: Vec::new(),
            fluid: Status::default(),
            dem: Status::default(),
            bytes: Vec::new(),
            points: Vec::new(),
        }
    }

    /// Whether the viewer channels exist at all.
    pub(crate) fn is_on(&self) -> bool {
        !matches!(self.due, Due::Never)
    }

    /// Looks at a data message on its way to the file.
    pub(crate) fn watch(&mut self, topic: Topic, payload: &[u8]) -> Result<(), CodecError> {
        match topic {
            Topic::Kinematics if self.is_on() => {
                let header = codec::decode_header(payload)?;
                self.pending = self.due.is_due(&header).then_some(header);
                if self.pending.is_some() {
                    self.grains = codec::decode_slice(payload)?.1;
                }
            }
            Topic::Status if self.pending.is_some() => {
                let (role, status): (u64, Status) = codec::decode(payload)?;
                match role == Role::Fluid as u64 {
                    true => self.fluid = status,
                    false => self.dem = status,
                }
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
        for topic in [Topic::Scene, Topic::Points, Topic::Window, Topic::Grains] {
            self.bytes.clear();
            match topic {
                Topic::Scene if self.grains.len() > MOST_SPHERES => continue,
                Topic::Scene => self.scene(time),
                Topic::Points => self.cloud(time),
                Topic::Window => self.window(&header),
                _ => self.plots(&header),
            }
            write(topic, header.step, time, &self.bytes)?;
        }
        Ok(())
    }

    /// `foxglove.SceneUpdate`: one entity with all grains as spheres, coloured by speed.
    fn scene(&mut self, time: u64) {
        let fastest = largest_speed(&self.grains).max(f64::MIN_POSITIVE);
        let (grains, radii) = (&self.grains, &self.radii);
        Proto(&mut self.bytes).message(2, |entity| {
            entity.timestamp(1, time);
            entity.bytes(2, FRAME_ID);
            entity.bytes(3, b"grains");
            for (grain, radius) in grains.iter().zip(radii) {
                entity.message(9, |sphere| write_sphere(sphere, grain, *radius, fastest));
            }
        });
    }

    /// `foxglove.PointCloud`.
    fn cloud(&mut self, time: u64) {
        self.points.clear();
        for (grain, radius) in self.grains.iter().zip(&self.radii) {
            let [x, y, z] = grain.position;
            let [vx, vy, vz] = grain.velocity;
            for value in [x, y, z, vx, vy, vz, *radius, grain.gap] {
                self.points.extend_from_slice(&(value as f32).to_le_bytes());
            }
        }
        let points = &self.points;
        let mut cloud = Proto(&mut self.bytes);
        cloud.timestamp(1, time);
        cloud.bytes(2, FRAME_ID);
        cloud.message(3, |pose| {
            pose.vector(1, [0.0; 3]);
            pose.doubles(2, &[0.0, 0.0, 0.0, 1.0]);
        });
        cloud.fixed32(4, 4 * POINT.len() as u32);
        for (index, name) in (0..).zip(POINT) {
            cloud.message(5, |field| {
                field.bytes(1, name.as_bytes());
                field.fixed32(2, 4 * index);
                field.integer(3, FLOAT32);
            });
        }
        cloud.bytes(6, points);
    }

    /// `bedload.viewer.Window`: fields in the order of `viewer.proto`.
    fn window(&mut self, header: &Header) {
        let total: f64 = self.grains.iter().map(|grain| norm(grain.velocity)).sum();
        let values = [
            header.time + header.dt,
            header.step as f64,
            header.attempt as f64,
            header.dt,
            header.substeps as f64,
            header.smallest_gap,
            header.largest_overlap,
            self.fluid.dt_limit,
            self.fluid.residual,
            self.fluid.solver_s,
            self.fluid.exchange_s,
            self.dem.residual,
            self.dem.solver_s,
            self.dem.exchange_s,
            total / self.grains.len().max(1) as f64,
            largest_speed(&self.grains),
        ];
        let mut out = Proto(&mut self.bytes);
        for (field, value) in (1..).zip(values) {
            out.double(field, value);
        }
    }

    /// `bedload.viewer.Grains`: the first [`MOST_PLOTTED`] grains.
    fn plots(&mut self, header: &Header) {
        let shown = &self.grains[..self.grains.len().min(MOST_PLOTTED)];
        let mut out = Proto(&mut self.bytes);
        out.double(1, header.time + header.dt);
        for axis in 0..3 {
            let field = axis as u32;
            out.packed(2 + field, shown.iter().map(|grain| grain.position[axis]));
            out.packed(5 + field, shown.iter().map(|grain| grain.velocity[axis]));
            out.packed(8 + field, shown.iter().map(|grain| grain.spin[axis]));
        }
        out.packed(11, shown.iter().map(|grain| grain.gap));
    }
}

fn write_sphere(sphere: &mut Proto<'_>, grain: &Kinematics, radius: f64, fastest: f64) {
    let [w, x, y, z] = grain.orientation;
    let heat = norm(grain.velocity) / fastest;
    sphere.message(1, |pose| {
        pose.vector(1, grain.position);
        pose.doubles(2, &[x, y, z, w]);
    });
    sphere.vector(2, [2.0 * radius; 3]);
    sphere.doubles(3, &[0.2 + 0.7 * heat, 0.45, 0.9 - 0.7 * heat, 1.0]);
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

    fn frames(decimation: Decimation, until: f64) -> Vec<u64> {
        let mut manifest = Manifest::new("", "", vec![1.0], 1e-3, until);
        manifest.first_step = 2;
        let mut viewer = Viewer::new(decimation, &manifest);
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
    fn decimation_depends_on_the_window_alone() {
        assert_eq!(frames(Decimation::Windows(5), 2.0), [2, 7, 12, 17]);
        assert_eq!(frames(Decimation::Auto, f64::INFINITY), [2, 12]);
        assert_eq!(frames(Decimation::Auto, 60.0), (2..22).collect::<Vec<_>>());
        assert_eq!(frames(Decimation::Auto, 600.0), [2, 9, 19]);
        assert_eq!(frames(Decimation::Period(0.45), 2.0), [2, 4, 8, 13, 17]);
        assert!(frames(Decimation::Off, 2.0).is_empty());
    }
}
