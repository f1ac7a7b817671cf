//! Plan and run: the only place that knows the whole order.
