//! Half list of near pairs with their contact history.

use crate::motion::Vec3;
use crate::state::SavedContact;

/// Pairs by first partner: row `i` holds the partners of grain `i`, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactList {
    start: Vec<u32>,
    pub(crate) first: Vec<u32>,
    /// Second partners: grains j > i, or walls.
    pub(crate) other: Vec<u32>,
    /// Tangential springs δ_t, m; zero where nothing touches.
    pub(crate) spring: Vec<Vec3>,
    /// Rolling angles θ, rad; zero where nothing touches or rolling is free.
    pub(crate) rolling: Vec<Vec3>,
    /// Whether the contact bears a force.
    pub(crate) touching: Vec<bool>,
}

impl ContactList {
    /// Range of entries of grain `i`.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    pub(crate) fn len(&self) -> usize {
        self.other.len()
    }

    /// All entries: first partner and place in the lists.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (1..self.start.len()).flat_map(|next| self.row(next - 1).map(move |k| (next - 1, k)))
    }

    /// The entries that bear a force, with their springs.
    pub(crate) fn bearing(&self) -> impl Iterator<Item = SavedContact> + '_ {
        let of = |(i, k): (usize, usize)| (i as u32, self.other[k], self.spring[k].into());
        let bearing = self.entries().filter(|(_, k)| self.touching[*k]).map(of);
        bearing.map(|(first, second, spring)| SavedContact { first, second, spring })
    }

    /// Empties the list and opens the first row.
    pub(crate) fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.first.clear();
        self.other.clear();
        self.spring.clear();
        self.rolling.clear();
        self.touching.clear();
    }

    /// Appends an entry to the open row.
    pub(crate) fn push(&mut self, other: u32, spring: Vec3, rolling: Vec3, touching: bool) {
        self.first.push(self.start.len() as u32 - 1);
        self.other.push(other);
        self.spring.push(spring);
        self.rolling.push(rolling);
        self.touching.push(touching);
    }

    pub(crate) fn close_row(&mut self) {
        self.start.push(self.other.len() as u32);
    }

    /// Appends `partners` (ascending) as row `i`, with the history that `old` has of them.
    pub(super) fn push_row(&mut self, i: usize, partners: &[u32], old: &Self) {
        let mut history = if i + 1 < old.start.len() { old.row(i) } else { 0..0 };
        for &other in partners {
            while history.start < history.end && old.other[history.start] < other {
                history.start += 1;
            }
            if history.start < history.end && old.other[history.start] == other {
                let k = history.start;
                self.push(other, old.spring[k], old.rolling[k], old.touching[k]);
            } else {
                self.push(other, Vec3::zeros(), Vec3::zeros(), false);
            }
        }
        self.close_row();
    }

    /// Takes the saved contacts of `grains` grains over; `rolling` holds their angles, if there are any.
    pub(crate) fn restore(&mut self, saved: &[SavedContact], rolling: &[[f64; 3]], grains: usize) {
        self.clear();
        let mut rest = saved.iter().enumerate().peekable();
        for i in 0..grains as u32 {
            while let Some((k, contact)) = rest.next_if(|(_, contact)| contact.first == i) {
                let angle = rolling.get(k).copied().unwrap_or_default();
                self.push(contact.second, contact.spring.into(), angle.into(), true);
            }
            self.close_row();
        }
    }
}
