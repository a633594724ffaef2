//! A low-pass in front of the recorder, recognised in the spectrum of the noise.

use super::fault::{FaultKind, RecordingFault};
use crate::noise::quantum;
use crate::stretches::{Stretch, rms_frequency};
use crate::{Filter, Recording, zero_phase};

/// Ratio of neighbouring band edges: three bands an octave.
const STEP: f64 = 1.259_921_049_894_873_2;

/// Fall over an octave that a sensor's noise and a body's motion do not have, as a power ratio: 14 dB.
const FALL: f64 = 25.0;

/// A sensor's noise goes on to half the sampling rate, and forces under dry friction fall by 6 dB an octave. Where the
/// spectrum of force or acceleration breaks off instead and goes on falling to the end, a low-pass of third order or
/// more (or one that was run forward and backward) was there. A recording in which no channel has a floor of noise is
/// a calculated one and says nothing.
pub(super) fn hidden_filter(recording: &Recording, stretch: &Stretch, out: &mut Vec<RecordingFault>) {
    let moving = rms_frequency(&stretch.grid(&recording.position), stretch.dt);
    let looked_at = ["position", "velocity", "acceleration", "force", "torque"];
    let spectra: Vec<(&str, Spectrum)> = recording
        .columns()
        .into_iter()
        .filter(|(name, _)| looked_at.iter().any(|q| name.starts_with(q)))
        .filter_map(|(name, values)| {
            Some((name, Spectrum::of(&stretch.grid(values), stretch.dt, 4.0 * moving)?))
        })
        .collect();
    for (name, spectrum) in &spectra {
        let judged = ["acceleration", "force", "torque"].iter().any(|q| name.starts_with(q));
        if !judged || !spectra.iter().any(|(other, s)| other != name && s.has_floor()) {
            continue;
        }
        if let Some((edge, fall)) = spectrum.break_off() {
            let why = format!(
                "{name} was low-passed: its spectrum breaks off near {edge:.0} Hz, by {:.0} dB within an octave, and no \
                 noise is left above",
                10.0 * fall.log10()
            );
            out.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
        }
    }
}

/// Power per hertz in bands of a third of an octave, up to 0.45 of the sampling rate.
struct Spectrum {
    edges: Vec<f64>,
    density: Vec<f64>,
    /// Density of the rounding of the numbers, where that is not the sensor's quantisation.
    rounding: f64,
}

impl Spectrum {
    /// None where there is no room for an octave before a fall, the fall, and something above.
    fn of(series: &[f64], dt: f64, lowest: f64) -> Option<Self> {
        let n = series.len();
        let lowest = lowest.max(10.0 / (n as f64 * dt));
        let mut edges = vec![0.45 / dt];
        while let Some(edge) = edges.last().map(|e| e / STEP).filter(|e| *e > lowest) {
            edges.push(edge);
        }
        edges.reverse();
        // A channel that stands still has nothing but rounding.
        let still = series.iter().all(|x| series.first() == Some(x));
        if edges.len() < 10 || still {
            return None;
        }
        let filtered: Vec<Vec<f64>> = edges
            .iter()
            .map(|e| Filter::butterworth(4, *e, dt).map(|f| zero_phase(&f, series)))
            .collect::<Result<_, _>>()
            .ok()?;
        let inner = ((2.0 / lowest / dt) as usize).min(n / 8);
        let inner = inner..n - inner;
        let density: Vec<f64> = filtered
            .windows(2)
            .zip(edges.windows(2))
            .map(|(f, e)| {
                let power: f64 = inner.clone().map(|i| (f[1][i] - f[0][i]).powi(2)).sum();
                power / inner.len() as f64 / (e[1] - e[0])
            })
            .collect();
        let largest = series.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let step = quantum(series);
        let rounding = if step < 1e-5 * largest { step.max(1e-13 * largest) } else { 1e-13 * largest };
        Some(Self { edges, density, rounding: rounding * rounding / 12.0 * 2.0 * dt })
    }

    /// Power ratio over the octave that ends with band `i`.
    fn fall(&self, i: usize) -> f64 {
        match (self.density.get(i.wrapping_sub(3)), self.density.get(i)) {
            (Some(before), Some(after)) if *after > 0.0 => before / after,
            _ => 1.0,
        }
    }

    /// The highest octave is flat.
    fn has_floor(&self) -> bool {
        self.fall(self.density.len() - 1) < 10.0
            && self.density.last().is_some_and(|d| *d > 4.0 * self.rounding)
    }

    /// Where it first breaks off, Hz, and the power ratio of the fall. A resonance of the body below the cut-off can be
    /// what breaks off first: that something was low-passed is sure, the frequency is a first guess.
    fn break_off(&self) -> Option<(f64, f64)> {
        let last = self.density.len() - 1;
        let top = self.density[last];
        // Second order in the sampled world falls by more than 18 dB up to half the rate; friction, sampled, by 12.
        let ends = self.fall(last) > 60.0 || top < 4.0 * self.rounding;
        let falls = |i: &usize| {
            let (before, fall) = (self.fall(*i), self.fall(*i + 3));
            fall > FALL && fall > 6.0 * before && top < 1e-2 * self.density[*i]
        };
        let i = (3..=last - 3).find(falls).filter(|_| ends)?;
        Some((self.edges[i + 1], self.fall(i + 3)))
    }
}
