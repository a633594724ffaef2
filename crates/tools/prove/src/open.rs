//! The open world: forces that are in nobody's catalogue. Half of them are random smooth functions of a coordinate, of a pair
//! of coordinates or of what was slid; the others are what machines do.

use crate::body::State;
use crate::kind::Kind;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

const PLACE: &[&str] = &["position", "position_forward", "position_backward"];
const SPEED: &[&str] = &["velocity", "low_speed"];
const FAST: &[&str] = &["acceleration", "jerk", "force"];
const BOTH: &[&str] = &["position", "position_forward", "position_backward", "velocity", "low_speed"];
const WARM: &[&str] = &["time", "velocity", "low_speed"];
const ONCE: &[&str] = &["time"];
const SLID: &[&str] = &["low_speed", "velocity", "time_since_reversal", "distance_since_reversal", "time"];

const fn kind(id: &'static str, shows_over: &'static [&'static str]) -> Kind {
    Kind { id, also: &["unnamed"], shows_over, size: (0.5, 20.0), rotary: false, never: false }
}

/// What is hidden in the open world. `random_…` are drawn; the others are forms.
pub(crate) const ALL: &[Kind] = &[
    kind("random_position", PLACE),
    kind("random_position_friction", PLACE),
    kind("random_velocity", SPEED),
    kind("random_acceleration", FAST),
    kind("random_position_velocity", BOTH),
    kind("random_time_velocity", WARM),
    kind("random_slid", SLID),
    kind("one_sided_spring", PLACE),
    kind("detent", PLACE),
    kind("eddy_current_brake", SPEED),
    kind("dried_lubricant", PLACE),
    kind("warming_grease", WARM),
    kind("screw_tight_in_the_middle", BOTH),
    kind("heated_by_sliding", SLID),
    kind("friction_steps_once", ONCE),
    kind("cable_caught_once", ONCE),
];

/// A smooth function of two numbers of the size of one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Smooth {
    /// Amplitude, two frequencies and a phase each.
    waves: [[f64; 4]; 5],
}

impl Smooth {
    /// Random waves whose lengths are from half of the range to three times it.
    pub(crate) fn draw(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |low: f64, high: f64| random.random_range(low..high);
        Self {
            waves: std::array::from_fn(|_| {
                [within(0.3, 1.0), within(-1.0, 1.0), within(-1.0, 1.0), within(0.0, TAU)]
            }),
        }
    }

    fn at(&self, u: f64, w: f64) -> f64 {
        self.waves.iter().map(|[a, f, g, phase]| a * (TAU * (f * u + g * w) + phase).cos()).sum()
    }
}

/// Largest speed of the programme, half strokes per second, about.
const SPEED_OF_ALL: f64 = 10.0;
/// Largest acceleration, half strokes per second squared, about.
const ACCELERATION: f64 = 200.0;

/// Force against positive motion that does not ask for the direction.
pub(crate) fn force(id: &str, f: &Smooth, scale: f64, state: &State) -> f64 {
    let State { y, w, a, t, seconds, slid, .. } = *state;
    let v = w / SPEED_OF_ALL;
    match id {
        "random_position" => f.at(y, 0.0),
        "random_velocity" => f.at(2.0 * v, 0.0),
        "random_acceleration" => f.at((a / ACCELERATION).clamp(-1.5, 1.5), 0.0),
        "random_position_velocity" => f.at(y, 2.0 * v),
        "random_time_velocity" => v * f.at(2.0 * t / seconds - 1.0, 0.0),
        "one_sided_spring" => (y - 0.2 * (scale - 1.0)).max(0.0),
        "detent" => {
            let u = (y - 0.5 * (scale - 1.0)) / 0.12;
            u * (-0.5 * u * u).exp()
        }
        "eddy_current_brake" => {
            let u = w / (2.0 * scale);
            u / (1.0 + u * u)
        }
        "warming_grease" => v * (-3.0 * scale * t.max(0.0) / seconds).exp(),
        "heated_by_sliding" => -v * slid,
        "cable_caught_once" if (t / seconds - 0.5 * scale).abs() < 0.04 => y,
        _ => 0.0,
    }
}

/// Friction it adds.
pub(crate) fn level(id: &str, f: &Smooth, scale: f64, state: &State) -> f64 {
    let State { y, w, t, seconds, slid, .. } = *state;
    match id {
        "random_position_friction" => f.at(y, 0.0),
        "random_slid" => f.at(0.5 * slid, 0.0),
        "dried_lubricant" => (-0.5 * ((y - 0.4 * (scale - 1.0)) / 0.15).powi(2)).exp(),
        "friction_steps_once" if t > 0.5 * scale * seconds => 1.0,
        "screw_tight_in_the_middle" => w.abs() / SPEED_OF_ALL * (-(y / (0.4 * scale)).powi(2)).exp(),
        _ => 0.0,
    }
}
