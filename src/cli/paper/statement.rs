//! Statements of the paper beside the findings.

use serde::Serialize;

/// Comparison of a finding with the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Verdict {
    /// The finding is what the paper says.
    Agrees,
    /// The finding contradicts the paper.
    Disagrees,
    /// The paper has no numbers to compare with.
    NotComparable,
}

impl Verdict {
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Disagrees => "disagrees",
            Self::NotComparable => "not comparable",
        }
    }

    pub(super) const fn of(agrees: bool) -> Self {
        if agrees { Self::Agrees } else { Self::Disagrees }
    }
}

/// One statement of the paper, or one of its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Statement {
    /// Place in the paper: `figure 2`, `equation 4`.
    pub place: &'static str,
    /// Subject of the statement.
    pub subject: &'static str,
    /// The paper's statement.
    pub paper: &'static str,
    /// Finding, with its numbers.
    pub found: String,
    /// True if the two agree.
    pub verdict: Verdict,
    /// Criterion of agreement; or the reason why nothing can be compared.
    pub why: String,
}

impl Statement {
    /// Verdict with its criterion, worded the same for either verdict.
    pub(super) fn judgement(&self) -> String {
        let Self { verdict, why, .. } = self;
        match verdict {
            Verdict::NotComparable => format!("{}: {why}", verdict.words()),
            Verdict::Agrees | Verdict::Disagrees => format!("{} (criterion: {why})", verdict.words()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_never_reads_as_its_opposite() {
        let told = |verdict, why: &str| {
            let (place, subject, paper) = ("figure 4", "springs or half-space", "no difference");
            Statement { place, subject, paper, found: "+4.6 dB".to_owned(), verdict, why: why.to_owned() }.judgement()
        };
        let why = "third octaves within 1 dB";
        assert_eq!(told(Verdict::Disagrees, why), "disagrees (criterion: third octaves within 1 dB)");
        assert_eq!(told(Verdict::Agrees, why), "agrees (criterion: third octaves within 1 dB)");
        assert_eq!(told(Verdict::NotComparable, "no numbers are given"), "not comparable: no numbers are given");
    }

    #[test]
    fn a_question_has_two_answers_and_each_verdict_its_words() {
        assert_eq!([true, false].map(Verdict::of), [Verdict::Agrees, Verdict::Disagrees]);
        let all = [Verdict::Agrees, Verdict::Disagrees, Verdict::NotComparable];
        assert_eq!(all.map(Verdict::words), ["agrees", "disagrees", "not comparable"]);
        assert_eq!(serde_json::to_string(&Verdict::NotComparable).unwrap(), "\"not-comparable\"");
    }
}
