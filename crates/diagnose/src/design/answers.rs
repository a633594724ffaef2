//! The questions a diagnosis leaves open, and the moves that answer them.

use super::{Designer, Experiment, Move, Question, elsewhere};
use crate::ambiguity::Rival;
use crate::result::{Blind, Missing};
use crate::search::Atom;
use serde::Serialize;

/// Where the device can make no move at all.
const NO_MOVE: &str = "no move within the limits: more stroke, speed or force is needed";

/// The one move that is best for everything that is open.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextExperiment {
    /// The command for the serial line.
    pub command: String,
    /// The same, to be read by a program.
    #[serde(rename = "move")]
    pub motion: Move,
    /// What it does for each open question.
    pub answers: Vec<Experiment>,
}

/// What is open, with the moves that answer it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Answers {
    pub blind: Vec<Blind>,
    pub experiments: Vec<Experiment>,
    pub next_experiment: Option<NextExperiment>,
}

impl Designer<'_> {
    /// Says of each open question which move answers it, or what else would. `rivals` are those of each missing effect.
    pub fn answer(
        &self,
        rivals: &[Vec<Rival>],
        blind: Vec<(Blind, Option<Atom>)>,
        missing: &mut [Missing],
    ) -> Answers {
        let mut questions = Vec::new();
        for (named, rivals) in rivals.iter().enumerate() {
            let fits = rivals.iter().filter_map(|r| r.fit.clone());
            questions.extend(fits.map(|rival| Question::Rival { named, rival }));
        }
        questions.extend(blind.iter().filter_map(|(_, atom)| atom.clone()).map(Question::Unseen));
        let plan = self.plan(&questions);
        let mut each = questions.iter().zip(&plan.each);
        for (entry, rivals) in missing.iter_mut().zip(rivals) {
            let (mut moves, mut others, mut standing) = (Vec::new(), Vec::new(), Vec::new());
            for rival in rivals {
                if rival.fit.is_none() {
                    standing.push(rival.id);
                    others.extend(elsewhere(rival.id, false).map(String::from));
                    continue;
                }
                let Some((question, best)) = each.next() else { continue };
                if best.as_ref().is_some_and(|e| self.contains(question, e)) {
                    // over a part of a turn a pendulum is a spring
                    if rival.id == "gravity" {
                        standing.push(rival.id);
                        others.extend(elsewhere(rival.id, true).map(String::from));
                    }
                    continue;
                }
                let best = best.as_ref();
                standing.push(rival.id);
                moves.push(best.map_or_else(|| NO_MOVE.into(), Experiment::says));
            }
            // a move first: it can be pasted
            moves.append(&mut others);
            entry.experiment = moves.join("; ");
            entry.indistinguishable_from = standing.into_iter().map(Into::into).collect();
        }
        let mut seen = Vec::new();
        for (mut entry, atom) in blind {
            if atom.is_some() {
                let best = each.next().and_then(|(_, best)| best.as_ref());
                entry.experiment = best.map_or_else(|| NO_MOVE.into(), Experiment::says);
            }
            seen.push(entry);
        }
        let next_experiment = plan.together.first().map(|e| NextExperiment {
            command: e.command.clone(),
            motion: e.motion,
            answers: plan.together.clone(),
        });
        let open = |e: &Experiment| {
            e.rival.is_none()
                || missing.iter().any(|m| {
                    m.effect == e.effect
                        && m.indistinguishable_from.iter().any(|r| Some(r) == e.rival.as_ref())
                })
        };
        let experiments = plan.each.into_iter().flatten().filter(open).collect();
        Answers { blind: seen, experiments, next_experiment }
    }
}
