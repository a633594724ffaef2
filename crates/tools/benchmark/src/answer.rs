//! What a benchmark found: the JSON and the text for the terminal.

use crate::rivals::Rival;
use crate::structure::{Found, Gain};
use report::Table;
use report::number::{number, with_std};
use serde::Serialize;
use std::fmt::Write;

/// Name and version of the JSON.
pub const SCHEMA: &str = "tribos.benchmark/1";

/// Result of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// `emps` or `silverbox`.
    pub benchmark: &'static str,
    /// Files that were read.
    pub files: Vec<String>,
    /// The protocol, one line each.
    pub protocol: Vec<String>,
    /// What stands for what in the units.
    pub units: &'static str,
    /// The model.
    pub parameters: Vec<Parameter>,
    /// Error of the free runs that were fitted, and its unit.
    pub fitted: Figure,
    /// Whether the fit ended at a minimum.
    pub converged: bool,
    /// The tests, in the order of the rivals' figures.
    pub tests: Vec<Test>,
    /// Error of the force that the frozen model predicts from the motion.
    pub force: Vec<Force>,
    /// Other models, run here on the same tests.
    pub compared: Vec<Compared>,
    /// What each term gains within the training span.
    pub gains: Vec<Gain>,
    /// How `gains` were judged, and their unit.
    pub gains_are: String,
    /// Published figures.
    pub rivals: Vec<Rival>,
    /// What is missing, if the official test could not be run.
    pub missing: Option<String>,
}

/// A parameter of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// As in an identification or in the catalogue.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// Standard error.
    pub std: f64,
    /// SI.
    pub unit: String,
}

/// A number with its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// Error of the force that a frozen model predicts, N rms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Force {
    /// Model and data.
    pub name: String,
    /// Against the force as recorded, with all its noise.
    pub recorded: f64,
    /// Both behind the zero-phase low-pass of a fit.
    pub filtered: f64,
    /// Key of docs/references.md, or `run here`.
    pub source: &'static str,
}

/// A free run on data that was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Test {
    /// Name.
    pub name: &'static str,
    /// Root mean square error, in `unit`.
    pub error: f64,
    /// mV or mm.
    pub unit: &'static str,
    /// Samples that count.
    pub samples: usize,
    /// Of the official protocol.
    pub official: bool,
}

/// Another model on the same tests.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// What it is.
    pub method: &'static str,
    /// Errors in the order and unit of the tests.
    pub errors: Vec<f64>,
    /// Key of docs/references.md.
    pub source: &'static str,
}

/// The parameters of a model with their names.
pub(crate) fn parameters(found: &Found) -> Vec<Parameter> {
    let numbers = found.fitted.values.iter().zip(&found.fitted.std);
    found
        .places
        .iter()
        .zip(numbers)
        .map(|(place, (value, std))| Parameter {
            name: place.name(),
            value: *value,
            std: *std,
            unit: place.unit(),
        })
        .collect()
}

impl Answer {
    /// Text for the terminal, at most 100 columns wide.
    #[must_use]
    pub fn describe(&self) -> String {
        let mut out = String::new();
        for line in self.files.iter().chain(&self.protocol) {
            let _ = writeln!(out, "  {line}");
        }
        let count = self.parameters.len();
        let _ = writeln!(out, "\n  Model, {count} parameters ({})", self.units);
        let mut table = Table::new(&["parameter", ">value", ">± std", "unit"]);
        for p in &self.parameters {
            let (value, std) = with_std(p.value, p.std);
            table.row([p.name.clone(), value, std, p.unit.clone()]);
        }
        out.push_str(&table.render());
        let Figure { name, value, unit } = &self.fitted;
        let _ = writeln!(out, "  {name}: {} {unit} rms", number(*value, 3));
        if !self.converged {
            out.push_str("  The fit did not end at a minimum; the figures are those of the last step.\n");
        }
        self.describe_gains(&mut out);
        self.describe_tests(&mut out);
        out
    }

    fn describe_gains(&self, out: &mut String) {
        if self.gains.is_empty() {
            return;
        }
        let _ = writeln!(out, "\n  What each term gains: {}", self.gains_are);
        let mut table = Table::new(&["term", ">without", ">with", ">ratio"]);
        for g in &self.gains {
            let ratio = number(g.without / g.with, 3);
            table.row([g.term.clone(), number(g.without, 3), number(g.with, 3), ratio]);
        }
        out.push_str(&table.render());
    }

    fn describe_tests(&self, out: &mut String) {
        if let Some(missing) = &self.missing {
            let _ = writeln!(out, "\n  {missing}");
        }
        let official = self.missing.is_none();
        let unit = self.tests.first().map_or("", |t| t.unit);
        let _ = writeln!(out, "\n  Free run on data that was not fitted, position error rms, {unit}");
        let names: Vec<String> = self.tests.iter().map(|t| format!(">{}", t.name)).collect();
        let heads: Vec<&str> =
            std::iter::once("method").chain(names.iter().map(String::as_str)).chain(["source"]).collect();
        let mut table = Table::new(&heads);
        let here: Vec<f64> = self.tests.iter().map(|t| t.error).collect();
        table.row(cells(&format!("this model, {} parameters", self.parameters.len()), &here, "run here"));
        for c in &self.compared {
            table.row(cells(c.method, &c.errors, c.source));
        }
        let published = |table: &mut Table| {
            for r in &self.rivals {
                table.row(cells(r.method, r.errors, r.source));
            }
        };
        // figures of the official test do not stand beside those of another
        if official {
            published(&mut table);
        }
        out.push_str(&table.render());
        if !official {
            let _ = writeln!(out, "\n  Published on the official test, {unit}");
            let mut table = Table::new(&["method", ">error", "source"]);
            published(&mut table);
            out.push_str(&table.render());
        }
        if !self.force.is_empty() {
            out.push_str("\n  Frozen model, force error on data that was not fitted, N rms: as recorded, and behind the\n");
            out.push_str("  low-pass of a fit\n");
            let mut table = Table::new(&["model and data", ">recorded", ">filtered", "source"]);
            for f in &self.force {
                table.row(cells(&f.name, &[f.recorded, f.filtered], f.source));
            }
            out.push_str(&table.render());
        }
    }
}

fn cells(method: &str, errors: &[f64], source: &str) -> Vec<String> {
    let numbers = errors.iter().map(|e| number(*e, 3));
    std::iter::once(method.to_owned()).chain(numbers).chain([source.to_owned()]).collect()
}
