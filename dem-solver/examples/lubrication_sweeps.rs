//! What sweeps over films cost and leave: `cargo run --release -p bedload-dem --example lubrication_sweeps [SCENE] [WINDOWS]`.
//!
//! The grains of a scene (by default the inclined bed) move under their weight through their films, in windows as a
//! fluid orders them; after each window the velocities are compared with those of 400 sweeps in every sub-step from the
//! same state. "From nothing": every sub-step is a window of its own, and begins without the impulses of the last.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use bedload_scene::{CheckedScene, SceneSource};
use dem_solver::config::Config;
use dem_solver::{Dem, DemSpec};

const WINDOW: f64 = 0.0195;
const SUBSTEPS: u32 = 87;

fn solver(scene: &str, sweeps: u32) -> Result<Dem, Box<dyn Error>> {
    let set = format!(
        "dem.lubrication={{ form = \"complement\", roughness = 4e-4, cut_off = 0.8, sweeps = {sweeps} }}"
    );
    let scene = CheckedScene::new(SceneSource::read(Path::new(scene), &[set])?)?;
    let spec: DemSpec = Config::new(&scene)?.spec;
    Ok(Dem::new(&spec)?)
}

/// One window; from nothing in every sub-step, or in the first only.
fn window(dem: &mut Dem, from_nothing: bool) -> Result<(), Box<dyn Error>> {
    if from_nothing {
        (0..SUBSTEPS).try_for_each(|_| dem.advance(WINDOW / f64::from(SUBSTEPS), 1, &[]).map(drop))?;
    } else {
        dem.advance(WINDOW, SUBSTEPS, &[])?;
    }
    Ok(())
}

struct Try {
    sweeps: u32,
    from_nothing: bool,
    dem: Dem,
    /// Largest error of a velocity over the largest velocity.
    worst: f64,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args().nth(1).unwrap_or_else(|| "scenes/inclined-bed.toml".into());
    let windows: u32 = std::env::args().nth(2).map_or(Ok(20), |text| text.parse())?;
    let mut exact = solver(&scene, 400)?;
    let mut tries = Vec::new();
    for from_nothing in [true, false] {
        for sweeps in [1, 2, 4, 8, 16] {
            tries.push(Try { sweeps, from_nothing, dem: solver(&scene, sweeps)?, worst: 0.0, seconds: 0.0 });
        }
    }
    for _ in 0..windows {
        let state = exact.save();
        window(&mut exact, true)?;
        let scale = exact.grains.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        for one in &mut tries {
            one.dem.restore(&state)?;
            let begin = Instant::now();
            window(&mut one.dem, one.from_nothing)?;
            one.seconds += begin.elapsed().as_secs_f64();
            let off = one.dem.grains.velocity.iter().zip(&exact.grains.velocity);
            one.worst = off.map(|(a, b)| (a - b).norm() / scale).fold(one.worst, f64::max);
        }
    }
    println!("sweeps  begin          error of a velocity  ms per window");
    for Try { sweeps, from_nothing, worst, seconds, .. } in tries {
        let begin = if from_nothing { "from nothing" } else { "with the last" };
        println!("{sweeps:>6}  {begin:<13}  {worst:>19.2e}  {:>13.2}", 1e3 * seconds / f64::from(windows));
    }
    Ok(())
}
