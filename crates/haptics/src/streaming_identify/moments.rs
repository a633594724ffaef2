//! Exact sums over the samples of one direction in one band of speed, and what they are in SI.

use crate::Device;

/// Steps of velocity in the overspeed. Velocity at a sample is a sum of two, so it has twice as many.
const PER_OVERSPEED: f32 = 1_048_576.0;
/// Largest magnitude of velocity, difference and roughness that is taken, steps: no sum can overflow.
const MOST: i32 = 1 << 22;
/// Middle of the converters' range.
const MIDDLE: i32 = 32_768;
/// Variance of the four-point difference over that of the fourth difference, both of velocity that is the difference
/// of noisy positions: (292/144)/252.
const DIFFERENCE_NOISE: f32 = 0.008_05;
/// The same for the mean of two velocities: 0.5/252.
const VELOCITY_NOISE: f32 = 0.001_98;

/// Numbers in [`Moments`].
pub(super) const SUMS: usize = 19;
const SAMPLES: usize = 0;
/// Samples in which the handle leaves rest; their load and accelerometer.
const LEAVING: usize = 1;
const LEAVING_F: usize = 2;
const LEAVING_R: usize = 3;
// d: differences of velocity, r: accelerometer, v: velocity, f: load cell
const D: usize = 4;
const R: usize = 5;
const V: usize = 6;
const F: usize = 7;
const DD: usize = 8;
const DR: usize = 9;
const RR: usize = 10;
const DV: usize = 11;
const RV: usize = 12;
const VV: usize = 13;
const DF: usize = 14;
const RF: usize = 15;
const VF: usize = 16;
const FF: usize = 17;
/// Squares of fourth differences of velocity: what is left of a smooth motion is noise.
const ROUGH: usize = 18;

/// Steps of velocity in 1 m/s on this device.
pub(super) fn per_m_s(device: &Device) -> f32 {
    PER_OVERSPEED / device.overspeed
}

/// Velocity in steps.
pub(super) fn steps(velocity: f32, per_m_s: f32) -> i32 {
    // `as` saturates and takes NaN to 0
    ((velocity * per_m_s) as i32).clamp(-MOST / 2, MOST / 2)
}

/// Accelerometer and load cell of one sample, codes from the middle of their range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Codes {
    r: i16,
    f: i16,
}

impl Codes {
    pub fn new(accel_code: u16, load_code: u16) -> Self {
        let middle = |code: u16| (i32::from(code) - MIDDLE) as i16;
        Self { r: middle(accel_code), f: middle(load_code) }
    }
}

/// Sums over samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Moments(pub(super) [i64; SUMS]);

impl Moments {
    /// Takes a sample: its codes, the velocity `v` at its instant in half steps, and the mean velocities over five
    /// periods, the middle one of which ended with it.
    pub(super) fn add(&mut self, means: [i32; 5], v: i32, codes: Codes) {
        let [a, b, now, c, e] = means;
        let d = (8 * (c - b) - (e - a)).clamp(-MOST, MOST);
        let rough = (a + e - 4 * (b + c) + 6 * now).clamp(-MOST, MOST);
        let (r, f) = (i32::from(codes.r), i32::from(codes.f));
        let product = |x: i32, y: i32| i64::from(x) * i64::from(y);
        // one by one: a loop over a table is compiled to one, with its bounds checked
        let sums = &mut self.0;
        sums[SAMPLES] += 1;
        sums[D] += i64::from(d);
        sums[R] += i64::from(r);
        sums[V] += i64::from(v);
        sums[F] += i64::from(f);
        sums[DD] += product(d, d);
        sums[DR] += product(d, r);
        sums[RR] += product(r, r);
        sums[DV] += product(d, v);
        sums[RV] += product(r, v);
        sums[VV] += product(v, v);
        sums[DF] += product(d, f);
        sums[RF] += product(r, f);
        sums[VF] += product(v, f);
        sums[FF] += product(f, f);
        sums[ROUGH] += product(rough, rough);
    }

    /// Takes note that the handle leaves rest in this sample.
    pub(super) fn leave(&mut self, codes: Codes) {
        self.0[LEAVING] += 1;
        self.0[LEAVING_F] += i64::from(codes.f);
        self.0[LEAVING_R] += i64::from(codes.r);
    }

    /// Adds the samples of another band.
    pub(super) fn merge(&mut self, other: &Self) {
        for (sum, more) in self.0.iter_mut().zip(&other.0) {
            *sum += more;
        }
    }

    /// Samples summed.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.0[SAMPLES] as u32
    }

    /// Means and centred sums in SI.
    pub(super) fn in_si(&self, units: &Units) -> Centred {
        let sums = &self.0;
        let n = sums[SAMPLES];
        let count = n.max(1) as f32;
        let mean = |sum: usize, unit: f32| sums[sum] as f32 / count * unit;
        // n·Σxy − Σx·Σy is exact
        let centred = |xy: usize, x: usize, y: usize, unit: f32| {
            let product = |x: i64, y: i64| i128::from(x) * i128::from(y);
            (product(n, sums[xy]) - product(sums[x], sums[y])) as f32 / count * unit
        };
        let Units { d, r, v, f, .. } = *units;
        let rough = sums[ROUGH] as f32 / count * (4.0 * v * v);
        Centred {
            n: n as f32,
            d: mean(D, d),
            r: mean(R, r) + units.r_middle,
            v: mean(V, v),
            f: mean(F, f) + units.f_middle,
            dd: centred(DD, D, D, d * d),
            dr: centred(DR, D, R, d * r),
            rr: centred(RR, R, R, r * r),
            dv: centred(DV, D, V, d * v),
            rv: centred(RV, R, V, r * v),
            vv: centred(VV, V, V, v * v),
            df: centred(DF, D, F, d * f),
            rf: centred(RF, R, F, r * f),
            vf: centred(VF, V, F, v * f),
            ff: centred(FF, F, F, f * f),
            noise_d: rough * DIFFERENCE_NOISE * units.rate * units.rate,
            noise_v: rough * VELOCITY_NOISE,
        }
    }

    /// The samples that left rest.
    pub(super) fn departures(&self, units: &Units) -> Departures {
        let sums = &self.0;
        let count = sums[LEAVING].max(1) as f32;
        let mean = |sum: usize, unit: f32| sums[sum] as f32 / count * unit;
        Departures {
            count: sums[LEAVING] as u32,
            load: mean(LEAVING_F, units.f) + units.f_middle,
            reading: mean(LEAVING_R, units.r) + units.r_middle,
        }
    }
}

/// Samples that left rest: how many, their mean load (N) and mean accelerometer reading (m/s²).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Departures {
    pub count: u32,
    pub load: f32,
    pub reading: f32,
}

/// SI of one step of each quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    rate: f32,
    d: f32,
    r: f32,
    v: f32,
    f: f32,
    r_middle: f32,
    f_middle: f32,
}

impl Units {
    pub fn of(device: &Device) -> Self {
        let rate = 1.0 / device.period;
        let v = 0.5 / per_m_s(device);
        Self {
            rate,
            d: v * rate * (1.0 / 6.0),
            r: device.accel.unit_per_code,
            v,
            f: device.load.unit_per_code,
            r_middle: (MIDDLE as f32 - device.accel.offset_code) * device.accel.unit_per_code,
            f_middle: (MIDDLE as f32 - device.load.offset_code) * device.load.unit_per_code,
        }
    }
}

/// Means, and sums of products of deviations from them, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Centred {
    pub n: f32,
    pub d: f32,
    pub r: f32,
    pub v: f32,
    pub f: f32,
    pub dd: f32,
    pub dr: f32,
    pub rr: f32,
    pub dv: f32,
    pub rv: f32,
    pub vv: f32,
    pub df: f32,
    pub rf: f32,
    pub vf: f32,
    pub ff: f32,
    /// Variance of the errors of d, (m/s²)².
    pub noise_d: f32,
    /// Variance of the errors of v, (m/s)².
    pub noise_v: f32,
}
