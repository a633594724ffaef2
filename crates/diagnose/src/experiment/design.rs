//! Which move tells rival explanations apart, by simulating them.
//!
//! T-optimal design (Atkinson and Fedorov 1975): for every move the device can make, a body with the parameters that
//! were fitted is moved; the rival, every linear parameter and its shape free, is fitted to what the other says of this
//! motion *and* of all that was recorded so far; what the best such fit leaves, in units of the noise floor, is the
//! discrimination of the move. It is taken both ways, each explanation being the truth in turn, and the worse counts.
//! An effect that was not visible so far is taken as strong as the noise floor, and its rival is the baseline alone.

use crate::experiment::evidence::{Contrast, Evidence};
use crate::experiment::moves::{Limits, Move, simulate};
use crate::experiment::proposal::{ENOUGH, Experiment, WORTHWHILE};
use crate::findings::free_run::Plant;
use crate::library::design_matrix::DesignMatrix;
use crate::library::kept::Column;
use crate::preparation::track::Reversals;
use crate::search::catalogue::needed_reliability;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use rayon::prelude::*;
use signals::{Basis, Channels, dot};

/// Length of a proposed move, s.
const SECONDS: f64 = 12.0;
/// Longest part of a move that is simulated, s, and fewest periods of it: the rest of it says the same again.
const SIMULATED: (f64, f64) = (5.0, 4.0);
/// What a question about what was named counts beside one about what was not seen.
const NAMED: f64 = 3.0;

/// Cosine with the best move above which a larger law contains the smaller one, as a wave much longer than the stroke
/// contains a spring: the same force in more parameters is not another explanation. However long the recording, the little
/// that it bends to fit is other physics that neither has.
const CONTAINS: f64 = 0.998;

/// One thing the recordings leave open.
#[derive(Debug, Clone)]
pub(crate) enum Question {
    /// Atom `named` of what was found against a rival hypothesis whose last atom stands in its place.
    Rival { named: usize, rival: Hypothesis },
    /// An effect that was not visible.
    Unseen(Atom),
}

/// Everything a design is made from.
pub(crate) struct Designer<'a> {
    pub search: &'a Search<'a>,
    pub found: &'a Hypothesis,
    /// What moves: the found model.
    pub plant: Plant,
    pub limits: Limits,
    /// Noise floor of a row.
    pub floor: f64,
    pub cutoff: f64,
    /// Dominant frequency so far, Hz.
    pub frequency: f64,
    /// The recordings have a velocity channel.
    pub velocity: bool,
    /// Questions that no move is to be made for.
    pub given_up: &'a [(String, Option<String>)],
}

/// The answer to a set of questions.
#[derive(Debug, Clone, Default)]
pub(crate) struct Plan {
    /// Best move for each question; None where the device can make no move at all.
    pub each: Vec<Option<Experiment>>,
    /// The move that is best for all of them together, and what it does for each question.
    pub together: Vec<Experiment>,
}

impl Designer<'_> {
    /// The best move for each question, and for all.
    pub fn plan(&self, questions: &[Question]) -> Plan {
        if questions.is_empty() {
            return Plan::default();
        }
        let friction = self.plant.coulomb.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let candidates = self.limits.candidates(self.plant.mass, friction, self.frequency, SECONDS);
        let evidence: Vec<Evidence> = questions.iter().map(|q| self.evidence(q)).collect();
        let judged: Vec<Vec<Option<Experiment>>> = candidates
            .par_iter()
            .map(|motion| {
                let Some(design) = self.design_of(motion) else { return vec![None; questions.len()] };
                let of = |(q, e): (&Question, &Evidence)| self.judge(motion, &design, q, e);
                questions.iter().zip(&evidence).map(of).collect()
            })
            .collect();
        let mut each: Vec<Option<Experiment>> = vec![None; questions.len()];
        for row in &judged {
            for (slot, e) in each.iter_mut().zip(row) {
                if let Some(e) = e
                    && slot.as_ref().is_none_or(|s| e.discrimination > s.discrimination)
                {
                    *slot = Some(e.clone());
                }
            }
        }
        let open: Vec<bool> = questions
            .iter()
            .zip(&each)
            .map(|(q, best)| best.as_ref().is_some_and(|e| !self.is_given_up(e) && !self.contains(q, e)))
            .collect();
        let mut together = Vec::new();
        let mut best = 0.0;
        for row in judged {
            let worth: f64 = row
                .iter()
                .zip(&open)
                .filter_map(|(e, open)| e.as_ref().filter(|_| *open))
                .filter(|e| e.discrimination >= WORTHWHILE.max(1.2 * e.discrimination_now))
                .map(|e| {
                    let weight = if e.rival.is_some() { NAMED } else { 1.0 };
                    weight * (e.discrimination.min(ENOUGH) - e.discrimination_now.min(ENOUGH)).max(0.0)
                })
                .sum();
            if worth > best {
                best = worth;
                together = row.into_iter().zip(&open).filter_map(|(e, open)| e.filter(|_| *open)).collect();
            }
        }
        Plan { each, together }
    }

    /// Whether a rival that is larger than what was named contains it, by the best move there is.
    pub fn contains(&self, question: &Question, best: &Experiment) -> bool {
        let Question::Rival { named, rival } = question else { return false };
        let size = |a: &Atom| a.columns.len() + a.term.kind.shape().len();
        let larger = rival.atoms.last().is_some_and(|theirs| size(theirs) > size(&self.found.atoms[*named]));
        larger && best.cosine > CONTAINS
    }

    /// The simulated recording of a move, behind the same filter as the real ones.
    fn design_of(&self, motion: &Move) -> Option<DesignMatrix> {
        let first = self.search.design.tracks.first()?;
        // no finer than the filter needs
        let dt = first.raw.dt.max(1.0 / (16.0 * self.cutoff));
        let part = Move { seconds: simulated(motion), ..*motion };
        let travel = simulate(&self.plant, &self.limits, &part, dt);
        if travel.position.iter().chain(&travel.force).any(|x| !x.is_finite()) {
            return None;
        }
        // where the real sensors do not know the direction, these shall not, either
        let guard = self.search.design.tracks.iter().map(|t| 3.0 * t.noise.velocity).fold(0.0, f64::max);
        let reversals = Reversals {
            static_band: first.reversals.static_band.max(guard),
            one_way: None,
            ..first.reversals
        };
        let channels = Channels {
            dt,
            position: travel.position,
            velocity: self.velocity.then_some(travel.velocity),
            force: travel.force,
            ..Channels::default()
        };
        let mut design = DesignMatrix::new(&[channels], self.cutoff, reversals, self.search.design.delay)?;
        if design.present != self.search.design.present {
            return None; // what was fitted does not say what happens there
        }
        // a nuisance of a recording already made is none of this one
        let rows = design.y.len();
        design.baseline.resize(self.search.design.baseline.len(), vec![0.0; rows]);
        design.model_force(&crate::search::applied_force::applied_force(self.search.design, self.found));
        Some(design)
    }

    /// What the recordings already say about a question.
    fn evidence(&self, question: &Question) -> Evidence {
        let (forth, back) = self.contrasts(self.search.design, question, None);
        Evidence::new(forth, back)
    }

    fn judge(
        &self,
        motion: &Move,
        design: &DesignMatrix,
        question: &Question,
        evidence: &Evidence,
    ) -> Option<Experiment> {
        let (forth, back) = self.contrasts(design, question, evidence.scale);
        let times = motion.seconds / simulated(motion);
        let mut judged = evidence.with(&forth, back.as_ref(), times, self.floor)?;
        if let Question::Unseen(atom) = question {
            // what its sensors' noise covers cannot be seen, however strong it is
            if atom.reliable < needed_reliability(atom.term.kind) {
                judged.now = 0.0;
            }
            if !self.is_above_its_noise(design, atom) {
                judged.after = judged.now;
            }
        }
        let (effect, rival) = self.names(question);
        Some(Experiment {
            effect,
            rival,
            command: motion.to_string(),
            motion: *motion,
            discrimination: judged.after,
            discrimination_now: judged.now,
            cosine_now: judged.cosine_now,
            cosine: judged.cosine,
        })
    }

    /// Whether an effect's signature on a move is more than what the sensors' noise makes of it: that noise was drawn on the
    /// recordings, and is the same on every move.
    fn is_above_its_noise(&self, design: &DesignMatrix, atom: &Atom) -> bool {
        let left = |design: &DesignMatrix, columns: &[Column]| -> f64 {
            let basis = Basis::of(&design.baseline);
            columns.iter().map(|c| basis.left(c)).sum::<f64>() / design.y.len().max(1) as f64
        };
        let noise = (1.0 - atom.reliable).max(0.0) * left(self.search.design, &atom.columns);
        noise <= (1.0 - needed_reliability(atom.term.kind)) * left(design, &active(design, atom))
    }

    /// Whichever of the two was named.
    fn is_given_up(&self, e: &Experiment) -> bool {
        self.given_up.iter().any(|(effect, rival)| match (&e.rival, rival) {
            (None, None) => e.effect == *effect,
            (Some(other), Some(rival)) => {
                (&e.effect, other) == (effect, rival) || (&e.effect, other) == (rival, effect)
            }
            _ => false,
        })
    }

    fn names(&self, question: &Question) -> (String, Option<String>) {
        match question {
            Question::Unseen(atom) => (atom.term.kind.id().into(), None),
            Question::Rival { named, rival } => (
                self.found.atoms[*named].term.kind.id().into(),
                rival.atoms.last().map(|a| a.term.kind.id().to_string()),
            ),
        }
    }

    /// Both directions of a question on a design matrix: what one explanation says beyond the other, and the columns with which
    /// the other may answer.
    fn contrasts(
        &self,
        design: &DesignMatrix,
        question: &Question,
        scale: Option<f64>,
    ) -> (Contrast, Option<Contrast>) {
        match question {
            Question::Unseen(atom) => {
                let mut own = vec![0.0; design.y.len()];
                for column in design.kept_columns(&atom.term).iter() {
                    add(&mut own, column, 1.0);
                }
                // as strong as the noise floor: on what was recorded, or where it was never excited on the move
                let size = (dot(&own, &own) / design.y.len().max(1) as f64).sqrt();
                let scale = scale.or_else(|| (size > 0.0).then(|| self.floor / size));
                own.iter_mut().for_each(|x| *x *= scale.unwrap_or(0.0));
                let mut shared: Vec<Vec<f64>> = design.baseline.clone();
                for (i, a) in self.found.atoms.iter().enumerate() {
                    shared.extend(active(design, a).iter().map(|c| c.to_vec()));
                    shared.extend(self.slopes(design, a, self.found.coefficients(self.search.design, i)));
                }
                (Contrast { target: own.clone(), own, shared, answer: Vec::new(), scale }, None)
            }
            Question::Rival { named, rival } => {
                let last = rival.atoms.len().saturating_sub(1);
                let (a, b) = (self.says(design, self.found), self.says(design, rival));
                let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
                let mut shared: Vec<Vec<f64>> = design.baseline.clone();
                for (i, atom) in self.found.atoms.iter().enumerate() {
                    if i != *named {
                        shared.extend(active(design, atom).iter().map(|c| c.to_vec()));
                    }
                }
                let side = |h: &Hypothesis, i: usize| -> (Vec<f64>, Vec<Vec<f64>>) {
                    let coefficients = h.coefficients(self.search.design, i);
                    let columns = active(design, &h.atoms[i]);
                    let mut own = vec![0.0; design.y.len()];
                    for (column, c) in columns.iter().zip(coefficients) {
                        add(&mut own, column, *c);
                    }
                    let slopes = self.slopes(design, &h.atoms[i], coefficients);
                    (own, columns.iter().map(|c| c.to_vec()).chain(slopes).collect())
                };
                let ((own_a, answer_a), (own_b, answer_b)) = (side(self.found, *named), side(rival, last));
                (
                    Contrast {
                        target: difference.clone(),
                        own: own_a,
                        shared: shared.clone(),
                        answer: answer_b,
                        scale: None,
                    },
                    Some(Contrast { target: difference, own: own_b, shared, answer: answer_a, scale: None }),
                )
            }
        }
    }

    /// What a hypothesis predicts on a design matrix.
    fn says(&self, design: &DesignMatrix, h: &Hypothesis) -> Vec<f64> {
        let mut out = vec![0.0; design.y.len()];
        for (column, c) in design.baseline.iter().zip(&h.fit.coefficients) {
            add(&mut out, column, *c);
        }
        for (i, atom) in h.atoms.iter().enumerate() {
            for (column, c) in active(design, atom).iter().zip(h.coefficients(self.search.design, i)) {
                add(&mut out, column, *c);
            }
        }
        out
    }

    /// How an atom's force changes with its shape: a rival may still bend.
    fn slopes(&self, design: &DesignMatrix, atom: &Atom, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let mut out = Vec::new();
        for (axis, parameter) in atom.term.kind.shape().iter().enumerate() {
            let (low, high, _) = self.search.scales.range(parameter);
            let here = atom.term.shape[axis];
            let step = (0.02 * here.abs()).max(1e-4 * (high - low));
            let side = |sign: f64| {
                let mut other = atom.clone();
                other.term.shape[axis] = here + sign * step;
                let mut sum = vec![0.0; design.y.len()];
                for (column, c) in active(design, &other).iter().zip(coefficients) {
                    add(&mut sum, column, *c);
                }
                sum
            };
            out.push(side(1.0).iter().zip(side(-1.0)).map(|(a, b)| (a - b) / (2.0 * step)).collect());
        }
        out
    }
}

/// Length of a move that is simulated, s.
fn simulated(motion: &Move) -> f64 {
    SIMULATED.0.max(SIMULATED.1 / motion.frequency).min(motion.seconds)
}

/// Those of an atom's columns that are fitted. Every question asks for those of everything that was found.
fn active(design: &DesignMatrix, atom: &Atom) -> Vec<Column> {
    let all = design.kept_columns(&atom.term);
    atom.active.iter().filter_map(|i| all.get(*i).cloned()).collect()
}

fn add(sum: &mut [f64], column: &[f64], c: f64) {
    for (s, x) in sum.iter_mut().zip(column) {
        *s += c * x;
    }
}
