//! The plant: a body on a contact, driven by a controller of its own.
//!
//! Contact is a set-valued law stepped implicitly (Moreau's time stepping): the impulse of friction is whatever stops the
//! body within the step, up to its level. There is no velocity band, no state machine of sticking and no smoothed sign.
//! Bristles are a field of elements, each with its own distance to slip. A second body hangs on the first by a spring
//! or by a contact with play. Lengths are in half strokes, so one set of numbers does for a slide and for an axis.

use crate::body::{Body, State};
use crate::hidden::{Bristle, Hidden, REFERENCE};
use crate::motion::{LOAD, Programme};
use crate::scale::RATE;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Steps per sample.
const STEPS: usize = 40;
/// Time constant with which the distance slid is forgotten, s.
const FADES: f64 = 0.5;
/// Forces kept per sample, so that a channel can be late by less than a sample.
pub(crate) const FINE: usize = 8;

/// Noise-free history, one entry a sample.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    /// Half strokes.
    pub y: Vec<f64>,
    /// Half strokes/s.
    pub w: Vec<f64>,
    /// Half strokes/s².
    pub a: Vec<f64>,
    /// Force of what is hidden in the contact.
    pub extra: Vec<f64>,
    /// Load on the contact, N or N·m.
    pub load: Vec<f64>,
    /// Whether the body slides.
    pub slides: Vec<bool>,
    /// Force on the body, [`FINE`] a sample.
    pub force: Vec<f64>,
    /// Force that was commanded, likewise.
    pub command: Vec<f64>,
}

/// The body that hangs on the first one.
struct Second {
    mass: f64,
    stiffness: f64,
    damping: f64,
    gap: f64,
    y: f64,
    w: f64,
}

impl Second {
    /// Force on the first body, against positive motion.
    fn pull(&self, y: f64, w: f64) -> f64 {
        let stretch = y - self.y;
        let beyond = stretch - stretch.clamp(-0.5 * self.gap, 0.5 * self.gap);
        if self.gap > 0.0 && beyond == 0.0 {
            0.0
        } else {
            self.stiffness * beyond + self.damping * (w - self.w)
        }
    }
}

/// Runs the plant for `seconds` after a second of settling.
pub(crate) fn run(body: &Body, hidden: &[Hidden], programme: &Programme, seconds: f64) -> History {
    let warm = 1.0;
    let h = 1.0 / (RATE * STEPS as f64);
    let samples = ((seconds + warm) * RATE) as usize;
    let first = (warm * RATE) as usize;
    let (stiffness, damping) = {
        let natural = TAU * 22.0;
        (body.mass * natural * natural, 1.6 * body.mass * natural)
    };
    let size = |id: &str| hidden.iter().find(|e| e.kind.id == id).map_or(0.0, |e| e.size);
    let lag = size("actuator_lag");
    let mut bristles: Vec<Bristle> = hidden.iter().flat_map(Hidden::bristles).collect();
    let renewal = hidden.iter().find_map(Hidden::renewal);
    let mut theta = renewal.map_or(0.0, |d| d / REFERENCE);
    let mut second = second(body, size("compliance"), size("backlash"));
    // velocities between now and as long ago as friction is late
    let late_by = hidden.iter().find_map(Hidden::lag).map(|time| (time / h).round() as usize);
    let mut past: VecDeque<f64> = VecDeque::from(vec![0.0; late_by.unwrap_or(0)]);
    let first_mass = body.mass - second.as_ref().map_or(0.0, |s| s.mass);

    let (mut y, mut w, mut real) = (programme.at(0.0), 0.0_f64, 0.0);
    let (mut age, mut late) = (0.0_f64, 1.0);
    let (mut a, mut slid) = (0.0_f64, 0.0_f64);
    let mut out = History::default();
    for sample in 0..samples {
        let at = |k: i64| programme.at((sample as i64 + k) as f64 / RATE);
        let (before, here, next, then) = (at(-1), at(0), at(1), at(2));
        // without a jump from one sample to the next, which every sample would meet in the same phase
        let speeds = [0.5 * (next - before) * RATE, 0.5 * (then - here) * RATE];
        for step in 0..STEPS {
            let share = step as f64 / STEPS as f64;
            let asked = here + (next - here) * share;
            let asked_speed = speeds[0] + (speeds[1] - speeds[0]) * share;
            let command = stiffness * (asked - y) + damping * (asked_speed - w);
            real = if lag > 0.0 { real + (command - real) * (1.0 - (-h / lag).exp()) } else { command };
            let t = (sample as f64 + share) / RATE - warm;
            let load = programme.load(t);
            let state = State { y, w, a, slid, t, seconds, load: load / LOAD, age, theta, drive: real, late };
            let even: f64 = hidden.iter().map(|e| e.force(&state)).sum();
            let bent: f64 = bristles.iter().map(Bristle::pull).sum();
            let hung = second.as_ref().map_or(0.0, |s| s.pull(y, w));

            let free = w + h / first_mass * (real - even - bent - hung);
            let s = if free < 0.0 { -1.0 } else { 1.0 };
            let side = usize::from(s < 0.0);
            let added: f64 = hidden.iter().map(|e| e.level(s, &state)).sum();
            // What is hidden can make friction smaller, never negative.
            let level = (body.coulomb[side] + added).max(0.0);
            let stop = h * level / first_mass;
            let after = if free.abs() <= stop {
                0.0
            } else {
                (free - s * stop) / (1.0 + h * body.viscous[side] / first_mass)
            };
            let acceleration = (after - w) / h;

            if sample >= first {
                if step % (STEPS / FINE) == 0 {
                    out.force.push(real);
                    out.command.push(command);
                }
                if step == 0 {
                    let inertia = second.as_ref().map_or(0.0, |s| hung - s.mass * acceleration);
                    out.y.push(y);
                    out.w.push(w);
                    out.a.push(acceleration);
                    out.load.push(load);
                    out.slides.push(after != 0.0 && w != 0.0);
                    out.extra.push(even + bent + s * (level - body.coulomb[side]) + inertia);
                }
            }

            // of a sample, not of a step: a drive that chatters within one accelerates nothing
            a += (acceleration - a) * (h * RATE);
            w = after;
            let moved = w * h;
            slid += moved.abs() - slid * h / FADES;
            y += moved;
            bristles.iter_mut().for_each(|b| b.take(moved));
            if let Some(d) = renewal {
                // implicit: an explicit step would overshoot where a sample is longer than the renewal
                theta = (theta + h) / (1.0 + moved.abs() / d);
            }
            age = (age + h) / (1.0 + moved.abs() / 0.02);
            past.push_back(w);
            if let Some(followed) = past.pop_front().filter(|w| *w != 0.0) {
                late = followed.signum();
            }
            if let Some(b) = &mut second {
                b.w += h / b.mass * hung;
                b.y += h * b.w;
            }
        }
    }
    out
}

/// A second body on a spring that gives by `give`, or behind a play with the mass `loose` (as shares of the whole mass).
fn second(body: &Body, give: f64, loose: f64) -> Option<Second> {
    if give > 0.0 {
        let mass = 0.35 * body.mass;
        let natural = TAU * 30.0 / give.sqrt();
        let stiffness = mass * natural * natural;
        let damping = 0.3 * mass * natural;
        return Some(Second { mass, stiffness, damping, gap: 0.0, y: 0.0, w: 0.0 });
    }
    (loose > 0.0).then(|| {
        let mass = loose * body.mass;
        let natural = TAU * 120.0;
        let (stiffness, damping) = (mass * natural * natural, 0.8 * mass * natural);
        Second { mass, stiffness, damping, gap: 0.02, y: 0.0, w: 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Body = Body { mass: 0.0042, coulomb: [1.75, 1.6], viscous: [0.04, 0.05] };

    #[test]
    fn forces_balance_while_it_slides_and_it_truly_rests() {
        let history = run(&BODY, &[], &Programme::new(8.0, 3), 8.0);
        let mut worst: f64 = 0.0;
        let mut rests = 0;
        for i in 0..history.y.len() {
            if history.slides[i] {
                let said = BODY.force(history.a[i], history.w[i]);
                worst = worst.max((said - history.force[i * FINE]).abs());
            } else {
                rests += usize::from(history.w[i] == 0.0);
            }
        }
        println!("worst imbalance {worst:.4} N, {rests} samples at rest");
        assert!(worst < 0.02, "{worst}");
        assert!(rests > 200, "{rests}");
    }

    #[test]
    fn the_acceleration_of_a_sample_is_that_of_its_neighbourhood() {
        let history = run(&BODY, &[], &Programme::new(8.0, 3), 8.0);
        let (mut both, mut own) = (0.0, 0.0);
        for i in 3..history.y.len() - 3 {
            if (i - 3..i + 4).all(|j| history.slides[j] && history.w[j] * history.w[i] > 0.0) {
                let mean = 0.5 * RATE * (history.w[i + 1] - history.w[i - 1]);
                both += mean * history.a[i];
                own += history.a[i] * history.a[i];
            }
        }
        println!("slope of the difference on the acceleration: {:.4}", both / own);
        assert!((both / own - 1.0).abs() < 0.01, "{}", both / own);
    }

    #[test]
    fn what_is_hidden_is_what_the_baseline_leaves() {
        let kind = super::super::hidden::find("cogging").unwrap();
        let smooth = crate::open::Smooth::draw(1);
        let effect = Hidden { kind, size: 0.3, scale: 1.0, phase: 0.4, smooth };
        let history = run(&BODY, &[effect], &Programme::new(8.0, 3), 8.0);
        for i in (0..history.y.len()).filter(|&i| history.slides[i]) {
            let left = history.force[i * FINE] - BODY.force(history.a[i], history.w[i]);
            assert!((left - history.extra[i]).abs() < 0.02, "{left} against {}", history.extra[i]);
        }
    }
}
