//! What `observe.totals` asks for.

use bedload_scene::{Axis, CheckedScene, Domain, Total};

use crate::contacts::{Contact, is_free};
use crate::motion::Vec3;
use crate::report::Observations;
use crate::solver::Dem;

/// Adds what [`bedload_output::totals::servos`] names, in its order.
pub(crate) fn add_servos(axes: &[Axis], dem: &Dem, out: &mut Vec<f64>) {
    for (_, servo) in dem.servos() {
        let stress = servo.stress();
        out.extend([servo.way_at(dem.time()), servo.speed]);
        out.extend(axes.iter().map(|axis| stress[axis.component()]));
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Totals {
    /// What is outside counts no more.
    domain: Domain,
    coordination: bool,
    forces: bool,
    films: bool,
    /// Number of walls before the faces of the box.
    walls: usize,
    faces: usize,
}

impl Totals {
    pub(crate) fn of(scene: &CheckedScene) -> Option<Self> {
        let asked = scene.scene.observe.totals.as_ref()?;
        let (domain, coordination) = (&scene.scene.domain, asked.has(&[Total::CoordinationNumber]));
        Some(Self {
            domain: domain.clone(),
            coordination,
            forces: asked.has(&Total::ON_WALLS),
            films: asked.has(&[Total::WallStress]),
            walls: scene.scene.walls.len(),
            faces: domain.contact_faces().len(),
        })
    }

    /// Adds the values in the order of [`bedload_output::totals::dem_values`].
    pub(crate) fn add(&self, dem: &Dem, contacts: impl FnOnce() -> Vec<Contact>, out: &mut Vec<f64>) {
        if self.coordination {
            let grains = &dem.grains;
            let holds = |place: &Vec3| self.domain.holds(&(*place).into());
            let free =
                (0..grains.len()).filter(|i| is_free(grains, *i) && holds(&grains.position[*i])).count();
            let of_both = |contact: Contact| [holds(&contact.end), !contact.held && holds(&contact.start)];
            let ends = contacts().into_iter().flat_map(of_both).filter(|counts| *counts).count();
            out.push(ends as f64 / free.max(1) as f64);
        }
        let Observations { wall_contact, wall_lubrication, .. } = dem.observations();
        for (asked, on_walls) in [(self.forces, wall_contact), (self.films, wall_lubrication)] {
            for face in 0..if asked { self.faces } else { 0 } {
                let push = on_walls.get(self.walls + face).copied().unwrap_or_default();
                out.extend(self.domain.geometry.axes().iter().map(|axis| push[axis.component()]));
            }
        }
    }
}
