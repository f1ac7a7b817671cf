//! Lists made on all threads, in their order.
//!
//! rayon's iterators are compiled anew, some hundred functions, wherever they are used. Here is one copy for all lists
//! whose items take so long that a call through a pointer and a place of their own do not count.

use std::iter::repeat_with;
use std::sync::OnceLock;

use rayon::prelude::*;

/// Maps every item, on all threads, in order.
pub(crate) fn map<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    made(items.len(), |index| of(&items[index]))
}

/// Returns `of`(0), `of`(1), ..., so many of them.
pub(crate) fn made<R: Send + Sync>(count: usize, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let places: Vec<OnceLock<R>> = repeat_with(OnceLock::new).take(count).collect();
    each(count, &|index| {
        // Nobody else has this place.
        let _ = places[index].set(of(index));
    });
    places.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// Does `of`(0), `of`(1), ..., in any order.
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
