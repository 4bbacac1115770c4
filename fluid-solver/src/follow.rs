//! The ranks but the first: they do what it says, each with its planes.

use crate::methods::calibrated::calibration::Calibration;
use crate::orders::{NUMBERS, Order, record};
use crate::participant::Fluid;
use crate::ranks::Ranks;
use bedload_scene::{CheckedScene, SceneSource};
use protocol::log::codec;
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, SolverError, Window};
use pulp::bytemuck;

/// Does what the first rank says until it says that the program ends.
///
/// # Errors
/// If a rank is gone. What goes wrong in the fluid the first rank tells.
pub fn follow(ranks: &Ranks) -> Result<(), SolverError> {
    let failed = |error: codec::CodecError| SolverError::Failed(error.to_string());
    let mut fluid: Option<Fluid> = None;
    let mut pool: Option<rayon::ThreadPool> = None;
    loop {
        let order: Order = codec::decode(&ranks.broadcast(Vec::new())?).map_err(failed)?;
        match (order, &mut fluid) {
            (Order::Quit, _) => return Ok(()),
            (Order::Leave, _) => fluid = None,
            (Order::Build(file, text, folder), _) => {
                let scene = CheckedScene::new(SceneSource { file, text });
                fluid = scene
                    .and_then(|scene| Fluid::of_rank(&scene, &folder, ranks, Calibration::default()))
                    .ok();
            }
            (Order::Advance(window, threads), Some(fluid)) => {
                if pool.as_ref().is_none_or(|pool| pool.current_num_threads() != threads) {
                    let made = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                    pool = Some(made.map_err(|error| {
                        SolverError::Failed(format!("cannot start {threads} threads: {error}"))
                    })?);
                }
                // What went wrong the first rank knows, too.
                let _ =
                    pool.as_ref().map(|pool| pool.install(|| fluid.advance(&window, &mut Follower(ranks))));
            }
            (Order::Save, Some(fluid)) => fluid.save(),
            (Order::Restore, Some(fluid)) => fluid.restore(),
            (Order::WriteCheckpoint(folder), Some(fluid)) => {
                let _ = fluid.write_checkpoint(&folder);
            }
            (Order::ReadCheckpoint(folder), Some(fluid)) => {
                let _ = fluid.read_checkpoint(&folder);
            }
            (Order::WriteFields(window), Some(fluid)) => {
                let _ = fluid.write_fields(&window);
            }
            (Order::MeanVelocity(axis), Some(fluid)) => {
                fluid.mean_velocity(axis);
            }
            (Order::Speed, Some(fluid)) => {
                fluid.mean_speed();
            }
            (Order::Show, Some(fluid)) => fluid.show(),
            (_, None) => {}
        }
        ranks.check()?;
    }
}

/// The exchange of every other rank.
struct Follower<'a>(&'a Ranks);

impl Exchange<Kinematics, Loads> for Follower<'_> {
    fn send(&mut self, _: Header, _: &mut dyn FnMut(&mut [Loads])) -> Result<(), ExchangeError> {
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[Kinematics]),
    ) -> Result<(), ExchangeError> {
        let bytes = self.0.broadcast(Vec::new());
        let bytes = bytes.map_err(|error| ExchangeError::Transport(error.to_string()))?;
        let mut motions = vec![[0.0; NUMBERS]; bytes.len() / size_of::<[f64; NUMBERS]>()];
        bytemuck::cast_slice_mut(&mut motions).copy_from_slice(&bytes);
        let Some((_, motions)) = motions.split_first() else { return Err(ExchangeError::Stopped) };
        let records: Vec<Kinematics> = motions.iter().map(record).collect();
        read(&window.header(), &records);
        Ok(())
    }
}
