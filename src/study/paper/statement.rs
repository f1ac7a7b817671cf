//! What the paper says beside what was found.

use serde::Serialize;

/// Whether what was found is what the paper says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It is.
    Agrees,
    /// It is not.
    Disagrees,
    /// The paper has no numbers to hold it against.
    NotComparable,
}

impl Verdict {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Disagrees => "disagrees",
            Self::NotComparable => "not comparable",
        }
    }

    /// That of a question.
    pub const fn of(agrees: bool) -> Self {
        if agrees { Self::Agrees } else { Self::Disagrees }
    }
}

/// One statement of the paper, or one of its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// Where it stands: `figure 2`, `equation 4`.
    pub place: &'static str,
    /// What it is about.
    pub subject: &'static str,
    /// What the paper says.
    pub paper: &'static str,
    /// What was found, with its numbers.
    pub found: String,
    /// Whether that is the same.
    pub verdict: Verdict,
    /// By what it was judged.
    pub why: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_has_two_answers_and_each_verdict_its_words() {
        assert_eq!([true, false].map(Verdict::of), [Verdict::Agrees, Verdict::Disagrees]);
        let all = [Verdict::Agrees, Verdict::Disagrees, Verdict::NotComparable];
        assert_eq!(all.map(Verdict::words), ["agrees", "disagrees", "not comparable"]);
        assert_eq!(serde_json::to_string(&Verdict::NotComparable).unwrap(), "\"not-comparable\"");
    }
}
