//! Laws between grains of several materials, as the kernels gather them.

use crate::grain::Grain;
use crate::laws::coefficients::LinearPair;
use crate::laws::table::LawTable;

/// Materials of grains at most: the number of a pair is a byte.
pub(super) const MOST: usize = 15;

/// Some laws that differ in their coefficients alone.
#[derive(Clone, Debug)]
pub(super) struct LawSet {
    /// The first of them.
    pub(super) first: LinearPair,
    /// Coefficients of each, as [`crate::bulk::law::LawLanes`] has them: k_n, γ_n, k_t, γ_t over m*, μ, 1/(k_t/m*).
    pub(super) rows: Vec<[f64; 8]>,
}

impl LawSet {
    /// None if there are no laws, or if they differ in the lever arm, or in what sliding does to the spring.
    pub(super) fn new(laws: &[LinearPair]) -> Option<Self> {
        let first = *laws.first()?;
        let cuts = |law: &LinearPair| law.capped && law.tangential_stiffness > 0.0;
        let alike =
            |law: &LinearPair| law.at_contact_point == first.at_contact_point && cuts(law) == cuts(&first);
        laws.iter().all(alike).then(|| Self { first, rows: laws.iter().map(row).collect() })
    }

    /// Whether there is one law only.
    pub(super) fn is_one(&self) -> bool {
        self.rows.len() == 1
    }
}

fn row(law: &LinearPair) -> [f64; 8] {
    let k_t = law.tangential_stiffness;
    let compliance = if k_t > 0.0 { 1.0 / k_t } else { 0.0 };
    [law.stiffness, law.damping, k_t, law.tangential_damping, law.friction, compliance, 0.0, 0.0]
}

/// Materials of the grains, and the laws between them.
#[derive(Clone, Debug)]
pub(super) struct Materials {
    /// Those that grains have, ascending.
    of_grains: Vec<usize>,
    /// Laws of all pairs of them, row by row.
    pub(super) laws: LawSet,
    /// Which of them each place of the order has; empty where there is one only.
    place: Vec<u8>,
}

/// Materials that grains have, ascending.
pub(super) fn used(grains: &[Grain]) -> Vec<usize> {
    let mut used: Vec<usize> = grains.iter().map(|grain| grain.material).collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// Laws between all pairs of `materials`, row by row.
pub(super) fn between(materials: &[usize], table: &LawTable) -> Option<LawSet> {
    let pairs = materials.iter().flat_map(|a| materials.iter().map(move |b| (*a, *b)));
    LawSet::new(&pairs.map(|(a, b)| table.linear(a, b)).collect::<Option<Vec<_>>>()?)
}

/// Laws of all `materials` at a wall of material `wall`.
pub(super) fn at_wall(materials: &[usize], wall: usize, table: &LawTable) -> Option<LawSet> {
    LawSet::new(&materials.iter().map(|a| table.linear(*a, wall)).collect::<Option<Vec<_>>>()?)
}

impl Materials {
    pub(super) fn new(of_grains: Vec<usize>, table: &LawTable) -> Option<Self> {
        let laws = between(&of_grains, table)?;
        Some(Self { of_grains, laws, place: Vec::new() })
    }

    /// Takes the materials of the grains by the places of the order.
    pub(super) fn arrange(&mut self, order: &[u32], material: &[usize]) {
        self.place.clear();
        if !self.laws.is_one() {
            let number = |i: &u32| self.of_grains.partition_point(|of| *of < material[*i as usize]) as u8;
            self.place.extend(order.iter().map(number));
        }
    }

    /// Number of the material at a place.
    pub(super) fn at(&self, place: u32) -> u8 {
        self.place.get(place as usize).copied().unwrap_or(0)
    }

    /// Number of the law between two places.
    #[inline]
    pub(super) fn pair(&self, a: u32, b: u32) -> u8 {
        if self.place.is_empty() {
            return 0;
        }
        self.at(a) * self.of_grains.len() as u8 + self.at(b)
    }
}
