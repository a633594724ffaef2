//! What can be hidden: every effect of the catalogue in equations of this module's own, each scaled by one size.

use crate::body::{Body, State};
use crate::kind::Kind;
use crate::motion::LOAD;
use crate::open::{self, Smooth};

use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Share of a transmission's loss that is left when the load drives it.
const BACK: f64 = 0.3;
/// Direct effect of the speed, as a share of that of the age.
const DIRECT: f64 = 0.6;
/// Speed to which rate and state refer, half strokes per second.
pub(crate) const REFERENCE: f64 = 0.5;

const LOW: &[&str] = &["velocity", "low_speed"];
const REVERSAL: &[&str] = &["distance_since_reversal", "time_since_reversal", "low_speed"];
const CHANGES: &[&str] = &["velocity", "low_speed", "distance_since_reversal", "time_since_reversal"];
const PLACE: &[&str] = &["position", "position_forward", "position_backward"];
const FAST: &[&str] = &["acceleration", "jerk", "force"];

const fn kind(id: &'static str, shows_over: &'static [&'static str], size: f64, most: f64) -> Kind {
    Kind { id, also: &[], shows_over, size: (size, most), rotary: false, never: false }
}

/// Everything that can be hidden.
pub(crate) const ALL: &[Kind] = &[
    kind("stribeck", LOW, 0.5, 5.0),
    kind("sublinear_viscous", LOW, 0.5, 5.0),
    kind("quadratic_drag", LOW, 0.3, 20.0),
    kind("presliding", REVERSAL, 0.5, 3.0),
    kind("lost_motion", REVERSAL, 0.5, 3.0),
    Kind { also: &["presliding"], ..kind("nonlocal_memory", REVERSAL, 0.5, 3.0) },
    Kind { also: &["presliding"], ..kind("cable_hysteresis", REVERSAL, 0.5, 3.0) },
    kind("frictional_lag", REVERSAL, 0.5, 3.0),
    kind("rising_static_friction", REVERSAL, 0.5, 5.0),
    kind("rate_and_state", CHANGES, 0.2, 0.8),
    kind("friction_drift", &["time"], 0.3, 3.0),
    kind("position_dependent_friction", PLACE, 0.3, 1.5),
    kind("load_dependent_friction", &["load"], 0.3, 3.0),
    // a body without a weight is hardly ever driven back: what is lost is more friction and less mass
    Kind { never: true, ..kind("directional_efficiency", &[], 0.2, 0.8) },
    kind("spring", PLACE, 0.3, 20.0),
    kind("nonlinear_spring", PLACE, 0.3, 20.0),
    Kind { rotary: true, ..kind("gravity", PLACE, 0.3, 20.0) },
    kind("cogging", PLACE, 0.2, 5.0),
    kind("periodic_friction", PLACE, 0.2, 1.3),
    kind("torque_ripple", PLACE, 0.1, 0.9),
    kind("hard_stop", PLACE, 0.5, 50.0),
    kind("backlash", FAST, 0.05, 0.35),
    kind("compliance", FAST, 0.02, 1.5),
    kind("saturation", FAST, 0.2, 0.9),
    kind("actuator_lag", FAST, 1e-3, 0.03),
    kind("time_skew", FAST, 1e-3, 0.03),
    kind("velocity_lag", REVERSAL, 1e-3, 0.03),
    kind("force_gain_asymmetry", FAST, 0.05, 0.9),
    kind("encoder_eccentricity", FAST, 1e-3, 0.03),
    Kind { never: true, ..kind("back_emf", &[], 1.0, 1.0) },
    Kind { never: true, ..kind("force_crosstalk", &[], 1.0, 1.0) },
    Kind { never: true, ..kind("offset", &[], 0.2, 1.0) },
];

/// The kind with this id.
pub(crate) fn find(id: &str) -> Option<&'static Kind> {
    ALL.iter().chain(open::ALL).find(|k| k.id == id)
}

/// An element that bends, first through a play without force, and slips.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bristle {
    /// Half of its play, half strokes.
    play: f64,
    /// How far it bends behind the play, half strokes.
    reach: f64,
    /// Its force when it slips.
    force: f64,
    /// Where it is.
    bend: f64,
}

impl Bristle {
    /// Its force against positive motion.
    pub(crate) fn pull(&self) -> f64 {
        self.force * (self.bend.abs() - self.play).max(0.0).copysign(self.bend) / self.reach
    }

    /// Takes it along.
    pub(crate) fn take(&mut self, moved: f64) {
        let end = self.play + self.reach;
        self.bend = (self.bend + moved).clamp(-end, end);
    }
}

/// An effect with its size and the constants that were drawn for it. Lengths are in half strokes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hidden {
    /// Which.
    pub kind: &'static Kind,
    /// Its size: N or N·m at full effect, or the unit of the sensor effect.
    pub size: f64,
    /// Length, speed or time of the effect, as a share of its usual one: 0.7 to 1.4.
    pub scale: f64,
    /// A phase, 0 to 2π.
    pub phase: f64,
    /// What the random effects of the open world are made of.
    pub smooth: Smooth,
}

impl Hidden {
    /// Speed of the low-speed effects, half strokes per second.
    fn speed(&self) -> f64 {
        let usual = if self.kind.id == "stribeck" { 1.6 } else { 2.2 };
        usual * self.scale
    }

    /// Period over the stroke, half strokes.
    pub(crate) fn wavelength(&self) -> f64 {
        0.4 * self.scale
    }

    /// The largest size that is still this effect: friction that is late may vanish and not drive.
    pub(crate) fn most(&self, body: &Body) -> f64 {
        match self.kind.id {
            "frictional_lag" => self.kind.size.1.min(0.5 * body.coulomb[0].min(body.coulomb[1])),
            _ => self.kind.size.1,
        }
    }

    /// Time constant, s.
    fn time(&self, seconds: f64) -> f64 {
        match self.kind.id {
            "frictional_lag" => 0.015 * self.scale,
            "rising_static_friction" => 0.12 * self.scale,
            _ => 0.3 * seconds * self.scale,
        }
    }

    /// What bends before it slips; empty where nothing does.
    pub(crate) fn bristles(&self) -> Vec<Bristle> {
        let of =
            |play: f64, reach: f64, share: f64| Bristle { play, reach, force: share * self.size, bend: 0.0 };
        let uniform =
            |reach: f64| (0..24).map(|i| of(0.0, reach * (f64::from(i) + 0.5) / 12.0, 1.0 / 24.0)).collect();
        let spread = |i: i32| 0.008 * self.scale * 10f64.powf(f64::from(i) / 8.0);
        match self.kind.id {
            "presliding" => uniform(0.03 * self.scale),
            "cable_hysteresis" => uniform(0.12 * self.scale),
            "nonlocal_memory" => (0..12).map(|i| of(0.0, spread(i), 1.0 / 12.0)).collect(),
            "lost_motion" => vec![of(0.5 * self.gap(), 0.4 * self.gap(), 1.0)],
            _ => Vec::new(),
        }
    }

    /// Length of a play in series with friction, half strokes.
    fn gap(&self) -> f64 {
        0.08 * self.scale
    }

    /// Distance over which a contact renews itself, half strokes.
    pub(crate) fn renewal(&self) -> Option<f64> {
        (self.kind.id == "rate_and_state").then_some(0.04 * self.scale)
    }

    /// Friction it adds while sliding in direction `s`, and to what holds a body at rest.
    pub(crate) fn level(&self, s: f64, state: &State) -> f64 {
        let State { y, w, t, seconds, load, age, theta, drive, .. } = *state;
        let g = self.size;
        match self.kind.id {
            "stribeck" => g * (-(w / self.speed()).powi(2)).exp(),
            "sublinear_viscous" => g * (1.0 - (-(w / self.speed()).abs()).exp()),
            "quadratic_drag" => g * w * w / 10.0,
            "back_emf" => g * w.abs() / 10.0,
            "position_dependent_friction" => g * y,
            "periodic_friction" => g * (TAU * y / self.wavelength() + self.phase).cos(),
            "friction_drift" => g * (-t.max(0.0) / self.time(seconds)).exp(),
            "load_dependent_friction" => g * load,
            "directional_efficiency" => g * drive.abs() * if drive * s < 0.0 { BACK } else { 1.0 },
            "rate_and_state" => {
                g * (DIRECT * (w.abs() / REFERENCE).max(2e-3).ln()
                    + (theta * REFERENCE / self.renewal().unwrap_or(1.0)).ln())
            }
            "rising_static_friction" => g * (1.0 - (-age / self.time(seconds)).exp()),
            "frictional_lag" if state.late != s => -2.0 * g,
            id => g * open::level(id, &self.smooth, self.scale, state),
        }
    }

    /// Force against positive motion that does not ask for the direction.
    pub(crate) fn force(&self, state: &State) -> f64 {
        let State { y, .. } = *state;
        let g = self.size;
        match self.kind.id {
            "spring" => g * y,
            "nonlinear_spring" => g * y.powi(3),
            "gravity" => g * (y + self.phase).sin(),
            "cogging" => g * (TAU * y / self.wavelength() + self.phase).cos(),
            "hard_stop" => g * (y - 0.55 * self.scale.min(1.2)).max(0.0),
            "offset" => g,
            id => g * open::force(id, &self.smooth, self.scale, state),
        }
    }

    /// How late friction is, s.
    pub(crate) fn lag(&self) -> Option<f64> {
        (self.kind.id == "frictional_lag").then(|| self.time(1.0))
    }

    /// Friction that a diagnosis states as the law's own: behind a play the effect is level·(φ − s), beside a law that has level·s.
    pub(crate) fn of_the_law(&self) -> f64 {
        if self.kind.id == "lost_motion" { self.size } else { 0.0 }
    }

    /// Parameters a diagnosis would state, where the equations are the same; `half` is the half stroke, m or rad.
    pub(crate) fn parameters(&self, half: f64, seconds: f64) -> BTreeMap<String, f64> {
        let g = self.size;
        let both = |name: &str, value: f64| vec![(format!("{name}_p"), value), (format!("{name}_n"), value)];
        let one = |name: &str, value: f64| vec![(name.to_string(), value)];
        let wave = |suffix: &str| {
            let at = |name: &str, v: f64| one(&format!("{name}{suffix}"), v);
            [
                at("cosine", g * self.phase.cos()),
                at("sine", -g * self.phase.sin()),
                one("wavelength", self.wavelength() * half),
            ]
            .concat()
        };
        let named = match self.kind.id {
            "stribeck" => [both("force", g), one("v_s", self.speed() * half)].concat(),
            "sublinear_viscous" => [both("force", g), one("v_0", self.speed() * half)].concat(),
            "quadratic_drag" => both("c", g / (10.0 * half * half)),
            "position_dependent_friction" => both("slope", g / half),
            "friction_drift" => [both("force", g), one("settling_time", self.time(seconds))].concat(),
            "load_dependent_friction" => one("mu", g / LOAD),
            "lost_motion" => {
                [both("level", g), one("gap", self.gap() * half), one("x_s", 0.4 * self.gap() * half)]
                    .concat()
            }
            "directional_efficiency" => [one("driving", g), one("back_driven", BACK * g)].concat(),
            "rate_and_state" => [
                one("force_a", DIRECT * g),
                one("force_b", g),
                one("d_c", self.renewal().unwrap_or(f64::NAN) * half),
                one("healing", 1.0),
            ]
            .concat(),
            "frictional_lag" => [one("force", g), one("lag", self.time(seconds))].concat(),
            "spring" => one("stiffness", g / half),
            "nonlinear_spring" => one("cubic", g / half.powi(3)),
            "gravity" => [one("sine", g * self.phase.cos()), one("cosine", g * self.phase.sin())].concat(),
            "cogging" => wave("_1"),
            "periodic_friction" | "torque_ripple" => wave(""),
            "hard_stop" => [one("k_p", g / half), one("x_max", 0.55 * self.scale.min(1.2) * half)].concat(),
            "time_skew" => one("tau", g),
            "actuator_lag" => one("lag", g),
            "velocity_lag" => one("lag", crate::estimator::estimator_delay(g)),
            "backlash" => one("gap", 0.02 * half),
            "compliance" => one("frequency", 30.0 / g.sqrt()),
            "force_gain_asymmetry" => one("gain", g),
            _ => Vec::new(),
        };
        named.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_a_diagnosis_can_name_can_be_hidden() {
        for id in diagnose::effect_ids() {
            let fault = crate::sensors::DECOYS.iter().any(|d| d.id == id);
            assert!(find(id).is_some() || fault, "{id}");
        }
        assert!(ALL.iter().enumerate().all(|(i, a)| ALL[i + 1..].iter().all(|b| b.id != a.id)));
    }
}
