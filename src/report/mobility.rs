//! The mobility of patches of the tread in a picture (Larsson's figure 2).

use num_complex::Complex64;

use crate::results::plots::{Axis, LinePlot, Series};
use crate::tyre::influence::mobility::{Mobility, level};

/// Title of the axis, and value of a mobility on it.
pub(crate) type Quantity = (&'static str, fn(Complex64) -> f64);

/// Level of the mobility.
pub(crate) const LEVEL: Quantity = ("Driving-point mobility [dB re 1 m/(N s)]", level);

/// Picture with a curve for each patch.
pub(crate) fn plot<'a>(
    mobility: &Mobility,
    title: &'a str,
    names: &'a [String],
    (quantity, shown): Quantity,
) -> LinePlot<'a> {
    let curves = names.iter().enumerate().map(|(column, name)| Series {
        name,
        points: mobility.frequencies.iter().zip(&mobility.values).map(|(&f, row)| (f, shown(row[column]))).collect(),
    });
    let values = mobility.values.iter().flatten().map(|&value| shown(value));
    LinePlot {
        title,
        x: Axis::logarithmic_around("Frequency [Hz]", mobility.frequencies.iter().copied(), [1.0, 1.0]),
        y: Axis::linear_around(quantity, values),
        series: curves.collect(),
    }
}
