//! Description of a road: extent, resolution, texture measures, and a sample to draw.

use serde::Serialize;

use super::error::RoadError;
use super::lattice::Lattice;
use super::piece_rows::column_of;
use super::profiles::lattice_of_profiles;
use super::report::{RoadNote, RoadReport};
use super::sources::Source;
use super::surface::{Limits, RoadSurface};
use super::texture::{HeightOrigin, OverallLevel, ProfileDepth, ProfileSpectrum, TextureLevel, rms};
use crate::scene::Road;

/// Length of a made road that is measured for its texture \[m\].
const MEASURED_LENGTH: f64 = 20.0;
/// Longest sample that is drawn \[m\].
const SAMPLE_LENGTH: f64 = 1.0;

/// A rectangular piece of the road on the run's lattice, to be drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeightSample {
    /// Road coordinate of the first row \[m\].
    pub start: f64,
    /// Row spacing \[m\].
    pub dx: f64,
    /// Column spacing \[m\].
    pub dy: f64,
    /// Number of rows, from the first one under element 0 on.
    pub rows: usize,
    /// Number of columns, centred on the tyre.
    pub columns: usize,
    /// Row-major heights \[m\].
    pub heights: Vec<f64>,
}

/// Extent, resolution and texture measures of a road.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadDescription {
    /// Available road coordinates \[m\]; absent for endless roads.
    pub extent: Option<(f64, f64)>,
    /// The run's lattice.
    pub lattice: Lattice,
    /// Third-octave levels of the road's profiles at the road's spacing (energy mean over the contact width), longest
    /// wavelength first; the shortest has two spacings.
    pub levels: Vec<TextureLevel>,
    /// Level of the macrotexture, 0.5 to 50 mm; absent where no such band is valid.
    pub(crate) macrotexture: Option<OverallLevel>,
    /// Level of the megatexture, 50 to 500 mm; absent where no such band is valid.
    pub(crate) megatexture: Option<OverallLevel>,
    /// Root-mean-square height of the profiles \[m\].
    pub rms: f64,
    /// Highest minus lowest height of the profiles \[m\].
    pub span: f64,
    /// Skewness and kurtosis of the profiles' heights; absent for the plane.
    pub moments: Option<[f64; 2]>,
    /// Mean profile depth of all profiles (ISO 13473-1); absent for the plane.
    pub mean_profile_depth: Option<ProfileDepth>,
    /// Highest frequency that the road excites in this run at the given speed \[Hz\], limited by the elements; absent
    /// for the plane.
    pub highest_frequency: Option<f64>,
    /// The same for the resolution of the road itself, however fine the run \[Hz\].
    pub highest_frequency_of_road: Option<f64>,
    /// Findings and actions of opening the road.
    pub report: RoadReport,
    /// A piece of the road to draw.
    pub(crate) sample: HeightSample,
}

/// Describes a road for a run with this `lattice` at `speed` \[m/s\].
///
/// Measured roads are measured over their whole length, at their spacing; of made roads 20 m are drawn and measured.
///
/// # Errors
/// As [`RoadSurface::open`].
pub fn describe(spec: &Road, lattice: Lattice, speed: f64, limits: Limits) -> Result<RoadDescription, RoadError> {
    let mut report = RoadReport::default();
    let (lattice, source) = match Source::read(spec, lattice, limits.bytes, &mut report) {
        // A road too narrow for the contact strip is described as wide as it is.
        Err(RoadError::Narrow { available, needed, .. }) if available > 0.0 => {
            let columns = (available / lattice.dy * (1.0 + 1e-9)).floor().max(1.0) as usize;
            let narrow = Lattice { columns, dy: lattice.dy.min(available), ..lattice };
            report = RoadReport::default();
            let source = Source::read(spec, narrow, limits.bytes, &mut report)?;
            report.notes.push(RoadNote::Narrow { available, needed });
            (narrow, source)
        }
        read => (lattice, read?),
    };
    let mut surface = RoadSurface::on(lattice, source.clone(), limits, report)?;
    let mut elements = (SAMPLE_LENGTH / lattice.dx).ceil().clamp(2.0, 1e6) as usize;
    if let Some((_, end)) = surface.extent() {
        elements = elements.min((end / lattice.dx + 1e-6).floor() as usize + 1);
    }
    limits.check(elements as f64 * lattice.along as f64 * lattice.columns as f64)?;
    let mut heights = vec![0.0; elements * lattice.cells()];
    surface.heights(0, elements, &mut heights)?;
    let profiles = Profiles::of(source, lattice.width(), limits)?;
    let report = surface.report().clone();
    let levels = profiles.levels();
    Ok(RoadDescription {
        extent: surface.extent(),
        lattice,
        macrotexture: OverallLevel::macrotexture(&levels),
        megatexture: OverallLevel::megatexture(&levels),
        levels,
        rms: profiles.rms(),
        span: profiles.span(),
        moments: profiles.moments(),
        mean_profile_depth: profiles.depth(),
        highest_frequency: report.highest_frequency(speed),
        highest_frequency_of_road: (profiles.shortest > 0.0).then(|| speed / profiles.shortest),
        report,
        sample: HeightSample {
            start: lattice.place(0, 1.0),
            dx: lattice.cell(),
            dy: lattice.dy,
            rows: elements * lattice.along,
            columns: lattice.columns,
            heights,
        },
    })
}

/// Profiles along at the spacing of the road, equally long; none for the plane.
#[derive(Default)]
struct Profiles {
    spacing: f64,
    /// Wavelengths between which levels are found \[m\].
    shortest: f64,
    longest: f64,
    profiles: Vec<Vec<f64>>,
    /// Origins of the heights, for each profile; empty for a profile that was measured throughout.
    origins: Vec<Vec<HeightOrigin>>,
}

impl Profiles {
    /// Profiles of a source within the contact width \[m\].
    fn of(source: Source, contact_width: f64, limits: Limits) -> Result<Self, RoadError> {
        let (spacing, shortest) = match &source {
            Source::Smooth => return Ok(Self::default()),
            Source::Made(design) => (design.spacing, design.target.shortest()),
            Source::Measured(map, _) => {
                let inside = |column: &usize| {
                    let y = map.first_y + *column as f64 * map.dy;
                    map.dy == 0.0 || y.abs() <= 0.5 * contact_width * (1.0 + 1e-9)
                };
                let columns = || (0..map.columns).filter(inside);
                let profiles = columns().map(|column| map.column(column)).collect();
                let origins = columns().map(|column| map.origins_of(column)).collect();
                // Fewer than four periods of a wave give no reliable level.
                let (spacing, longest) = (map.dx, 0.25 * map.end());
                return Ok(Self { spacing, shortest: 2.0 * spacing, longest, profiles, origins });
            }
        };
        let grid = lattice_of_profiles(spacing);
        let rows = (MEASURED_LENGTH / spacing).ceil() as usize;
        limits.check(rows as f64 * grid.columns as f64)?;
        let mut heights = vec![0.0; rows * grid.columns];
        RoadSurface::on(grid, source, limits, RoadReport::default())?.heights(0, rows, &mut heights)?;
        let column = |column: usize| column_of(&heights, column, grid.columns);
        let profiles: Vec<Vec<f64>> = (0..grid.columns).map(column).collect();
        let origins = vec![Vec::new(); profiles.len()];
        Ok(Self { spacing, shortest, longest: 0.5, profiles, origins })
    }

    fn levels(&self) -> Vec<TextureLevel> {
        let Some(first) = self.profiles.first() else { return Vec::new() };
        let mut spectrum = ProfileSpectrum::new(first.len(), self.spacing);
        self.profiles.iter().for_each(|profile| spectrum.add(profile));
        spectrum.levels(self.longest, self.shortest)
    }

    fn rms(&self) -> f64 {
        let square = self.profiles.iter().fold(0.0, |sum, profile| sum + rms(profile).powi(2));
        (square / self.profiles.len().max(1) as f64).sqrt()
    }

    fn span(&self) -> f64 {
        let heights = || self.profiles.iter().flatten().copied();
        if self.profiles.is_empty() {
            0.0
        } else {
            heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min)
        }
    }

    fn moments(&self) -> Option<[f64; 2]> {
        let heights = || self.profiles.iter().flatten().copied();
        let count = heights().count() as f64;
        let mean = heights().sum::<f64>() / count;
        let central = |power: i32| heights().map(|height| (height - mean).powi(power)).sum::<f64>() / count;
        let variance = central(2);
        (variance > 0.0).then(|| [central(3) / variance.powf(1.5), central(4) / variance.powi(2)])
    }

    fn depth(&self) -> Option<ProfileDepth> {
        let profiles = self.profiles.iter().map(Vec::as_slice).zip(self.origins.iter().map(Vec::as_slice));
        (!self.profiles.is_empty()).then(|| ProfileDepth::of(profiles, self.spacing))
    }
}
