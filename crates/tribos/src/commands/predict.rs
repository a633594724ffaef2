//! `tribos predict --model model.toml REC --out pred.csv`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, reading};
use identify::{Model, Predicted};
use report::number::number;
use signals::{Geometry, LowPass, Recording, noise_std};
use std::fmt::Write;
use std::path::PathBuf;

/// Options of `predict`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Model written by `identify --out` or `diagnose --out`
    #[arg(long, value_name = "model.toml")]
    model: PathBuf,
    /// Recording: CSV, .mat (v5) or .json; signals named with their units, or by --map
    #[arg(value_name = "REC")]
    recording: PathBuf,
    /// Prediction to write, CSV: time_s, force_n (torque_nm) and its standard deviation force_std_n (torque_std_nm) at every
    /// sample
    #[arg(long, value_name = "pred.csv")]
    out: PathBuf,
    /// The encoder is absolute, or was homed: phases of periodic effects hold on another recording, too
    #[arg(long)]
    absolute: bool,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    files::check_writable(&args.out)?;
    let mut model = Model::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = reading::read(&args.recording, &args.mapping)?;
    if !args.absolute && model.name != super::identify::model_name(std::slice::from_ref(&recording)) {
        let left_out = model.without_phases();
        if !left_out.is_empty() {
            eprintln!(
                "{}: {} left out: a phase along the stroke holds only while the zero of the position does; keep it with \
                 --absolute",
                args.recording.display(),
                left_out.join(", ")
            );
        }
    }
    let Predicted { force: predicted, std, is_sliding } =
        model.predict_with_std(&recording).map_err(Failure::new)?;
    let rotary = recording.geometry == Geometry::Rotary;
    let (name, std_name, unit) =
        if rotary { ("torque_nm", "torque_std_nm", "N·m") } else { ("force_n", "force_std_n", "N") };
    let mut text = format!("# predicted_by: tribos {}\n# model: {}\n", env!("CARGO_PKG_VERSION"), model.name);
    let _ = writeln!(text, "time_s,{name},{std_name}");
    for ((t, p), s) in recording.time.iter().zip(&predicted).zip(&std) {
        let _ = writeln!(text, "{t},{p},{s}");
    }
    files::write(&args.out, text.as_bytes())?;
    let unknown = predicted.iter().filter(|p| p.is_nan()).count();
    if unknown > 0 {
        eprintln!(
            "{}: {unknown} of {} samples are predicted as NaN: they lie in or between gaps of more than four samples, \
             and their velocity is not known",
            args.recording.display(),
            predicted.len()
        );
    }
    if args.out.as_os_str() != "-" {
        let file = args.out.display();
        print!("{}", Errors::of(&recording, &predicted, &is_sliding, model.cutoff_hz).words(&file.to_string(), unit));
    }
    Ok(Outcome::Done)
}

/// Errors of a prediction where a force is recorded.
struct Errors {
    samples: usize,
    /// Samples with a force and a prediction, and how many of them slide.
    compared: usize,
    sliding: usize,
    /// Root mean square over all of them: of the error, of the force.
    all: (f64, f64),
    /// The same over those that slide.
    determined: (f64, f64),
    /// The same behind the filter, and its cut-off, Hz.
    filtered: Option<(f64, f64, f64)>,
    /// Standard deviation of the recorded force's noise.
    noise: f64,
}

impl Errors {
    fn of(recording: &Recording, predicted: &[f64], is_sliding: &[bool], cutoff: Option<f64>) -> Self {
        let pairs: Vec<(f64, f64, bool)> = recording
            .force
            .iter()
            .zip(predicted)
            .zip(is_sliding)
            .filter(|((f, p), _)| f.is_finite() && p.is_finite())
            .map(|((f, p), s)| (f - p, *f, *s))
            .collect();
        let rms = |wanted: &dyn Fn(&(f64, f64, bool)) -> bool| -> (f64, f64) {
            let (mut error, mut force, mut count) = (0.0, 0.0, 0.0);
            for (e, f, _) in pairs.iter().filter(|p| wanted(p)) {
                (error, force, count) = (error + e * e, force + f * f, count + 1.0);
            }
            (f64::sqrt(error / f64::max(count, 1.0)), f64::sqrt(force / f64::max(count, 1.0)))
        };
        let filtered = cutoff.zip(recording.sample_period()).map(|(cutoff, dt)| {
            // what is not determined is taken out in front of the filter, as in the diagnosis
            let kept = |of: &dyn Fn(&(f64, f64, bool)) -> f64| -> Vec<f64> {
                pairs.iter().map(|p| if p.2 { of(p) } else { 0.0 }).collect()
            };
            let low_pass = LowPass::new(cutoff, dt);
            let [error, force] = [low_pass.apply(&kept(&|p| p.0)), low_pass.apply(&kept(&|p| p.1))];
            let over = |series: &[f64]| {
                let inside = series.iter().zip(&pairs).filter(|(_, p)| p.2).map(|(x, _)| x * x);
                let (sum, count) = inside.fold((0.0, 0.0), |(s, n), x| (s + x, n + 1.0));
                f64::sqrt(sum / f64::max(count, 1.0))
            };
            (over(&error), over(&force), cutoff)
        });
        Self {
            samples: predicted.len(),
            compared: pairs.len(),
            sliding: pairs.iter().filter(|p| p.2).count(),
            all: rms(&|_| true),
            determined: rms(&|p| p.2),
            filtered,
            noise: noise_std(&recording.force),
        }
    }

    fn words(&self, file: &str, unit: &str) -> String {
        let of_force = |(error, force): (f64, f64)| {
            let share = if force > 0.0 { format!(", {:.2} % of the force", 100.0 * error / force) } else { String::new() };
            format!("{} {unit} rms{share}", number(error, 4))
        };
        let mut out = format!("{file}: {} samples\n", self.samples);
        if self.compared == 0 || self.all.1 <= 0.0 {
            return out;
        }
        let share = 100.0 * self.sliding as f64 / self.compared as f64;
        if self.sliding > 0 {
            let (what, at) = match self.filtered {
                Some((error, force, cutoff)) => ((error, force), format!(" behind {cutoff:.0} Hz")),
                None => (self.determined, String::new()),
            };
            let _ = writeln!(
                out,
                "  sliding, {share:.0} % of the samples, where the motion determines the force: residual{at} {}",
                of_force(what)
            );
            let _ = writeln!(
                out,
                "  the same unfiltered: {}, of which the noise of the recorded force is {} {unit}",
                of_force(self.determined),
                number(self.noise, 4)
            );
        }
        let _ = writeln!(
            out,
            "  all samples, unfiltered: {}{}",
            of_force(self.all),
            if share < 99.5 { "; at rest friction is whatever balances, see the column of the standard deviation" } else { "" }
        );
        out
    }
}
