//! The end of a run: costs, summary, children gone.

use std::path::Path;
use std::time::Duration;

use bedload_output::{GrainRow, MetricValue, Summary, atomic_write, grains_table};
use bedload_scene::{Grain, Motion};
use protocol::log::Recorder;
use protocol::memory::peak_rss_bytes;
use protocol::message::Kinematics;

use super::conductor::Conductor;
use crate::failure::Failure;
use crate::iterate::{Tally, Watch};
use crate::resume::Spent;

impl Conductor<'_> {
    /// Costs so far, those before a resume included.
    pub(super) fn spent(&self) -> Spent {
        let record = self.recorder.as_ref().map(Recorder::statistics).unwrap_or_default();
        Spent {
            wall: self.before.wall + self.begin.elapsed().as_secs_f64(),
            fluid: self.before.fluid + self.fluid.solver_s,
            dem: self.before.dem + self.dem.solver_s,
            coupler: self.before.coupler + own_cpu_seconds(),
            exchange: self.before.exchange + self.fluid.exchange_s + self.dem.exchange_s,
            record: self.before.record + record.call_s + record.write_s,
        }
    }

    /// `grains.csv`: the grains after the last window, whoever moved them.
    fn write_grains(&self) -> Result<(), Failure> {
        let Some((slot, time)) = self.latest else { return Ok(()) };
        let row = |(grain, now): (&Grain, &Kinematics)| GrainRow {
            position: now.position,
            radius: grain.radius,
            density: grain.density,
            velocity: now.velocity,
            spin: now.spin,
            free: grain.motion == Motion::Free,
            round: grain.shape.is_round(),
        };
        let rows: Vec<GrainRow> =
            self.prepared.scene.grains.iter().zip(&self.slots[slot].motion).map(row).collect();
        Ok(atomic_write(&self.folder.grains(), grains_table(time, &rows).as_bytes())?)
    }

    /// Ends the children, finishes log and series, and fills the summary.
    ///
    /// # Errors
    /// [`Failure`] if the log or the series could not be finished.
    pub(crate) fn close(mut self, summary: &mut Summary, in_order: bool) -> Result<(), Failure> {
        self.progress.finish();
        let grace = Duration::from_millis(if in_order { 2000 } else { 300 });
        if !(in_order && self.supervisor.wait_all(grace)) {
            self.supervisor.end(grace);
        }
        let spent = self.spent();
        let recorded = self.recorder.take().map_or(Ok(()), |recorder| recorder.finish().map(|_| ()));
        self.observer.finish(summary, self.prepared.plan.steps.contact_time)?;
        if in_order {
            self.write_grains()?;
        }
        summary.remark(&self.prepared.scene.scene.metrics);
        if self.late > 0 {
            let value = MetricValue::measured(self.late as f64, "windows", None, None);
            summary.metrics.insert("late_contacts".into(), value);
        }
        if let Some(Tally { windows, attempts, unconverged }) = self.watch.as_ref().map(Watch::tally) {
            let mut metric = |name: &str, value: f64, unit: &str| {
                let value = MetricValue::measured(value, unit, None, None);
                summary.metrics.insert(name.into(), value);
            };
            metric("attempts_per_window", attempts as f64 / windows.max(1) as f64, "-");
            metric("unconverged_windows", unconverged as f64, "windows");
        }
        let cost = &mut summary.cost;
        cost.wall_s = spent.wall;
        cost.fluid_cpu_s = spent.fluid;
        cost.dem_cpu_s = spent.dem;
        cost.coupler_cpu_s = spent.coupler;
        cost.exchange_s = spent.exchange;
        cost.record_s = spent.record;
        cost.peak_rss_bytes.fluid = Some(self.fluid.peak_rss);
        cost.peak_rss_bytes.dem = Some(self.dem.peak_rss);
        cost.peak_rss_bytes.coupler = Some(peak_rss_bytes());
        Ok(recorded?)
    }
}

/// CPU time of this process, user and system, s; 0 where the system does not tell.
fn own_cpu_seconds() -> f64 {
    let Ok(text) = std::fs::read_to_string(Path::new("/proc/self/stat")) else { return 0.0 };
    // Fields 14 and 15, counted from 1, after the name in brackets, which may hold spaces.
    let after = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: f64 =
        after.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    // USER_HZ is 100 on every Linux that runs Rust.
    ticks / 100.0
}
