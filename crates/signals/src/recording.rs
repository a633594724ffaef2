//! A recording: columns of equal length in SI units, and what is known about them.

use crate::Error;
use std::collections::BTreeMap;

pub use friction::Geometry;

/// Columns of equal length, SI. Only time, position and force are required; a value that is not a number is kept
/// as NaN and is a fault that [`crate::audit`] reports.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// File name, or what it is called in messages and reports.
    pub name: String,
    /// Slide or axis.
    pub geometry: Geometry,
    /// s.
    pub time: Vec<f64>,
    /// m or rad.
    pub position: Vec<f64>,
    /// Force that moves the body, N or N·m.
    pub force: Vec<f64>,
    /// m/s or rad/s.
    pub velocity: Option<Vec<f64>>,
    /// m/s² or rad/s².
    pub acceleration: Option<Vec<f64>>,
    /// Force that presses the contact together, N.
    pub normal_force: Option<Vec<f64>>,
    /// Commanded force, N.
    pub command: Option<Vec<f64>>,
    /// Reference position, m.
    pub reference: Option<Vec<f64>>,
    /// °C.
    pub temperature: Option<Vec<f64>>,
    /// Further columns of numbers, by name: another joint's motion, a supply voltage. A mismatch may follow one.
    pub extra: BTreeMap<String, Vec<f64>>,
    /// `# key: value` lines of the file.
    pub metadata: BTreeMap<String, String>,
    /// What reading did to the numbers: units converted, clocks joined. Sentences for the user; they are in no file.
    pub remarks: Vec<String>,
}

impl Recording {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// No samples at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Median time between samples, s: lost samples do not change it. None where there are no two samples in order.
    #[must_use]
    pub fn sample_period(&self) -> Option<f64> {
        let mut steps: Vec<f64> =
            self.time.windows(2).map(|w| w[1] - w[0]).filter(|d| d.is_finite() && *d > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied()
    }

    /// Names and values of the columns there are, time first, as in the header of a CSV file.
    #[must_use]
    pub fn columns(&self) -> Vec<(&'static str, &[f64])> {
        let pick = |linear, rotary| if self.geometry == Geometry::Rotary { rotary } else { linear };
        let optional: [(&'static str, &Option<Vec<f64>>); 6] = [
            (pick("velocity_m_s", "velocity_rad_s"), &self.velocity),
            (pick("acceleration_m_s2", "acceleration_rad_s2"), &self.acceleration),
            ("normal_force_n", &self.normal_force),
            ("command_n", &self.command),
            ("reference_m", &self.reference),
            ("temperature_c", &self.temperature),
        ];
        let mut out: Vec<(&'static str, &[f64])> = vec![
            ("time_s", &self.time),
            (pick("position_m", "position_rad"), &self.position),
            (pick("force_n", "torque_nm"), &self.force),
        ];
        out.extend(optional.into_iter().filter_map(|(name, values)| Some((name, values.as_deref()?))));
        out
    }

    /// [`Self::columns`] and the further ones.
    pub(crate) fn all_columns(&self) -> Vec<(&str, &[f64])> {
        let extra = self.extra.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        self.columns().into_iter().chain(extra).collect()
    }

    /// Checks that every column is as long as `time`.
    ///
    /// # Errors
    /// The first column that is not.
    pub fn check_lengths(&self) -> Result<(), Error> {
        for (name, values) in self.all_columns() {
            if values.len() != self.time.len() {
                return Err(Error::Recording {
                    recording: self.name.clone(),
                    why: format!("{name} has {} samples, time_s has {}", values.len(), self.time.len()),
                });
            }
        }
        Ok(())
    }
}
