//! What the page asks for, and what it shows.

use diagnose::diagnose;
use procedures::identified::{How, identify};
use procedures::recordings::{model_name, read_bytes};
use procedures::{diagnosed, numbers};
use signals::Recording;
use std::fmt;

/// Options as people type them; an empty text is the default.
#[derive(Debug, Clone, PartialEq, Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// `karnopp` or `dahl`.
    pub law: String,
    /// `SIGNAL=VARIABLE,…`, for files with other names; several are separated by line ends.
    pub map: String,
    /// Which joint, of a file that has several.
    pub joint: String,
    /// Standard deviation of one force sample, N (N·m).
    pub noise: String,
    /// Cut-off of the zero-phase filter, Hz.
    pub cutoff: String,
}

/// A refusal: what the command prints behind `error: `.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal(String);

impl Refusal {
    fn option(name: &str, value: &str, why: &str) -> Self {
        Self(format!("{name}: `{value}`: {why}"))
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl From<procedures::Error> for Refusal {
    fn from(error: procedures::Error) -> Self {
        Self(match error.help() {
            Some(help) => format!("{error}\n  help: {help}"),
            None => error.to_string(),
        })
    }
}

/// Recordings, and how they are analysed.
#[derive(Debug, Clone)]
pub struct Analysis {
    recordings: Vec<Recording>,
    how: How,
    options: diagnose::Options,
}

/// What the command writes for `--report`, `--json` and `--out`.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// One self-contained page.
    pub html: String,
    /// With a line end.
    pub json: String,
    /// None where the recordings cannot be tested.
    pub model: Option<String>,
}

impl Analysis {
    /// Reads files, given by name and content.
    ///
    /// # Errors
    /// The option that is refused, or the file with line and column; what would be accepted.
    pub fn new(files: &[(String, Vec<u8>)], options: &Options) -> Result<Self, Refusal> {
        let number = |name: &str, text: &str, parse: fn(&str) -> Result<f64, String>| match text.trim() {
            "" => Ok(None),
            text => parse(text).map(Some).map_err(|why| Refusal::option(name, text, &why)),
        };
        let noise = number("noise", &options.noise, numbers::noise)?;
        let cutoff_hz = number("cutoff", &options.cutoff, numbers::cutoff)?;
        let law = if options.law.is_empty() { How::default().law } else { options.law.parse()? };
        let maps: Vec<String> =
            options.map.lines().map(str::trim).filter(|map| !map.is_empty()).map(str::to_owned).collect();
        let joint = Some(options.joint.trim()).filter(|joint| !joint.is_empty());
        let recordings = read_bytes(files, &maps, joint)?;
        let options = diagnose::Options { declared_noise: noise, cutoff_hz, ..diagnose::Options::default() };
        diagnosed::check(&options, recordings.len())?;
        Ok(Self { recordings, how: How { law, cutoff_hz, ..How::default() }, options })
    }

    /// What reading did to the numbers, a line each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let of =
            |r: &Recording| r.remarks.iter().map(|text| format!("{}: {text}", r.name)).collect::<Vec<_>>();
        self.recordings.iter().flat_map(of).collect()
    }

    /// Number of samples in all recordings.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.recordings.iter().map(Recording::len).sum()
    }

    /// As `tribos identify`.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    pub fn identify(&self) -> Result<Answer, Refusal> {
        let fit = identify(&self.recordings, &self.how)?;
        let json = fit.found.to_json().map_err(|e| Refusal(e.to_string()))?;
        Ok(Answer { html: fit.report(), json: format!("{json}\n"), model: Some(fit.model.to_toml()) })
    }

    /// As `tribos diagnose`; `progress` is told the share that is done, 0 to 1, and what is being done.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    pub fn diagnose(&self, progress: &dyn Fn(f32, &str)) -> Result<Answer, Refusal> {
        let found = diagnose(&self.recordings, &[], &self.options, progress)
            .map_err(|e| Refusal::from(procedures::Error::from(e)))?;
        let name = self.recordings.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
        let json = serde_json::to_string_pretty(&found).map_err(|e| Refusal(e.to_string()))?;
        let model = found
            .model
            .clone()
            .map(|model| identify::Model { name: model_name(&self.recordings), ..model }.to_toml());
        Ok(Answer { html: report::diagnosis(&found, &name), json: format!("{json}\n"), model })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(options: &Options) -> String {
        let text = "t,x,F\n0,1,2\n1,2,3\n";
        let files = [("a.csv".to_owned(), text.as_bytes().to_vec())];
        Analysis::new(&files, options).expect_err("refused").to_string()
    }

    #[test]
    fn refusals_name_option_or_file_and_what_is_accepted() {
        let with = |change: &dyn Fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            refused(&options)
        };
        assert_eq!(
            with(&|o| o.cutoff = "-3".into()),
            "cutoff: `-3`: a frequency in Hz, above 0 and up to 1000000, is accepted"
        );
        assert!(with(&|o| o.noise = "loud".into()).starts_with("noise: `loud`: a standard deviation in N"));
        assert!(with(&|o| o.law = "stokes".into()).contains("accepted are karnopp, dahl"));
        assert_eq!(with(&|_| {}), "a.csv:1: no column time_s; the header has t, x, F");
        assert!(
            with(&|o| o.map = "time_s=t,position_m=y,force_n=F".into())
                .contains("no variable `y`; it has t, x, F")
        );
    }
}
