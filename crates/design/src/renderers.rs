//! What each renderer makes of a preset through the sensors of the device: errors of its force, creep and noise at rest.

use crate::closed::{self, DELAY, Error};
use haptics::{Device, RendererKind, Settings};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// What was measured of one renderer.
#[derive(Debug, Clone, Copy)]
pub struct Measured {
    /// Which.
    pub renderer: RendererKind,
    /// With the passivity observer and controller.
    pub passivity: bool,
    /// rms difference of the rendered friction to the law at the true velocity while sliding at 20 mm/s, N.
    pub sliding_error: f64,
    /// Mean difference of the force of the hand to the law meanwhile, N: what the device itself adds.
    pub felt_error: f64,
    /// Force at which a slowly growing push moves what rubs, less the static friction, N.
    pub break_away_error: f64,
    /// Drift of the handle under a hand that presses and holds still, m/s.
    pub creep: f64,
    /// rms of the force about its mean meanwhile, N.
    pub noise: f64,
    /// Energy that the renderer gives to a trembling handle, stuck, J a cycle; negative: takes.
    pub energy: f64,
}

/// A relaxed hand: mass kg, damping N·s/m, stiffness N/m.
const HAND: (f64, f64, f64) = (0.1, 6.0, 400.0);
/// A hand that leads the handle along a path: stiffer.
const LEADING: (f64, f64, f64) = (0.3, 60.0, 5_000.0);

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Every renderer with this preset on the device of [thesis, table 3-1], each without and with the passivity controller.
///
/// # Errors
/// A preset that the device refuses under one of them.
pub fn measure(preset: &Settings) -> Result<Vec<Measured>, Error> {
    let both = |&renderer| [false, true].map(|passivity| Settings { renderer, passivity, ..*preset });
    RendererKind::ALL.iter().flat_map(both).map(|settings| one(&settings)).collect()
}

fn one(settings: &Settings) -> Result<Measured, Error> {
    let device = Device { delay: DELAY as f32, ..Device::default() };
    let (creep, noise) = at_rest(settings, &device)?;
    let (sliding_error, felt_error) = sliding(settings, &device)?;
    Ok(Measured {
        renderer: settings.renderer,
        passivity: settings.passivity,
        sliding_error,
        felt_error,
        break_away_error: break_away(settings, &device)?,
        creep,
        noise,
        energy: trembling(settings, &device)?,
    })
}

/// Led to and fro at 20 mm/s: rms error of what is rendered, mean error of what is felt, N.
fn sliding(settings: &Settings, device: &Device) -> Result<(f64, f64), Error> {
    const SPEED: f64 = 0.02;
    const LENGTH: f64 = 0.02;
    let (mass, damping, stiffness) = LEADING;
    let path = |t: f64| {
        let along = (SPEED * (t - 1.0)) % (2.0 * LENGTH);
        if along < LENGTH { (along - 0.5 * LENGTH, SPEED) } else { (1.5 * LENGTH - along, -SPEED) }
    };
    let wide = |x: f32| f64::from(x);
    let (mut errors, mut felt) = (Vec::new(), Vec::new());
    let hand = |t, x, v| {
        let (to, speed) = path(t);
        // taken to the start of the path first
        let (to, speed) = if t < 1.0 { (-0.5 * LENGTH * t, -0.5 * LENGTH) } else { (to, speed) };
        stiffness * (to - x) + damping * (speed - v)
    };
    closed::run(settings, device, 5.0, mass, hand, |out, truth| {
        // half a second after every turn
        let since_turn = truth.time % (LENGTH / SPEED);
        if truth.time > 2.0 && since_turn > 0.5 && since_turn < 0.95 {
            let v = truth.velocity;
            let law = if v > 0.0 {
                wide(settings.f_dynamic_p) + wide(settings.damping_p) * v
            } else {
                -wide(settings.f_dynamic_n) + wide(settings.damping_n) * v
            };
            // the force of a handle that follows is not that of the friction
            let follows = settings.renderer == RendererKind::Admittance;
            errors.push(if follows { wide(out.friction) } else { -wide(out.force) } - law);
            felt.push((truth.hand_force - law) * v.signum());
        }
    })?;
    Ok((rms(&errors), mean(&felt)))
}

/// Pushed by 0.5 N more every second.
fn break_away(settings: &Settings, device: &Device) -> Result<f64, Error> {
    const GROWTH: f64 = 0.5;
    let (mass, damping, _) = HAND;
    let fixed = f64::from(settings.f_static_p);
    let mut broke = f64::NAN;
    let seconds = (fixed + 1.0) / GROWTH;
    let spring = fixed / f64::from(settings.k_vc);
    let mut start = None;
    // a handle that runs away is let go: it broke before
    let _ = closed::run(
        settings,
        device,
        seconds,
        mass,
        |t, _, v| GROWTH * t - damping * v,
        |_, truth| {
            let from = *start.get_or_insert(truth.position);
            // ten counts beyond what the spring gives
            let beyond = 10.0 * f64::from(device.metre_per_count);
            if broke.is_nan() && truth.position - from > 1.05 * spring + beyond {
                broke = GROWTH * truth.time;
            }
        },
    );
    Ok(broke - fixed)
}

/// Slid to where it is pressed with 60 % of the break-away force, and held still there. Creep m/s, noise N.
fn at_rest(settings: &Settings, device: &Device) -> Result<(f64, f64), Error> {
    const SECONDS: f64 = 8.0;
    let (mass, damping, stiffness) = HAND;
    let moving = f64::from(settings.f_dynamic_p);
    let pressed = 0.6 * f64::from(settings.f_static_p);
    // over 4 mm in a second, then back by what the load is to fall
    let path = |t: f64| {
        let forward = 4e-3 * t.min(1.0) + moving / stiffness * t.min(1.0);
        forward - (moving - pressed).max(0.0) / stiffness * (2.0 * (t - 1.0)).clamp(0.0, 1.0)
    };
    let hand = |t, x, v| stiffness * (path(t) - x) - damping * v;
    let (mut early, mut late, mut forces) = (Vec::new(), Vec::new(), Vec::new());
    closed::run(settings, device, SECONDS, mass, hand, |out, truth| {
        if truth.time > SECONDS - 3.5 {
            forces.push(f64::from(out.force));
            let half = 0.5;
            if truth.time < SECONDS - 3.5 + half {
                early.push(truth.position);
            } else if truth.time > SECONDS - half {
                late.push(truth.position);
            }
        }
    })?;
    let middle = mean(&forces);
    let noise: Vec<f64> = forces.iter().map(|f| f - middle).collect();
    Ok(((mean(&late) - mean(&early)).abs() / 3.0, rms(&noise)))
}

/// Led to and fro by 50 µm at 8 Hz, below break-away.
fn trembling(settings: &Settings, device: &Device) -> Result<f64, Error> {
    const HZ: f64 = 8.0;
    let (mass, damping, stiffness) = LEADING;
    let hand = |t: f64, x: f64, v: f64| {
        let (to, speed) = (50e-6 * (TAU * HZ * t).sin(), 50e-6 * TAU * HZ * (TAU * HZ * t).cos());
        stiffness * (to - x) + damping * (speed - v)
    };
    let (mut given, mut last) = (0.0, None);
    closed::run(settings, device, 3.0, mass, hand, |out, truth| {
        if let Some((x, force)) = last.filter(|_| truth.time > 1.0) {
            given += force * (truth.position - x);
        }
        last = Some((truth.position, f64::from(out.force)));
    })?;
    Ok(given / (2.0 * HZ))
}

/// What a hand finds that leads the handle to and fro.
#[derive(Debug, Clone, Copy)]
pub struct Felt {
    /// Which renderer.
    pub renderer: RendererKind,
    /// Mass, kg.
    pub mass: f64,
    /// Damping, N·s/m.
    pub damping: f64,
    /// Friction, N.
    pub friction: f64,
    /// rms of what these three leave of the force, N.
    pub rest: f64,
}

/// What is felt of this block under every renderer: mass, damping and friction fitted to the force of the hand. The reason
/// where the device refuses it or lets go.
#[must_use]
pub fn felt(preset: &Settings) -> Vec<(RendererKind, Result<Felt, Error>)> {
    let one = |&renderer| (renderer, led(&Settings { renderer, ..*preset }));
    RendererKind::ALL.iter().map(one).collect()
}

/// Led by two sines, 8 mm at 1.2 Hz and 1 mm at 4 Hz.
fn led(settings: &Settings) -> Result<Felt, Error> {
    /// Samples of a mean: the noise of a load cell shakes the handle, and a mass against it is not the one that is felt.
    const MEAN: usize = 25;
    /// Samples after a turn that belong to the break-away.
    const AFTER: u32 = 60;
    let device = Device { delay: DELAY as f32, ..Device::default() };
    let (mass, damping, stiffness) = LEADING;
    let sines = [(8e-3, TAU * 1.2), (1e-3, TAU * 4.0)];
    let hand = |t: f64, x: f64, v: f64| {
        let to: f64 = sines.iter().map(|(a, w)| a * (w * t).sin()).sum();
        let speed: f64 = sines.iter().map(|(a, w)| a * w * (w * t).cos()).sum();
        stiffness * (to - x) + damping * (speed - v)
    };
    let (mut stretch, mut since_turn) = (Vec::new(), 0_u32);
    // rows of acceleration, velocity, direction and force
    let (mut rows, mut means): (Vec<[f64; 4]>, Vec<[f64; 4]>) = (Vec::new(), Vec::new());
    closed::run(settings, &device, 10.0, mass, hand, |_, truth| {
        let v = truth.velocity;
        since_turn = if v.abs() > 0.01 { since_turn + 1 } else { 0 };
        if truth.time < 1.0 || since_turn <= AFTER {
            stretch.clear();
            return;
        }
        stretch.push([truth.acceleration, v, v.signum(), truth.hand_force]);
        if stretch.len() == MEAN {
            means.push(std::array::from_fn(|k| mean(&stretch.iter().map(|row| row[k]).collect::<Vec<_>>())));
            rows.append(&mut stretch);
        }
    })?;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [a, v, way, force] in means {
        let row = Vector3::new(a, v, way);
        normal += row * row.transpose();
        right += row * force;
    }
    let [[mass, damping, friction]] = normal.lu().solve(&right).unwrap_or(Vector3::repeat(f64::NAN)).data.0;
    let rest: Vec<f64> =
        rows.iter().map(|[a, v, way, force]| force - mass * a - damping * v - friction * way).collect();
    Ok(Felt { renderer: settings.renderer, mass, damping, friction, rest: rms(&rest) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passivity_control_takes_what_a_trembling_hand_was_given() {
        // [thesis, table 5-3] is beyond the passivity bound of [colgate-1997]: b < KT/2 + B
        let rows = measure(&Settings::forced_choice()).expect("accepted");
        let held_by_a_coupling = |m: &&[Measured]| m[0].renderer != RendererKind::Admittance;
        for pair in rows.chunks(2).filter(held_by_a_coupling) {
            let (off, on) = (&pair[0], &pair[1]);
            println!(
                "{:17} {:+.3} µJ a cycle without, {:+.3} with",
                off.renderer.id(),
                1e6 * off.energy,
                1e6 * on.energy
            );
            assert!((off.passivity, on.passivity) == (false, true));
            assert!(off.energy > 0.0 && on.energy < 0.0);
            // what it costs: within a hundredth of the static friction
            assert!(
                (on.break_away_error - off.break_away_error).abs() < 0.02 && on.noise <= off.noise + 1e-4
            );
            assert!((on.sliding_error - off.sliding_error).abs() < 2e-3);
        }
    }

    #[test]
    fn through_the_load_cell_a_hand_feels_the_block_without_the_device() {
        // 0.692 kg and 6.92 N·s/m are the device's, 0.05 kg of it between hand and cell
        let block = Settings {
            mass: 0.1,
            f_static_p: 0.3,
            f_static_n: 0.3,
            f_dynamic_p: 0.3,
            f_dynamic_n: 0.3,
            damping_p: 0.0,
            damping_n: 0.0,
            dv: 0.01,
            ..Settings::brass()
        };
        for (renderer, felt) in felt(&block) {
            let felt = felt.expect("accepted");
            println!("{:17} {felt:?}", renderer.id());
            let (mass, damping) = match renderer {
                RendererKind::Impedance => (0.692, 6.92),
                RendererKind::VirtualCoupling | RendererKind::StoppingForce => (0.792, 6.92),
                RendererKind::Admittance => (0.15, 0.0),
            };
            assert!((felt.mass - mass).abs() < 0.03 && (felt.damping - damping).abs() < 1.0);
            assert!((felt.friction - 0.3).abs() < 0.06);
        }
    }
}
