//! Single and double precision behind one name, side by side in the processor's vectors.

use pulp::Simd;

/// A floating-point number of which a SIMD vector holds several.
pub trait Element: Copy + Default + Send + Sync + 'static {
    /// Numbers in the widest vector of any instruction set (64 bytes).
    const MOST_LANES: usize;
    /// Distance from 1 to the next number.
    const EPSILON: f64;
    /// SIMD vector of such numbers.
    type Vector<S: Simd>: Copy;

    /// Rounds from double precision.
    fn rounded(value: f64) -> Self;
    /// The number in double precision, exactly.
    fn double(self) -> f64;
    /// Whole vectors of the numbers; a remainder that does not fill one is left out.
    fn vectors<S: Simd>(values: &[Self]) -> &[Self::Vector<S>];
    /// As [`Element::vectors`], for writing.
    fn vectors_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Vector<S>];
    /// The first numbers as a vector, filled up with zeros.
    fn load<S: Simd>(simd: S, values: &[Self]) -> Self::Vector<S>;
    /// Stores as many numbers of a vector as fit.
    fn store<S: Simd>(simd: S, values: &mut [Self], vector: Self::Vector<S>);
    /// The same number in all lanes.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;
    /// a + b.
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a - b.
    fn sub<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b.
    fn mul<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b + c, fused where the processor can.
    fn mul_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;
    /// c - a b, fused where the processor can.
    fn negate_mul_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;
    /// -a.
    fn neg<S: Simd>(simd: S, a: Self::Vector<S>) -> Self::Vector<S>;

    /// Numbers per vector of this instruction set.
    #[inline(always)]
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Vector<S>>() / size_of::<Self>()
    }
}

macro_rules! element {
    ($number:ty, $vector:ident, $round:expr, $as:ident, $as_mut:ident, $load:ident, $store:ident, $splat:ident,
     $add:ident, $sub:ident, $mul:ident, $mul_add:ident, $negate_mul_add:ident, $neg:ident) => {
        impl Element for $number {
            const MOST_LANES: usize = 64 / size_of::<Self>();
            const EPSILON: f64 = Self::EPSILON as f64;
            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn rounded(value: f64) -> Self {
                $round(value)
            }
            #[inline(always)]
            fn double(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn vectors<S: Simd>(values: &[Self]) -> &[S::$vector] {
                S::$as(values).0
            }
            #[inline(always)]
            fn vectors_mut<S: Simd>(values: &mut [Self]) -> &mut [S::$vector] {
                S::$as_mut(values).0
            }
            #[inline(always)]
            fn load<S: Simd>(simd: S, values: &[Self]) -> S::$vector {
                // The call for a part of a vector is not inlined.
                match Self::vectors::<S>(values) {
                    [whole, ..] => *whole,
                    [] => simd.$load(values),
                }
            }
            #[inline(always)]
            fn store<S: Simd>(simd: S, values: &mut [Self], vector: S::$vector) {
                if values.len() < Self::lanes::<S>() {
                    simd.$store(values, vector);
                } else if let Some(whole) = Self::vectors_mut::<S>(values).first_mut() {
                    *whole = vector;
                }
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$vector {
                simd.$splat(value)
            }
            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$mul_add(a, b, c)
            }
            #[inline(always)]
            fn negate_mul_add<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$negate_mul_add(a, b, c)
            }
            #[inline(always)]
            fn neg<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$neg(a)
            }
        }
    };
}

element!(
    f64,
    f64s,
    |value| value,
    as_simd_f64s,
    as_mut_simd_f64s,
    partial_load_f64s,
    partial_store_f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    mul_add_e_f64s,
    negate_mul_add_e_f64s,
    neg_f64s
);
element!(
    f32,
    f32s,
    |value| value as f32,
    as_simd_f32s,
    as_mut_simd_f32s,
    partial_load_f32s,
    partial_store_f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    mul_add_e_f32s,
    negate_mul_add_e_f32s,
    neg_f32s
);
