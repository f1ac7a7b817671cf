//! The wavenumber from which each wavenumber starts: a plan of the whole fit, fixed before any of it is done.
//!
//! Poles vary smoothly with n, so that a fit is short where it starts from a neighbour's. Two *roots*, n = 0 and about
//! the middle, start from nothing; every other wavenumber starts from the nearest one below it that belongs to a
//! coarser stride: strides halve from root to leaf. A wavenumber may be fitted as soon as the one from which it starts
//! is done, and its start never depends on what else is running: same bits for any number of threads.

/// A wavenumber in the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Visit {
    /// Wavenumber n.
    pub wavenumber: usize,
    /// Distance to the wavenumber from which it starts; 0: it starts from nothing.
    pub stride: usize,
}

/// All wavenumbers, coarse strides first. The *rank* of one is its index in this order; a start has a lower rank than
/// those that start from it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Tree {
    visits: Vec<Visit>,
    /// Ranks by wavenumber.
    ranks: Vec<usize>,
    /// By rank, the ranks of those that start from it, coarse strides first.
    followers: Vec<Vec<usize>>,
}

impl Tree {
    /// Plan for n = 0..=`last`.
    pub(super) fn new(last: usize) -> Self {
        let middle = last.next_power_of_two() / 2;
        let mut visits = vec![Visit { wavenumber: 0, stride: 0 }];
        if middle > 0 {
            visits.push(Visit { wavenumber: middle, stride: 0 });
        }
        let mut ranks: Vec<Option<usize>> = vec![None; last + 1];
        for (rank, visit) in visits.iter().enumerate() {
            ranks[visit.wavenumber] = Some(rank);
        }
        let mut stride = middle.max(1);
        while stride > 0 {
            for wavenumber in (stride..=last).step_by(stride) {
                if ranks[wavenumber].is_none() {
                    ranks[wavenumber] = Some(visits.len());
                    visits.push(Visit { wavenumber, stride });
                }
            }
            stride /= 2;
        }
        let ranks: Vec<usize> = ranks.into_iter().flatten().collect();
        let mut followers = vec![Vec::new(); visits.len()];
        for (rank, visit) in visits.iter().enumerate().filter(|(_, visit)| visit.stride > 0) {
            followers[ranks[visit.wavenumber - visit.stride]].push(rank);
        }
        Self { visits, ranks, followers }
    }

    /// Number of wavenumbers.
    pub(super) fn len(&self) -> usize {
        self.visits.len()
    }

    /// Ranks of those that start from nothing.
    pub(super) fn roots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|&rank| self.visits[rank].stride == 0)
    }

    pub(super) fn visit(&self, rank: usize) -> Visit {
        self.visits[rank]
    }

    /// Rank of the one from which a rank starts; `None` for a root.
    pub(super) fn start(&self, rank: usize) -> Option<usize> {
        let Visit { wavenumber, stride } = self.visits[rank];
        (stride > 0).then(|| self.ranks[wavenumber - stride])
    }

    /// Ranks of those that start from a rank, coarse strides first.
    pub(super) fn followers(&self, rank: usize) -> &[usize] {
        &self.followers[rank]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wavenumber_has_one_place_after_what_it_starts_from() {
        for last in [2, 3, 4, 7, 8, 100, 256, 257, 511] {
            let tree = Tree::new(last);
            assert_eq!(tree.len(), last + 1);
            let mut reached = vec![false; tree.len()];
            let mut open: Vec<usize> = tree.roots().collect();
            assert_eq!(open.len(), 2);
            while let Some(rank) = open.pop() {
                assert!(!reached[rank], "{last}: rank {rank} twice");
                reached[rank] = true;
                assert_eq!(tree.ranks[tree.visit(rank).wavenumber], rank);
                for &follower in tree.followers(rank) {
                    assert_eq!(tree.start(follower), Some(rank));
                    assert!(follower > rank);
                }
                open.extend(tree.followers(rank));
            }
            assert!(reached.iter().all(|&reached| reached), "{last}");
        }
    }

    #[test]
    fn no_chain_of_starts_is_longer_than_the_strides_can_be_halved() {
        let tree = Tree::new(512);
        let depth = |mut rank: usize| {
            let mut depth = 0;
            while let Some(start) = tree.start(rank) {
                (rank, depth) = (start, depth + 1);
            }
            depth
        };
        assert_eq!((0..tree.len()).map(depth).max(), Some(8));
        assert_eq!(tree.visit(tree.start(tree.ranks[512]).unwrap_or(0)).wavenumber, 256);
    }
}
