//! Simulated subjects: complete sessions without people. Their files say so.

use crate::forced_choice::ForcedChoice;
use crate::forced_choice_plan::ForcedChoicePlan;
use crate::hand::{HandModel, reach};
use crate::observer::Observer;
use crate::record::{Experiment, Header, Record, SCHEMA, Simulated, Subject};
use crate::targeting::Targeting;
use crate::targeting_plan::TargetingPlan;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Description of the hand model in every header.
pub const HAND_MODEL: &str = "simulated hand: minimum-jerk submovements, corrected by delayed sight, force noise in proportion to the force, on the simulated device with its own renderer; no human data";
/// Description of the observer model in every header.
pub const OBSERVER_MODEL: &str = "simulated observer: impressions of dynamic and static friction with noise in proportion to the level; no human data";

/// A simulated subject.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedSubject {
    /// Label.
    pub id: String,
    /// Seed of all noise.
    pub seed: u64,
    /// Hand model.
    pub hand: HandModel,
    /// Observer.
    pub observer: Observer,
}

impl SimulatedSubject {
    /// Subject `number`, from 1, of an experiment.
    #[must_use]
    pub fn drawn(number: usize, seed: u64) -> Self {
        let seed = seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x0b5e);
        let mut vary = |value: f64, by: f64| {
            let z: f64 = StandardNormal.sample(&mut rng);
            value * (by * z.clamp(-2.5, 2.5)).exp()
        };
        // hands discriminate about a tenth of a force; a start is brief and discriminated four times worse
        let weber_dynamic = vary(0.10, 0.3);
        let observer = Observer { weber_dynamic, weber_static: 4.0 * weber_dynamic, lapse: vary(0.01, 0.3) };
        Self { id: format!("simulated-{number:02}"), seed, hand: HandModel::drawn(seed), observer }
    }

    fn header(&self, model: &str, parameters: Vec<(String, f64)>, experiment: Experiment) -> Header {
        Header {
            schema: SCHEMA.into(),
            subject: Subject {
                id: self.id.clone(),
                simulated: Some(Simulated { model: model.into(), seed: self.seed, parameters }),
            },
            began: String::new(),
            device: "the simulated rig of 1.4 kg and 0.8 N (table 5-2)".into(),
            experiment,
        }
    }

    /// Runs the targeting task from beginning to end.
    ///
    /// # Errors
    /// The device rejects a resistance, or the hand never finishes a segment.
    pub fn targeting(&self, plan: TargetingPlan) -> Result<(Header, Vec<Record>), String> {
        let mut task = Targeting::new(plan);
        let header =
            self.header(HAND_MODEL, self.hand.parameters(), Experiment::Targeting(task.plan().clone()));
        let mut records = Vec::new();
        while task.next().is_some() {
            let seed = self.seed.wrapping_mul(977).wrapping_add(records.len() as u64);
            records.push(Record::Targeting(reach(&mut task, &self.hand, seed)?));
        }
        Ok((header, records))
    }

    /// Runs the forced choice from beginning to end.
    #[must_use]
    pub fn forced_choice(&self, plan: ForcedChoicePlan) -> (Header, Vec<Record>) {
        let mut choice = ForcedChoice::new(plan);
        let parameters = vec![
            ("observer.weber_dynamic".to_owned(), self.observer.weber_dynamic),
            ("observer.weber_static".to_owned(), self.observer.weber_static),
            ("observer.lapse".to_owned(), self.observer.lapse),
        ];
        let header = self.header(OBSERVER_MODEL, parameters, Experiment::ForcedChoice(choice.plan().clone()));
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0xab);
        let mut records = Vec::new();
        while let Some(shown) = choice.next() {
            choice.advance();
            choice.advance();
            let answer = self.observer.answer(&shown, &mut rng);
            // a model answers at once
            let Some(trial) = choice.answer(answer, 0.0) else { break };
            records.push(Record::ForcedChoice(trial));
        }
        (header, records)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{Margins, counts, differences, segments, throughput};
    use crate::log::Session;
    use crate::stimulus::Resistance;
    use crate::targeting_plan::{Segment, TABLE_5_1};

    #[test]
    fn simulated_subjects_finish_and_are_labelled() {
        let subject = SimulatedSubject::drawn(1, 7);
        let mut order = Vec::new();
        for resistance in Resistance::ALL {
            for difficulty in [TABLE_5_1[3], TABLE_5_1[8]] {
                order.push(Segment { practice: false, resistance, difficulty });
            }
        }
        let plan = TargetingPlan { order, practice: false, ..TargetingPlan::thesis(1) };
        let (header, records) = subject.targeting(plan).expect("it finishes");
        assert!(header.subject.simulated.as_ref().is_some_and(|s| s.model.contains("no human data")));
        let session = Session { header, records, cut_off: false };
        for s in segments(std::slice::from_ref(&session)) {
            let t = s.trial;
            let tp = throughput(t).map_or(f64::NAN, |x| x.bits_per_s);
            println!(
                "{:<13} index {}: {:.1} s, {} errors of {:.2} mm, {tp:.1} bit/s",
                t.resistance.id(),
                t.difficulty.index,
                t.completion_s,
                t.errors,
                t.mean_error_mm
            );
            assert!((1.5..90.0).contains(&t.completion_s));
        }
        let table = counts(&differences(&segments(&[session])), &Margins::THESIS);
        assert_eq!(table.len(), 8);
    }

    #[test]
    fn the_same_seed_is_the_same_subject() {
        let of = |seed| SimulatedSubject::drawn(3, seed).forced_choice(ForcedChoicePlan::thesis(seed));
        assert_eq!(of(5), of(5));
        assert_ne!(of(5).1, of(6).1);
    }
}
