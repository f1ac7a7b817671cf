//! Loads that load indices stand for.

/// First and last index of car tyres.
pub(crate) const OF_CARS: [u16; 2] = [60, 126];
/// Loads of these indices (ISO 4000-1, rounded to a series of preferred numbers) \[kg\].
const LOADS: [u16; 67] = [
    250, 257, 265, 272, 280, 290, 300, 307, 315, 325, 335, 345, 355, 365, 375, 387, 400, 412, 425, 437, 450, 462, 475,
    487, 500, 515, 530, 545, 560, 580, 600, 615, 630, 650, 670, 690, 710, 730, 750, 775, 800, 825, 850, 875, 900, 925,
    950, 975, 1000, 1030, 1060, 1090, 1120, 1150, 1180, 1215, 1250, 1285, 1320, 1360, 1400, 1450, 1500, 1550, 1600,
    1650, 1700,
];

/// Load of a car tyre's index \[kg\]; `None` for other indices.
pub(crate) fn load_of_car(index: u16) -> Option<u16> {
    LOADS.get(usize::from(index.checked_sub(OF_CARS[0])?)).copied()
}

/// Load of any index \[kg\]: beyond those of cars 45 kg, ten times as much every 80, which is within 2 % of the table.
pub(crate) fn load_of(index: u16) -> f64 {
    load_of_car(index).map_or_else(|| 45.0 * 10_f64.powf(f64::from(index) / 80.0), f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_stand_for_the_loads_of_the_standard() {
        assert_eq!(usize::from(OF_CARS[1] - OF_CARS[0]) + 1, LOADS.len());
        assert_eq!(
            [59, 60, 91, 105, 126, 127].map(load_of_car),
            [None, Some(250), Some(615), Some(925), Some(1700), None]
        );
        for (index, load) in [(82, 475.0), (91, 615.0), (105, 925.0)] {
            assert!((load_of(index) - load).abs() < 1e-9, "{index}");
        }
        for (index, load) in [(50, 190.0), (154, 3750.0)] {
            assert!((load_of(index) / load - 1.0).abs() < 0.02, "{index}");
        }
    }
}
