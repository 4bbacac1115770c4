//! Coarse-graining (Goldhirsch 2010): fields of a continuum from grains and their contacts.
//!
//! With φ_c the part of a point, grain or line that belongs to cell c of volume V_c:
//!
//! solid fraction Σ φ_c V_i/V_c,  density ρ_c = Σ φ_c m_i/V_c,  velocity u_c = Σ φ_c m_i v_i/(ρ_c V_c),
//! kinetic stress Σ φ_c m_i v′_i v′_i/V_c with v′_i = v_i − u_c,
//! contact stress Σ f_ij r_ij ∫₀¹ φ_c ds/V_c over the line between the centres,
//!
//! f_ij the force on i, r_ij from j to i: compression is positive. Against walls and held grains the
//! line ends at the point of contact (Weinhart, Thornton, Luding & Bokhove 2012). The granular
//! pressure is the third part (plane: half) of the trace. Summed over all cells the contact stress
//! times V_c is the virial Σ f_ij r_ij.

use crate::contacts::{Contact, is_free};
use crate::grain::Shape;
use crate::grains::Grains;
use crate::motion::Vec3;
use crate::output::partition::Partition;
use nalgebra::Matrix3;

/// Averages in one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Solid fraction.
    pub solid: f64,
    /// Mass of grains over the volume, kg/m³.
    pub density: f64,
    /// Mean velocity, weighted with mass, m/s; zero where there is no grain.
    pub velocity: Vec3,
    /// Kinetic stress, Pa.
    pub kinetic: Matrix3<f64>,
    /// Contact stress, Pa; first index the force.
    pub contact: Matrix3<f64>,
}

impl Cell {
    /// Kinetic and contact stress, Pa.
    pub fn stress(&self) -> Matrix3<f64> {
        self.kinetic + self.contact
    }

    /// Granular pressure, Pa, of spheres or discs.
    pub fn pressure(&self, shape: Shape) -> f64 {
        match shape {
            Shape::Sphere => self.stress().trace() / 3.0,
            Shape::Disc => self.stress().trace() / 2.0,
        }
    }
}

/// Averages of the free grains whose centres are `inside`, cell by cell.
pub fn coarse_grain(
    grains: &Grains,
    shape: Shape,
    contacts: &[Contact],
    partition: &Partition,
    inside: impl Fn(&Vec3) -> bool,
) -> Vec<Cell> {
    let mut cells = vec![Cell::default(); partition.count()];
    let free = || (0..grains.len()).filter(|&i| is_free(grains, i) && inside(&grains.position[i]));
    for i in free() {
        let volume = shape.mass(grains.radius[i], 1.0);
        partition.ball(&grains.position[i], grains.radius[i], |cell, part| {
            cells[cell].solid += part * volume;
            cells[cell].density += part * grains.mass[i];
            cells[cell].velocity += grains.velocity[i] * (part * grains.mass[i]);
        });
    }
    for cell in &mut cells {
        if cell.density > 0.0 {
            cell.velocity /= cell.density;
        }
    }
    for i in free() {
        partition.ball(&grains.position[i], grains.radius[i], |cell, part| {
            let apart = grains.velocity[i] - cells[cell].velocity;
            cells[cell].kinetic += apart * apart.transpose() * (part * grains.mass[i]);
        });
    }
    for contact in contacts.iter().filter(|contact| inside(&contact.end)) {
        let virial = contact.force * (contact.end - contact.start).transpose();
        partition.line(&contact.start, &contact.end, |cell, part| cells[cell].contact += virial * part);
    }
    let per_volume = 1.0 / partition.volume();
    for cell in &mut cells {
        cell.solid *= per_volume;
        cell.density *= per_volume;
        cell.kinetic *= per_volume;
        cell.contact *= per_volume;
    }
    cells
}
