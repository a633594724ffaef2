//! Analysis of the targeting task: each subject against its own baseline, and throughput [iso-9241-411, annex B].

use crate::log::Session;
use crate::record::{Record, RingTrial, TargetingTrial};
use crate::stimulus::Resistance;
use crate::targeting_plan::TABLE_5_1;
use serde::Serialize;

/// Smallest changes that count as better or worse [thesis, ch. 5.4.1].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Change of the completion time, s; a larger one counts.
    pub time_s: f64,
    /// Change of the number of errors; this one counts.
    pub errors: f64,
    /// Change of the mean error magnitude, mm; this one counts.
    pub error_mm: f64,
}

impl Margins {
    /// Half a second, one error, one millimetre.
    pub const THESIS: Self = Self { time_s: 0.5, errors: 1.0, error_mm: 1.0 };
}

/// A finished segment with its subject.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scored<'a> {
    /// Label.
    pub subject: &'a str,
    /// Whether the subject is simulated.
    pub simulated: bool,
    /// The segment.
    pub trial: &'a TargetingTrial,
}

/// All segments except practice.
#[must_use]
pub fn segments(sessions: &[Session]) -> Vec<Scored<'_>> {
    let mut all = Vec::new();
    for session in sessions {
        let subject = &session.header.subject;
        for record in &session.records {
            if let Record::Targeting(trial) = record
                && !trial.practice
            {
                all.push(Scored { subject: &subject.id, simulated: subject.simulated.is_some(), trial });
            }
        }
    }
    all
}

/// Difference between a segment and the baseline of the same subject and index.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Label.
    pub subject: String,
    /// Whether the subject is simulated.
    pub simulated: bool,
    /// Resistance.
    pub resistance: Resistance,
    /// Number in [thesis, table 5-1].
    pub index: u32,
    /// Change of the completion time, s. Negative is faster.
    pub time_s: f64,
    /// Change of the number of errors. Negative is fewer.
    pub errors: f64,
    /// Change of the mean error magnitude, mm.
    pub error_mm: f64,
    /// Completion time of the baseline, s.
    pub baseline_s: f64,
}

/// Every segment against its baseline. Segments without a baseline are left out.
#[must_use]
pub fn differences(segments: &[Scored<'_>]) -> Vec<Difference> {
    let baseline = |of: &Scored<'_>| {
        let mine =
            segments.iter().filter(|s| s.subject == of.subject && s.trial.resistance == Resistance::Baseline);
        mine.map(|s| s.trial).find(|trial| trial.difficulty == of.trial.difficulty)
    };
    let others = segments.iter().filter(|s| s.trial.resistance != Resistance::Baseline);
    others
        .filter_map(|s| {
            let base = baseline(s)?;
            Some(Difference {
                subject: s.subject.to_owned(),
                simulated: s.simulated,
                resistance: s.trial.resistance,
                index: s.trial.difficulty.index,
                time_s: s.trial.completion_s - base.completion_s,
                errors: s.trial.errors as f64 - base.errors as f64,
                error_mm: s.trial.mean_error_mm - base.mean_error_mm,
                baseline_s: base.completion_s,
            })
        })
        .collect()
}

/// One cell of [thesis, table 5-7 to 5-9].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Count {
    /// Number of subjects that did better.
    pub better: usize,
    /// Number of subjects that did worse.
    pub worse: usize,
}

/// A row of [thesis, table 5-7 to 5-9] for one resistance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Counts {
    /// Number in [thesis, table 5-1].
    pub index: u32,
    /// Resistance.
    pub resistance: Resistance,
    /// Number of subjects compared.
    pub subjects: usize,
    /// Completion time [thesis, table 5-7].
    pub time: Count,
    /// Number of errors [thesis, table 5-8].
    pub errors: Count,
    /// Error magnitude [thesis, table 5-9].
    pub error_mm: Count,
    /// Mean change of the completion time, as a share of the mean baseline.
    pub slower: f64,
    /// Mean change of the number of errors.
    pub more_errors: f64,
}

/// Counts as in [thesis, table 5-7 to 5-9].
#[must_use]
pub fn counts(differences: &[Difference], margins: &Margins) -> Vec<Counts> {
    let mut all = Vec::new();
    for index in TABLE_5_1.map(|difficulty| difficulty.index) {
        for resistance in Resistance::ALL {
            let of: Vec<&Difference> =
                differences.iter().filter(|d| d.index == index && d.resistance == resistance).collect();
            if of.is_empty() {
                continue;
            }
            let count = |better: &dyn Fn(&Difference) -> bool, worse: &dyn Fn(&Difference) -> bool| Count {
                better: of.iter().filter(|d| better(d)).count(),
                worse: of.iter().filter(|d| worse(d)).count(),
            };
            let mean = |value: &dyn Fn(&Difference) -> f64| {
                of.iter().map(|d| value(d)).sum::<f64>() / of.len() as f64
            };
            all.push(Counts {
                index,
                resistance,
                subjects: of.len(),
                time: count(&|d| d.time_s < -margins.time_s, &|d| d.time_s > margins.time_s),
                errors: count(&|d| d.errors <= -margins.errors, &|d| d.errors >= margins.errors),
                error_mm: count(&|d| d.error_mm <= -margins.error_mm, &|d| d.error_mm >= margins.error_mm),
                slower: mean(&|d| d.time_s) / mean(&|d| d.baseline_s),
                more_errors: mean(&|d| d.errors),
            });
        }
    }
    all
}

/// Throughput of one segment [iso-9241-411, annex B]. A click ends a movement, whether it hit or missed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Throughput {
    /// Number of movements, without the first, which begins anywhere.
    pub movements: usize,
    /// Effective width W_e, 4.133 standard deviations of the clicks along the movement, mm of handle travel.
    pub effective_width_mm: f64,
    /// Mean distance moved A_e, mm.
    pub effective_distance_mm: f64,
    /// Effective index of difficulty log₂(A_e/W_e + 1), bits.
    pub effective_bits: f64,
    /// Mean movement time, s.
    pub movement_s: f64,
    /// Throughput, ID_e over movement time, bit/s.
    pub bits_per_s: f64,
}

/// Throughput of a segment. `None` with fewer than three movements, or if all clicks are at one place.
#[must_use]
pub fn throughput(trial: &TargetingTrial) -> Option<Throughput> {
    // the first click on each target, and the start of its movement: the previous valid click
    let mut moves = Vec::new();
    let mut from: Option<(f64, f64)> = None;
    let mut ended = false;
    for click in &trial.clicks {
        if let (Some((x, t)), false) = (from, ended) {
            let way = (click.target_px - x).signum();
            moves.push((
                (click.position_px - x).abs(),
                way * (click.position_px - click.target_px),
                click.time_s - t,
            ));
        }
        ended = !click.valid;
        if click.valid {
            from = Some((click.position_px, click.time_s));
        }
    }
    Throughput::of(&moves, trial.metre_per_px * 1e3)
}

impl Throughput {
    /// Of movements, each with its length, the place of its end beyond the target, and its time, s; `mm` millimetres are the
    /// unit of length.
    pub(crate) fn of(moves: &[(f64, f64, f64)], mm: f64) -> Option<Self> {
        let n = moves.len() as f64;
        if moves.len() < 3 {
            return None;
        }
        let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| moves.iter().map(of).sum::<f64>() / n;
        let (distance, bias, time) = (mean(&|m| m.0), mean(&|m| m.1), mean(&|m| m.2));
        let spread = (moves.iter().map(|m| (m.1 - bias).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let width = 4.133 * spread;
        if !(width > 0.0 && time > 0.0 && distance > 0.0) {
            return None;
        }
        let bits = (distance / width + 1.0).log2();
        Some(Self {
            movements: moves.len(),
            effective_width_mm: width * mm,
            effective_distance_mm: distance * mm,
            effective_bits: bits,
            movement_s: time,
            bits_per_s: bits / time,
        })
    }
}

impl RingTrial {
    /// Throughput with the effective width [iso-9241-411, annex B]: the spread of the selections along each movement, which
    /// is the line between the centres of two targets. `None` with fewer than three movements, or without spread.
    #[must_use]
    pub fn throughput(&self) -> Option<Throughput> {
        let moves: Vec<(f64, f64, f64)> = self
            .clicks
            .iter()
            .zip(self.clicks.iter().skip(1))
            .map(|(from, to)| {
                let (x, y) = (to.target_x_m - from.target_x_m, to.target_y_m - from.target_y_m);
                let length = x.hypot(y);
                let along = |dx: f64, dy: f64| (dx * x + dy * y) / length;
                (
                    along(to.x_m - from.x_m, to.y_m - from.y_m),
                    along(to.x_m - to.target_x_m, to.y_m - to.target_y_m),
                    to.time_s - from.time_s,
                )
            })
            .collect();
        Throughput::of(&moves, 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Click;
    use crate::record::{Experiment, Header, SCHEMA, Subject};
    use crate::targeting_plan::{Segment, TargetingPlan};

    fn trial(resistance: Resistance, seconds: f64, errors: usize) -> TargetingTrial {
        let difficulty = TABLE_5_1[3];
        let mut clicks = Vec::new();
        let mut side = 1.0;
        for k in 0..8 + errors {
            let time_s = seconds * (k + 1) as f64 / (8 + errors) as f64;
            let missed = k < errors;
            // misses by 50 px, 3 mm
            let position_px = side * (150.0 + if missed { 56.0 } else { [-3.0, 0.0, 3.0][k % 3] });
            clicks.push(Click { time_s, position_px, target_px: side * 150.0, valid: !missed });
            if !missed {
                side = -side;
            }
        }
        let segment = Segment { practice: false, resistance, difficulty };
        TargetingTrial::new(1, segment, &TargetingPlan::thesis(1), clicks)
    }

    fn session(id: &str, records: Vec<Record>) -> Session {
        let header = Header {
            schema: SCHEMA.into(),
            subject: Subject { id: id.into(), simulated: None },
            began: String::new(),
            device: String::new(),
            experiment: Experiment::Targeting(TargetingPlan::thesis(1)),
        };
        Session { header, records, cut_off: false }
    }

    #[test]
    fn margins_decide_better_and_worse() {
        let sessions: Vec<Session> = [(5.4, 0), (5.6, 1), (4.4, 0), (4.5, 2)]
            .iter()
            .enumerate()
            .map(|(k, &(seconds, errors))| {
                let of = |r, s, e| Record::Targeting(trial(r, s, e));
                session(
                    &format!("s{k}"),
                    vec![of(Resistance::Baseline, 5.0, 1), of(Resistance::Real, seconds, errors)],
                )
            })
            .collect();
        let all = segments(&sessions);
        let found = differences(&all);
        assert_eq!(found.len(), 4);
        let table = counts(&found, &Margins::THESIS);
        println!("{table:?}");
        let [row] = table.as_slice() else { panic!("one row") };
        assert_eq!((row.time.better, row.time.worse), (1, 1), "exactly half a second is neither");
        assert_eq!((row.errors.better, row.errors.worse), (2, 1));
        assert_eq!((row.error_mm.better, row.error_mm.worse), (2, 0), "no error has no magnitude");
        assert!((row.slower - (-0.025 / 5.0)).abs() < 1e-9);
    }

    #[test]
    fn throughput_matches_a_hand_calculation() {
        // clicks at −3, 0 and +3 px about the centre in turn: by hand, and with the side taken into account
        let t = throughput(&trial(Resistance::Baseline, 8.0, 0)).expect("seven movements");
        println!("{t:?}");
        assert_eq!(t.movements, 7);
        assert!((t.movement_s - 1.0).abs() < 1e-12);
        let off = [0.0, 3.0, -3.0, 0.0, 3.0, -3.0, 0.0_f64];
        let spread = (off.iter().map(|x| x * x).sum::<f64>() / 6.0).sqrt();
        assert!((t.effective_width_mm - 4.133 * spread * 0.06).abs() < 0.02, "{}", t.effective_width_mm);
        assert!((t.bits_per_s - (t.effective_distance_mm / t.effective_width_mm + 1.0).log2()).abs() < 1e-9);
    }
}
