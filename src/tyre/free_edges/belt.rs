//! A belt with free lateral edges: its layers, and the sidewalls that act at its edges.

use thiserror::Error;

use super::lateral_shapes::{LateralShapes, Parity};
use crate::scene::{Cavity, Tyre};
use crate::sidewall::{EdgeStatics, Sidewall};
use crate::tyre::layers::curved::CurvedStack;
use crate::tyre::layers::lateral_split::{LateralSplit, LayerPolynomials};

/// Truncation of the section's unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Largest lateral number M of the waves that meet the edges.
    pub waves: usize,
    /// Degree of the polynomials across each layer.
    pub degree: usize,
    /// Rates of the families of lifts times the thickness of the layers, the first of them 0.
    pub rates: &'static [f64],
}

impl Resolution {
    /// Truncation of runs.
    pub(super) const RUN: Self = Self { waves: 16, degree: 8, rates: &[0.0, 7.0, 42.0] };
    /// Truncation of reference values.
    pub(super) const FINE: Self = Self { waves: 48, degree: 12, rates: &[0.0, 5.0, 20.0, 80.0] };
}

/// Errors of a belt with free edges.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FreeEdgesError {
    /// The tyre is flat.
    #[error("free edges need a curved tyre: curvature = true")]
    Flat,
    /// Pressure acts on the belt's face, and no sidewall carries it at the edges.
    #[error("free edges under a pressure of {pressure} Pa need sidewalls as arcs, which act at the edges")]
    NoSidewalls {
        /// Inflation pressure \[Pa\].
        pressure: f64,
    },
    /// The sidewalls have no steady state.
    #[error("the sidewalls have no steady shape: a smaller angle, a lower speed or a higher pressure")]
    NoSteadyShape,
    /// The edge zones overlap, or have no length.
    #[error("the zone of {zone} m at each edge must be above 0 and below half the width of {width} m")]
    Zone {
        /// Zone at each edge \[m\].
        zone: f64,
        /// Width of the belt \[m\].
        width: f64,
    },
}

/// A belt with free lateral edges and sidewalls that act there.
#[derive(Debug)]
pub struct FreeEdges {
    pub(super) stack: CurvedStack,
    statics: Option<EdgeStatics>,
    polynomials: Vec<LayerPolynomials>,
    /// Even parity, then odd.
    shapes: [LateralShapes; 2],
}

impl FreeEdges {
    /// The belt of a curved tyre with sidewalls that act on a zone of a length \[m\] at each edge of its inner face.
    ///
    /// The sidewalls' pull across, R_i N_b sin a_b per radian, is borne by the layers in the proportion of their
    /// tension along, or by the stiffest one if none has any.
    pub fn new(tyre: &Tyre, edge_zone: f64) -> Result<Self, FreeEdgesError> {
        if !tyre.curvature {
            return Err(FreeEdgesError::Flat);
        }
        // The air moves with the edges here, not by a share of the width.
        let mut stack = CurvedStack { cavity: tyre.cavity, ..CurvedStack::new(tyre) };
        if let Some(sidewall) = &stack.sidewall {
            let statics = sidewall.edge().ok_or(FreeEdgesError::NoSteadyShape)?;
            let pull = stack.inner_radius() * statics.tension * statics.angle.sin();
            let (mut from, along) = (stack.inner_radius(), tyre.tension_along());
            let stiffest = tyre.stiffest_layer();
            for (index, layer) in stack.layers.iter_mut().enumerate() {
                let share = if along > 0.0 { layer.tension[0] / along } else { f64::from(u8::from(index == stiffest)) };
                layer.tension[1] += share * pull / (from + 0.5 * layer.thickness);
                from += layer.thickness;
            }
        }
        Self::of(stack, edge_zone, Resolution::RUN)
    }

    /// As [`Self::new`], of a stack whose tension includes that across.
    pub(super) fn of(stack: CurvedStack, edge_zone: f64, resolution: Resolution) -> Result<Self, FreeEdgesError> {
        let width = stack.width;
        if !(edge_zone > 0.0 && edge_zone < 0.5 * width) {
            return Err(FreeEdgesError::Zone { zone: edge_zone, width });
        }
        let statics = match &stack.sidewall {
            Some(sidewall) => Some(sidewall.edge().ok_or(FreeEdgesError::NoSteadyShape)?),
            None if stack.pressure.abs() > 0.0 => {
                return Err(FreeEdgesError::NoSidewalls { pressure: stack.pressure });
            }
            None => None,
        };
        let layers = stack.layers_by_radius();
        let polynomials = layers.map(|(layer, from)| LayerPolynomials::new(layer, from, resolution.degree)).collect();
        let thickness = stack.radius - stack.inner_radius();
        let rates: Vec<f64> = resolution.rates.iter().map(|rate| rate / thickness).collect();
        let shapes = [Parity::Even, Parity::Odd]
            .map(|parity| LateralShapes::new(parity, [width, edge_zone], resolution.waves, &rates));
        Ok(Self { stack, statics, polynomials, shapes })
    }

    /// A sidewall and its steady state at the edge.
    pub(super) fn sidewall(&self) -> Option<(&Sidewall, EdgeStatics)> {
        self.stack.sidewall.as_deref().zip(self.statics)
    }

    /// B_e/B: the part of a uniform pressure that the sidewalls leave to a belt on guided sides; 1 without them.
    pub(super) fn swept_share(&self) -> f64 {
        let width = self.stack.width;
        self.sidewall().and_then(|(sidewall, _)| sidewall.effective_width(width)).map_or(1.0, |part| part / width)
    }

    /// The same belt on guided sides, its sidewalls spread over the width.
    pub(super) fn guided(&self) -> CurvedStack {
        let share = self.swept_share();
        let cavity = self.stack.cavity.map(|cavity| Cavity { density: cavity.density * share * share, ..cavity });
        CurvedStack { cavity, ..self.stack.clone() }
    }

    /// Mass per width and radian, sum of rho h r \[kg/m\].
    pub(super) fn mass(&self) -> f64 {
        let layers = self.stack.layers_by_radius();
        layers.map(|(layer, from)| layer.material.density * layer.thickness * (from + 0.5 * layer.thickness)).sum()
    }

    /// Energy of the layers in motion of n periods round the tyre.
    pub(super) fn layers(&self, n: i64) -> Vec<LateralSplit> {
        let layers = self.stack.layers.iter().zip(&self.polynomials);
        let split =
            layers.map(|(layer, polynomials)| LateralSplit::new(layer, polynomials, &self.stack.rotation, n as f64));
        split.collect()
    }

    pub(super) fn shapes(&self, parity: Parity) -> &LateralShapes {
        let [even, odd] = &self.shapes;
        match parity {
            Parity::Even => even,
            Parity::Odd => odd,
        }
    }
}
