//! The questions a diagnosis leaves open, and the moves that answer them.

use crate::experiment::design::{Designer, Question};
use crate::experiment::other_means::elsewhere;
use crate::experiment::proposal::{Experiment, NextExperiment};
use crate::findings::ambiguity::Rival;
use crate::result::{Blind, Missing};
use crate::search::hypothesis::Atom;

/// Where the device can make no move at all.
const NO_MOVE: &str = "no move within the limits: more stroke, speed or force is needed";

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
                    standing.push(rival.about.id);
                    others.extend(elsewhere(rival.about, false).map(String::from));
                    continue;
                }
                let Some((question, best)) = each.next() else { continue };
                if best.as_ref().is_some_and(|e| self.contains(question, e)) {
                    // over part of a turn a pendulum acts as a spring; a test without motion may still separate them
                    if let Some(test) = elsewhere(rival.about, true) {
                        standing.push(rival.about.id);
                        others.push(test.to_string());
                    }
                    continue;
                }
                let best = best.as_ref();
                standing.push(rival.about.id);
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
