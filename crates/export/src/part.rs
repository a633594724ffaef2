//! What a format can hold of an effect.
//!
//! An effect is asked by motions, not by its name: its force along a motion in which position, speed, direction, load and applied
//! force vary independently is compared with the best sum of the terms of the format, with what a speed alone gives, and with what
//! a place alone gives.

use crate::format::Format;
use friction::Motion;
use friction::effects::{Effect, EffectState};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// What a format holds of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    /// A sum of the terms of the format.
    Sum(Sum),
    /// Dry friction that falls with the speed.
    Falling(Falling),
    /// An odd function of the speed.
    Speed,
    /// A function of the position.
    Place,
    /// A sum of waves over the position.
    Waves([Wave; WAVES]),
    /// Bristles that bend before the contact slides.
    Presliding(Presliding),
}

impl Part {
    /// None: nothing of it.
    pub(crate) fn of(format: Format, effect: &Effect<f64>) -> Option<Self> {
        if let Some(sum) = sum(format, effect) {
            return Some(Self::Sum(sum));
        }
        match format {
            Format::Urdf => None,
            Format::Mujoco => falling(effect)
                .map(Self::Falling)
                .or_else(|| waves(effect).map(Self::Waves))
                .or_else(|| presliding(effect).map(Self::Presliding)),
            Format::Bam => falling(effect).map(Self::Falling),
            Format::Modelica
                if depends_on(effect, |m| Motion { velocity: m.velocity, ..Motion::default() }) =>
            {
                is_odd(effect).then_some(Self::Speed)
            }
            Format::Modelica => depends_on(effect, |m| Motion { position: m.position, ..Motion::default() })
                .then_some(Self::Place),
        }
    }

    /// The sum, if it is one.
    pub(crate) fn sum(&self) -> Option<Sum> {
        if let Self::Sum(sum) = self { Some(*sum) } else { None }
    }
}

/// F = force·exp(−(|v|/speed)^exponent)·sgn v.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Falling {
    /// At rest, N or N·m.
    pub force: f64,
    /// Speed at which it has fallen to 1/e, m/s or rad/s.
    pub speed: f64,
    /// 1: exponential; 2: Gaussian.
    pub exponent: f64,
}

/// Most waves of an effect.
pub(crate) const WAVES: usize = 2;

/// F = amplitude·sin(per_length·x + phase); no wave where the amplitude is 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wave {
    /// N or N·m.
    pub amplitude: f64,
    /// Wave number, rad/m or rad/rad.
    pub per_length: f64,
    /// rad.
    pub phase: f64,
}

/// F = force·(z − s), dz/dx = (1 − s·z)/distance, s = sgn v: what bristles take from friction that turns round at once.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Presliding {
    /// N or N·m.
    pub(crate) force: f64,
    /// m or rad.
    pub(crate) distance: f64,
}

/// F = friction·sgn v + damping·v + stiffness·x + constant + per_load·|F_applied|·sgn v.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sum {
    pub(crate) friction: f64,
    pub(crate) damping: f64,
    pub(crate) stiffness: f64,
    pub(crate) constant: f64,
    pub(crate) per_load: f64,
}

impl Sum {
    pub(crate) fn plus(self, more: Self) -> Self {
        Self {
            friction: self.friction + more.friction,
            damping: self.damping + more.damping,
            stiffness: self.stiffness + more.stiffness,
            constant: self.constant + more.constant,
            per_load: self.per_load + more.per_load,
        }
    }
}

/// Force of an effect that has no memory, at a speed alone.
pub(crate) fn at_speed(effect: &Effect<f64>, velocity: f64) -> f64 {
    effect.step(&mut EffectState::default(), &Motion { velocity, ..Motion::default() })
}

/// At a place alone.
pub(crate) fn at_place(effect: &Effect<f64>, position: f64) -> f64 {
    effect.step(&mut EffectState::default(), &Motion { position, ..Motion::default() })
}

/// Samples of the motion that shows what an effect is made of.
const PROBE: usize = 600;
/// Sizes of that motion: an effect that begins at a place or a speed is not the same at all of them.
const SIZES: [f64; 3] = [1e-2, 1.0, 1e3];
/// Share of the force, or of a term, that is rounding.
const ROUNDING: f64 = 1e-9;

/// The motion of a size.
fn motion(size: f64) -> impl Iterator<Item = Motion<f64>> {
    let dt = 1e-2;
    let mut last = 0.0;
    (0..PROBE).map(move |i| {
        let t = dt * i as f64;
        let (slow, quick) = (TAU * 0.31 * t, TAU * 1.7 * t);
        let position = size * (0.05 * slow.sin() + 0.02 * quick.sin() + 0.004);
        let motion = Motion {
            dt,
            position,
            displacement: position - last,
            velocity: size * TAU * (0.0155 * slow.cos() + 0.034 * quick.cos()),
            applied: 2.0 * (TAU * 0.77 * t).sin(),
            mass: 0.0,
            normal: Some(5.0 + (TAU * 0.53 * t).sin()),
        };
        last = position;
        motion
    })
}

/// Whether the force is that of this part of the motion alone, without a memory, whatever the size of the motion.
fn depends_on(effect: &Effect<f64>, part: impl Fn(&Motion<f64>) -> Motion<f64>) -> bool {
    let mut acts = false;
    SIZES.iter().all(|size| {
        let mut state = EffectState::default();
        motion(*size).all(|m| {
            let (whole, alone) =
                (effect.step(&mut state, &m), effect.step(&mut EffectState::default(), &part(&m)));
            acts |= whole != 0.0;
            (whole - alone).abs() <= ROUNDING * whole.abs()
        })
    }) && acts
}

/// Speeds that show what a function of the speed is, m/s or rad/s.
fn speeds() -> impl Iterator<Item = f64> {
    (-60..=20).map(|i| 10.0_f64.powf(f64::from(i) / 10.0))
}

fn is_odd(effect: &Effect<f64>) -> bool {
    speeds().all(|v| {
        let (p, n) = (at_speed(effect, v), at_speed(effect, -v));
        (p + n).abs() <= ROUNDING * p.abs().max(n.abs())
    })
}

/// The effect as a falling friction, if it is nothing else: ln(−ln(F/F_0)) is a line over ln v.
fn falling(effect: &Effect<f64>) -> Option<Falling> {
    if !(depends_on(effect, |m| Motion { velocity: m.velocity, ..Motion::default() }) && is_odd(effect)) {
        return None;
    }
    let force = at_speed(effect, f64::MIN_POSITIVE);
    let points: Vec<(f64, f64)> = speeds()
        .map(|v| (v.ln(), at_speed(effect, v) / force))
        .filter(|(_, share)| *share > 1e-9 && *share < 1.0 - 1e-6)
        .map(|(log, share)| (log, (-share.ln()).ln()))
        .collect();
    let ((x0, y0), (x1, y1)) = (*points.first()?, *points.last()?);
    let exponent = (y1 - y0) / (x1 - x0);
    let at_e = x0 - y0 / exponent;
    let is_line = points.iter().all(|(x, y)| (exponent * (x - at_e) - y).abs() < 1e-6);
    (force > 0.0 && points.len() > 2 && exponent > 0.0 && is_line).then(|| Falling {
        force: rounded(force),
        speed: rounded(at_e.exp()),
        exponent: rounded(exponent),
    })
}

/// The effect as bristles, if it is nothing else.
fn presliding(effect: &Effect<f64>) -> Option<Presliding> {
    // its force at the end of slides from rest; speed and applied force must not matter
    let after = |slides: &[f64]| {
        let mut state = EffectState::default();
        slides.iter().enumerate().fold(0.0, |_, (i, dx)| {
            let (velocity, applied) = (dx.signum() * (0.1 + i as f64), 1.0 - i as f64);
            let motion = Motion { dt: 1e-3, displacement: *dx, velocity, applied, ..Motion::default() };
            effect.step(&mut state, &motion)
        })
    };
    const FAR: f64 = 1e6;
    let force = 0.5 * after(&[FAR, -1e-15]);
    if !(force > 0.0 && force.is_finite()) {
        return None;
    }
    // where a reversal has gone on to 1/e
    let (mut near, mut far) = (1e-12_f64.ln(), 1e3_f64.ln());
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        let is_near = after(&[FAR, -middle.exp()]) > 2.0 * force * (-1.0_f64).exp();
        *(if is_near { &mut near } else { &mut far }) = middle;
    }
    let d = near.exp();
    let bent = |slides: &[f64]| {
        slides.iter().fold(0.0, |z: f64, dx| dx.signum() + (z - dx.signum()) * (-dx.abs() / d).exp())
    };
    let slides: [&[f64]; 5] =
        [&[FAR], &[FAR, -0.1 * d], &[FAR, -5.0 * d], &[-FAR, 0.5 * d], &[FAR, -0.5 * d, 0.3 * d, -d]];
    let same = slides.iter().all(|slides| {
        let last = slides.last().map_or(0.0, |dx| dx.signum());
        (after(slides) - force * (bent(slides) - last)).abs() <= 1e-6 * force
    });
    same.then(|| Presliding { force: rounded(force), distance: rounded(d) })
}

/// The effect as waves over the position, if it is nothing else.
///
/// A sum of two waves fulfils f(x+2h) + f(x−2h) + a·(f(x+h) + f(x−h)) + b·f(x) = 0 at every x, and a and b give both wave
/// numbers (Prony's method). Steps h longer than half a wave give wrong ones, short steps inaccurate ones: from the longest on,
/// the first is taken whose waves are the effect.
fn waves(effect: &Effect<f64>) -> Option<[Wave; WAVES]> {
    if !depends_on(effect, |m| Motion { position: m.position, ..Motion::default() }) {
        return None;
    }
    (0..60).find_map(|i| waves_of_step(effect, 10.0_f64.powf(1.0 - f64::from(i) / 8.0)))
}

fn waves_of_step(effect: &Effect<f64>, h: f64) -> Option<[Wave; WAVES]> {
    const ROWS: usize = 40;
    let f = |x: f64| at_place(effect, x);
    // places that have no step in common
    let places: Vec<f64> = (0..ROWS).map(|i| h * (0.377 * i as f64 + 0.11 * (i as f64).sin())).collect();
    let least = |x: DMatrix<f64>, y: DVector<f64>, within: f64| -> Option<DVector<f64>> {
        let solved = x.clone().svd(true, true).solve(&y, 1e-9).ok()?;
        ((&x * &solved - &y).norm() <= within * y.norm()).then_some(solved)
    };
    // one wave: f(x+h) + f(x−h) = 2·cos(k·h)·f(x)
    let near = DVector::from_iterator(ROWS, places.iter().map(|x| f(x + h) + f(x - h)));
    let here = DVector::from_iterator(ROWS, places.iter().map(|x| f(*x)));
    let one = least(DMatrix::from_columns(std::slice::from_ref(&here)), near.clone(), 1e-9)
        .map(|c| vec![0.5 * c[0]]);
    let cosines = one.or_else(|| {
        let far = DVector::from_iterator(ROWS, places.iter().map(|x| f(x + 2.0 * h) + f(x - 2.0 * h)));
        let c = least(DMatrix::from_columns(&[near, here]), -far, 1e-9)?;
        // a = −2·(c1 + c2), b = 2 + 4·c1·c2
        let (sum, product) = (-0.5 * c[0], 0.25 * (c[1] - 2.0));
        let root = (0.25 * sum * sum - product).sqrt();
        Some(vec![0.5 * sum + root, 0.5 * sum - root])
    })?;
    if !cosines.iter().all(|c| c.abs() < 1.0) {
        return None;
    }
    let numbers: Vec<f64> = cosines.iter().map(|c| c.acos() / h).collect();
    let columns: Vec<DVector<f64>> = numbers
        .iter()
        .flat_map(|k| {
            [f64::sin as fn(f64) -> f64, f64::cos]
                .map(|wave| DVector::from_iterator(ROWS, places.iter().map(|x| wave(k * x))))
        })
        .collect();
    let here = DVector::from_iterator(ROWS, places.iter().map(|x| f(*x)));
    let gains = least(DMatrix::from_columns(&columns), here, 1e-6)?;
    let mut out = [Wave::default(); WAVES];
    for (i, (wave, k)) in out.iter_mut().zip(&numbers).enumerate() {
        let (sine, cosine) = (gains[2 * i], gains[2 * i + 1]);
        *wave = Wave {
            amplitude: rounded(sine.hypot(cosine)),
            per_length: rounded(*k),
            phase: rounded(cosine.atan2(sine)),
        };
    }
    // a wave may fit the places above and no others: four of the longest are looked at
    let size: f64 = out.iter().map(|w| w.amplitude).sum();
    let longest = TAU / numbers.iter().fold(f64::INFINITY, |least, k| k.min(least));
    let same = (-97..=97).all(|i| {
        let x = 4.0 * longest * f64::from(i) / 97.0;
        let made: f64 = out.iter().map(|w| w.amplitude * (w.per_length * x + w.phase).sin()).sum();
        (made - f(x)).abs() <= 1e-5 * size
    });
    (size > 0.0 && same).then_some(out)
}

/// The effect in the terms of a format, if it is nothing else, whatever the size of the motion.
fn sum(format: Format, effect: &Effect<f64>) -> Option<Sum> {
    let all: Option<Vec<Sum>> = SIZES.iter().map(|size| sum_at(format, effect, *size)).collect();
    let all = all?;
    let first = *all.first()?;
    let like = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let same = |h: &Sum| {
        like(h.friction, first.friction)
            && like(h.damping, first.damping)
            && like(h.stiffness, first.stiffness)
            && like(h.constant, first.constant)
            && like(h.per_load, first.per_load)
    };
    let least = first.friction.min(first.damping).min(first.stiffness).min(first.per_load);
    (all.iter().all(same) && least >= 0.0).then_some(first)
}

/// As [`sum`] in a motion of this size.
fn sum_at(format: Format, effect: &Effect<f64>, size: f64) -> Option<Sum> {
    let mut state = EffectState::default();
    let used = format.terms();
    let (mut force, mut terms) = (Vec::with_capacity(PROBE), Vec::with_capacity(PROBE));
    for m in motion(size) {
        force.push(effect.step(&mut state, &m));
        let s = m.velocity.signum();
        // terms of one size, so that each shows
        let all = [s, m.velocity / size, m.position / size, 1.0, s * m.applied.abs()];
        terms.push([0, 1, 2, 3, 4].map(|i| if used[i] { all[i] } else { 0.0 }));
    }
    let x = DMatrix::from_fn(PROBE, used.len(), |row, column| terms[row][column]);
    let f = DVector::from_vec(force);
    let whole = f.norm();
    let gains = x.clone().svd(true, true).solve(&f, 1e-12).ok()?;
    // an effect that is silent here acts elsewhere
    if !(whole > 0.0 && (&x * &gains - &f).norm() < ROUNDING * whole) {
        return None;
    }
    let held = |i: usize, unit: f64| {
        let share = gains[i] * x.column(i).norm();
        if share.abs() > ROUNDING * whole { rounded(gains[i] / unit) } else { 0.0 }
    };
    Some(Sum {
        friction: held(0, 1.0),
        damping: held(1, size),
        stiffness: held(2, size),
        constant: held(3, 1.0),
        per_load: held(4, 1.0),
    })
}

/// Without the rounding of the fit: ten significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}
