//! A texture on the simulated device: the force at the handle against the force of a block of that mass on that surface.

use crate::closed::{self, DELAY, Error};
use friction::effects::EffectState;
use friction::{FrictionLaw as _, Motion};
use haptics::{Device, Settings};

/// A hand that leads the handle: mass kg, damping N·s/m, stiffness N/m.
const LEADING: (f64, f64, f64) = (0.3, 60.0, 5_000.0);
/// Path of the handle to either side of the middle, m.
const REACH: f64 = 0.010;
/// Speed along it, m/s.
const SPEED: f64 = 0.02;

/// What was measured while the handle was led across in one direction and back.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Texture {
    /// Largest force asked for less the smallest, over both directions, N.
    pub asked: f64,
    /// The same of the force at the handle, N.
    pub rendered: f64,
    /// rms difference of the two, N.
    pub error: f64,
    /// Largest change of the force asked for from a period to the next, N.
    pub step_asked: f64,
    /// The same of the force at the handle, N.
    pub step: f64,
}

/// Leads the handle across the stroke and back at 20 mm/s, with these settings at the control rate of `rate`, Hz.
///
/// # Errors
/// Settings that the device refuses at this rate, and the fault that ended the rendering.
pub fn measure(settings: &Settings, rate: f64) -> Result<Texture, Error> {
    let device = Device { delay: DELAY as f32, period: (1.0 / rate) as f32, ..Device::default() };
    let law = settings.friction_law();
    let sweep = 2.0 * REACH / SPEED;
    let (mass, damping, stiffness) = LEADING;
    let path = |t: f64| {
        let t = t - 1.0;
        match t {
            // to the start, across, back
            _ if t < 0.0 => (-REACH * (t + 1.0), -REACH),
            _ if t < sweep => (SPEED * t - REACH, SPEED),
            _ => (REACH - SPEED * (t - sweep), -SPEED),
        }
    };
    let hand = |t: f64, x: f64, v: f64| {
        let (to, speed) = path(t);
        stiffness * (to - x) + damping * (speed - v)
    };
    let mut found = Texture::default();
    let (mut asked_range, mut range) =
        ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
    let (mut squares, mut count, mut last, mut velocity) = (0.0, 0.0_f64, None, 0.0_f32);
    closed::run(settings, &device, 1.0 + 2.0 * sweep, mass, hand, |out, truth| {
        let (_, speed) = path(truth.time);
        let into = (truth.time - 1.0) % sweep;
        // a quarter of each way for the turn
        if truth.time < 1.0 || into < 0.25 * sweep || into > 0.97 * sweep {
            (last, velocity) = (None, out.block_velocity);
            return;
        }
        let motion = Motion {
            dt: device.period,
            position: out.block_position,
            velocity: if out.block_velocity == 0.0 { 1e-6 * speed as f32 } else { out.block_velocity },
            ..Motion::default()
        };
        let friction = law.step(
            &mut Default::default(),
            &Motion { displacement: 1.0_f32.copysign(motion.velocity), ..motion },
        );
        let effects: f32 = settings
            .effects
            .iter()
            .flatten()
            .map(|effect| effect.step(&mut EffectState::default(), &motion))
            .sum();
        let inertia = settings.mass * (out.block_velocity - velocity) / device.period;
        velocity = out.block_velocity;
        let (asked, rendered) = (f64::from(friction + effects + inertia), -f64::from(out.force));
        for ([low, high], force) in [(&mut asked_range, asked), (&mut range, rendered)] {
            (*low, *high) = (low.min(force), high.max(force));
        }
        squares += (rendered - asked) * (rendered - asked);
        count += 1.0;
        if let Some((before_asked, before)) = last {
            found.step_asked = found.step_asked.max(f64::abs(asked - before_asked));
            found.step = found.step.max(f64::abs(rendered - before));
        }
        last = Some((asked, rendered));
    })?;
    found.asked = asked_range[1] - asked_range[0];
    found.rendered = range[1] - range[0];
    found.error = (squares / count.max(1.0)).sqrt();
    Ok(found)
}
