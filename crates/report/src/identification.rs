//! The report of an identification: the force that is not inertia against velocity [thesis, fig. 3-5], with the
//! law that was fitted through it.

use crate::chart::{Chart, Ink, Stroke, laid_end_to_end};
use crate::escape::escape;
use crate::fragments::{Undetermined, every, identified, identified_parameters, method};
use crate::number::html as number;
use crate::page::Page;
use diagnose::Quantity;
use std::collections::BTreeMap;

/// Largest number of points of a scatter plot. Beyond, every n-th is drawn.
const MAX_SCATTER: usize = 4000;

/// Contents of the report of an identification. Series have equal lengths; units are N and m, or N·m and rad.
#[derive(Debug, Clone, Default)]
pub struct Identified {
    /// Name of the recording.
    pub name: String,
    /// Law id.
    pub law: String,
    /// Unit of the force.
    pub force_unit: String,
    /// Number of fitted samples.
    pub samples: usize,
    /// ‖e‖/‖F‖ over the fitted samples.
    pub relative_error: f64,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Quantity>,
    /// Parameters that the recording does not determine.
    pub undetermined: Vec<Undetermined>,
    /// Faults of the recording.
    pub faults: Vec<signals::RecordingFault>,
    /// Preprocessing and estimator in words, for "how computed".
    pub how: Vec<String>,
    /// Time, s.
    pub time: Vec<f64>,
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Measured force.
    pub force: Vec<f64>,
    /// Force of the fitted model.
    pub predicted: Vec<f64>,
    /// Force less mass times acceleration, the part of friction.
    pub friction: Vec<f64>,
}

/// The report of an identification, as one HTML document; with the properties of [`crate::diagnosis()`].
#[must_use]
pub fn identification(found: &Identified) -> String {
    let mut page = Page::default();
    let unit = escape(&found.force_unit);
    identified(&mut page, &found.name, &headline(found), &found.faults);
    page.heading("Friction against velocity");
    page.chart(&scatter(found));
    identified_parameters(&mut page, &found.parameters, &found.undetermined);
    page.heading("Measured against fitted");
    let (time, _) = laid_end_to_end(&found.time);
    let error = found.force.iter().zip(&found.predicted).map(|(f, p)| f - p).collect();
    page.chart(
        &Chart::new(format!("force, {}", found.force_unit), "time, s", time.clone())
            .height(260)
            .sync("time")
            .series("measured", Ink::Measured, Stroke::Line, found.force.clone())
            .series("fitted", Ink::After, Stroke::Dashed, found.predicted.clone()),
    );
    page.chart(
        &Chart::new(format!("measured − fitted, {}", found.force_unit), "time, s", time)
            .height(190)
            .sync("time")
            .series("residual", Ink::Before, Stroke::Line, error)
            .caption(format!("What this law leaves, {unit}. <code>tribos diagnose</code> says what it is.")),
    );
    method(&mut page, &found.how);
    page.finish(&format!("tribos identification of {}", found.name), "")
}

fn headline(found: &Identified) -> String {
    let mass = found.parameters.get("mass");
    let mass =
        mass.map_or(String::new(), |m| format!(" and a mass of {} {}", number(m.value, 3), escape(&m.unit)));
    let left = if found.relative_error.is_finite() {
        format!("all but {:.2}\u{a0}% of the force (rms).", 100.0 * found.relative_error)
    } else {
        "an unknown share of the force.".into()
    };
    format!("{} friction{mass} explain {left}", escape(&capitalised(&found.law)))
}

fn capitalised(law: &str) -> String {
    let mut letters = law.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Measured points and the fitted law in order of velocity.
fn scatter(found: &Identified) -> Chart {
    let inertia: Vec<f64> = found.force.iter().zip(&found.friction).map(|(f, r)| f - r).collect();
    let every = every(found.velocity.len(), MAX_SCATTER);
    let mut points: Vec<(f64, f64, f64)> = found
        .velocity
        .iter()
        .zip(&found.friction)
        .zip(found.predicted.iter().zip(&inertia))
        .step_by(every)
        .map(|((&v, &r), (&p, &i))| (v, r, p - i))
        .filter(|(v, r, _)| v.is_finite() && r.is_finite())
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let length = if found.force_unit == "N" { "m/s" } else { "rad/s" };
    let column = |f: fn(&(f64, f64, f64)) -> f64| points.iter().map(f).collect::<Vec<_>>();
    Chart::new(
        format!("force − mass · acceleration, {}", found.force_unit),
        format!("velocity, {length}"),
        column(|p| p.0),
    )
    .height(380)
    .series("measured", Ink::Measured, Stroke::Points, column(|p| p.1))
    .series("fitted law", Ink::After, Stroke::Line, column(|p| p.2))
    .caption("Each point is one sample with the inertia taken off; the line is the law that was fitted.")
}
