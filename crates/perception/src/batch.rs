//! Batches of the forced choice: printed, user-defined and adaptive.

use crate::stimulus::Stimulus;
use serde::{Deserialize, Serialize};

/// Levels that differ from the reference, and the sign of the difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Varied {
    /// Static and dynamic level higher (batch 1).
    BothUp,
    /// Static level higher, dynamic level as in the reference (batch 2).
    StaticUp,
    /// Static and dynamic level lower (batch 3).
    BothDown,
}

impl Varied {
    /// The reference with its levels changed by `difference`, N.
    #[must_use]
    pub fn apply(self, reference: &Stimulus, difference: f64) -> Stimulus {
        let (s, d) = (reference.f_static, reference.f_dynamic);
        match self {
            Self::BothUp => reference.with_levels(s + difference, d + difference),
            Self::StaticUp => reference.with_levels(s + difference, d),
            Self::BothDown => reference.with_levels(s - difference, d - difference),
        }
    }
}

/// Choice of the levels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "procedure", rename_all = "snake_case", deny_unknown_fields)]
pub enum Procedure {
    /// Method of constant stimuli: each comparison once per round, in random order.
    Constant {
        /// Blocks compared with the reference.
        comparisons: Vec<Stimulus>,
        /// Number of rounds.
        rounds: usize,
    },
    /// QUEST+ [watson-2017]: presents the difference with the most informative expected answer.
    Adaptive {
        /// Levels that differ.
        varied: Varied,
        /// Smallest and largest difference, N.
        range_n: (f64, f64),
        /// Largest number of answers.
        trials: usize,
        /// Ratio of the limits of the 95 % interval of the JND at which the batch ends early.
        enough: f64,
    },
}

/// A batch: one reference and its comparisons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Batch {
    /// Name in reports.
    pub name: String,
    /// Baseline of every trial.
    pub reference: Stimulus,
    /// Choice of the levels.
    pub procedure: Procedure,
}

/// Larger of the differences in static and dynamic friction, N.
#[must_use]
pub(crate) fn difference(reference: &Stimulus, comparison: &Stimulus) -> f64 {
    let by_static = (comparison.f_static - reference.f_static).abs();
    let by_dynamic = (comparison.f_dynamic - reference.f_dynamic).abs();
    by_static.max(by_dynamic)
}

/// Largest number of trials of a batch: a day without a pause.
const MAX_TRIALS: usize = 10_000;

impl Batch {
    /// Batch 1, 2 or 3 with the levels of [thesis, table 5-4, 5-5 and 5-6], two rounds of five [thesis, ch. 5.3.2].
    #[must_use]
    pub fn printed(number: usize) -> Option<Self> {
        let reference = Stimulus::REFERENCE;
        let comparisons = match number {
            1 => [2.03, 2.08, 2.1, 2.5, 3.1].map(|f| reference.with_levels(f, f)),
            2 => [2.2, 2.6, 3.0, 3.5, 4.0].map(|f| reference.with_levels(f, 2.0)),
            3 => [1.95, 1.9, 1.8, 1.5, 1.0].map(|f| reference.with_levels(f, f)),
            _ => return None,
        };
        let procedure = Procedure::Constant { comparisons: comparisons.to_vec(), rounds: 2 };
        Some(Self { name: format!("batch {number}"), reference, procedure })
    }

    /// Batch 1, 2 or 3 with levels chosen by QUEST+. The range extends beyond the printed levels, so that it includes the
    /// JND of batch 2, which they do not reach.
    #[must_use]
    pub fn adaptive(number: usize) -> Option<Self> {
        let (varied, range_n) = match number {
            1 => (Varied::BothUp, (0.02, 4.0)),
            2 => (Varied::StaticUp, (0.1, 6.0)),
            3 => (Varied::BothDown, (0.02, 1.9)),
            _ => return None,
        };
        let procedure = Procedure::Adaptive { varied, range_n, trials: 60, enough: 2.0 };
        Some(Self { name: format!("batch {number} adaptive"), reference: Stimulus::REFERENCE, procedure })
    }

    /// Checks that everything can be presented.
    ///
    /// # Errors
    /// Batch, parameter, value and accepted range.
    pub fn validate(&self) -> Result<(), String> {
        let named = |what: String| format!("batch `{}`: {what}", self.name);
        self.reference.validate().map_err(|e| named(format!("reference: {e}")))?;
        match &self.procedure {
            Procedure::Constant { comparisons, rounds } => {
                if comparisons.is_empty() || *rounds == 0 {
                    return Err(named("at least one comparison and one round are accepted".into()));
                }
                if comparisons.len().saturating_mul(*rounds) > MAX_TRIALS {
                    return Err(named(format!(
                        "{rounds} rounds of {} comparisons: at most {MAX_TRIALS} trials are accepted",
                        comparisons.len()
                    )));
                }
                for (k, comparison) in comparisons.iter().enumerate() {
                    comparison.validate().map_err(|e| named(format!("comparison {}: {e}", k + 1)))?;
                    if difference(&self.reference, comparison) == 0.0 {
                        return Err(named(format!(
                            "comparison {}: its friction is the reference's; accepted is another",
                            k + 1
                        )));
                    }
                }
            }
            Procedure::Adaptive { varied, range_n: (low, high), trials, enough } => {
                if !(low.is_finite() && high.is_finite() && *low > 0.0 && high > low) {
                    return Err(named(format!(
                        "range_n = {low} to {high}: two numbers above 0, the larger last, are accepted"
                    )));
                }
                varied
                    .apply(&self.reference, *high)
                    .validate()
                    .map_err(|e| named(format!("range_n: {e}")))?;
                if *trials > MAX_TRIALS {
                    return Err(named(format!("trials = {trials}: at most {MAX_TRIALS} are accepted")));
                }
                if *trials == 0 || !(enough.is_finite() && *enough >= 1.0) {
                    return Err(named("trials above 0 and an `enough` from 1 on are accepted".into()));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_levels_are_exact() {
        // (F_s, F_d) as [thesis, table 5-4, 5-5 and 5-6] print them
        let printed: [[(f64, f64); 5]; 3] = [
            [(2.03, 2.03), (2.08, 2.08), (2.1, 2.1), (2.5, 2.5), (3.1, 3.1)],
            [(2.2, 2.0), (2.6, 2.0), (3.0, 2.0), (3.5, 2.0), (4.0, 2.0)],
            [(1.95, 1.95), (1.9, 1.9), (1.8, 1.8), (1.5, 1.5), (1.0, 1.0)],
        ];
        for (k, levels) in printed.iter().enumerate() {
            let batch = Batch::printed(k + 1).expect("a printed batch");
            assert_eq!(batch.reference, Stimulus::REFERENCE);
            let Procedure::Constant { comparisons, rounds } = &batch.procedure else { panic!("constant") };
            assert_eq!(*rounds, 2);
            let ours: Vec<(f64, f64)> = comparisons.iter().map(|s| (s.f_static, s.f_dynamic)).collect();
            println!("{}: {ours:?}", batch.name);
            assert_eq!(ours, levels.to_vec());
            for s in comparisons {
                assert_eq!(s.with_levels(2.0, 2.0), batch.reference, "nothing else differs");
            }
            assert_eq!(batch.validate(), Ok(()));
            assert_eq!(Batch::adaptive(k + 1).expect("an adaptive one").validate(), Ok(()));
        }
        assert_eq!(Batch::printed(0).or(Batch::printed(4)), None);
    }

    #[test]
    fn a_batch_of_a_billion_rounds_took_all_memory() {
        let mut batch = Batch::printed(1).expect("a printed batch");
        let Procedure::Constant { rounds, .. } = &mut batch.procedure else { panic!("constant") };
        *rounds = usize::MAX;
        let refused = batch.validate().expect_err("too many");
        println!("{refused}");
        assert!(refused.ends_with(" rounds of 5 comparisons: at most 10000 trials are accepted"));
        let mut adaptive = Batch::adaptive(1).expect("an adaptive one");
        let Procedure::Adaptive { trials, .. } = &mut adaptive.procedure else { panic!("adaptive") };
        *trials = 10_001;
        assert!(adaptive.validate().is_err_and(|e| e.contains("trials = 10001")));
    }

    #[test]
    fn a_comparison_equal_to_the_reference_is_rejected() {
        let mut batch = Batch::printed(1).expect("a printed batch");
        batch.procedure = Procedure::Constant { comparisons: vec![Stimulus::REFERENCE], rounds: 1 };
        assert!(batch.validate().is_err_and(|e| e.contains("comparison 1")));
    }
}
