//! Where the filter cuts: for a search for what is missing, and for the fit of one law.
//!
//! The two have different needs, which was measured: behind the cut-off of a search an identification is worse (hsm150:
//! an inertia five times too small), behind that of a fit with an accelerometer a diagnosis names effects where none is
//! (13 of 60 nulls instead of at most 3).

use super::channels::Channels;
use super::one_way::one_way;
use crate::stretches::rms_frequency;
use crate::{
    Basis, LowPass, Source, Sources, dot, four_point_difference, noise_std, noise_variance, quantile, rms,
    spread,
};
use std::f64::consts::PI;

/// Share of the acceleration's root mean square that its error may be behind the filter of a fit.
const NOISE_SHARE: f64 = 0.05;
/// Error of the inertial force that does no harm, as a share of the force's spread.
const NEGLIGIBLE: f64 = 0.005;
/// Highest cut-off, Hz, and as a share of the sampling rate: above an eighth differences are no derivatives any more.
const HIGHEST: f64 = 150.0;
const HIGHEST_SHARE: f64 = 0.125;
/// Lowest cut-off, in frequencies of the motion: its harmonics have to pass.
const HARMONICS: f64 = 8.0;
/// A mass in standard errors from which on inertia shows.
const MIN_T_STATISTIC: f64 = 5.0;
/// Where it does not, the noise of the velocity, as a share of the speed that a tenth of the motion is slower than.
const NOISE_OF_SPEED: f64 = 0.2;
/// Cut-off of the filter behind which a search takes derivatives, in cut-offs of its own.
pub const SHARPER: f64 = 3.0;

/// Cycles of a low-pass within which it smears an edge: so far from a moment without a known direction, and from the ends of a stretch,
/// its samples say nothing.
pub const SMEARED: f64 = 0.75;

/// Standard deviation of the white noise of each channel, and of what is derived behind a low-pass.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Of a raw position sample, m or rad.
    pub position: f64,
    /// Of a raw force sample, N or N·m.
    pub force: f64,
    /// Of the velocity behind the low-pass, m/s or rad/s.
    pub velocity: f64,
    /// Of the acceleration behind the low-pass, m/s² or rad/s².
    pub acceleration: f64,
}

/// Standard deviation of white noise of unit standard deviation behind a low-pass at `cutoff` Hz after `order`
/// differentiations, in the small-band approximation; 1/s to the power of `order`.
#[must_use]
pub fn differentiated(order: i32, cutoff: f64, dt: f64) -> f64 {
    let w = 2.0 * PI * cutoff;
    (w.powi(2 * order) * 2.0 * cutoff * dt / f64::from(2 * order + 1)).sqrt()
}

/// White noise of the raw channels: position, velocity, acceleration, force.
struct White {
    dt: f64,
    position: f64,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    force: f64,
}

impl White {
    fn of(channels: &Channels) -> Self {
        let column = |c: Option<&Vec<f64>>| c.map(|c| noise_std(c).max(1e-300));
        // a velocity that lags at low speed does not lower the noise there
        let velocity = channels.velocity.as_ref().filter(|_| channels.late_below.is_none());
        Self {
            dt: channels.dt,
            position: noise_std(&channels.position),
            velocity: column(velocity),
            acceleration: column(channels.acceleration.as_ref()),
            force: noise_std(&channels.force),
        }
    }

    /// Every source of velocity and acceleration used by its weight.
    fn derived(&self, cutoff: f64) -> Noise {
        let behind = |std: f64, order: i32| std * differentiated(order, cutoff, self.dt);
        let parallel = |sources: &[Option<f64>]| {
            let information: f64 = sources.iter().flatten().map(|s| 1.0 / (s * s).max(1e-300)).sum();
            if information > 0.0 { information.sqrt().recip() } else { 0.0 }
        };
        Noise {
            position: self.position,
            force: self.force,
            velocity: parallel(&[Some(behind(self.position, 1)), self.velocity.map(|s| behind(s, 0))]),
            acceleration: parallel(&[
                Some(behind(self.position, 2)),
                self.velocity.map(|s| behind(s, 1)),
                self.acceleration.map(|s| behind(s, 0)),
            ]),
        }
    }
}

/// Noise of velocity and acceleration behind a low-pass at `cutoff` Hz, every source of either used by its weight.
#[must_use]
pub fn derived_noise(channels: &Channels, cutoff: f64) -> Noise {
    White::of(channels).derived(cutoff)
}

/// The cut-off for a search of stretches that are filtered alike, Hz: as high as their noise allows, so that what happens at
/// a reversal stays visible.
///
/// The noise that differentiating puts on the inertial force must not exceed the force channel's own noise, or half a
/// percent of the force: above it the smallest forces that were left out would be hidden by it. Where a body only advances and
/// its inertia does not show, that noise hides nothing, and the speed has to be known. At most 150 Hz and an eighth of the slowest rate, at least eight
/// times the highest frequency of the motion.
#[must_use]
pub fn choose_cutoff(stretches: &[Channels]) -> f64 {
    let slowest = stretches.iter().map(|c| 1.0 / c.dt).fold(f64::INFINITY, f64::min);
    let ceiling = HIGHEST_SHARE * slowest;
    let motion = stretches.iter().map(Channels::dominant_frequency).fold(0.0, f64::max);
    let lowest = (HARMONICS * motion).min(ceiling);
    let looks = looks((10.0 * motion).min(ceiling), ceiling);
    let rough: Vec<Rough> = stretches.iter().map(|c| Rough::of(c, &looks)).collect();
    let mass = rough.iter().map(|r| r.mass).fold(0.0, f64::max);
    // a body that reverses also rests, and the force at rest hides its mass
    let shows = one_way(stretches).is_none() || rough.iter().any(|r| r.shows);
    let white: Vec<White> = stretches.iter().map(White::of).collect();
    let tolerated: Vec<f64> = stretches.iter().map(|c| NEGLIGIBLE * spread(&c.force)).collect();
    let fits = |cutoff: f64| {
        white.iter().zip(&rough).zip(&tolerated).all(|((white, rough), tolerated)| {
            let force = white.force * differentiated(0, cutoff, white.dt);
            if shows {
                mass * white.derived(cutoff).acceleration <= force.max(*tolerated)
            } else {
                white.derived(SHARPER * cutoff).velocity <= NOISE_OF_SPEED * rough.slow
            }
        })
    };
    let mut cutoff = ceiling.min(HIGHEST);
    while cutoff > lowest && !fits(cutoff) {
        cutoff *= 0.85;
    }
    cutoff.max(lowest).min(ceiling)
}

/// The cut-off for a fit of one law, Hz: the highest at which the error of the acceleration is at most 5 % of it, over the
/// longest stretch.
///
/// The variance of that error is known and taken out of the fit; while it is small, more bandwidth is more information. At
/// most a tenth of the sampling rate, at least five times the frequency of the motion.
#[must_use]
pub fn choose_cutoff_of_fit(stretches: &[Channels]) -> Option<f64> {
    let longest = stretches.iter().max_by_key(|c| c.len())?;
    let dt = longest.dt;
    let noise = Sources {
        dt,
        position: noise_variance(&longest.position),
        velocity: longest.velocity.as_deref().map(noise_variance),
        acceleration: longest.acceleration.as_deref().map(noise_variance),
    };
    let highest = 0.1 / dt;
    let moving = rms_frequency(&longest.position, dt);
    let floor = (5.0 * moving).max(8.0 / (longest.len() as f64 * dt)).min(highest);
    let mut cutoff = highest;
    while cutoff > floor {
        let low_pass = LowPass::new(cutoff, dt);
        let (error, source) = noise.acceleration(&low_pass);
        let all = shown(longest, source, &low_pass);
        if error.sqrt() <= NOISE_SHARE * (all * all - error).max(0.0).sqrt() {
            return Some(cutoff);
        }
        cutoff *= 0.8;
    }
    Some(floor)
}

/// Root mean square of the acceleration from a source, m/s² or rad/s².
fn shown(c: &Channels, source: Source, low_pass: &LowPass) -> f64 {
    let (column, order) = match (source, &c.velocity, &c.acceleration) {
        (Source::Column, _, Some(a)) => (a, 0),
        (Source::Velocity, Some(v), _) => (v, 1),
        _ => (&c.position, 2),
    };
    let series = (0..order).fold(low_pass.apply(column), |s, _| four_point_difference(&s, c.dt));
    let trim = (2 * low_pass.settle()).min(series.len() / 8);
    rms(&series[trim..series.len() - trim])
}

/// Cut-offs of first looks, Hz: each twice the one before.
fn looks(lowest: f64, highest: f64) -> Vec<f64> {
    let next = |last: &f64| Some(2.0 * last).filter(|next| next > last && *next <= highest);
    std::iter::successors(Some(lowest), next).collect()
}

/// What a first look says of a stretch.
#[derive(Clone, Copy)]
struct Rough {
    /// Mass, kg or kg·m².
    mass: f64,
    /// Whether it is surely not zero.
    shows: bool,
    /// Speed that a tenth of the motion is slower than, m/s or rad/s.
    slow: f64,
}

impl Rough {
    /// The largest mass that surely is not zero, at any of the `looks`: behind a low cut-off friction and rests hide the
    /// inertia of a body that moves now and then, behind a high one noise takes it for smaller. Where none is sure, that of the
    /// first look.
    fn of(channels: &Channels, looks: &[f64]) -> Self {
        let mut all = looks.iter().map(|cutoff| Self::behind(channels, *cutoff));
        let first = all.next().unwrap_or(Self { mass: 0.0, shows: false, slow: 0.0 });
        let larger = |a: Self, b: Self| if b.shows && !(a.shows && a.mass >= b.mass) { b } else { a };
        let mass = all.fold(first, larger);
        Self { slow: first.slow, ..mass }
    }

    /// By a regression on acceleration, direction, velocity and a constant behind a filter at `cutoff` Hz.
    fn behind(channels: &Channels, cutoff: f64) -> Self {
        let filter = LowPass::new(cutoff, channels.dt);
        let v = four_point_difference(&filter.apply(&channels.position), channels.dt);
        let a = four_point_difference(&v, channels.dt);
        let sign: Vec<f64> =
            filter.apply(&v.iter().map(|v| if *v < 0.0 { -1.0 } else { 1.0 }).collect::<Vec<_>>());
        let f = filter.apply(&channels.force);
        let slow = quantile(&v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.1);
        let basis = Basis::of(&[&v[..], &sign[..], &vec![1.0; v.len()][..]]);
        let (a, f) = (basis.project_out(&a), basis.project_out(&f));
        let power = dot(&a, &a);
        let mass = dot(&a, &f) / power;
        let left = (dot(&f, &f) - mass * mass * power).max(0.0);
        // behind the filter as many samples are independent
        let independent = (2.0 * cutoff * channels.dt * f.len() as f64).max(1.0);
        let std = (left / (independent * power)).sqrt();
        let mass = if power > 0.0 { mass.abs() } else { 0.0 };
        Self { mass, shows: mass > MIN_T_STATISTIC * std, slow }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force at rest hides the inertia and the zero speed limits the cut-off, unless both rules are kept to bodies that only advance.
    #[test]
    fn a_body_that_rests_half_of_the_time_was_filtered_at_five_hertz() {
        let (dt, mass, friction, stroke) = (1e-3, 0.4, 3.0, 0.012);
        let (mut position, mut force) = (Vec::new(), Vec::new());
        for i in 0..16_000 {
            let (number, u) = (i / 1000, f64::from(i % 1000) / 400.0);
            let way = if number % 2 == 0 { 1.0 } else { -1.0 };
            let s = u.min(1.0);
            let at = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s) - 0.5;
            let a = stroke * (60.0 * s - 180.0 * s * s + 120.0 * s * s * s) / (0.4 * 0.4);
            let noise = 0.03 * f64::from((i * 7919) % 101 - 50) / 29.0;
            position.push((way * stroke * at / 2.6e-6).round() * 2.6e-6);
            // at rest the drive holds with what it happens to have
            let push = if u < 1.0 { friction } else { 2.0 * f64::from((number * 37) % 19 - 9) / 9.0 };
            force.push(way * (push + if u < 1.0 { mass * a } else { 0.0 }) + noise);
        }
        let cutoff = choose_cutoff(&[Channels { position, force, dt, ..Channels::default() }]);
        println!("{cutoff} Hz");
        assert!(cutoff > 30.0, "{cutoff} Hz");
    }
}
