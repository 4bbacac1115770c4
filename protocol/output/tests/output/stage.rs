//! Scenes, folders and windows for these tests.

use std::path::PathBuf;

use bedload_output::{Columns, Metrics, Sample, Sides};
use bedload_scene::{CheckedScene, SceneSource};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::Window;

/// One sphere of radius 1 and density 3 above the bottom of an axisymmetric box, in a fluid of density 1
/// and viscosity 0.5 under gravity 10; `more` follows.
pub(crate) fn sphere(more: &str) -> CheckedScene {
    let text = format!(
        "until = 10.0\ngravity = [0.0, 0.0, -10.0]\n\
         [domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, 0.0]\nupper = [10.0, 40.0]\n\
         cells = [20, 80]\n[domain.boundary]\nr_upper = \"free-slip\"\nz_lower = \"no-slip\"\n\
         z_upper = \"no-slip\"\n[medium]\ndensity = 1.0\nviscosity = 0.5\n\
         [[grains]]\nposition = [0.0, 0.0, 20.0]\nradius = 1.0\ndensity = 3.0\n{more}"
    );
    scene(&text)
}

/// Two discs in a plane box, dry.
pub(crate) fn discs(more: &str) -> CheckedScene {
    let text = format!(
        "until = 1.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, -1.0]\nupper = [10.0, 9.0]\n\
         boundary = {{ x = \"periodic\", z = \"no-slip\" }}\n\
         [[grains]]\nposition = [2.0, 0.0, 1.0]\nradius = 1.0\ndensity = 2.0\n\
         [[grains]]\nposition = [6.0, 0.0, 1.0]\nradius = 0.5\ndensity = 2.0\n{more}"
    );
    scene(&text)
}

pub(crate) fn scene(text: &str) -> CheckedScene {
    let source = SceneSource { file: "test.toml".into(), text: text.to_owned() };
    CheckedScene::new(source).unwrap_or_else(|error| panic!("{error}: {}\n{text}", error.remedy))
}

/// A fresh folder below the system's temporary one.
pub(crate) fn fresh(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("bedload-output-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("a folder below the temporary one");
    path
}

pub(crate) fn window(step: u64, dt: f64) -> Window {
    Window { step, attempt: 0, time: step as f64 * dt, dt, substeps: 0, output: false }
}

/// Motion along z at the end of a window.
pub(crate) fn falling(velocity: f64, gap: f64) -> Kinematics {
    Kinematics {
        position: [0.0, 0.0, gap + 1.0],
        velocity: [0.0, 0.0, velocity],
        gap,
        ..Kinematics::default()
    }
}

/// Columns and metrics fed with windows of one length.
pub(crate) struct Watch {
    pub(crate) columns: Columns,
    pub(crate) metrics: Metrics,
    pub(crate) step: u64,
    pub(crate) dt: f64,
}

impl Watch {
    pub(crate) fn new(scene: &CheckedScene, dt: f64) -> Self {
        let columns = Columns::new(scene, Sides::coupled());
        let metrics = Metrics::new(scene, &columns, Sides::coupled()).expect("metrics of the scene");
        Self { columns, metrics, step: 0, dt }
    }

    pub(crate) fn feed(&mut self, motion: Kinematics) {
        self.feed_all(&[Loads::default()], &Header::default(), &[motion], &[]);
    }

    pub(crate) fn feed_all(
        &mut self,
        loads: &[Loads],
        header: &Header,
        kinematics: &[Kinematics],
        extras: &[f64],
    ) -> Vec<f64> {
        self.feed_window(&window(self.step, self.dt), loads, header, kinematics, extras)
    }

    pub(crate) fn feed_window(
        &mut self,
        window: &Window,
        loads: &[Loads],
        header: &Header,
        kinematics: &[Kinematics],
        extras: &[f64],
    ) -> Vec<f64> {
        let sample = Sample { window, loads, header, kinematics, extras };
        let row = self.columns.fill(&sample).to_vec();
        self.metrics.record(&sample, &row);
        self.step += 1;
        row
    }

    pub(crate) fn value(&self, name: &str) -> f64 {
        let metric = &self.metrics.finish()[name];
        metric.value.unwrap_or_else(|| panic!("{name} has no value: {:?}", metric.note))
    }

    pub(crate) fn note(&self, name: &str) -> String {
        let metric = &self.metrics.finish()[name];
        assert_eq!(metric.value, None, "{name} has a value");
        metric.note.clone().unwrap_or_else(|| panic!("{name} has neither value nor note"))
    }
}
