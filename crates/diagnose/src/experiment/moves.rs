//! Moves a device can be asked for, what it can do, and how a body follows.

use crate::findings::free_run::Plant;
use crate::library::quick::Quick;
use friction::Motion;
use friction::effects::MAX_MEMORY;
use haptics::generator::Generator;
use haptics::{Excitation, Wave};
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt;

/// Time the body is moved before what is kept begins, s: the device's ramp-in has passed.
const WARM_UP_S: f64 = 1.5;
/// Longest integration step, s.
const STEP_S: f64 = 2.5e-4;
/// Share of what the device can do that a proposed move asks of it: friction and mass are estimates.
const MARGIN: f64 = 0.9;

/// A move as the serial line takes it: `move WAVE AMP FREQ SECONDS`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Move {
    /// Shape: sine, multisine, chirp, triangle or dwell.
    #[serde(serialize_with = "as_id")]
    pub wave: Wave,
    /// Half of peak to peak, m or rad.
    pub amplitude: f64,
    /// Repetition rate, Hz; of a chirp the highest.
    pub frequency: f64,
    /// Length, s.
    pub seconds: f64,
}

fn as_id<S: serde::Serializer>(wave: &Wave, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(wave.id())
}

impl fmt::Display for Move {
    /// The command to paste.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "move {} {} {} {}", self.wave.id(), self.amplitude, self.frequency, self.seconds)
    }
}

/// What the device that makes the moves can do, and how it drives. In N, m, kg for a slide; N·m, rad, kg·m² for an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest amplitude.
    pub amplitude: f64,
    /// Largest speed.
    pub speed: f64,
    /// Largest force of the drive.
    pub force: f64,
    /// Mass that the drive moves beside what its force sensor feels.
    pub drive_mass: f64,
    /// Proportional gain of the position controller.
    pub stiffness: f64,
    /// Derivative gain of the position controller.
    pub damping: f64,
}

impl Limits {
    /// Of a device of this project.
    #[must_use]
    pub fn of_device(device: &haptics::Device) -> Self {
        Self {
            amplitude: 0.5 * f64::from(device.stroke) - 1e-3,
            speed: 0.5 * f64::from(device.overspeed),
            force: f64::from(device.force_max),
            drive_mass: f64::from(device.mass),
            stiffness: f64::from(device.tracking_stiffness),
            damping: f64::from(device.tracking_damping),
        }
    }

    /// What a recording itself shows to be possible: its stroke, twice its speed and half more than its force, under a
    /// controller that is well damped at 20 Hz.
    pub(crate) fn shown(stroke: f64, speed: f64, force: f64, mass: f64) -> Self {
        let natural = TAU * 20.0;
        Self {
            amplitude: 0.5 * stroke,
            speed: 2.0 * speed,
            force: 1.5 * force,
            drive_mass: 0.0,
            stiffness: mass * natural * natural,
            damping: 1.4 * mass * natural,
        }
    }

    /// Whether the device makes this move with such a body on it; `friction` is what sliding costs at most.
    fn allows(&self, motion: &Move, mass: f64, friction: f64) -> bool {
        let turn = TAU * motion.frequency;
        let speed = turn * f64::from(motion.wave.speed_factor()) * motion.amplitude;
        let acceleration = turn * turn * f64::from(motion.wave.acceleration_factor()) * motion.amplitude;
        motion.amplitude <= self.amplitude
            // friction must not swallow the move: the controller needs an error to push with
            && motion.amplitude * self.stiffness >= 3.0 * friction
            && speed <= MARGIN * self.speed
            && (self.drive_mass + mass) * acceleration + friction <= MARGIN * self.force
    }

    /// Moves worth considering for a body of this mass and friction: every wave, from the whole stroke down, from a
    /// quarter of `frequency` up to what speed and force allow.
    pub(crate) fn candidates(&self, mass: f64, friction: f64, frequency: f64, seconds: f64) -> Vec<Move> {
        let base = frequency.clamp(0.05, 20.0);
        let mut out: Vec<Move> = Vec::new();
        for &wave in Wave::ALL {
            for share in [1.0, 0.4, 0.12] {
                for octave in [-2.0, -1.0, 0.0, 1.0, 2.0] {
                    // a dwell or a chirp needs its whole pattern within the time
                    let frequency = rounded(base * 2f64.powf(octave));
                    let amplitude = rounded_down(MARGIN * self.amplitude * share);
                    let motion = Move { wave, amplitude, frequency, seconds };
                    if frequency * seconds >= 4.0 && self.allows(&motion, mass, friction) {
                        out.push(motion);
                    }
                }
            }
        }
        out
    }
}

/// Two significant digits: something one can type.
fn rounded(x: f64) -> f64 {
    let scale = 10f64.powf(1.0 - x.abs().max(1e-12).log10().floor());
    (x * scale).round() / scale
}

fn rounded_down(x: f64) -> f64 {
    let scale = 10f64.powf(1.0 - x.abs().max(1e-12).log10().floor());
    (x * scale + 1e-9).floor() / scale
}

/// What a body does under a move.
#[derive(Debug, Clone, Default)]
pub(crate) struct Travel {
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    /// Force between drive and body.
    pub force: Vec<f64>,
}

/// Moves `plant` and keeps a sample every `dt` seconds. Friction is a stopping force: the body truly rests.
pub(crate) fn simulate(plant: &Plant, limits: &Limits, motion: &Move, dt: f64) -> Travel {
    let steps = (dt / STEP_S).ceil().max(1.0) as usize;
    let h = dt / steps as f64;
    let mass = plant.mass + limits.drive_mass;
    let excitation = Excitation {
        wave: motion.wave,
        amplitude_m: motion.amplitude as f32,
        frequency_hz: motion.frequency as f32,
        seconds: (motion.seconds + WARM_UP_S) as f32,
    };
    let mut generator = Generator::new(&excitation, dt as f32);
    let skipped = (WARM_UP_S / dt) as usize;
    let kept = (motion.seconds / dt) as usize;
    let mut here = motion.amplitude * f64::from(generator.next());
    let (mut x, mut v) = (here, 0.0_f64);
    let mut memory = vec![[Quick(0.0); MAX_MEMORY]; plant.effects.len()];
    let shapes: Vec<_> = plant.effects.iter().map(|(_, _, shape)| shape.map(Quick)).collect();
    let mut out = Travel::default();
    for sample in 0..skipped + kept {
        let next = motion.amplitude * f64::from(generator.next());
        let rate = (next - here) / dt;
        for step in 0..steps {
            let asked = here + (next - here) * step as f64 / steps as f64;
            let drive = (limits.stiffness * (asked - x) + limits.damping * (rate - v))
                .clamp(-limits.force, limits.force);
            let mut extra = 0.0;
            let motion = Motion {
                dt: Quick(h),
                position: Quick(x),
                displacement: Quick(v * h),
                velocity: Quick(v),
                applied: Quick(drive),
                mass: Quick(0.0),
                normal: None,
            };
            for (((kind, gains, _), shape), memory) in plant.effects.iter().zip(&shapes).zip(&mut memory) {
                let unit = kind.unit(shape, memory, &motion);
                extra += unit.iter().zip(gains).map(|(Quick(u), g)| u * g).sum::<f64>();
            }
            let way = usize::from(v < 0.0);
            let free = v + h * (drive - plant.viscous[way] * v - extra) / mass;
            let stop = h * plant.coulomb[usize::from(free < 0.0)].max(0.0) / mass;
            let after = if free.abs() <= stop { 0.0 } else { free - stop * free.signum() };
            if step == 0 && sample >= skipped {
                out.position.push(x);
                out.velocity.push(v);
                out.force.push(drive - limits.drive_mass * (after - v) / h);
            }
            v = after;
            x += h * v;
        }
        here = next;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proposed_moves_are_ones_the_device_takes() {
        let device = haptics::Device::default();
        let limits = Limits::of_device(&device);
        let candidates = limits.candidates(0.4, 2.0, 2.0, 12.0);
        println!("{} candidates", candidates.len());
        assert!(candidates.len() > 20 && Wave::ALL.iter().all(|w| candidates.iter().any(|c| c.wave == *w)));
        for motion in &candidates {
            let excitation = Excitation {
                wave: motion.wave,
                amplitude_m: motion.amplitude as f32,
                frequency_hz: motion.frequency as f32,
                seconds: motion.seconds as f32,
            };
            assert!(excitation.validate(&device).is_ok(), "{motion}");
        }
        // what asks for more than the drive has is not proposed
        assert!(limits.candidates(0.4, 20.0, 2.0, 12.0).is_empty());
    }

    #[test]
    fn a_body_follows_a_slow_move_and_its_force_balances() {
        let device = haptics::Device::default();
        let limits = Limits::of_device(&device);
        let plant = Plant { mass: 0.4, coulomb: [1.5, 1.2], viscous: [2.0, 2.0], ..Plant::default() };
        let motion = Move { wave: Wave::Sine, amplitude: 0.01, frequency: 1.0, seconds: 4.0 };
        let travel = simulate(&plant, &limits, &motion, 1e-3);
        assert_eq!(travel.position.len(), 4000);
        let reach = travel.position.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut worst: f64 = 0.0;
        for i in 5..3995 {
            let a = (travel.velocity[i + 1] - travel.velocity[i - 1]) / 2e-3;
            let v = travel.velocity[i];
            let slides = (i - 5..i + 5).all(|j| travel.velocity[j] * v > 0.0);
            if slides {
                let level = if v > 0.0 { 1.5 } else { -1.2 };
                worst = worst.max((travel.force[i] - 0.4 * a - 2.0 * v - level).abs());
            }
        }
        println!("reach {reach:.5} m of 0.01, worst imbalance {worst:.4} N");
        assert!((reach - 0.01).abs() < 1.5e-3 && worst < 0.02);
    }
}
