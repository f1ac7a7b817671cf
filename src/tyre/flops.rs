//! Floating-point operations of one compliance evaluation, counted by running the kernel on numbers that count.

/// Real additions, multiplications, divisions and square roots of one evaluation for normal traction, both faces: of a
/// stack with one layer, and of every further one, where k h is so large that the layer's waves are taken
/// ([`thick`](super::layer::Way::Thick)); exp as 34, sin and cos together as 40, a complex square root as 8. The test
/// counts them.
pub const FIRST_LAYER: u64 = 1260;
/// See [`FIRST_LAYER`].
pub const FURTHER_LAYER: u64 = 1160;

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::{Add, Mul, Neg, Sub};

    use num_complex::Complex64;

    use super::super::compliance::{Stack, climb};
    use super::super::layer::{LayerAt, Way};
    use super::*;
    use crate::numeric::ComplexField;
    use crate::test_models::tyre;
    use crate::tyre::matrix2::Matrix2;

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
        fn reciprocal(self) -> Self {
            counted(6, self.0.inv())
        }
        fn square_root(self) -> Self {
            counted(8, self.0.sqrt())
        }
        fn exponential(self) -> Self {
            counted(34 + 40 + 2, self.0.exp())
        }
        fn select_below(self, limit: f64, small: Self, large: Self) -> Self {
            counted(3, self.0.select_below(limit, small.0, large.0))
        }
    }

    /// Operations with the tread put on `below` belts, and the surface compliance.
    fn operations(below: usize) -> (u64, Complex64) {
        let tyre = tyre(0.25);
        let mut layers = vec![tyre.layers[0].clone(); below];
        layers.push(tyre.layers[1].clone());
        let at = Stack::of(layers, tyre.foundation).at(Complex64::new(100.0, 6000.0));
        let layers: Vec<LayerAt<Counted>> = at
            .layers()
            .iter()
            .map(|layer| LayerAt {
                thickness: layer.thickness,
                shear: Counted(layer.shear),
                inverse_shear: Counted(layer.inverse_shear),
                modulus_ratio: layer.modulus_ratio,
                inertia: Counted(layer.inertia),
                prestress: layer.prestress,
            })
            .collect();
        COUNT.set(0);
        let [tangential, normal] = at.foundation().map(Counted);
        let foundation = Matrix2::diagonal(tangential, normal);
        let (top, transfer) = climb(&layers, foundation, 300.0, 500.0, |layer, exponents, under| {
            layer.p_sv(exponents, Way::Thick, under)
        })
        .expect("there are layers");
        let surface = top.displacement.over(top.traction);
        let _ = transfer * surface;
        let exact = at.normal(300.0, 500.0).surface;
        let value = surface.0[1][1].0;
        assert!((value - exact).norm() < 1e-10 * exact.norm());
        (COUNT.get(), value)
    }

    #[test]
    fn operations_of_an_evaluation_are_those_stated() {
        let counts = [operations(0).0, operations(1).0, operations(2).0, operations(3).0];
        assert_eq!(counts[0], FIRST_LAYER, "{counts:?}");
        assert_eq!(counts[2] - counts[1], FURTHER_LAYER, "{counts:?}");
        assert_eq!(counts[3] - counts[2], FURTHER_LAYER, "{counts:?}");
    }
}
