//! Scenes for unit tests.

use bedload_scene::{CheckedScene, SceneSource};

pub(crate) fn scene(text: impl Into<String>) -> CheckedScene {
    CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).expect("a scene")
}

/// Two grains, 2 m apart across the periodic side along x.
pub(crate) fn two_grains() -> CheckedScene {
    scene(
        "until = 1.0\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [8, 4, 4]\n\
         boundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }\n\
         [[grains]]\nposition = [1, 2, 2]\nradius = 0.5\ndensity = 2.0\n\
         [[grains]]\nposition = [7, 2, 2]\nradius = 0.5\ndensity = 2.0\n",
    )
}
