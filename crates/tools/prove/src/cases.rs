//! Which effects are hidden where, and how strong: planned from one seed, in an order that tells nothing.

use crate::body::Body;
use crate::hidden::{ALL, Hidden, find};
use crate::kind::Kind;
use crate::motion::Programme;
use crate::open::{self, Smooth};
use crate::plant::{History, run};
use crate::scale::NOISE;
use crate::sensors::{Bench, Channels, DECOYS, Decoy, channels};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pairs of effects that are hidden together.
pub(crate) const PAIRS: &[(&str, &str)] = &[
    ("stribeck", "cogging"),
    ("spring", "quadratic_drag"),
    ("presliding", "friction_drift"),
    ("nonlinear_spring", "time_skew"),
    ("position_dependent_friction", "stribeck"),
    ("periodic_friction", "spring"),
    ("hard_stop", "sublinear_viscous"),
    ("torque_ripple", "friction_drift"),
    ("cogging", "force_gain_asymmetry"),
    ("presliding", "spring"),
];

/// Share of an effect left by the baseline (U) below which a recording hides it.
pub(crate) const HIDES: f64 = 0.1;

/// What a case is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// Nothing is hidden.
    Null,
    /// One effect or two, each at this many times the noise.
    Hidden {
        /// The first.
        first: &'static Kind,
        /// The second.
        second: Option<&'static Kind>,
        /// Times the noise.
        strength: f64,
    },
    /// A fault of the recording.
    Decoy(&'static Decoy),
}

/// A case as planned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Planned {
    /// What is hidden.
    pub purpose: Purpose,
    /// Draws everything else.
    pub seed: u64,
}

/// A case with its plant.
pub(crate) struct Scene {
    /// The bench.
    pub bench: Bench,
    /// The body.
    pub body: Body,
    /// What is hidden, in its final size.
    pub hidden: Vec<Hidden>,
    /// Times the noise that were reached.
    pub reached: Vec<f64>,
    /// Share of what is hidden, all of it together, that mass, Coulomb and viscous friction do not absorb (U).
    pub left: f64,
    /// What was recorded, without noise.
    pub recorded: (History, Channels),
    /// The same bench on another motion.
    pub again: (History, Channels),
}

/// What to plan.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Extent {
    /// Recordings of each case.
    pub seeds: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Times the noise.
    pub strengths: Vec<f64>,
    /// Length of a recording, s.
    pub seconds: f64,
    /// Effects to hide; all when empty.
    pub effects: Vec<String>,
    /// Whether pairs and decoys are part of it.
    pub companions: bool,
    /// Hide what is in nobody's catalogue, instead of the catalogue.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub open: bool,
}

/// All cases in an order drawn from the seed.
pub(crate) fn plan(extent: &Extent) -> Vec<Planned> {
    let mut purposes = Vec::new();
    let wanted = |k: &Kind| extent.effects.is_empty() || extent.effects.iter().any(|e| e == k.id);
    let all = if extent.open { open::ALL } else { ALL };
    for first in all.iter().filter(|k| wanted(k)) {
        let strengths = if first.never { &[1.0][..] } else { &extent.strengths };
        for &strength in strengths {
            purposes.push((Purpose::Hidden { first, second: None, strength }, extent.seeds));
        }
    }
    if extent.companions {
        let at = extent.strengths.iter().copied().filter(|s| *s >= 1.0);
        for strength in at {
            for (a, b) in PAIRS {
                if let (Some(first), Some(b)) = (find(a), find(b)) {
                    let hidden = Purpose::Hidden { first, second: Some(b), strength };
                    purposes.push((hidden, extent.seeds.div_ceil(2)));
                }
            }
        }
        purposes.extend(DECOYS.iter().map(|d| (Purpose::Decoy(d), extent.seeds)));
    }
    purposes.push((
        Purpose::Null,
        extent.seeds * if extent.companions || (extent.open && extent.effects.is_empty()) { 10 } else { 1 },
    ));
    let mut random = ChaCha8Rng::seed_from_u64(extent.seed);
    let mut planned: Vec<Planned> = purposes
        .iter()
        .flat_map(|(purpose, count)| (0..*count).map(|_| *purpose))
        .map(|purpose| Planned { purpose, seed: random.random() })
        .collect();
    for i in (1..planned.len()).rev() {
        planned.swap(i, random.random_range(0..=i));
    }
    planned
}

/// Draws a plant and a motion, and sizes what is hidden.
pub(crate) fn stage(planned: &Planned, seconds: f64) -> Scene {
    let mut random = ChaCha8Rng::seed_from_u64(planned.seed);
    let (kinds, strength): (Vec<&'static Kind>, f64) = match planned.purpose {
        Purpose::Hidden { first, second, strength } => {
            (std::iter::once(first).chain(second).collect(), strength)
        }
        _ => (Vec::new(), 0.0),
    };
    let has = |id: &str| kinds.iter().any(|k| k.id == id);
    // channels and benches vary for all alike, so that what is there says nothing
    let rotary = random.random::<f64>() < 0.25 || kinds.iter().any(|k| k.rotary);
    let velocity = random.random::<bool>() || has("velocity_lag");
    let acceleration = random.random::<f64>() < 0.3;
    // rate and state would be a friction of the load where one is recorded
    let load = (random.random::<f64>() < 0.3 || has("load_dependent_friction")) && !has("rate_and_state");
    let bench = Bench { half: if rotary { 1.0 } else { 0.01 }, rotary, velocity, acceleration, load };
    let mut within = |low: f64, high: f64| random.random_range(low..high);
    let coulomb = within(1.2, 2.2);
    let viscous = within(0.03, 0.06);
    let body = Body {
        mass: within(0.003, 0.006),
        coulomb: [coulomb * within(0.85, 1.15), coulomb * within(0.85, 1.15)],
        viscous: [viscous * within(0.8, 1.2), viscous * within(0.8, 1.2)],
    };
    let mut hidden: Vec<Hidden> = kinds
        .iter()
        .map(|kind| Hidden {
            kind,
            size: kind.size.0 * strength,
            scale: within(0.75, 1.3),
            phase: within(0.0, std::f64::consts::TAU),
            smooth: Smooth::draw(planned.seed ^ 0x6f70),
        })
        .collect();
    for h in hidden.iter_mut().filter(|h| h.kind.id == "gravity") {
        h.phase *= 0.1;
    }
    let programme = Programme::new(seconds, planned.seed ^ 0x6d6f);
    let mut reached = vec![0.0; hidden.len()];
    for i in 0..hidden.len() {
        if hidden[i].kind.never {
            hidden[i].size = hidden[i].kind.size.0;
            continue;
        }
        for _ in 0..10 {
            let alone = [hidden[i]];
            let history = run(&body, &alone, &programme, seconds);
            reached[i] = unabsorbed(&history, &channels(&history, &body, &alone)) / NOISE;
            let ratio = strength / reached[i].max(1e-9);
            if (ratio - 1.0).abs() < 0.03 {
                break;
            }
            hidden[i].size = (hidden[i].size * ratio.clamp(0.1, 5.0)).min(hidden[i].most(&body));
        }
    }
    let make = |programme: &Programme| {
        let history = run(&body, &hidden, programme, seconds);
        let seen = channels(&history, &body, &hidden);
        (history, seen)
    };
    let recorded = make(&programme);
    let again = make(&Programme::new(seconds, planned.seed ^ 0x6167_6169));
    let left = share_left(&recorded.0, &recorded.1);
    Scene { bench, body, hidden, reached, left, recorded, again }
}

/// Share of the force beyond the baseline that the baseline cannot absorb, rms over rms; 0 where there is none.
fn share_left(history: &History, seen: &Channels) -> f64 {
    let (sum, count) = (0..seen.y.len())
        .filter(|&i| history.slides[i])
        .fold((0.0, 0.0), |(sum, count), i| (sum + seen.beyond[i].powi(2), count + 1.0));
    if sum > 0.0 { unabsorbed(history, seen) / f64::sqrt(sum / count) } else { 0.0 }
}

/// Rms over sliding samples of what is left of the force beyond the baseline after the baseline took what it can.
pub(crate) fn unabsorbed(history: &History, seen: &Channels) -> f64 {
    let rows: Vec<usize> = (0..seen.y.len()).filter(|&i| history.slides[i]).collect();
    if rows.len() < 100 {
        return 0.0;
    }
    let column = |i: usize| {
        let (a, w) = (history.a[i], history.w[i]);
        let forward = f64::from(u8::from(w > 0.0));
        [a, forward, forward - 1.0, forward * w, (1.0 - forward) * w]
    };
    let mut gram = DMatrix::<f64>::zeros(5, 5);
    let mut moment = DVector::<f64>::zeros(5);
    let mut power = 0.0;
    for &i in &rows {
        let c = column(i);
        let e = seen.beyond[i];
        power += e * e;
        for p in 0..5 {
            moment[p] += c[p] * e;
            for q in 0..5 {
                gram[(p, q)] += c[p] * c[q];
            }
        }
    }
    let taken = gram.cholesky().map_or(0.0, |g| moment.dot(&g.solve(&moment)));
    ((power - taken).max(0.0) / rows.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_motion_shows_is_absorbed_by_the_baseline_and_nothing_else_is() {
        for kind in ALL {
            let planned =
                Planned { purpose: Purpose::Hidden { first: kind, second: None, strength: 1.0 }, seed: 11 };
            let left = stage(&planned, 8.0).left;
            println!("{:<28} {:.1} % left", kind.id, 100.0 * left);
            assert_eq!(left < HIDES, kind.never, "{}", kind.id);
        }
    }

    #[test]
    fn every_effect_reaches_the_strength_it_is_asked_for() {
        for kind in ALL.iter().filter(|k| !k.never) {
            for strength in [0.3, 5.0] {
                let planned =
                    Planned { purpose: Purpose::Hidden { first: kind, second: None, strength }, seed: 7 };
                let scene = stage(&planned, 8.0);
                println!(
                    "{:<28} × {strength}: {:.3}, size {:.4}",
                    kind.id, scene.reached[0], scene.hidden[0].size
                );
                // a late velocity turns Coulomb friction round by whole samples: one is the least it can do
                let steps = kind.id == "velocity_lag";
                let reached = (scene.reached[0] / strength - 1.0).abs() < 0.1;
                assert!(reached || strength > 1.0 || steps, "{}", kind.id);
            }
        }
    }
}
