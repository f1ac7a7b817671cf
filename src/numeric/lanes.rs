//! Several complex numbers in lockstep: [`ComplexField`] in structure-of-arrays form over `pulp`'s vectors.
//!
//! As many lanes as the processor's vectors hold doubles (8 with AVX-512, 4 with AVX2). exp, sin and cos are written
//! out, range reduction after Cody & Waite, polynomials of fdlibm, because a library call would end the vectorisation;
//! errors stay below 2 units in the last place for |Im| < 1e5. Explicit vector operations, because plain loops over
//! eight lanes were measured not to vectorise in a function of this size.

use std::ops::{Add, Mul, Neg, Sub};

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::ComplexField;

/// Most lanes that any instruction set has.
pub(crate) const MOST_LANES: usize = 8;

/// `S::F64_LANES` complex numbers.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    /// Real parts.
    pub re: S::f64s,
    /// Imaginary parts.
    pub im: S::f64s,
}

/// Runs the work with the widest vectors that the processor has. Not inlined: such work is long, and every caller
/// would have a copy.
#[inline(never)]
pub(crate) fn dispatch<W: WithSimd>(work: W) -> W::Output {
    Arch::new().dispatch(work)
}

/// Carries out a long part of a dispatched work as a function that all callers share: inlined, each would have a copy
/// for every set of instructions. The call takes some nanoseconds.
#[inline(never)]
pub(crate) fn outlined<S: Simd, R>(simd: S, part: impl FnOnce() -> R) -> R {
    simd.vectorize(part)
}

/// Loads the first `S::F64_LANES` numbers into a vector.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, values: &[f64; MOST_LANES]) -> S::f64s {
    simd.partial_load_f64s(&values[..S::F64_LANES])
}

/// -x, zeros included: as a subtraction from -0, which the compiler knows for a change of sign; pulp's negation it
/// does not.
#[inline(always)]
fn negated<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    simd.sub_f64s(simd.splat_f64s(-0.0), x)
}

/// |x|, by clearing the sign bit.
#[inline(always)]
fn absolute<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    simd.and_f64s(x, simd.splat_f64s(f64::from_bits(!f64::to_bits(-0.0))))
}

/// The numbers of a vector; zeros past its lanes.
#[inline(always)]
pub(crate) fn store<S: Simd>(simd: S, vector: S::f64s) -> [f64; MOST_LANES] {
    let mut values = [0.0; MOST_LANES];
    simd.partial_store_f64s(&mut values[..S::F64_LANES], vector);
    values
}

impl<S: Simd> Lanes<S> {
    /// The numbers `value`(0), `value`(1), ..., one per lane.
    #[inline(always)]
    pub fn from_fn(simd: S, mut value: impl FnMut(usize) -> Complex64) -> Self {
        let (mut re, mut im) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
        for lane in 0..S::F64_LANES {
            let value = value(lane);
            (re[lane], im[lane]) = (value.re, value.im);
        }
        Self { simd, re: load(simd, &re), im: load(simd, &im) }
    }

    /// Zero in all lanes.
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        Self { simd, re: simd.splat_f64s(0.0), im: simd.splat_f64s(0.0) }
    }

    /// The numbers of the lanes; zeros past them.
    #[inline(always)]
    pub fn to_array(self) -> [Complex64; MOST_LANES] {
        let (re, im) = (store(self.simd, self.re), store(self.simd, self.im));
        std::array::from_fn(|lane| Complex64::new(re[lane], im[lane]))
    }

    /// |z|^2, lane by lane.
    #[inline(always)]
    pub fn norm_squared(&self) -> S::f64s {
        self.simd.mul_add_e_f64s(self.re, self.re, self.simd.mul_f64s(self.im, self.im))
    }

    /// self + weight z, one real weight per lane.
    #[inline(always)]
    pub fn plus_weighted(self, weight: S::f64s, z: Self) -> Self {
        let simd = self.simd;
        Self { simd, re: simd.mul_add_e_f64s(weight, z.re, self.re), im: simd.mul_add_e_f64s(weight, z.im, self.im) }
    }

    /// `yes` where the mask is set, `no` elsewhere.
    #[inline(always)]
    pub fn blend(mask: S::m64s, yes: Self, no: Self) -> Self {
        let simd = yes.simd;
        Self { simd, re: simd.select_f64s(mask, yes.re, no.re), im: simd.select_f64s(mask, yes.im, no.im) }
    }

    /// Instruction set of these lanes.
    #[inline(always)]
    pub fn simd(&self) -> S {
        self.simd
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let simd = self.simd;
        Self { simd, re: simd.add_f64s(self.re, other.re), im: simd.add_f64s(self.im, other.im) }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let simd = self.simd;
        Self { simd, re: simd.sub_f64s(self.re, other.re), im: simd.sub_f64s(self.im, other.im) }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let simd = self.simd;
        let cross = simd.mul_f64s(self.im, other.im);
        let re = simd.mul_add_e_f64s(self.re, other.re, negated(simd, cross));
        let im = simd.mul_add_e_f64s(self.re, other.im, simd.mul_f64s(self.im, other.re));
        Self { simd, re, im }
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let simd = self.simd;
        let factor = simd.splat_f64s(factor);
        Self { simd, re: simd.mul_f64s(self.re, factor), im: simd.mul_f64s(self.im, factor) }
    }
}

impl<S: Simd> Add<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, term: f64) -> Self {
        let simd = self.simd;
        Self { simd, re: simd.add_f64s(self.re, simd.splat_f64s(term)), im: self.im }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        let simd = self.simd;
        Self { simd, re: negated(simd, self.re), im: negated(simd, self.im) }
    }
}

/// 1.5 2^52: adding it rounds to the nearest integer, which then stands in the low bits.
const ROUND: f64 = 6755399441055744.0;
/// ln 2 in two parts; the first has 32 trailing zero bits.
const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// pi/2 in three parts of 33 bits.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// 1/j!, j = 13, ..., 0: exp(r) for |r| < 0.347 to 3e-18.
const EXPONENTIAL: [f64; 14] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];
/// fdlibm's __kernel_sin: (sin r - r)/r^3 in r^2, highest power first.
const SINE: [f64; 6] = [
    1.589_690_995_211_55e-10,
    -2.505_076_025_340_686_3e-8,
    2.755_731_370_707_006_8e-6,
    -1.984_126_982_985_795e-4,
    8.333_333_333_322_49e-3,
    -1.666_666_666_666_663_2e-1,
];
/// fdlibm's __kernel_cos: (cos r - 1 + r^2/2)/r^4 in r^2, highest power first.
const COSINE: [f64; 6] = [
    -1.135_964_755_778_819_5e-11,
    2.087_572_321_298_175e-9,
    -2.755_731_435_139_066_3e-7,
    2.480_158_728_947_673e-5,
    -1.388_888_888_887_411e-3,
    4.166_666_666_666_66e-2,
];

#[inline(always)]
fn polynomial<S: Simd, const N: usize>(simd: S, coefficients: &[f64; N], x: S::f64s) -> S::f64s {
    let mut sum = simd.splat_f64s(coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = simd.mul_add_e_f64s(sum, x, simd.splat_f64s(coefficient));
    }
    sum
}

/// exp(x) for x up to 709; below -708 it stays at 3e-308.
#[inline(always)]
fn exp<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let x = simd.max_f64s(x, simd.splat_f64s(-708.0));
    // x = n ln 2 + r, |r| <= ln(2)/2; n is subtracted in two parts so that r keeps its digits.
    let shifted = simd.mul_add_e_f64s(x, simd.splat_f64s(std::f64::consts::LOG2_E), simd.splat_f64s(ROUND));
    let n = simd.sub_f64s(shifted, simd.splat_f64s(ROUND));
    let r = simd.mul_add_e_f64s(n, simd.splat_f64s(-LN2[0]), x);
    let r = simd.mul_add_e_f64s(n, simd.splat_f64s(-LN2[1]), r);
    let sum = polynomial(simd, &EXPONENTIAL, r);
    // 2^n by its exponent bits; n sits in the low bits of the shifted number.
    let mut powers = store(simd, shifted);
    for power in &mut powers {
        *power = f64::from_bits(power.to_bits().wrapping_add(1023) << 52);
    }
    simd.mul_f64s(sum, load(simd, &powers))
}

/// (cos x, sin x) for |x| < 1e5.
#[inline(always)]
pub(crate) fn cos_sin<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    // 1. x = n pi/2 + r, |r| <= pi/4.
    let shifted = simd.mul_add_e_f64s(x, simd.splat_f64s(std::f64::consts::FRAC_2_PI), simd.splat_f64s(ROUND));
    let n = simd.sub_f64s(shifted, simd.splat_f64s(ROUND));
    let mut r = x;
    for part in HALF_PI {
        r = simd.mul_add_e_f64s(n, simd.splat_f64s(-part), r);
    }
    // 2. Sine and cosine of r.
    let z = simd.mul_f64s(r, r);
    let sine = simd.mul_add_e_f64s(simd.mul_f64s(r, z), polynomial(simd, &SINE, z), r);
    let quartic = simd.mul_f64s(simd.mul_f64s(z, z), polynomial(simd, &COSINE, z));
    let half = simd.mul_f64s(simd.splat_f64s(0.5), z);
    let cosine = simd.add_f64s(simd.sub_f64s(simd.splat_f64s(1.0), half), quartic);
    // 3. n mod 4 decides which of the two is which, and the signs.
    let quadrant = simd.transmute_u64s_f64s(shifted);
    let bit =
        |value: S::u64s, mask: u64| simd.equal_u64s(simd.and_u64s(value, simd.splat_u64s(mask)), simd.splat_u64s(0));
    let even = bit(quadrant, 1);
    let (c, s) = (simd.select_f64s(even, cosine, sine), simd.select_f64s(even, sine, cosine));
    let next = simd.add_u64s(quadrant, simd.splat_u64s(1));
    (simd.select_f64s(bit(next, 2), c, negated(simd, c)), simd.select_f64s(bit(quadrant, 2), s, negated(simd, s)))
}

impl<S: Simd> ComplexField for Lanes<S> {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        let simd = self.simd;
        Self { simd, re: simd.splat_f64s(value), im: simd.splat_f64s(0.0) }
    }

    #[inline(always)]
    fn plus_scaled(self, factor: f64, z: Self) -> Self {
        self.plus_weighted(self.simd.splat_f64s(factor), z)
    }

    #[inline(always)]
    fn times_i(self) -> Self {
        Self { simd: self.simd, re: negated(self.simd, self.im), im: self.re }
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        let simd = self.simd;
        let scale = simd.div_f64s(simd.splat_f64s(1.0), self.norm_squared());
        Self { simd, re: simd.mul_f64s(self.re, scale), im: negated(simd, simd.mul_f64s(self.im, scale)) }
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        let simd = self.simd;
        let (zero, half) = (simd.splat_f64s(0.0), simd.splat_f64s(0.5));
        let size = simd.add_f64s(absolute(simd, self.re), simd.sqrt_f64s(self.norm_squared()));
        let large = simd.sqrt_f64s(simd.mul_f64s(half, size));
        // The divisor keeps z = 0 from 0/0.
        // Re z >= 0: root = (large, small); else the two change places, the sign of Im z on the imaginary part.
        let divisor = simd.max_f64s(large, simd.splat_f64s(f64::MIN_POSITIVE));
        let small = simd.div_f64s(simd.mul_f64s(half, self.im), divisor);
        let right = simd.greater_than_or_equal_f64s(self.re, zero);
        let sign = simd.and_f64s(self.im, simd.splat_f64s(-0.0));
        Self {
            simd,
            re: simd.select_f64s(right, large, absolute(simd, small)),
            im: simd.select_f64s(right, small, simd.or_f64s(large, sign)),
        }
    }

    #[inline(always)]
    fn exponential(self) -> Self {
        let simd = self.simd;
        let size = exp(simd, self.re);
        let (cosine, sine) = cos_sin(simd, self.im);
        Self { simd, re: simd.mul_f64s(size, cosine), im: simd.mul_f64s(size, sine) }
    }

    #[inline(always)]
    fn gathered(self, value: impl FnMut(usize) -> Complex64) -> Self {
        Self::from_fn(self.simd, value)
    }

    #[inline(always)]
    fn select_below(self, limit: f64, small: Self, large: Self) -> Self {
        let simd = self.simd;
        let mask = simd.less_than_f64s(self.norm_squared(), simd.splat_f64s(limit));
        Self::blend(mask, small, large)
    }

    #[inline(always)]
    fn outlined<R>(self, part: impl FnOnce() -> R) -> R {
        outlined(self.simd, part)
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::*;

    /// exp, square root, reciprocal of each number, through lanes.
    struct Functions<'a>(&'a [Complex64]);

    impl WithSimd for Functions<'_> {
        type Output = Vec<[Complex64; 3]>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut results = Vec::new();
            for chunk in self.0.chunks(S::F64_LANES) {
                let lanes = Lanes::from_fn(simd, |lane| chunk[lane.min(chunk.len() - 1)]);
                let (a, b, c) =
                    (lanes.exponential().to_array(), lanes.square_root().to_array(), lanes.reciprocal().to_array());
                results.extend((0..chunk.len()).map(|lane| [a[lane], b[lane], c[lane]]));
            }
            results
        }
    }

    #[test]
    fn functions_agree_with_the_scalar_ones_to_rounding() {
        let numbers: Vec<_> = (0..30_000)
            .map(|step| {
                let t = f64::from(step);
                let re = -(t * 0.731).sin().abs() * 10f64.powf((t * 0.37).sin() * 2.5);
                Complex64::new(re, (t * 0.917).cos() * 10f64.powf((t * 0.21).cos() * 4.5))
            })
            .collect();
        let results = Arch::new().dispatch(Functions(&numbers));
        assert_eq!(results.len(), numbers.len());
        for (&z, [exponential, root, inverse]) in numbers.iter().zip(results) {
            let close = |a: Complex64, b: Complex64, bound: f64| {
                assert!((a - b).norm() <= bound * b.norm(), "{z}: {a} {b}");
            };
            // The argument itself is rounded: its last place times its size.
            close(exponential, z.exp(), 6e-16 + 1.2e-16 * z.norm());
            close(root, z.sqrt(), 6e-16);
            close(inverse, z.inv(), 6e-16);
        }
    }

    #[test]
    fn quadrants_signs_and_the_branch_cut_are_right() {
        let mut numbers: Vec<_> = [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6]
            .into_iter()
            .flat_map(|x| [x, -x, x + 100.0 * std::f64::consts::TAU])
            .map(|x| Complex64::new(0.0, x))
            .collect();
        numbers.extend([Complex64::new(-4.0, 0.0), Complex64::new(-4.0, -0.0), Complex64::new(-5000.0, 0.0)]);
        let results = Arch::new().dispatch(Functions(&numbers));
        for (z, [exponential, ..]) in numbers.iter().zip(&results).take(24) {
            assert!((exponential.re - z.im.cos()).abs() < 4e-16 && (exponential.im - z.im.sin()).abs() < 4e-16, "{z}");
        }
        assert_eq!(results[0][1], Complex64::ZERO);
        assert_eq!(results[24][1], Complex64::new(0.0, 2.0));
        assert_eq!(results[25][1], Complex64::new(0.0, -2.0));
        assert!(results[26][0].re < 1e-300);
    }
}
