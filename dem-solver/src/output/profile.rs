//! Profile of the grains over slabs, and its table.

use std::fmt::Write;

use crate::contacts::{Contact, is_free};
use crate::grain::Shape;
use crate::grains::Grains;
use crate::laws::walls::Wall;
use crate::motion::Vec3;
use crate::output::coarse_grain::{Cell, coarse_grain};
use crate::output::partition::{Partition, Slabs};
use crate::spec::DemSpec;

/// Averages over slabs.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Component across the slabs.
    pub axis: usize,
    /// Middle of the first slab, m.
    pub first: f64,
    /// Thickness of a slab, m.
    pub width: f64,
    /// Area of the region across the axis, m² (m for discs).
    pub area: f64,
    /// Length of that area's sides along which walls stand, m (for discs their number).
    pub perimeter: f64,
    /// Shape of the grains.
    pub shape: Shape,
    /// Averages, slab by slab.
    pub cells: Vec<Cell>,
    /// Force of the side walls per slab, inward and along the axis, N.
    pub walls: Vec<[f64; 2]>,
}

impl Profile {
    /// Averages over the region of `asked`.
    pub fn new(
        asked: &bedload_scene::Profile,
        spec: &DemSpec,
        grains: &Grains,
        contacts: &[Contact],
    ) -> Self {
        let axis = asked.axis.component();
        let disc = spec.shape == Shape::Disc;
        let others = [(axis + 1) % 3, (axis + 2) % 3].into_iter();
        let sides: Vec<usize> = others.filter(|c| !(disc && *c == 1)).collect();
        let extent = |c: &usize| asked.upper[*c] - asked.lower[*c];
        let width = (asked.upper[axis] - asked.lower[axis]) / asked.slabs as f64;
        let slabs = Slabs {
            axis,
            lower: asked.lower[axis],
            width,
            count: asked.slabs,
            area: sides.iter().map(extent).product(),
            period: spec.periods[axis].map(|(_, length)| length),
            shape: spec.shape,
        };
        let both = sides.iter().flat_map(|&across| Side::both(asked, across));
        let walled: Vec<Side> = both.filter(|side| side.is_walled(spec, grains, &slabs)).collect();
        let length = |side: &Side| sides.iter().filter(|c| **c != side.across).map(extent).product::<f64>();
        let perimeter = walled.iter().map(length).sum();
        let inside = |x: &Vec3| sides.iter().all(|&c| (asked.lower[c]..=asked.upper[c]).contains(&x[c]));
        let area = slabs.area;
        let partition = Partition::Slabs(slabs);
        let cells = coarse_grain(grains, spec.shape, contacts, &partition, inside);
        let mut walls = vec![[0.0; 2]; asked.slabs];
        for contact in contacts.iter().filter(|contact| contact.held && inside(&contact.end)) {
            let Some(push) = inward_part(contact, axis, &walled) else { continue };
            partition.line(&contact.point, &contact.point, |slab, part| {
                walls[slab][0] += push * part;
                walls[slab][1] += contact.force[axis] * part;
            });
        }
        let first = asked.lower[axis] + 0.5 * width;
        Self { axis, first, width, area, perimeter, shape: spec.shape, cells, walls }
    }

    /// Middle of a slab along the axis, m.
    pub fn middle(&self, slab: usize) -> f64 {
        self.first + self.width * slab as f64
    }

    /// Granular pressure of a slab, Pa.
    pub fn pressure(&self, slab: usize) -> f64 {
        self.cells[slab].pressure(self.shape)
    }

    /// Force of the side walls, inward and along the axis, per area of wall, Pa; zero where there are none.
    pub fn wall_stress(&self, slab: usize) -> [f64; 2] {
        let area = self.perimeter * self.width;
        self.walls[slab].map(|force| if area > 0.0 { force / area } else { 0.0 })
    }

    /// Slabs whose middle lies in `range`.
    pub fn slabs_in(&self, range: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).filter(move |&slab| (range[0]..=range[1]).contains(&self.middle(slab)))
    }

    /// As CSV; `more` are columns by name, one number per slab.
    pub fn table(&self, more: &[(&str, Vec<f64>)]) -> String {
        let mut text = String::from(["x", "y", "z"][self.axis]);
        text += ",solid_fraction,density,velocity_x,velocity_y,velocity_z,stress_xx,stress_yy,stress_zz,stress_xy,\
                 stress_xz,stress_yz,kinetic_pressure,pressure,wall_shear,wall_pressure";
        for (name, _) in more {
            let _ = write!(text, ",{name}");
        }
        text.push('\n');
        for (slab, cell) in self.cells.iter().enumerate() {
            let (u, s) = (cell.velocity, cell.stress());
            let kinetic = Cell { contact: nalgebra::Matrix3::zeros(), ..*cell }.pressure(self.shape);
            let ours = [self.middle(slab), cell.solid, cell.density, u.x, u.y, u.z];
            let stress = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| s[at]);
            let [inward, shear] = self.wall_stress(slab);
            let pressures = [kinetic, self.pressure(slab), shear, inward];
            let more = more.iter().map(|(_, values)| values[slab]);
            let row = ours.into_iter().chain(stress).chain(pressures).chain(more);
            text += &row.map(|value| value.to_string()).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }
}

/// A side of the region.
struct Side {
    /// Component across it.
    across: usize,
    /// Its place, m.
    at: f64,
    /// 1 or −1: where the region lies.
    inward: f64,
}

impl Side {
    fn both(asked: &bedload_scene::Profile, across: usize) -> [Self; 2] {
        [(asked.lower, 1.0), (asked.upper, -1.0)].map(|(x, inward)| Self { across, at: x[across], inward })
    }

    /// Whether a wall stands along it: a plane a radius away at most, or held grains just outside it over
    /// half of the slabs.
    fn is_walled(&self, spec: &DemSpec, grains: &Grains, slabs: &Slabs) -> bool {
        let radius = spec.largest_radius();
        let along = |wall: &Wall| {
            let normal = Vec3::from(wall.normal);
            normal[self.across].abs() > 0.999 * normal.norm()
        };
        let near = |wall: &Wall| along(wall) && (wall.point[self.across] - self.at).abs() <= radius;
        if spec.walls.iter().any(near) {
            return true;
        }
        let mut beside = vec![false; slabs.count];
        for i in (0..grains.len()).filter(|i| !is_free(grains, *i)) {
            let (x, r) = (&grains.position[i], grains.radius[i]);
            if (0.0..=2.0 * radius).contains(&(self.inward * (self.at - x[self.across]))) {
                slabs.ball(x[slabs.axis], r, &mut |slab, _| beside[slab] = true);
            }
        }
        2 * beside.iter().filter(|beside| **beside).count() >= slabs.count
    }
}

/// Part of a boundary force along the inward normal of the nearest of the `walled` sides of the region, N;
/// none of a contact that lies along the axis from the grain, at a floor or a lid.
fn inward_part(contact: &Contact, axis: usize, walled: &[Side]) -> Option<f64> {
    let away = contact.point - contact.end;
    if walled.iter().all(|side| away[side.across].abs() <= away[axis].abs()) {
        return None;
    }
    let apart = |side: &&Side| (contact.point[side.across] - side.at).abs();
    let nearest = walled.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    nearest.map(|side| side.inward * contact.force[side.across])
}
