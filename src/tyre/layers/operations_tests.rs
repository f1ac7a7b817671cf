//! Floating-point operations of one evaluation, counted by running the kernel on numbers that count.

use std::cell::Cell;
use std::ops::{Add, Mul, Neg, Sub};

use super::*;
use crate::test_models::tyre;

thread_local!(static COUNT: Cell<u64> = const { Cell::new(0) });

#[derive(Clone, Copy, Debug)]
struct Counted(Complex64);

fn counted(operations: u64, value: Complex64) -> Counted {
    COUNT.set(COUNT.get() + operations);
    Counted(value)
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        counted(2, self.0 + other.0)
    }
}
impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        counted(2, self.0 - other.0)
    }
}
impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        counted(6, self.0 * other.0)
    }
}
impl Mul<f64> for Counted {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        counted(2, self.0 * factor)
    }
}
impl Add<f64> for Counted {
    type Output = Self;
    fn add(self, term: f64) -> Self {
        counted(1, self.0 + term)
    }
}
impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
impl ComplexField for Counted {
    fn like(self, value: f64) -> Self {
        Self(value.into())
    }
    fn plus_scaled(self, factor: f64, z: Self) -> Self {
        counted(4, self.0 + z.0 * factor)
    }
    fn times_i(self) -> Self {
        Self(Complex64::i() * self.0)
    }
    fn reciprocal(self) -> Self {
        counted(6, self.0.inv())
    }
    fn square_root(self) -> Self {
        counted(8, self.0.sqrt())
    }
    fn exponential(self) -> Self {
        counted(34 + 40 + 2, self.0.exp())
    }
    fn gathered(self, mut value: impl FnMut(usize) -> Complex64) -> Self {
        Self(value(0))
    }
    fn select_below(self, limit: f64, small: Self, large: Self) -> Self {
        counted(3, self.0.select_below(limit, small.0, large.0))
    }
    fn outlined<R>(self, part: impl FnOnce() -> R) -> R {
        part()
    }
}

/// Operations with the tread on `below` belts.
fn counted_operations(below: usize) -> u64 {
    let tyre = tyre(0.25);
    let mut layers = vec![tyre.layers[0].clone(); below];
    layers.push(tyre.layers[1].clone());
    let at = Stack::of(layers, tyre.foundation).at(Complex64::new(100.0, 6000.0));
    let counting = StackAt {
        layers: at
            .layers
            .iter()
            .map(|layer| LayerAt {
                thickness: layer.thickness,
                shear: Counted(layer.shear),
                inverse_shear: Counted(layer.inverse_shear),
                modulus_ratio: layer.modulus_ratio,
                inertia: Counted(layer.inertia),
                prestress: layer.prestress,
            })
            .collect(),
        foundation: at.foundation.map(Counted),
        anisotropic: None,
    };
    COUNT.set(0);
    let pass = |layer: &LayerAt<Counted>, exponents: &Exponents<Counted>, under| {
        layer.p_sv(exponents, LayerMethod::Thick, under)
    };
    let value = counting.p_sv(300.0, 500.0, false, pass).0.normal().surface.0;
    let exact = at.normal(300.0, 500.0).surface;
    assert!((value - exact).norm() < 1e-10 * exact.norm());
    COUNT.get()
}

#[test]
fn operations_of_an_evaluation_are_those_stated() {
    let counts = [0, 1, 2, 3].map(counted_operations);
    assert_eq!(counts[0], operations(1), "{counts:?}");
    assert_eq!(counts[2] - counts[1], operations(3) - operations(2), "{counts:?}");
    assert_eq!(counts[3] - counts[2], operations(4) - operations(3), "{counts:?}");
}
