//! `[road]` of `kind = "made"`: a random texture.

use serde::Serialize;

use super::named_texture::NamedTexture;
use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::{Bounds, NumberList, OneOf, Whole};
use crate::scene::problem::short;
use crate::scene::table::{Keys, Nested, Table};

const LENGTH: Bounds = Bounds::positive("m").plausible(1e-6, 1e4);
/// Texture in millimetres lies above.
const WAVELENGTH: Bounds = Bounds::positive("m").plausible(1e-5, 10.0);
/// 120 dB re 1e-6 m are one metre: no tyre rolls on that, and it is far from overflow.
const LEVEL: Bounds = Bounds::between(-100.0, 120.0, "dB re 1e-6 m");
/// Ratio of a third-octave band's mid-wavelength to its lower edge.
const HALF_BAND: f64 = 1.122_018_454_301_963_3;

keys! {
    /// A random isotropic texture. Give a `texture` by its name, or `wavelengths` with `levels`, or a `power_law`; none
    /// of them: the dense asphalt `dac-11`.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub MadeRoad {
        /// Seed of the random numbers.
        seed: u64 = 0 => Whole::least(0),
        /// Third-octave mid-wavelengths \[m\].
        wavelengths?: Vec<f64> => NumberList(WAVELENGTH),
        /// Third-octave texture levels of a profile, dB re 1e-6 m.
        levels?: Vec<f64> => NumberList(LEVEL),
        /// Power-law spectrum instead of levels.
        power_law?: PowerLawTexture => POWER_LAW,
        /// Name of a road instead of levels: a test track of ISO 10844, dense asphalt with stones up to 11 mm, stone
        /// mastic asphalt up to 8 and 11 mm, one measured rough asphalt, a chip seal; mean profile depths DEPTHS
        /// mm. Each has its own skewness and kurtosis where none are given. `tyrewave road` reports the source
        /// of the levels and their uncertainty.
        texture?: NamedTexture => OneOf::new(),
        /// Added to all levels of the spectrum, such as the uncertainty of a named texture's \[dB\].
        offset: f64 = 0.0 => Bounds::between(-40.0, 40.0, "dB"),
        /// Spacing of the lattice on which the texture is made, independent of the run's elements \[m\]; by default a
        /// quarter of the shortest wavelength of the named textures, 4 mm.
        spacing: f64 = 0.001 => LENGTH,
        /// Skewness of the heights: 0 for Gaussian ones, negative where stones have flat tops between deep gaps. By
        /// default that of the named texture, or 0.
        skewness?: f64 => Bounds::between(-3.0, 3.0, ""),
        /// Kurtosis of the heights: 3 for Gaussian ones. By default that of the named texture or, with a skewness s,
        /// that of a gamma distribution, 3 + 1.5 s^2. Which pairs a road can have is reported when it is opened.
        kurtosis?: f64 => Bounds::between(1.0, 30.0, ""),
    }
}

impl MadeRoad {
    /// Skewness and kurtosis of the heights: those given, else those of the texture, else of a gamma distribution.
    pub fn moments(&self) -> [f64; 2] {
        let named = self.named().map(NamedTexture::moments);
        let skewness = self.skewness.or(named.map(|[skewness, _]| skewness)).unwrap_or(0.0);
        let of_texture = named.filter(|_| self.skewness.is_none()).map(|[_, kurtosis]| kurtosis);
        [skewness, self.kurtosis.or(of_texture).unwrap_or(3.0 + 1.5 * skewness * skewness)]
    }

    /// The named texture, also if it is the default one; `None` if the road has a spectrum instead.
    pub fn named(&self) -> Option<NamedTexture> {
        let has_spectrum = self.wavelengths.is_some() || self.levels.is_some() || self.power_law.is_some();
        self.texture.or_else(|| (!has_spectrum).then_some(NamedTexture::DEFAULT))
    }
}

keys! {
    /// Profile spectrum proportional to wavenumber^(-exponent) between two wavelengths.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub PowerLawTexture {
        /// Root-mean-square height \[m\].
        rms: f64 => Bounds::positive("m").plausible(1e-9, 1.0),
        /// Decay exponent of the one-sided profile spectrum.
        exponent: f64 => Bounds::between(0.0, 10.0, ""),
        /// Longest wavelength \[m\].
        longest: f64 => LENGTH,
        /// Shortest wavelength \[m\].
        shortest: f64 => LENGTH,
    }
}

const POWER_LAW: Nested<PowerLawTexture> =
    Nested::new("a power-law texture", "a table, { rms = ..., exponent = ..., longest = ..., shortest = ... }")
        .read_by(power_law);

pub(super) fn made(table: &mut Table<'_>) -> Option<MadeRoad> {
    let read = MadeRoad::read(table);
    if table.has("power_law") && (table.has("levels") || table.has("wavelengths")) {
        let other = if table.has("levels") { "levels" } else { "wavelengths" };
        return table.complain("power_law", Problem::conflict(other));
    }
    let spectrum = ["wavelengths", "levels", "power_law"].into_iter().find(|other| table.has(other));
    if let Some(other) = spectrum.filter(|_| table.has("texture")) {
        return table.complain("texture", Problem::conflict(other));
    }
    let road = read?;
    match (&road.wavelengths, &road.levels) {
        (Some(_), None) => {
            return table.complain("levels", Problem::missing("one third-octave level for each of the wavelengths"));
        }
        (None, Some(_)) => {
            let wanted = "the third-octave mid-wavelength of each of the levels";
            return table.complain("wavelengths", Problem::missing(wanted));
        }
        (Some(wavelengths), Some(levels)) if wavelengths.len() != levels.len() => {
            let problem = Problem::length_mismatch(levels.len(), "wavelengths", wavelengths.len());
            return table.complain("levels", problem);
        }
        (Some(wavelengths), Some(_)) => bands(table, wavelengths, road.spacing)?,
        (None, None) => match &road.power_law {
            Some(texture) => resolved(table, "power_law.shortest", texture.shortest, 2.0 * road.spacing, road.spacing)?,
            None => {
                let (shortest, least) = (NamedTexture::SHORTEST, 2.0 * HALF_BAND * road.spacing);
                resolved(table, "spacing", shortest, least, road.spacing)?;
            }
        },
    }
    Some(road)
}

/// Checks that the bands are in order, each once, and that the lattice resolves the lower edge of each.
fn bands(table: &Table<'_>, wavelengths: &[f64], spacing: f64) -> Option<()> {
    let falling = wavelengths.first() > wavelengths.last();
    for (number, pair) in wavelengths.windows(2).enumerate() {
        let in_order = if falling { pair[1] < pair[0] } else { pair[1] > pair[0] };
        if !in_order {
            let wrong = format!("{} after {} breaks the order", short(pair[1]), short(pair[0]));
            let right = "list the values from short to long or from long to short, each one once";
            return table.complain(&format!("wavelengths[{}]", number + 1), Problem::new(wrong, right));
        }
    }
    // All are checked before the first failure counts, so that every one is reported.
    let checked: Vec<_> = wavelengths
        .iter()
        .enumerate()
        .map(|(number, &wavelength)| {
            resolved(table, &format!("wavelengths[{number}]"), wavelength, 2.0 * HALF_BAND * spacing, spacing)
        })
        .collect();
    checked.into_iter().collect()
}

/// Checks a wavelength against the shortest one that a lattice resolves: two spacings, at the lower edge of its band.
fn resolved(table: &Table<'_>, key: &str, wavelength: f64, least: f64, spacing: f64) -> Option<()> {
    // Two spacings exactly pass, although 2 x 0.001 may not be 0.002 to the last bit.
    if wavelength >= least * (1.0 - 1e-12) {
        return Some(());
    }
    let wrong = format!("a wavelength of {} m needs a finer lattice than {} m", short(wavelength), short(spacing));
    let coarsest = short(spacing * wavelength / least);
    let right = format!("leave shorter wavelengths out, or set road.spacing to at most {coarsest} m");
    table.complain(key, Problem::new(wrong, right))
}

fn power_law(table: &mut Table<'_>) -> Option<PowerLawTexture> {
    let read = PowerLawTexture::read(table);
    table.below("shortest", "longest", &LENGTH, "the longest wavelength")?;
    read
}
