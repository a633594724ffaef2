//! Statistics of a running machine.

use crate::UNITS_PER_SECOND;

/// Smallest, largest, sum and number of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Number of values.
    pub count: u64,
    sum: f64,
}

impl Summary {
    /// Mean. 0 without values.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }

    /// Range: largest less smallest.
    #[must_use]
    pub fn spread(&self) -> f64 {
        self.max - self.min
    }

    pub(crate) fn add(&mut self, value: f64) {
        if self.count == 0 {
            (self.min, self.max) = (value, value);
        }
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.sum += value;
        self.count += 1;
    }
}

/// Counts and times since [`crate::Machine::reset_statistics`] or boot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Statistics {
    /// Conversions started by the pacing timer.
    pub triggers: u64,
    /// Control steps: forces written to the DAC after a sample.
    pub steps: u64,
    /// Samples not served before the next, and triggers at a busy converter.
    pub missed: u64,
    /// End of conversion to the force in the DAC's holding register, µs.
    pub compute_us: Summary,
    /// End of conversion to the change of the output, µs.
    pub latency_us: Summary,
    /// Motion that an absolute encoder shows to the change of the output that answers it, µs.
    pub angle_us: Summary,
    /// Force on a load cell with its own converter to the change of the output of the step that sees it, µs.
    pub load_us: Summary,
    /// Output to output, µs.
    pub output_period_us: Summary,
    /// End of conversion to the reading of the encoder, µs.
    pub sampling_us: Summary,
    /// Outputs without a new force: the step was late.
    pub stale_outputs: u64,
    /// Control interrupt from entry to exit, core cycles, with those that the core waits for memories and buses.
    pub step_cycles: Summary,
    /// Most loads from flash in one control interrupt.
    pub step_flash_loads: u64,
    /// Core cycles awake, and in total.
    pub busy_cycles: u64,
    /// Virtual time observed, units.
    pub elapsed: u64,
    /// Virtual time asleep, units.
    pub asleep: u64,
    /// Longest time between two feedings of the watchdog, ms.
    pub watchdog_gap_ms: Summary,
}

impl Statistics {
    /// Share of time with the core awake.
    #[must_use]
    pub fn load(&self) -> f64 {
        if self.elapsed == 0 { 0.0 } else { 1.0 - self.asleep as f64 / self.elapsed as f64 }
    }
}

pub(crate) fn us(units: u64) -> f64 {
    units as f64 * 1e6 / UNITS_PER_SECOND as f64
}
