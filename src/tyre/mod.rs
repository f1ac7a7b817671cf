//! The tyre: a layered elastic plate under tension, its compliance and its influence functions.
