//! Lists computed on all threads, in order.
//!
//! rayon's iterators are compiled anew, some hundred functions, wherever they are used. Here is one copy for all lists
//! whose items take so long that a call through a pointer and a cell per item do not count.

use std::iter::repeat_with;
use std::sync::OnceLock;

use rayon::prelude::*;

/// Maps every item, on all threads; results in the order of the items.
pub(crate) fn map<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    made(items.len(), |index| of(&items[index]))
}

/// `of`(0), ..., `of`(`count` - 1), computed on all threads.
pub(crate) fn made<R: Send + Sync>(count: usize, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let places: Vec<OnceLock<R>> = repeat_with(OnceLock::new).take(count).collect();
    each(count, &|index| {
        // Each index is visited once: the cell is empty.
        let _ = places[index].set(of(index));
    });
    places.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// Calls `of`(0), ..., `of`(`count` - 1), on all threads, in any order.
pub(crate) fn each(count: usize, of: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(of);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_their_order_on_any_number_of_threads() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let squares = pool.install(|| made(1000, |index| index * index));
            assert!(squares.iter().enumerate().all(|(index, square)| *square == index * index));
            assert_eq!(pool.install(|| map(&squares[..3], |square| square + 1)), [1, 2, 5]);
        }
        assert!(made(0, |index| index).is_empty());
    }
}
