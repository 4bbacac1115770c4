//! How the planes along the last axis are shared: fixed blocks, and the slab of each rank.
//!
//! The blocks depend on the number of planes alone; the slab of a rank is a whole number of them. What
//! is computed depends on the blocks, never on the slabs, so every number of ranks finds the same bits.
//!
//! Every rank keeps the indices of the whole grid. Its fields have the length of the whole grid, too, but a
//! page of memory that is never touched takes none: a rank works on its own planes and those beside them.

use crate::ranks::Ranks;
use std::ops::Range;
use thiserror::Error;

/// Planes of a block at least.
const LEAST: usize = 4;

/// Planes of a block from which on there are more than [`FEW`] blocks.
const MANY: usize = 8;

/// Number of blocks below that.
const FEW: usize = 8;

/// The planes of a grid, and who works on which.
#[derive(Clone, Debug)]
pub struct Division {
    /// First plane of each block, and the number of planes; empty: the tridiagonal solve knows no blocks.
    pub(crate) cuts: Vec<usize>,
    own: Range<usize>,
    ranks: Ranks,
}

/// Why planes cannot be shared.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DivisionError {
    /// Two axes.
    #[error("a grid with two axes cannot be divided among ranks: only one in space can")]
    Axes,
    /// Too few planes for two blocks.
    #[error(
        "{0} cells along the last axis are too few to be divided: at least {least} are needed",
        least = 2 * LEAST
    )]
    Planes(usize),
    /// More ranks than blocks.
    #[error("{ranks} ranks for {planes} cells along the last axis: 1 to {most} are possible")]
    Ranks {
        /// Ranks given.
        ranks: usize,
        /// Number of planes.
        planes: usize,
        /// Number of blocks.
        most: usize,
    },
    /// Faces that fluid passes through.
    #[error("inflow and outflow cannot be divided among ranks")]
    Open,
}

/// Number of blocks of a grid with so many planes.
pub fn blocks(planes: usize) -> usize {
    let largest = |count: usize| if count > 1 { 1 << count.ilog2() } else { count };
    largest(planes / MANY).max(largest(planes / LEAST).min(FEW))
}

/// The blocks of rank `rank` of `ranks`.
pub(crate) fn blocks_of(count: usize, rank: usize, ranks: usize) -> Range<usize> {
    count * rank / ranks..count * (rank + 1) / ranks
}

impl Division {
    /// One process, and a solve that knows no blocks.
    pub(crate) fn whole(planes: usize) -> Self {
        Self { cuts: Vec::new(), own: 0..planes, ranks: Ranks::alone() }
    }

    pub(crate) fn new(planes: usize, ranks: Ranks) -> Result<Self, DivisionError> {
        let cuts = Self::cuts_for(planes, ranks.size())?;
        let own = Self::planes_of(&cuts, ranks.rank(), ranks.size());
        Ok(Self { cuts, own, ranks })
    }

    /// The blocks of a grid with so many planes, if so many ranks can share them.
    fn cuts_for(planes: usize, size: usize) -> Result<Vec<usize>, DivisionError> {
        let count = blocks(planes);
        if count < 2 {
            return Err(DivisionError::Planes(planes));
        }
        if size > count {
            return Err(DivisionError::Ranks { ranks: size, planes, most: count });
        }
        Ok((0..=count).map(|block| planes * block / count).collect())
    }

    /// Planes of the rank that has fewest and of the one that has most, if so many ranks share a grid.
    ///
    /// # Errors
    /// If they cannot.
    pub fn slabs(planes: usize, size: usize) -> Result<[usize; 2], DivisionError> {
        let cuts = Self::cuts_for(planes, size)?;
        let planes = || (0..size).map(|rank| Self::planes_of(&cuts, rank, size).len());
        Ok([planes().min().unwrap_or(0), planes().max().unwrap_or(0)])
    }

    fn planes_of(cuts: &[usize], rank: usize, size: usize) -> Range<usize> {
        let blocks = blocks_of(cuts.len() - 1, rank, size);
        cuts[blocks.start]..cuts[blocks.end]
    }

    /// The planes that this rank works on.
    pub fn own(&self) -> Range<usize> {
        self.own.clone()
    }

    /// The planes of rank `rank`.
    pub fn of(&self, rank: usize) -> Range<usize> {
        if self.ranks.is_alone() { self.own() } else { Self::planes_of(&self.cuts, rank, self.ranks.size()) }
    }

    /// Planes of the rank that has fewest.
    pub fn least(&self) -> usize {
        (0..self.ranks.size()).map(|rank| self.of(rank).len()).min().unwrap_or(0)
    }

    /// The ranks.
    pub fn ranks(&self) -> &Ranks {
        &self.ranks
    }

    /// Ranks below and above, where there are planes beyond; on a `periodic` axis they go round.
    pub(crate) fn neighbours(&self, periodic: bool) -> [Option<usize>; 2] {
        let (rank, size) = (self.ranks.rank(), self.ranks.size());
        let below = if rank > 0 { Some(rank - 1) } else { periodic.then_some(size - 1) };
        let above = if rank + 1 < size { Some(rank + 1) } else { periodic.then_some(0) };
        [below, above]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_from_the_planes() {
        let planes = [7, 8, 12, 16, 31, 32, 128, 255, 256, 512, 1000];
        assert_eq!(planes.map(blocks), [1, 2, 2, 4, 4, 8, 16, 16, 32, 64, 64]);
    }

    #[test]
    fn slabs_are_whole_blocks() {
        for size in 1..=8 {
            let mut next = 0;
            for ranks in crate::ranks::threads::ranks(size) {
                let division = Division::new(44, ranks).expect("44 planes have 8 blocks");
                assert!(division.cuts.contains(&division.own().start));
                assert_eq!(
                    (division.own().start, division.of(division.ranks().rank())),
                    (next, division.own())
                );
                next = division.own().end;
            }
            assert_eq!(next, 44);
        }
        let nine = crate::ranks::threads::ranks(9).remove(0);
        let error = Division::new(44, nine).expect_err("nine are too many");
        assert!(error.to_string().contains("1 to 8"), "{error}");
    }
}
