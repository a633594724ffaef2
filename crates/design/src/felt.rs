//! Friction force that a hand feels of a preset while it slides the handle, over speed and over position.

use friction::effects::EffectState;
use friction::{FrictionLaw, LawState, Motion};
use haptics::{Device, Settings};

/// Steps from one stop to the other.
const STEPS: usize = 512;
/// Share of the way, at either end, that is not averaged: friction settles there after the reversal.
const ENDS: usize = STEPS / 16;

/// Force of each step of a slide from stop to stop, N, positive against positive motion; `velocity` has a sign.
fn slide(settings: &Settings, device: &Device, velocity: f32) -> Vec<f32> {
    let law = settings.friction_law();
    let mut state = LawState::default();
    let mut effects = settings.effects.map(|effect| effect.map(|effect| (effect, EffectState::default())));
    let step = device.stroke / STEPS as f32;
    let mut forces = Vec::with_capacity(STEPS);
    // to and fro before it counts: friction remembers
    for direction in [1.0, -1.0, 1.0] {
        forces.clear();
        let speed = direction * velocity;
        for k in 0..STEPS {
            let along = step * (k as f32 + 0.5) - 0.5 * device.stroke;
            let mut motion = Motion {
                dt: step / velocity.abs(),
                position: speed.signum() * along,
                displacement: speed.signum() * step,
                velocity: speed,
                // within the dead band friction is up to its static level
                applied: speed.signum() * 2.0 * device.force_max,
                mass: settings.mass,
                normal: None,
            };
            let mut force = law.step(&mut state, &motion);
            // at constant speed friction balances what is applied
            motion.applied = force;
            for (effect, memory) in effects.iter_mut().flatten() {
                force += effect.step(memory, &motion);
            }
            forces.push(force.clamp(-device.force_max, device.force_max));
        }
    }
    forces
}

/// Friction force at each velocity, N, averaged over the stroke; within Karnopp's dead band its static level.
///
/// ```
/// use haptics::{Device, Settings};
/// let felt = design::felt_over_speed(&Settings::brass(), &Device::default(), &[-0.05, 0.05]);
/// // [thesis, table 3-3], run 1: 1.729 N + 0.6196 N·s/m · 50 mm/s, and 1.7714 N + 0.457 N·s/m · 50 mm/s
/// assert!((felt[0] + 1.760).abs() < 1e-3 && (felt[1] - 1.794).abs() < 1e-3);
/// ```
#[must_use]
pub fn felt_over_speed(settings: &Settings, device: &Device, velocities: &[f32]) -> Vec<f32> {
    let mean = |velocity: f32| {
        let forces = slide(settings, device, velocity);
        let counted = &forces[ENDS..STEPS - ENDS];
        counted.iter().sum::<f32>() / counted.len() as f32
    };
    velocities.iter().map(|velocity| mean(*velocity)).collect()
}

/// Friction force at each position, N, while the handle slides at `velocity`.
#[must_use]
pub fn felt_over_position(
    settings: &Settings,
    device: &Device,
    velocity: f32,
    positions: &[f32],
) -> Vec<f32> {
    let forces = slide(settings, device, velocity);
    let at = |position: f32| {
        let along = velocity.signum() * position / device.stroke + 0.5;
        forces[((along * STEPS as f32) as usize).min(STEPS - 1)]
    };
    positions.iter().map(|position| at(*position)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptics::LawKind;

    #[test]
    fn every_law_slides_at_its_dynamic_level() {
        let device = Device::default();
        for law in LawKind::ALL {
            let base = Settings { stribeck_velocity: 2e-3, dv: 1e-3, ..Settings::brass() };
            let settings = Settings {
                law: *law,
                damping_n: base.damping_p,
                f_dynamic_n: base.f_dynamic_p,
                f_static_n: base.f_static_p,
                ..base
            };
            let felt = felt_over_speed(&settings, &device, &[-0.08, -0.03, 0.03, 0.08]);
            println!("{:17} {felt:?}", law.id());
            // the classic law counts its viscous part from where friction has fallen; six bonds snap at random
            let from = if *law == LawKind::Classic { settings.stribeck_velocity } else { 0.0 };
            let level = if *law == LawKind::Viscous { 0.0 } else { settings.f_dynamic_p };
            let tolerance = if *law == LawKind::Bristle { 0.1 } else { 0.02 };
            for (force, velocity) in felt.iter().zip([-0.08, -0.03, 0.03, 0.08_f32]) {
                let expected =
                    velocity.signum() * level + settings.damping_p * (velocity - velocity.signum() * from);
                assert!(
                    (force - expected).abs() < tolerance,
                    "{}: {force} N, expected {expected} N",
                    law.id()
                );
            }
        }
    }

    #[test]
    fn a_pattern_shows_over_position_and_averages_out_over_speed() {
        let device = Device::default();
        let mut settings = Settings::brass();
        settings.set("cogging.sine_1", "0.5").expect("known");
        settings.set("cogging.wavelength", "0.008").expect("known");
        let positions: Vec<f32> = (0..80).map(|k| -0.012 + 0.0003 * k as f32).collect();
        let felt = felt_over_position(&settings, &device, 0.03, &positions);
        let (low, high) = felt.iter().fold((f32::MAX, f32::MIN), |(l, h), f| (l.min(*f), h.max(*f)));
        println!("{low} to {high} N");
        assert!((high - low - 1.0).abs() < 0.02);
        let mean = felt_over_speed(&settings, &device, &[0.03])[0];
        assert!((mean - felt_over_speed(&Settings::brass(), &device, &[0.03])[0]).abs() < 0.05, "{mean} N");
    }
}
