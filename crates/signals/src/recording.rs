//! A recording: columns of equal length in SI units, and what is known about them.

use crate::{Error, Map, csv_io, files, json_io, mat_io};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::Path;

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
}

/// How to read a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// What the columns are, for a file that does not use the names of this crate.
    pub map: Option<Map>,
}

impl Recording {
    /// Reads a recording: MATLAB v5 if the file is called `.mat` or begins as one, JSON if it is called `.json`, CSV
    /// otherwise.
    ///
    /// # Errors
    /// Names the file, the line and the column, what was found and what would be accepted.
    pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, Error> {
        Self::read_by(path.as_ref(), |_| options.map.as_ref())
    }

    /// Reads a recording with the map that its file needs: the first whose variables it all has, or none where its columns have
    /// the names of this crate. Returns that map, too.
    ///
    /// # Errors
    /// As [`Recording::read`], with the map that misses the fewest variables.
    pub fn read_with_maps(path: impl AsRef<Path>, maps: &[Map]) -> Result<(Self, Option<&Map>), Error> {
        let used = Cell::new(None);
        let recording = Self::read_by(path.as_ref(), |has| {
            used.set(Map::needed(maps, has));
            used.get()
        })?;
        Ok((recording, used.get()))
    }

    /// Reads a recording; `map` chooses by whether the file has a variable.
    fn read_by<'m>(
        path: &Path,
        map: impl Fn(&dyn Fn(&str) -> bool) -> Option<&'m Map>,
    ) -> Result<Self, Error> {
        let file = path.display().to_string();
        let bytes =
            std::fs::read(path).map_err(|e| Error::File { file: file.clone(), why: files::reason(&e) })?;
        let named = |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
        let mut recording = if named("mat") || bytes.starts_with(b"MATLAB 5.0") {
            mat_io::read(&file, &bytes, map)?
        } else if named("json") {
            json_io::read(&file, &bytes, map)?
        } else {
            csv_io::read(&file, &bytes, map)?
        };
        recording.name = path.file_name().map_or_else(|| file.clone(), |n| n.to_string_lossy().into_owned());
        Ok(recording)
    }

    /// Reads the text of a CSV file; `name` stands for the file in messages.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_csv(name: &str, text: &[u8], options: &ReadOptions) -> Result<Self, Error> {
        Ok(Self { name: name.into(), ..csv_io::read(name, text, |_| options.map.as_ref())? })
    }

    /// A recording of columns by name, as from a data frame; `name` stands for them in messages. Without a map, columns of other
    /// names are kept as [`Recording::extra`].
    ///
    /// ```
    /// use signals::Recording;
    /// let columns = [("time_s", [0.0, 1e-3]), ("position_m", [0.0, 1e-6]), ("force_n", [1.0, 1.1])];
    /// let columns = columns.map(|(name, values)| (name.to_owned(), values.to_vec()));
    /// let recording = Recording::from_columns("frame", columns.to_vec(), &[])?;
    /// assert_eq!(recording.force, [1.0, 1.1]);
    /// # Ok::<(), signals::Error>(())
    /// ```
    ///
    /// # Errors
    /// The column that is missing, given twice, of another length, or not what the map needs.
    pub fn from_columns(name: &str, columns: Vec<(String, Vec<f64>)>, maps: &[Map]) -> Result<Self, Error> {
        Ok(Self { name: name.into(), ..mat_io::of_columns(name, columns, maps)? })
    }

    /// Writes CSV: [`Recording::read`] gives back equal columns, bit for bit.
    ///
    /// # Errors
    /// Columns of unequal length, or a file that cannot be written.
    pub fn write_csv(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let text = self.to_csv()?;
        std::fs::write(path, text)
            .map_err(|e| Error::File { file: path.display().to_string(), why: files::reason(&e) })
    }

    /// The text of [`Recording::write_csv`].
    ///
    /// # Errors
    /// Columns of unequal length.
    pub fn to_csv(&self) -> Result<String, Error> {
        csv_io::write(self)
    }

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

    /// Checks that every column is as long as `time`.
    ///
    /// # Errors
    /// The first column that is not.
    pub fn check_lengths(&self) -> Result<(), Error> {
        let extra = self.extra.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        for (name, values) in self.columns().into_iter().chain(extra) {
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
