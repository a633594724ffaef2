//! The closed loop: record, diagnose everything together, make the move that separates what is left, repeat.
//!
//! A question is a pair of explanations that fit equally well, or an effect the recordings cannot show. One that two
//! moves chosen for it have not answered is given up: the design knows the noise floor, not every way a sensor can fail.

mod reasoning;

use crate::Error;
use crate::error::Result;
use crate::watch::{Watch, record};
use client::{Move, Plan, Recorded, Session};
use diagnose::{Diagnosis, Limits, NextExperiment, Options, Verdict, WORTHWHILE, diagnose};

use serde::Serialize;
use signals::{ReadOptions, Recording};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use reasoning::beliefs;

/// Moves made for a question before it is given up.
const TRIES: usize = 2;

/// Looks at the line, of 5 ms each, that the ramp-out of a move and its fade take, and as much again.
const REST_POLLS: u32 = 250;

/// What may be spent.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Seconds of motion.
    pub seconds: f64,
    /// Rounds.
    pub rounds: usize,
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// Nothing is open that a move could answer.
    OneExplanation,
    /// Something is open, and no move within the device's limits would answer it.
    NothingToLearn,
    /// The budget is spent.
    Budget,
    /// It was interrupted.
    Interrupted,
    /// The recordings cannot be diagnosed.
    NotTestable,
}

impl Ended {
    /// For a person.
    pub fn says(self) -> &'static str {
        match self {
            Self::OneExplanation => "one explanation is left",
            Self::NothingToLearn => "nothing more can be learned by moving",
            Self::Budget => "the budget is spent",
            Self::Interrupted => "interrupted",
            Self::NotTestable => "the recordings cannot answer",
        }
    }
}

/// One round, as it stands in the JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Round {
    /// The command that was sent.
    pub command: String,
    /// File of the recording.
    pub recording: String,
    /// Length, s.
    pub seconds: f64,
    /// What was believed afterwards, in one sentence.
    pub believed: String,
    /// Effects named, with what explains the recordings as well.
    pub named: BTreeMap<String, Vec<String>>,
    /// Effects the recordings could not show.
    pub blind_to: Vec<String>,
    /// What this round changed.
    pub changed: Vec<String>,
    /// The move chosen next, and why.
    pub next: Option<NextExperiment>,
}

/// Everything that happened.
#[derive(Debug, Serialize)]
pub struct Investigation {
    schema: &'static str,
    /// In order.
    pub rounds: Vec<Round>,
    /// Why it ended.
    pub ended: Ended,
    /// Of all recordings together.
    pub diagnosis: Diagnosis,
}

/// A question: an effect, and what it is told from.
type Question = (String, Option<String>);

/// The loop and what it remembers.
pub struct Loop<'a> {
    session: &'a mut Session,
    out: &'a Path,
    limits: Limits,
    notes: Vec<(String, String)>,
    watch: &'a dyn Watch,
    recordings: Vec<Recording>,
    tries: BTreeMap<Question, usize>,
    spent: f64,
}

impl<'a> Loop<'a> {
    /// A loop over `session`, whose recordings go to the folder `out`.
    pub fn new(
        session: &'a mut Session,
        out: &'a Path,
        limits: Limits,
        notes: Vec<(String, String)>,
        watch: &'a dyn Watch,
    ) -> Self {
        Self {
            session,
            out,
            limits,
            notes,
            watch,
            recordings: Vec::new(),
            tries: BTreeMap::new(),
            spent: 0.0,
        }
    }

    /// Runs from `first` until nothing is left to learn or to spend; tells every round to `say`.
    ///
    /// # Errors
    /// The device refuses every move or falls silent, a file cannot be written, or nothing was recorded at all.
    pub fn run(mut self, first: Move, budget: Budget, say: &mut dyn FnMut(&str)) -> Result<Investigation> {
        let mut rounds: Vec<Round> = Vec::new();
        let mut last: Option<Diagnosis> = None;
        let mut moves = vec![first];
        let ended = loop {
            say(&format!("\nround {}", rounds.len() + 1));
            let (motion, path, recorded) = self.record(&moves, rounds.len() + 1, say)?;
            if recorded.interrupted {
                break Ended::Interrupted;
            }
            self.spent += recorded.seconds;
            self.recordings.push(Recording::read(&path, &ReadOptions::default())?);
            let found = self.diagnose()?;
            let changed = last.as_ref().map_or_else(Vec::new, |before| reasoning::changes(before, &found));
            for line in reasoning::told(&found, &changed) {
                say(&line);
            }
            let next = found.next_experiment.clone();
            rounds.push(Round {
                command: format!("move {motion}"),
                recording: path.display().to_string(),
                seconds: recorded.seconds,
                believed: found.summary.clone(),
                named: reasoning::named(&found),
                blind_to: found.blind_to.iter().map(|b| b.effect.clone()).collect(),
                changed,
                next: next.clone(),
            });
            let testable = found.verdict != Verdict::NotTestable;
            let open = found.experiments.iter().any(|e| !self.given_up().contains(&question(e)));
            moves = alternatives(&found);
            last = Some(found);
            if self.watch.is_interrupted() {
                break Ended::Interrupted;
            }
            if !testable {
                break Ended::NotTestable;
            }
            let Some(next) = next else {
                break if open { Ended::NothingToLearn } else { Ended::OneExplanation };
            };
            for line in reasoning::reasons(&next) {
                say(&line);
            }
            if rounds.len() >= budget.rounds || self.spent + next.motion.seconds > budget.seconds {
                break Ended::Budget;
            }
            for answer in next.answers.iter().filter(|a| reasoning::is_a_reason(a)) {
                *self.tries.entry(question(answer)).or_default() += 1;
            }
        };
        let Some(diagnosis) = last else {
            return Err(Error::Interrupted);
        };
        Ok(Investigation { schema: "tribos.investigation/1", rounds, ended, diagnosis })
    }

    /// Questions that moves chosen for them have not answered.
    fn given_up(&self) -> Vec<Question> {
        self.tries.iter().filter(|(_, tries)| **tries >= TRIES).map(|(q, _)| q.clone()).collect()
    }

    fn diagnose(&self) -> Result<Diagnosis> {
        let options = Options { limits: Some(self.limits), given_up: self.given_up(), ..Options::default() };
        let bar = self.watch.begin("diagnosing");
        Ok(diagnose(&self.recordings, &[], &options, &|share, what| bar.set(share, what))?)
    }

    /// Waits until the handle has come to rest after the move before: until then the device is busy.
    fn let_it_rest(&mut self) -> Result<()> {
        for _ in 0..REST_POLLS {
            self.session.poll()?;
        }
        Ok(())
    }

    /// Makes the first of `moves` that the device takes.
    fn record(
        &mut self,
        moves: &[Move],
        round: usize,
        say: &mut dyn FnMut(&str),
    ) -> Result<(Move, PathBuf, Recorded)> {
        self.let_it_rest()?;
        let mut refused = None;
        for motion in moves {
            let path = self.out.join(format!("round-{round}.csv"));
            let seconds = motion.seconds.unwrap_or(12.0);
            let plan = Plan { motion: Some(*motion), seconds, notes: self.notes.clone() };
            say(&format!("  > move {motion}"));
            match record(self.session, &plan, &path, self.watch) {
                Ok(recorded) => {
                    let lost = recorded.lost;
                    say(&format!("  {}: {} samples, {lost} lost", path.display(), recorded.samples));
                    return Ok((*motion, path, recorded));
                }
                // a move too much for the device is no reason to give up: the next best one may not be
                Err(why) if why.is_declined() => {
                    say(&format!("  {why}"));
                    let _ = self.session.command("clear");
                    refused = Some(why);
                }
                Err(why) => return Err(why.into()),
            }
        }
        Err(refused.map_or(Error::NoMove, Error::Device))
    }
}

fn question(e: &diagnose::Experiment) -> Question {
    (e.effect.clone(), e.rival.clone())
}

/// The move that is best for everything, then the best for each question.
fn alternatives(found: &Diagnosis) -> Vec<Move> {
    let host = |m: &diagnose::Move| Move {
        wave: m.wave,
        amplitude: m.amplitude,
        frequency: m.frequency,
        seconds: Some(m.seconds),
    };
    let mut out: Vec<Move> = found.next_experiment.iter().map(|n| host(&n.motion)).collect();
    for e in &found.experiments {
        let motion = host(&e.motion);
        if e.discrimination >= WORTHWHILE && !out.contains(&motion) {
            out.push(motion);
        }
    }
    out
}
