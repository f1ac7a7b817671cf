//! What can be wrong with a scene, one variant per kind of mistake.

use super::SceneError;
use super::kind::{Bounds, short};

/// A mistake in a scene: [`Display`](std::fmt::Display) says what is wrong, [`Problem::right`] what would be right.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The text is not TOML.
    #[error("{message}")]
    Syntax {
        /// What the parser found.
        message: String,
    },
    /// A key or table that is given a second time.
    #[error("this is given twice")]
    Duplicate,
    /// A key that the table does not have.
    #[error("this is not a key of {table}")]
    UnknownKey {
        /// The table, in words.
        table: &'static str,
        /// The key that was probably meant.
        nearest: Option<&'static str>,
        /// The keys that the table has.
        known: Vec<&'static str>,
    },
    /// A key that must be given and is not.
    #[error("this key is missing")]
    Missing {
        /// What has to be given.
        wanted: String,
    },
    /// A value of another type.
    #[error("{found} cannot stand here")]
    WrongType {
        /// What stands there.
        found: String,
        /// What should.
        wanted: String,
    },
    /// `nan` or `inf`.
    #[error("{value} is not a finite number")]
    NotFinite {
        /// The value.
        value: f64,
        /// What should stand there.
        wanted: String,
    },
    /// A number that cannot be held.
    #[error("{text} is too large")]
    TooLarge {
        /// The number as written.
        text: String,
        /// What should stand there.
        wanted: String,
    },
    /// A number outside its bounds.
    #[error("{} is out of range", short(*.value))]
    OutOfRange {
        /// The value, in the unit of the bounds.
        value: f64,
        /// Where it has to lie.
        bounds: Bounds,
    },
    /// A whole number that is too small.
    #[error("{value} is too small")]
    TooSmall {
        /// The value.
        value: i128,
        /// The smallest one accepted.
        least: u64,
    },
    /// An odd number where an even one is needed.
    #[error("{value} is odd")]
    Odd {
        /// The value.
        value: u64,
    },
    /// A word that is not in the list.
    #[error("\"{given}\" is not known here")]
    NotAChoice {
        /// The word as written.
        given: String,
        /// The word that was probably meant.
        nearest: Option<&'static str>,
        /// The words accepted.
        accepted: &'static [&'static str],
    },
    /// Nothing where something is needed.
    #[error("this is empty")]
    Empty {
        /// What has to be given.
        wanted: String,
    },
    /// An array of another length.
    #[error("this has {found} values")]
    WrongCount {
        /// Values given.
        found: usize,
        /// Values wanted.
        wanted: usize,
    },
    /// Two arrays that belong together and differ in length.
    #[error("this has {length} values, `{other}` has {other_length}")]
    LengthMismatch {
        /// Values in the array complained about.
        length: usize,
        /// The array it belongs to.
        other: &'static str,
        /// Values in that one.
        other_length: usize,
    },
    /// A sequence that turns or stands still.
    #[error("{} after {} breaks the order", short(*.value), short(*.previous))]
    NotSorted {
        /// The value that breaks the order.
        value: f64,
        /// The one before.
        previous: f64,
    },
    /// A key that means nothing beside another one.
    #[error("this means nothing with {owner}")]
    DoesNotBelong {
        /// The choice that it does not belong to, as written in TOML.
        owner: String,
        /// What to do.
        right: &'static str,
    },
    /// Two keys that exclude each other.
    #[error("this and `{other}` exclude each other")]
    Conflict {
        /// The other key.
        other: &'static str,
    },
    /// A number above another one of the scene.
    #[error("{} {unit} is more than {limit_name}, {} {unit}", short(*.value), short(*.limit))]
    Exceeds {
        /// The value.
        value: f64,
        /// The largest one possible.
        limit: f64,
        /// What sets the limit.
        limit_name: &'static str,
        /// Unit of both.
        unit: &'static str,
    },
    /// A number that is not below another one of the scene.
    #[error("{} {unit} is not below {limit_name}, {} {unit}", short(*.value), short(*.limit))]
    NotBelow {
        /// The value.
        value: f64,
        /// What it has to stay below.
        limit: f64,
        /// What sets the limit.
        limit_name: &'static str,
        /// Unit of both.
        unit: &'static str,
    },
    /// A wavelength that the lattice cannot carry.
    #[error("a wavelength of {} m needs a finer lattice than {} m", short(*.wavelength), short(*.spacing))]
    BelowResolution {
        /// The wavelength \[m\].
        wavelength: f64,
        /// The lattice spacing \[m\].
        spacing: f64,
        /// The coarsest spacing that carries it \[m\].
        coarsest: f64,
    },
    /// The tyre file cannot be read.
    #[error("{source}")]
    TyreFile {
        /// Why.
        source: Box<SceneError>,
    },
    /// A law without a causal time-domain form in a time-domain run.
    #[error("the law \"hysteretic\" is not causal: the tread would move before it is touched")]
    NotCausal,
    /// What a later stage found: the road reader, the planner, ...
    #[error("{wrong}")]
    Complaint {
        /// What is wrong.
        wrong: String,
        /// What would be right.
        right: String,
    },
}

impl Problem {
    /// What would be right, as a short request.
    pub fn right(&self) -> String {
        match self {
            Self::Syntax { .. } => "write it as TOML: `key = value`, texts in quotes".to_owned(),
            Self::Duplicate => {
                "give each key and each [table] once; [[name]] begins one more item of an array".to_owned()
            }
            Self::UnknownKey { nearest: Some(nearest), .. } => format!("did you mean `{nearest}`?"),
            Self::UnknownKey { known, .. } => format!("known keys: {}", known.join(", ")),
            Self::Missing { wanted } => format!("add it: {wanted}"),
            Self::WrongType { wanted, .. } | Self::NotFinite { wanted, .. } | Self::Empty { wanted } => {
                format!("write {wanted}")
            }
            Self::TooLarge { wanted, .. } => format!("write {wanted} that fits into 64 bits"),
            Self::OutOfRange { bounds, .. } => format!("write {bounds}"),
            Self::TooSmall { least, .. } => format!("write a whole number of at least {least}"),
            Self::Odd { value } => format!("write an even number, such as {}", value.saturating_sub(1)),
            Self::NotAChoice { nearest, accepted, .. } => {
                let meant = nearest.map(|nearest| format!("did you mean \"{nearest}\"? "));
                format!("{}accepted: {}", meant.unwrap_or_default(), quoted(accepted))
            }
            Self::WrongCount { wanted, .. } => format!("write {wanted} values"),
            Self::LengthMismatch { other, .. } => format!("give as many values as in `{other}`"),
            Self::NotSorted { .. } => {
                "list the values from short to long or from long to short, each one once".to_owned()
            }
            Self::DoesNotBelong { right, .. } => (*right).to_owned(),
            Self::Conflict { other } => format!("give either this or `{other}`"),
            Self::Exceeds { limit, limit_name, unit, .. } => {
                format!("write at most {} {unit}, {limit_name}", short(*limit))
            }
            Self::NotBelow { limit, limit_name, unit, .. } => {
                format!("write less than {} {unit}, {limit_name}", short(*limit))
            }
            Self::BelowResolution { coarsest, .. } => {
                format!("leave shorter wavelengths out, or set road.spacing to at most {} m", short(*coarsest))
            }
            Self::TyreFile { .. } => "name a tyre file, relative to the scene, or give the table [tyre]".to_owned(),
            Self::NotCausal => "use \"power-law\", \"prony\" or \"elastic\" here; \"hysteretic\" serves \
                                frequency-domain results only"
                .to_owned(),
            Self::Complaint { right, .. } => right.clone(),
        }
    }

    /// Whether the key is at fault, not its value.
    pub(super) fn points_at_key(&self) -> bool {
        matches!(
            self,
            Self::UnknownKey { .. }
                | Self::Missing { .. }
                | Self::LengthMismatch { .. }
                | Self::DoesNotBelong { .. }
                | Self::Conflict { .. }
        )
    }
}

/// Words in quotes, separated by commas.
pub(super) fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// The candidate that a misspelt word was probably meant to be: at most a third of its letters differ.
pub(super) fn nearest(word: &str, candidates: &[&'static str]) -> Option<&'static str> {
    let word = word.to_lowercase();
    let distances = candidates.iter().map(|candidate| (strsim::damerau_levenshtein(&word, candidate), *candidate));
    let (distance, candidate) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= (candidate.chars().count() / 3).max(1)).then_some(candidate)
}
