//! Oblique collisions of pairs of grains (Foerster et al. 1994; Izard et al. 2014, section 3.2).
//!
//! Ψ₁ = v_t/v_n and Ψ₂ = v_t′/v_n: slip of the surfaces before and after the collision, over the normal
//! speed before it. n joins the centres at t = 0, t is the direction of the slip before.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use super::line::interpolate;
use super::rule::{Rule, published};
use bedload_scene::table::{Table, line, number};
use bedload_scene::{CheckedScene, Grain, SceneError};
use protocol::message::Kinematics;

/// Reference Ψ₂(Ψ₁), ascending.
#[derive(Clone, Debug)]
struct Oblique {
    curve: Vec<(f64, f64)>,
}

/// One collision: Ψ₁, Ψ₂ and the reference.
struct Collision {
    psi1: f64,
    psi2: f64,
    reference: f64,
}

impl Collision {
    fn error(&self) -> f64 {
        (self.psi2 - self.reference).abs() / self.reference.abs()
    }
}

/// The rule of metric `index`: the published table is read at once.
pub(super) fn rule(
    scene: &CheckedScene,
    index: usize,
    file: &Path,
    select: &BTreeMap<String, String>,
) -> Result<Rule, SceneError> {
    let columns = "psi1 and psi2 and those of `select`";
    let table = Arc::new(published(scene, index, file, columns, |text| Oblique::parse(text, select))?);
    let curve = table.clone();
    Ok(Rule::of_last(move |last| table.largest_error(&last.grains, &last.kinematics))
        .leaving("oblique.csv", move |last| curve.table(&last.grains, &last.kinematics).ok()))
}

impl Oblique {
    /// The rows of a CSV file whose columns hold the selected texts.
    fn parse(text: &str, select: &BTreeMap<String, String>) -> Result<Self, String> {
        let table = Table::parse(text)?;
        table.refuse_odd()?;
        let (x, y) = (table.need("psi1")?, table.need("psi2")?);
        let wanted = select.iter().map(|(name, text)| Ok((table.need(name)?, text.as_str())));
        let wanted = wanted.collect::<Result<Vec<_>, String>>()?;
        let is_wanted =
            |row: &&csv::StringRecord| wanted.iter().all(|(column, text)| row.get(*column) == Some(*text));
        let point = |row| {
            let point = number(row, x).zip(number(row, y));
            point.ok_or_else(|| format!("has the line {:?} without psi1 or psi2", line(row)))
        };
        let mut curve = table.rows.iter().filter(is_wanted).map(point).collect::<Result<Vec<_>, _>>()?;
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        if curve.len() < 2 {
            return Err(format!("has {} rows with {select:?}; two are needed", curve.len()));
        }
        Ok(Self { curve })
    }

    /// Reference at Ψ₁, between the rows on a straight line.
    fn at(&self, psi1: f64) -> Option<f64> {
        let near = 1e-6;
        if let Some((_, psi2)) = self.curve.iter().find(|(x, _)| (x - psi1).abs() < near) {
            return Some(*psi2);
        }
        let after = self.curve.iter().position(|(x, _)| *x > psi1).filter(|after| *after > 0)?;
        Some(interpolate(psi1, self.curve[after - 1], self.curve[after]))
    }

    fn collisions(&self, grains: &[Grain], last: &[Kinematics]) -> Result<Vec<Collision>, String> {
        let pair = |number: usize| {
            let (i, j) = (2 * number, 2 * number + 1);
            let n = (Vector3::from(grains[i].position) - Vector3::from(grains[j].position)).normalize();
            let slip = |motion: [[f64; 3]; 4]| {
                let [vi, vj, wi, wj] = motion.map(Vector3::from);
                let surface = vi - vj - (wi * grains[i].radius + wj * grains[j].radius).cross(&n);
                (surface - n * n.dot(&surface), n.dot(&surface))
            };
            let (a, b) = (&grains[i], &grains[j]);
            let (before, approach) =
                slip([&a.velocity, &b.velocity, &a.spin, &b.spin].map(|value| value.start()));
            let (a, b) = (&last[i], &last[j]);
            let (after, leave) = slip([a.velocity, b.velocity, a.spin, b.spin]);
            if !(approach < 0.0 && leave > 0.0) {
                return Err(format!("grains {i} and {j} have not collided and parted"));
            }
            let (psi1, psi2) = (before.norm() / -approach, after.dot(&before.normalize()) / -approach);
            let reference =
                self.at(psi1).ok_or_else(|| format!("the reference does not reach psi1 = {psi1}"))?;
            Ok(Collision { psi1, psi2, reference })
        };
        (0..grains.len() / 2).map(pair).collect()
    }

    /// Largest |Ψ₂ − reference|/|reference| over the pairs.
    fn largest_error(&self, grains: &[Grain], last: &[Kinematics]) -> Result<f64, String> {
        let all = self.collisions(grains, last)?;
        if all.is_empty() {
            return Err("the scene has no pair of grains".into());
        }
        Ok(all.iter().map(Collision::error).fold(0.0, f64::max))
    }

    fn table(&self, grains: &[Grain], last: &[Kinematics]) -> Result<String, String> {
        let mut text = String::from("psi1,psi2,reference,relative_error\n");
        for hit in self.collisions(grains, last)? {
            let _ = writeln!(text, "{},{},{},{}", hit.psi1, hit.psi2, hit.reference, hit.error());
        }
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# remark\nratio,psi1,psi2\n0.2,1.0,0.5\n0.2,2.0,1.5\n0.3,1.0,9.0\n0.3,2.0,9.0\n";

    fn grain(x: f64, velocity: [f64; 3]) -> Grain {
        Grain { velocity: velocity.into(), ..Grain::at([x, 0.0, 0.0], 0.5, 1.0) }
    }

    #[test]
    fn psi_comes_from_slip_over_normal_speed() {
        let table = Oblique::parse(TABLE, &BTreeMap::from([("ratio".into(), "0.2".into())])).unwrap();
        let grains = [grain(0.0, [1.0, 0.0, 1.5]), grain(1.0, [-1.0, 0.0, -1.5])];
        // After: normal speed reversed, slip 2.2 with the grains turning at 0.5 rad/s each.
        let spin = [0.0, 0.5, 0.0];
        let last = [
            Kinematics { velocity: [-1.0, 0.0, 1.0], spin, ..Kinematics::default() },
            Kinematics { velocity: [1.0, 0.0, -1.0], spin, ..Kinematics::default() },
        ];
        // Ψ₁ = 3/2, reference (0.5 + 1.5)/2 = 1; slip: ω × (R x̂) is −ω R along z on the left grain,
        // so (1 − (−1)) − 2·0.5·0.5 = 1.5, Ψ₂ = 0.75.
        let error = table.largest_error(&grains, &last).unwrap();
        assert!((error - 0.25).abs() < 1e-12, "{error}");
        let start = |g: &Grain| Kinematics { velocity: g.velocity.start(), ..Kinematics::default() };
        assert!(table.largest_error(&grains, &grains.each_ref().map(start)).is_err());
        assert!(Oblique::parse(TABLE, &BTreeMap::from([("ratio".into(), "0.4".into())])).is_err());
        assert!(Oblique::parse("a,b\n1,2\n", &BTreeMap::new()).unwrap_err().contains("psi1"));
    }
}
