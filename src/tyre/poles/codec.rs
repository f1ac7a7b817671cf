//! A model as bytes: little-endian 64-bit fields, counts first. Bits are kept: what is read is what was written.

use num_complex::Complex64;

use super::model::{FitStatistics, RationalModel};
use crate::tyre::influence::Field;

/// Fields of [`FitStatistics`] that are counts, then those that are numbers.
const COUNTS: usize = 5;
const NUMBERS: usize = 4;

/// The bytes of a model.
pub(super) fn encode(model: &RationalModel) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut count = |value: u64| bytes.extend_from_slice(&value.to_le_bytes());
    count(model.elements as u64);
    count(match model.driven {
        Field::Surface => 0,
        Field::Bottom => 1,
        Field::UnderTread => 2,
    });
    count(model.poles.len() as u64);
    for n in 0..model.statistics.len() {
        count(model.offsets[n + 1] as u64);
        count(model.first_real[n] as u64);
    }
    for entry in &model.statistics {
        count(entry.order as u64);
        count(entry.samples as u64);
        count(entry.fresh_samples as u64);
        count(entry.evaluations);
        count(entry.relocations as u64);
    }
    let mut number = |value: f64| bytes.extend_from_slice(&value.to_le_bytes());
    number(model.top);
    number(model.tolerance);
    for values in [&model.poles, &model.driven_residues, &model.bottom_residues] {
        for value in values {
            number(value.re);
            number(value.im);
        }
    }
    for [driven, bottom] in &model.constants {
        number(*driven);
        number(*bottom);
    }
    for entry in &model.statistics {
        number(entry.error);
        number(entry.real_axis_error);
        number(entry.bottom_error);
        number(entry.passivity);
    }
    bytes
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn field(&mut self) -> Option<[u8; 8]> {
        let (field, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        Some(*field)
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.field()?)).ok()
    }

    fn number(&mut self) -> Option<f64> {
        Some(f64::from_le_bytes(self.field()?))
    }

    fn complex(&mut self) -> Option<Complex64> {
        Some(Complex64::new(self.number()?, self.number()?))
    }
}

/// The model of some bytes; `None` if they do not make one.
pub(super) fn decode(bytes: &[u8]) -> Option<RationalModel> {
    let mut reader = Reader(bytes);
    let elements = reader.count()?;
    let driven = match reader.count()? {
        0 => Field::Surface,
        1 => Field::Bottom,
        2 => Field::UnderTread,
        _ => return None,
    };
    let poles = reader.count()?;
    let rows = (elements / 2).checked_add(1)?;
    // Everything that follows, in fields: no allocation is larger than the bytes that are there.
    let needed = rows.checked_mul(2 + COUNTS + 2 + NUMBERS)?.checked_add(poles.checked_mul(6)?)?.checked_add(2)?;
    if reader.0.len() != needed.checked_mul(8)? {
        return None;
    }
    let (mut offsets, mut first_real) = (vec![0], Vec::with_capacity(rows));
    for _ in 0..rows {
        let start = *offsets.last()?;
        let (end, real) = (reader.count()?, reader.count()?);
        if !(start <= real && real <= end && end <= poles) {
            return None;
        }
        offsets.push(end);
        first_real.push(real);
    }
    if *offsets.last()? != poles {
        return None;
    }
    let mut statistics = vec![FitStatistics::default(); rows];
    for entry in &mut statistics {
        entry.order = reader.count()?;
        entry.samples = reader.count()?;
        entry.fresh_samples = reader.count()?;
        entry.evaluations = reader.count()? as u64;
        entry.relocations = reader.count()?;
    }
    let (top, tolerance) = (reader.number()?, reader.number()?);
    let mut list = || (0..poles).map(|_| reader.complex()).collect::<Option<Vec<_>>>();
    let (poles, driven_residues, bottom_residues) = (list()?, list()?, list()?);
    let mut constants = vec![[0.0; 2]; rows];
    for entry in &mut constants {
        *entry = [reader.number()?, reader.number()?];
    }
    for entry in &mut statistics {
        entry.error = reader.number()?;
        entry.real_axis_error = reader.number()?;
        entry.bottom_error = reader.number()?;
        entry.passivity = reader.number()?;
    }
    Some(RationalModel {
        elements,
        driven,
        top,
        tolerance,
        offsets,
        first_real,
        poles,
        driven_residues,
        bottom_residues,
        constants,
        statistics,
    })
}
