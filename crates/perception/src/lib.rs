//! Experiments on how friction feels, without a screen: what to present next, what an answer means, and a file that
//! keeps every finished trial.
//!
//! * [`Targeting`]: the Fitts task of ch. 5.3.1, nine indices of difficulty ([`TABLE_5_1`]) under five resistances
//!   ([`Resistance`], table 5-2).
//! * [`ForcedChoice`]: which of two cases differs from the baseline (ch. 5.3.2), with the printed levels
//!   ([`Batch::printed`], tables 5-3 to 5-6), levels of one's own, or chosen by [`QuestPlus`] as the answers come.
//! * [`Log`]: one JSON line a finished trial, on disk before the next one begins; reading it resumes the session.
//!
//! A session is the same for a person at the lab page and for a simulated subject; the file says which
//! ([`Subject::simulated`]).
//!
//! ```
//! use perception::{Answer, Event, Targeting, TargetingPlan};
//! let mut task = Targeting::new(TargetingPlan { practice: false, ..TargetingPlan::thesis(7) });
//! let segment = task.next().expect("45 segments");
//! assert_eq!(segment.resistance, perception::Resistance::Baseline);
//! task.start(0.0);
//! let mut clock = 0.0;
//! let trial = loop {
//!     clock += 0.8;
//!     let target = task.target_m().expect("a target");
//!     if let Some(Event::Finished(trial)) = task.click(clock, target) {
//!         break trial;
//!     }
//! };
//! assert_eq!(trial.clicks.len(), 8);
//! # let _ = Answer::A;
//! ```
#![forbid(unsafe_code)]

mod analysis;
mod batch;
mod fit;
mod forced_choice;
mod hand;
mod log;
mod observer;
mod psychometric;
mod quest;
mod record;
mod simulate;
mod stimulus;
mod targeting;
mod targeting_plan;

pub use analysis::{
    Count, Counts, Difference, Margins, Scored, Throughput, counts, differences, segments, throughput,
};
pub use batch::{Batch, Procedure, Varied};
pub use fit::{Fit, Level, Threshold, levels};
pub use forced_choice::{Case, ForcedChoice, ForcedChoicePlan, Planned, Presentation};
pub use hand::{HandModel, reach};
pub use log::{Log, LogError, Session};
pub use observer::Observer;
pub use psychometric::{AT_JND, GUESS, Psychometric};
pub use quest::{Belief, QuestPlus};
pub use record::{
    Answer, Click, Experiment, ForcedChoiceTrial, Header, Record, SCHEMA, Simulated, Subject, TargetingTrial,
};
pub use simulate::{HAND_MODEL, OBSERVER_MODEL, SimulatedSubject};
pub use stimulus::{Resistance, Stimulus};
pub use targeting::{Event, Targeting};
pub use targeting_plan::{CLICKS, Difficulty, Segment, TABLE_5_1, TargetingPlan};
