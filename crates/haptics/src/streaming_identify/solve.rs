//! From moments to parameters. Runs in a task, not in the interrupt; `f32`, in closed form.

use super::break_away::{BreakAway, UNIFORM};
use super::fit::{Accelerometer, Fit};
use super::identified::{Estimate, Identified, Unidentified};
use super::moments::{Departures, Moments, Units};
use super::recorder::{BANDS, Number, Procedure};
use crate::Device;
use friction::Scalar;

/// Fewest used samples in a direction.
pub(super) const FEWEST: u32 = 50;

/// Takes a recording number by number, fastest band first, and finds which bands slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    units: Units,
    width: f32,
    period: f32,
    /// Of the device without its block.
    mass: f32,
    damping: f32,
    /// Moments of the band that is coming.
    coming: [Moments; 2],
    /// Moments of what is used.
    used: [Moments; 2],
    /// A band that slides, not used yet: the one above the edge is not, its differences of velocity reach below.
    held: Option<[Moments; 2]>,
    /// Samples that leave rest, of each band.
    departures: [[Departures; 2]; BANDS],
    set_aside: u32,
    edge: Option<u8>,
}

impl Solver {
    /// For what this procedure records on this device.
    #[must_use]
    pub fn new(device: &Device, procedure: &Procedure) -> Self {
        Self {
            units: Units::of(device),
            width: procedure.band_width(),
            period: device.period,
            mass: device.mass,
            damping: device.damping,
            coming: Default::default(),
            used: Default::default(),
            held: None,
            departures: Default::default(),
            set_aside: 0,
            edge: None,
        }
    }

    /// Takes a number. The last index begins anew, index 0 ends with the result.
    pub fn take(&mut self, number: &Number) -> Option<Result<Identified, Unidentified>> {
        let (band, begins, ends) = number.band();
        if begins && band == BANDS - 1 {
            (self.used, self.departures, self.held) = Default::default();
            (self.set_aside, self.edge) = (0, None);
        }
        if let Some(sum) = number.place(&mut self.coming) {
            *sum = number.value;
        }
        if ends {
            self.band(band);
        }
        (number.index == 0).then(|| self.result())
    }

    /// A band is complete.
    fn band(&mut self, index: usize) {
        let ways = self.coming;
        let count = |ways: &[Moments; 2]| ways[0].samples() + ways[1].samples();
        let merge = |all: &mut [Moments; 2], ways: &[Moments; 2]| {
            for (sum, way) in all.iter_mut().zip(ways) {
                sum.merge(way);
            }
        };
        if let Some(departures) = self.departures.get_mut(index) {
            *departures = [ways[0].departures(&self.units), ways[1].departures(&self.units)];
        }
        if index == BANDS - 1 {
            self.used = ways;
            return;
        }
        // rest is in the slowest band whatever the friction
        let steps = self.edge.is_none() && (index == 0 || !self.slides(&ways));
        if steps {
            self.edge = Some(index as u8);
            self.set_aside += self.held.take().as_ref().map_or(0, count);
        }
        if self.edge.is_some() {
            self.set_aside += count(&ways);
        } else if let Some(held) = self.held.replace(ways) {
            merge(&mut self.used, &held);
        }
    }

    fn fit(&self) -> Result<Fit, Unidentified> {
        let [p, n] = &self.used;
        if p.samples() < FEWEST || n.samples() < FEWEST {
            return Err(Unidentified::TooLittleMotion { positive: p.samples(), negative: n.samples() });
        }
        let ways = [p.in_si(&self.units), n.in_si(&self.units)];
        Fit::new(&ways, Accelerometer::calibrate(&ways)?)
    }

    fn slides(&self, ways: &[Moments; 2]) -> bool {
        // without a fit there is nothing to compare with; the result will say why
        let Ok(fit) = self.fit() else { return true };
        fit.explains(&[ways[0].in_si(&self.units), ways[1].in_si(&self.units)])
    }

    /// Acceleration at the end of a period over that in its middle. The force is held, but damping follows the velocity:
    /// it takes (b + b_device)·T/2 of what the masses gain. Less than 1 % with the blocks of [thesis, table 3-3], and more than
    /// the standard deviation of the mass.
    fn late(&self, fit: &Fit) -> f32 {
        let damping = self.damping + 0.5 * (fit.viscous[0].value + fit.viscous[1].value);
        let late = 1.0 - 0.5 * self.period * damping / (self.mass + fit.mass.value);
        Scalar::clamp(late, 0.9, 1.1)
    }

    /// Where no step of friction is seen: Δv is in the band of the edge, and what leaves rest below it is static.
    fn below_the_edge(&self, fit: &Fit) -> BreakAway {
        let edge = usize::from(self.edge.unwrap_or(0));
        let level = |way: usize, sign: f32| {
            let (mut count, mut sum) = (0, 0.0);
            for there in self.departures.iter().take(edge.max(1)).filter_map(|ways| ways.get(way)) {
                count += there.count;
                let friction = there.load - fit.mass.value * fit.accelerometer.of(there.reading);
                sum += there.count as f32 * sign * friction;
            }
            (count >= 2).then(|| Estimate {
                value: sum / count as f32,
                std: Scalar::sqrt(fit.noise_by_accelerometer / count as f32),
            })
        };
        BreakAway {
            delta_v: Estimate { value: (edge as f32 + 0.5) * self.width, std: UNIFORM * self.width },
            levels: [level(0, 1.0), level(1, -1.0)],
        }
    }

    fn result(&self) -> Result<Identified, Unidentified> {
        let fit = self.fit()?;
        let [p, n] = &self.used;
        let late = self.late(&fit);
        let break_away = BreakAway::find(&self.departures, &fit, self.width, self.period)
            .unwrap_or_else(|| self.below_the_edge(&fit));
        Ok(Identified {
            mass: Estimate { value: fit.mass.value / late, std: fit.mass.std / late },
            coulomb_p: fit.coulomb[0],
            viscous_p: fit.viscous[0],
            coulomb_n: fit.coulomb[1],
            viscous_n: fit.viscous[1],
            static_p: break_away.levels[0],
            static_n: break_away.levels[1],
            delta_v: break_away.delta_v,
            mass_least_squares: fit.mass_least_squares / late,
            accel_scale: fit.accelerometer.scale * late,
            accel_offset: fit.accelerometer.offset * late,
            relative_error: fit.relative_error,
            used: p.samples() + n.samples(),
            set_aside: self.set_aside,
        })
    }
}
