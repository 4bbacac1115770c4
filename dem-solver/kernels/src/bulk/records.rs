//! What the engine stores: a grain is a row of 12 numbers, eight contacts are a pack.

use crate::laws::walls::Plane;

/// Grains of a block.
pub(super) const SIZE: usize = 512;

/// One grain: all that its contacts and its motion read. 96 bytes, so that a pair is four loads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct GrainRecord {
    /// x, y, z, r | v_x, v_y, v_z, 1/m*, the last the inverse mass that contacts see.
    pub(super) a: [f64; 8],
    /// ω_x, ω_y, ω_z, r.
    pub(super) b: [f64; 4],
}

impl GrainRecord {
    /// A row without extent at the origin: what fills a pack. It touches nothing, not even itself.
    pub(super) const NONE: Self = Self { a: [0.0; 8], b: [0.0; 4] };

    /// Centre, m.
    #[inline(always)]
    pub(super) fn position(&self) -> [f64; 3] {
        [self.a[0], self.a[1], self.a[2]]
    }

    /// Radius, m.
    #[inline(always)]
    pub(super) fn radius(&self) -> f64 {
        self.a[3]
    }

    /// Velocity, m/s.
    #[inline(always)]
    pub(super) fn velocity(&self) -> [f64; 3] {
        [self.a[4], self.a[5], self.a[6]]
    }

    /// Inverse mass that contacts see, 1/kg: zero for a grain that nothing moves.
    #[inline(always)]
    pub(super) fn inverse_mass(&self) -> f64 {
        self.a[7]
    }

    /// Gap to a wall at time `t`, m.
    pub(super) fn gap(&self, plane: &Plane, t: f64) -> f64 {
        plane.gap(&self.position().into(), self.radius(), t)
    }

    /// Angular velocity, rad/s.
    #[inline(always)]
    pub(super) fn spin(&self) -> [f64; 3] {
        [self.b[0], self.b[1], self.b[2]]
    }
}

/// Force (0..3) and torque (4..7) on one grain, N and N m.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct ForceTorque(pub(super) [f64; 8]);

/// Eight contacts of one block, by (i, j) ascending over all packs.
///
/// Lanes that hold no contact point to a row without extent ([`GrainRecord::NONE`]).
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct ContactPack {
    /// Tangential springs δ_t, m: x, y, z of eight lanes.
    pub(super) spring: [[f64; 8]; 3],
    /// First partners: rows of the block.
    pub(super) i: [u16; 8],
    /// Second partners: rows of the block, or of its halo; for walls of no meaning.
    pub(super) j: [u32; 8],
    /// Lanes that bear a force.
    pub(super) touching: u8,
    /// Number of the wall, where the pack is one of wall contacts.
    pub(super) wall: u16,
}

impl ContactPack {
    pub(super) fn empty(i: u16, j: u32, wall: u16) -> Self {
        Self { spring: [[0.0; 8]; 3], i: [i; 8], j: [j; 8], touching: 0, wall }
    }

    /// Lanes that hold a contact of a block of `n` grains.
    pub(super) fn filled(&self, n: usize) -> u8 {
        (0..8).map(|k| u8::from((self.i[k] as usize) < n) << k).sum()
    }

    pub(super) fn spring(&self, lane: usize) -> [f64; 3] {
        [self.spring[0][lane], self.spring[1][lane], self.spring[2][lane]]
    }
}

/// A contact with its history, outside of the packs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SavedSpring {
    /// Place in its block.
    pub(super) i: u32,
    /// Other grain in the order of the engine, or wall.
    pub(super) j: u32,
    /// Spring of i against j, m.
    pub(super) spring: [f64; 3],
}

/// Contacts with their history: within the block, with other blocks, with walls; by (i, j) ascending.
pub(super) type History = [Vec<SavedSpring>; 3];
