//! Pressures at the receivers, by all that causes them.

use crate::response::pressure::BlockPressures;

/// Pressures of blocks due to vibration and, where blocks squeeze air, due to that.
pub(super) struct Summed<'a> {
    pub pressures: &'a BlockPressures<'a>,
    pub squeezed: Option<&'a BlockPressures<'a>>,
}

impl Summed<'_> {
    /// Gives the sum of all parts at a receiver, block after block \[Pa\].
    pub(super) fn of(&self, receiver: usize, mut take: impl FnMut(&[f64])) {
        let Some(squeezed) = self.squeezed else { return self.pressures.of(receiver, take) };
        let mut sum = Vec::new();
        self.pressures.of(receiver, |block| sum.extend_from_slice(block));
        let mut from = 0;
        squeezed.of(receiver, |block| {
            let covered = &mut sum[from..from + block.len()];
            covered.iter_mut().zip(block).for_each(|(sum, more)| *sum += more);
            take(covered);
            from += block.len();
        });
    }
}
