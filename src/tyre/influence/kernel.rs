//! The compliance kernel: C and D of a wave of n periods round the tyre and of the lateral number m, at s.
//!
//! Whatever sums over waves asks here, and nowhere else, how the tyre answers one. The tyre is a flat layered plate,
//! periodic along x and simply supported at both sides: the wave (n, m) is exp(i kx x) sin(ky y) with kx = 2 pi n/L and
//! ky = m pi/B, answered by the [`Stack`] at (kx, ky, s), and of the m a centred strip excites the odd ones.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::Simd;
use serde::{Deserialize, Serialize};

use crate::numeric::{Lanes, MOST_LANES};
use crate::scene::{Layer, Tyre};
use crate::tyre::layers::compliance::{Matrix3, NormalCompliance, Stack, StackAt};
use crate::tyre::layers::lane_compliance::LaneStack;
use crate::tyre::layers::layer::LayerAt;

/// Which displacement a force on the tread element is related to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// The tread surface.
    Surface,
    /// The innermost face, force on the surface.
    Bottom,
    /// The carcass driven directly under the outermost layer, which rides along as mass: what the springs of a bedding
    /// act on.
    UnderTread,
}

/// The wavenumbers of the plate's waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Circumference L \[m\].
    pub circumference: f64,
    /// Plate width B \[m\].
    pub width: f64,
}

impl Waves {
    /// Those of a tyre.
    pub fn new(tyre: &Tyre) -> Self {
        Self { circumference: tyre.circumference, width: tyre.width }
    }

    /// kx of the integer wavenumber n \[1/m\].
    pub fn kx(&self, n: i64) -> f64 {
        2.0 * PI * n as f64 / self.circumference
    }

    /// ky of the lateral number m \[1/m\].
    pub fn ky(&self, m: usize) -> f64 {
        PI * m as f64 / self.width
    }

    /// The lateral numbers that a centred strip excites, from the lowest on.
    pub fn lateral_numbers() -> impl Iterator<Item = usize> {
        (1..).step_by(2)
    }
}

/// The kernel of a tyre.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    stack: Stack,
    waves: Waves,
}

/// The kernel at one s.
#[derive(Clone, Debug)]
pub(crate) struct KernelAt {
    stack: StackAt,
    waves: Waves,
}

impl Kernel {
    pub(crate) fn new(tyre: &Tyre) -> Self {
        Self { stack: Stack::new(tyre), waves: Waves::new(tyre) }
    }

    /// The outermost layer, if short waves feel it as a half-space: a layer under tension has no such limit.
    pub(super) fn tread(&self) -> Option<&Layer> {
        self.stack.layers().last().filter(|tread| !tread.is_tense())
    }

    /// At s \[1/s\].
    pub(crate) fn at(&self, s: Complex64) -> KernelAt {
        KernelAt { stack: self.stack.at(s), waves: self.waves }
    }
}

impl KernelAt {
    /// The outermost layer.
    pub(crate) fn tread(&self) -> &LayerAt<Complex64> {
        self.stack.tread()
    }

    /// C or D of a wave for normal traction \[m/Pa\].
    pub(super) fn normal(&self, n: i64, m: usize, field: Field) -> Complex64 {
        let (kx, ky) = (self.waves.kx(n), self.waves.ky(m));
        match field {
            Field::Surface => self.stack.normal(kx, ky).surface,
            Field::Bottom => self.stack.normal(kx, ky).bottom,
            Field::UnderTread => self.stack.under_tread(kx, ky),
        }
    }

    /// C_xz of a wave: displacement of the surface along x for normal traction \[m/Pa\].
    pub(crate) fn tangential(&self, n: i64, m: usize) -> Complex64 {
        self.stack.tangential(self.waves.kx(n), self.waves.ky(m))
    }

    /// C of a wave for all tractions \[m/Pa\]; order circumferential, lateral, outward.
    pub(crate) fn full(&self, n: i64, m: usize) -> Matrix3 {
        self.stack.full(self.waves.kx(n), self.waves.ky(m)).0
    }
}

/// The kernel at several s in lockstep.
pub(super) struct LaneKernel<'a, S: Simd> {
    stack: LaneStack<'a, S>,
    waves: Waves,
}

impl<'a, S: Simd> LaneKernel<'a, S> {
    /// Puts kernels of the same tyre side by side.
    pub(super) fn new(simd: S, kernels: [&'a KernelAt; MOST_LANES]) -> Self {
        Self { stack: LaneStack::new(simd, kernels.map(|kernel| &kernel.stack)), waves: kernels[0].waves }
    }

    /// C and D of a wave for normal traction \[m/Pa\].
    #[inline(always)]
    pub(super) fn normal(&self, n: i64, m: usize) -> NormalCompliance<Lanes<S>> {
        self.stack.normal(self.waves.kx(n), self.waves.ky(m))
    }
}
