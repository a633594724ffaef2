#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod analysis;
mod batch;
mod fit;
mod forced_choice;
mod forced_choice_plan;
mod hand;
mod log;
mod observer;
mod psychometric;
mod quest;
mod record;
mod ring;
mod ring_plan;
mod simulate;
mod stimulus;
pub mod study;
mod targeting;
mod targeting_plan;

pub use analysis::{
    Count, Counts, Difference, Margins, Scored, Throughput, counts, differences, segments, throughput,
};
pub use batch::{Batch, Procedure, Varied};
pub use fit::{Fit, Level, Threshold, levels};
pub use forced_choice::ForcedChoice;
pub use forced_choice_plan::{Answer, Case, ForcedChoicePlan, Planned, Presentation};
pub use hand::{HandModel, reach};
pub use log::{Log, LogError, Session};
pub use observer::Observer;
pub use psychometric::{AT_JND, GUESS, Psychometric};
pub use quest::{Belief, QuestPlus};
pub use record::{
    Click, Experiment, ForcedChoiceTrial, Header, Record, RingClick, RingTrial, SCHEMA, Simulated, Subject,
    TargetingTrial,
};
pub use ring::{Ring, Selection};
pub use ring_plan::{RingCase, RingPlan};
pub use simulate::{HAND_MODEL, OBSERVER_MODEL, SimulatedSubject};
pub use stimulus::{Resistance, Stimulus};
pub use targeting::{Event, Targeting};
pub use targeting_plan::{CLICKS, Difficulty, Segment, TABLE_5_1, TargetingPlan};
