//! The grid of a scene with another D/Δx.

use bedload_scene::CheckedScene;

use coupler::resolution::{of, set};

/// How far from a whole number the cells of an axis may come out, from rounding alone.
const ROUNDING: f64 = 1e-6;

/// `--set` that gives the scene another D/Δx: all cells scaled. A stretched axis keeps its uniform
/// part and gets as many cells as that asks for, rounded up; any other must come out whole.
pub(super) fn scaled(scene: &CheckedScene, wanted: f64) -> Result<Vec<String>, String> {
    let Some(written) = of(scene) else {
        return Err("has no meaning: the scene has no grid, or no grains".to_owned());
    };
    if !(wanted > 0.0 && wanted.is_finite()) {
        return Err(format!("is {wanted}; allowed: a positive number of cells per diameter"));
    }
    let domain = &scene.scene.domain;
    let factor = wanted / written;
    let stretched = |axis: usize| {
        domain.stretching.as_ref().is_some_and(|stretching| stretching.axis == domain.geometry.axes()[axis])
    };
    let mut cells = Vec::new();
    for (axis, count) in domain.cells.iter().enumerate() {
        let exact = *count as f64 * factor;
        let whole = if stretched(axis) { (exact - ROUNDING).ceil() } else { exact.round() };
        if !stretched(axis) && (exact - whole).abs() > ROUNDING * exact.max(1.0) {
            return Err(format!(
                "is {wanted}, which makes {exact:.3} of the {count} cells of domain.cells[{axis}] at D/Δx = {written}; \
                 allowed: values that give whole numbers, such as {}",
                written * whole / *count as f64
            ));
        }
        cells.push(whole as u64);
    }
    Ok(set(&cells, domain.stretching.map(|stretching| stretching.spacing / factor)))
}

#[cfg(test)]
mod tests {
    use bedload_scene::SceneSource;

    use super::*;

    fn scene(cells: &str, stretching: &str) -> CheckedScene {
        let text = format!(
            "until = 1.0\n[domain]\ngeometry = \"axisymmetric\"\nlower = [0.0, 0.0]\nupper = [20.0, 40.0]\n\
             cells = {cells}\n{stretching}\nboundary = {{ r_upper = \"free-slip\", z = \"free-slip\" }}\n\
             [medium]\ndensity = 1.0\nviscosity = 1.0\n\
             [[grains]]\nposition = [0.0, 0.0, 20.0]\nradius = 0.5\ndensity = 2.0\n"
        );
        CheckedScene::new(SceneSource { file: "s.toml".into(), text }).expect("a scene")
    }

    #[test]
    fn a_grid_is_scaled_and_its_stretched_axis_rounded_up() {
        let uniform = scene("[400, 800]", "");
        assert_eq!(of(&uniform), Some(20.0));
        assert_eq!(scaled(&uniform, 8.0).unwrap(), ["domain.cells=[160, 320]"]);
        let refused = scaled(&uniform, 8.01).unwrap_err();
        assert!(refused.contains("160.2") && refused.contains("such as 8"), "{refused}");
        assert!(scaled(&uniform, -1.0).is_err());
        let stretched =
            scene("[128, 800]", "stretching = { axis = \"r\", uniform_to = 1.5, spacing = 0.05 }");
        let set = scaled(&stretched, 8.0).unwrap();
        assert_eq!(set, ["domain.cells=[52, 320]", "domain.stretching.spacing=0.125"]);
        let again =
            CheckedScene::new(stretched.source.with_overrides(&set).unwrap()).expect("the scaled scene");
        assert_eq!(of(&again), Some(8.0));
    }
}
