//! Start and end of a window: between two windows the state is in [`Grains`], in the grains' own
//! numbers, and in the springs.

use crate::bulk::batch::Blocks;
use crate::bulk::block::Block;
use crate::bulk::engine::Bulk;
use crate::bulk::integrate::BodyForce;
use crate::bulk::records::{ForceTorque, GrainRecord, History, SIZE};
use crate::bulk::skins::Skin;
use crate::bulk::spatial_order::order;
use crate::bulk::sync::{mutex_mut, rwlock_mut};
use crate::grains::{Grains, Response};
use crate::motion::Vec3;
use crate::report::Observations;
use crate::state::{SavedContact, State};
use nalgebra::{Quaternion, UnitQuaternion};

/// Cells of the order over the mean diameter.
const CELL: f64 = 1.1;

/// Motion after which the order is made anew, over the mean diameter.
const STALE: f64 = 1.0;

/// What a window asks for besides the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wanted {
    /// Forces, gaps and speeds per grain.
    pub(crate) observations: bool,
    pub(crate) orientation: bool,
}

impl Bulk {
    /// Takes the state of all grains, and what acts on them over the window if that is other than
    /// before (`response`).
    pub(crate) fn begin(
        &mut self,
        grains: &Grains,
        response: Option<&Response>,
        gravity: &Vec3,
        wanted: Wanted,
    ) {
        let stale = self.order.is_empty() || self.order_travel > STALE * self.diameter;
        if stale || self.observed != wanted.observations {
            let (pairs, walls) = self.contacts();
            self.observed = wanted.observations;
            if stale {
                self.arrange(grains, self.new_order(grains), 0.0);
                self.loaded = true; // what acts on the grains must be set
            } else {
                self.deactivate(grains);
            }
            self.take(&pairs, &walls);
        }
        if let Some(response) = response {
            self.set_loads(grains, response);
            self.loaded = true;
        } else if self.loaded {
            self.set_gravity(grains, gravity);
            self.loaded = false;
        }
        let (mut fastest, mut moved) = (0.0f64, false);
        self.lists.skins.resize(self.blocks.block.len(), Skin::default());
        let inactive = self.blocks.inactive;
        for (b, (block, rows)) in self.blocks.block.iter_mut().zip(&mut self.blocks.rows).enumerate() {
            let [now, other] = rows;
            let (block, [now, other]) =
                (mutex_mut(block), if self.now == 0 { [now, other] } else { [other, now] });
            let rows = rwlock_mut(now);
            let (n, mut speed2) = (block.len(), 0.0f64);
            let order = &self.order[block.first as usize..][..n];
            for (row, &i) in rows[..n].iter_mut().zip(order) {
                let (x, v, w) =
                    (&grains.position[i as usize], &grains.velocity[i as usize], &grains.spin[i as usize]);
                moved |= row.a[0] != x.x || row.a[1] != x.y || row.a[2] != x.z;
                row.a[..3].copy_from_slice(x.as_slice());
                row.a[4..7].copy_from_slice(v.as_slice());
                row.b[..3].copy_from_slice(w.as_slice());
                speed2 = speed2.max(v.norm_squared());
            }
            self.lists.skins[b].speed = speed2.sqrt();
            self.lists.skins[b].recent_speed = self.lists.skins[b].recent_speed.max(speed2.sqrt());
            fastest = fastest.max(speed2);
            block.observed.clear(if wanted.observations { n } else { 0 }, self.common.walls.len());
            block.orientation.clear();
            if b < inactive {
                rwlock_mut(other).clone_from(rows); // nobody will
            } else if wanted.orientation {
                let turned = order.iter().map(|&i| &grains.orientation[i as usize]);
                block.orientation.extend(turned.map(|q| [q.w, q.i, q.j, q.k]));
            }
        }
        // someone else may have moved a grain
        self.valid &= !moved;
        self.speed = fastest.sqrt();
    }

    /// Hands the state back, positions within the period.
    pub(crate) fn end(&mut self, grains: &mut Grains) {
        let periods = self.periods;
        for (block, rows) in self.blocks.block.iter_mut().zip(&mut self.blocks.rows) {
            let (block, rows) = (mutex_mut(block), rwlock_mut(&mut rows[self.now]));
            let n = block.len();
            let order = &self.order[block.first as usize..][..n];
            for (row, &i) in rows[..n].iter_mut().zip(order) {
                let i = i as usize;
                let mut x = Vec3::from(row.position());
                periods.wrap(&mut x, &mut grains.image[i]);
                row.a[..3].copy_from_slice(x.as_slice());
                grains.position[i] = x;
                grains.velocity[i] = row.velocity().into();
                grains.spin[i] = row.spin().into();
            }
            for (&[w, x, y, z], &i) in block.orientation.iter().zip(order) {
                grains.orientation[i as usize] = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
            }
        }
    }

    /// Adds the sums of the contact forces on each wall over the sub-steps, N.
    pub(crate) fn add_wall_forces(&mut self, walls: &mut [Vec3]) {
        for block in self.blocks.active_mut() {
            for (sum, ForceTorque([x, y, z, ..])) in walls.iter_mut().zip(&mutex_mut(block).observed.walls) {
                *sum -= Vec3::new(*x, *y, *z);
            }
        }
    }

    /// Per-grain observations of the window, in sums over its sub-steps; gaps of overlapping pairs at its
    /// end `t`.
    pub(crate) fn observe(&mut self, observed: &mut Observations, (t, dt): (f64, f64)) {
        if !self.lists_are_good() {
            self.build(t, dt);
        }
        let (periods, mut listed) = (self.periods, History::default());
        for b in 0..self.blocks.block.len() {
            let block = mutex_mut(&mut self.blocks.block[b]);
            let first = block.first as usize;
            for (k, (force, speeds)) in block.observed.force.iter().zip(&block.observed.speeds).enumerate() {
                let i = self.order[first + k] as usize;
                observed.mean_contact[i] = Vec3::new(force[0], force[1], force[2]);
                (observed.impact_speed[i], observed.rebound_speed[i]) = (speeds[0], speeds[1]);
            }
            block.history(true, &mut listed);
            let near: Vec<(u32, u32)> =
                listed[0].iter().chain(&listed[1]).map(|pair| (pair.i, pair.j)).collect();
            for (i, j) in near {
                let (a, b) = (self.row(first + i as usize), self.row(j as usize));
                let apart = periods.nearest(Vec3::from(a.position()) - Vec3::from(b.position()));
                let gap = apart.norm() - a.radius() - b.radius();
                if gap <= 0.0 {
                    for place in [first + i as usize, j as usize] {
                        let nearest = &mut observed.gap_end[self.order[place] as usize];
                        *nearest = nearest.min(gap);
                    }
                }
            }
        }
    }

    /// Record of the grain at a place of the order.
    fn row(&mut self, place: usize) -> GrainRecord {
        rwlock_mut(&mut self.blocks.rows[place / SIZE][self.now])[place % SIZE]
    }

    /// Puts the grains into blocks in a new order.
    fn arrange(&mut self, grains: &Grains, order: Vec<u32>, travel: f64) {
        let (mut rows, mut blocks) = (Vec::new(), Vec::new());
        for (b, numbers) in order.chunks(SIZE).enumerate() {
            let mut block = Block { first: (b * SIZE) as u32, ..Block::default() };
            let of = |&i: &u32| {
                let (mut row, r) = (GrainRecord::NONE, grains.radius[i as usize]);
                (row.a[3], row.b[3]) = (r, r);
                // no place yet: the first window finds all grains moved
                row.a[0] = f64::NAN;
                row
            };
            let mut own: Vec<GrainRecord> = numbers.iter().map(of).collect();
            own.push(GrainRecord::NONE);
            block.inverse_inertia = vec![0.0; numbers.len()];
            let prescribed = (0u16..).zip(numbers).filter(|(_, i)| !grains.responds(**i as usize));
            block.prescribed = prescribed.map(|(k, &i)| (k, grains.motion[i as usize].clone())).collect();
            rows.push([own.clone().into(), own.into()]);
            blocks.push(block.into());
        }
        (self.order, self.order_travel, self.now) = (order, travel, 0);
        self.blocks = Blocks::new(rows, blocks, 0);
        self.lists.skins.clear();
        self.deactivate(grains);
    }

    /// Numbers of the grains in a new order: fixed ones first, as many as fill blocks of their own.
    fn new_order(&self, grains: &Grains) -> Vec<u32> {
        let order = order(&grains.position, CELL * self.diameter);
        let is_fixed = |i: &&u32| grains.is_fixed(**i as usize);
        let fixed = order.iter().filter(is_fixed).count();
        let mut whole = fixed - fixed % SIZE;
        let (mut first, mut rest) = (Vec::with_capacity(order.len()), Vec::new());
        for i in &order {
            if whole > 0 && is_fixed(&i) {
                whole -= 1;
                first.push(*i);
            } else {
                rest.push(*i);
            }
        }
        first.append(&mut rest);
        first
    }

    /// Takes those blocks out that may be.
    fn deactivate(&mut self, grains: &Grains) {
        let fixed = |numbers: &&[u32]| numbers.iter().all(|&i| grains.is_fixed(i as usize));
        let inactive = if self.observed { 0 } else { self.order.chunks(SIZE).take_while(fixed).count() };
        self.blocks.deactivate(inactive);
        self.valid = false;
    }

    /// Distance that the mean moving grain goes in the window.
    pub(crate) fn note_travel(&mut self, grains: &Grains, dt: f64) {
        let speeds: f64 = grains.velocity.iter().map(|v| v.norm()).sum();
        self.order_travel += dt * speeds / self.moving.max(1) as f64;
    }

    /// Masses, and gravity or whatever acts on each grain.
    fn set_loads(&mut self, grains: &Grains, response: &Response) {
        let (order, falls) = (&self.order, self.common.gravity.is_some());
        for (block, rows) in self.blocks.block.iter_mut().zip(&mut self.blocks.rows) {
            let block = mutex_mut(block);
            let order = &order[block.first as usize..][..block.len()];
            block.drive.clear();
            block.mass.clear();
            block.mass.extend(order.iter().filter(|_| falls).map(|&i| grains.mass[i as usize]));
            for (k, &i) in order.iter().enumerate() {
                let i = i as usize;
                for rows in &mut *rows {
                    rwlock_mut(rows)[k].a[7] = response.contact_inverse_mass[i];
                }
                block.inverse_inertia[k] = response.inverse_inertia[i].max();
                block.drive.push(BodyForce::new(
                    [&response.acceleration[i], &response.spin_acceleration[i]],
                    [&grains.translation[i], &grains.rotation[i]],
                ));
            }
        }
    }

    /// No load but gravity: one entry for all grains of a block, where all are free in the same way.
    fn set_gravity(&mut self, grains: &Grains, gravity: &Vec3) {
        self.set_loads(grains, &Response::new(grains, gravity, &[]));
        let order = &self.order;
        for block in &mut self.blocks.block {
            let block = mutex_mut(block);
            let mut moving = order[block.first as usize..][..block.len()]
                .iter()
                .map(|&i| i as usize)
                .filter(|&i| grains.responds(i))
                .map(|i| (grains.translation[i], grains.rotation[i]));
            let Some((free, turns)) = moving.next() else { continue };
            if moving.all(|other| other == (free, turns)) {
                let fall = gravity.component_mul(&free);
                let one = BodyForce::new([&fall, &Vec3::zeros()], [&free, &turns]);
                block.drive = vec![one];
            }
        }
    }

    /// Order and springs into a state.
    pub(crate) fn save_into(&self, state: &mut State) {
        state.order.clone_from(&self.order);
        state.order_travel = self.order_travel;
        (state.contacts, state.wall_contacts) = self.contacts();
    }

    /// Order and springs of a checked state, which `grains` already hold.
    pub(crate) fn restore(&mut self, grains: &Grains, state: &State) {
        let (order, travel) = if state.order.is_empty() {
            (self.new_order(grains), 0.0)
        } else {
            (state.order.clone(), state.order_travel)
        };
        self.arrange(grains, order, travel);
        let stays = |contact: &&SavedContact| (contact.second as usize) < self.common.walls.len();
        let walls: Vec<SavedContact> = state.wall_contacts.iter().filter(stays).copied().collect();
        self.take(&state.contacts, &walls);
        self.loaded = true;
    }
}
