//! Surface of the undeformed tread across each column: its crown, and the depths of a pattern.

use crate::tyre::tread_pattern::map::TreadMap;

/// Depths of the tread's cells below the middle of its uncut surface.
#[derive(Clone, Debug)]
pub(crate) struct TreadSurface {
    /// By cell across, the same all round \[m\].
    crown: Vec<f64>,
    /// By cell round the tyre; empty without a pattern \[m\].
    all_round: Vec<f64>,
}

impl From<Vec<f64>> for TreadSurface {
    fn from(crown: Vec<f64>) -> Self {
        Self { crown, all_round: Vec::new() }
    }
}

impl TreadSurface {
    /// Surface of a crown \[m\] with the depths of a pattern added.
    pub(crate) fn with_pattern(crown: Vec<f64>, map: &TreadMap) -> Self {
        let of = |(cell, depth): (usize, &f64)| crown[cell % crown.len()] + depth;
        let all_round = map.depths.iter().enumerate().map(of).collect();
        Self { crown, all_round }
    }

    pub(crate) fn across(&self) -> usize {
        self.crown.len()
    }

    /// Depths across at the number of an element \[m\]; a pattern repeats with every revolution.
    pub(crate) fn row(&self, element: i64) -> &[f64] {
        let across = self.across();
        match self.all_round.len() / across {
            0 => &self.crown,
            columns => &self.all_round[element.rem_euclid(columns as i64) as usize * across..][..across],
        }
    }
}
