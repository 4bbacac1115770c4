//! Springs in and out, by the grains' own numbers.

use crate::bulk::engine::Bulk;
use crate::bulk::records::{History, SIZE, SavedSpring};
use crate::bulk::sync::{lock, mutex_mut};
use crate::state::SavedContact;

impl Bulk {
    /// Contacts between grains and with walls that bear a force, each ascending.
    pub(crate) fn contacts(&self) -> (Vec<SavedContact>, Vec<SavedContact>) {
        let (mut pairs, mut walls) = (Vec::new(), Vec::new());
        let mut history = History::default();
        let inactive = self.blocks.inactive;
        for block in self.blocks.block.iter().skip(inactive) {
            let block = lock(block);
            match &block.pending {
                Some(pending) => history.clone_from(pending),
                None => block.history(false, &mut history),
            }
            let [inner, cross, at_walls] = &history;
            let number = |place: u32| self.order[place as usize];
            for kept in inner.iter().chain(cross) {
                let place = block.first + kept.i;
                // the other block has the same contact the other way round, if it is active
                if place < kept.j || (kept.j as usize) < inactive * SIZE {
                    pairs.push(between(number(place), number(kept.j), kept.spring));
                }
            }
            walls.extend(at_walls.iter().map(|kept| SavedContact {
                first: number(block.first + kept.i),
                second: kept.j,
                spring: kept.spring,
            }));
        }
        for list in [&mut pairs, &mut walls] {
            list.sort_unstable_by_key(|contact| (contact.first, contact.second));
        }
        (pairs, walls)
    }

    /// Takes springs over; the next build puts them into its lists.
    pub(super) fn take(&mut self, contacts: &[SavedContact], wall_contacts: &[SavedContact]) {
        let mut place = vec![0u32; self.n];
        for (k, &i) in (0u32..).zip(&self.order) {
            place[i as usize] = k;
        }
        let size = SIZE as u32;
        let mut histories = vec![Box::<History>::default(); self.blocks.block.len()];
        for contact in contacts {
            let (i, j) = (place[contact.first as usize], place[contact.second as usize]);
            let within = i / size == j / size;
            // within a block the first of the two has the contact, else each in its own block
            for (i, j, spring) in [(i, j, contact.spring), (j, i, contact.spring.map(|s| -s))] {
                if i < j || !within {
                    let list = &mut histories[(i / size) as usize][usize::from(!within)];
                    list.push(SavedSpring { i: i % size, j, spring });
                }
            }
        }
        for contact in wall_contacts {
            let i = place[contact.first as usize];
            let kept = SavedSpring { i: i % size, j: contact.second, spring: contact.spring };
            histories[(i / size) as usize][2].push(kept);
        }
        for (mut pending, block) in histories.into_iter().zip(&mut self.blocks.block) {
            let [pairs, cross, walls] = &mut *pending;
            pairs.sort_unstable_by_key(|kept| (kept.i, kept.j));
            cross.sort_unstable_by_key(|kept| (kept.i, kept.j));
            walls.sort_unstable_by_key(|kept| (kept.j, kept.i));
            mutex_mut(block).pending = Some(pending);
        }
        self.valid = false;
    }

    /// Largest overlap of the window, m.
    pub(crate) fn largest_overlap(&mut self) -> f64 {
        let overlaps = self.blocks.active_mut().iter_mut().map(|block| mutex_mut(block).observed.overlap);
        overlaps.fold(0.0, f64::max)
    }
}

/// A contact as it is saved, the lower number first.
fn between(i: u32, j: u32, spring: [f64; 3]) -> SavedContact {
    if i < j {
        SavedContact { first: i, second: j, spring }
    } else {
        SavedContact { first: j, second: i, spring: spring.map(|s| -s) }
    }
}
