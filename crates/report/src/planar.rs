//! The report of an identification in the plane: the direction of friction against that of the motion, and the level by
//! direction.

use crate::chart::{Chart, Ink, Stroke};
use crate::fragments::{Undetermined, every, identified, identified_parameters, method};
use crate::number::html as number;
use crate::page::Page;
use crate::picture::{self, BLUE, GREY, Line, ORANGE, Panel, Picture};
use diagnose::Quantity;
use std::collections::BTreeMap;

/// Most points of a picture; beyond, every n-th is drawn.
const MOST: usize = 3000;

/// Contents of the report of an identification in the plane.
#[derive(Debug, Clone, Default)]
pub struct PlanarIdentified {
    /// Names of the recordings.
    pub name: String,
    /// Number of fitted samples.
    pub samples: usize,
    /// ‖e‖/‖F‖ over both axes.
    pub relative_error: f64,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Quantity>,
    /// Parameters that the recording does not determine.
    pub undetermined: Vec<Undetermined>,
    /// Faults of the recording.
    pub faults: Vec<signals::RecordingFault>,
    /// Estimator and preprocessing in words.
    pub how: Vec<String>,
    /// Velocity of samples at which the body slides, m/s.
    pub motion: Vec<[f64; 2]>,
    /// Force less inertia, viscous friction and offset, N.
    pub friction: Vec<[f64; 2]>,
    /// The same of the model.
    pub fitted: Vec<[f64; 2]>,
}

/// The report, as one HTML document; with the properties of [`crate::diagnosis()`].
#[must_use]
pub fn planar_identification(found: &PlanarIdentified) -> String {
    let mut page = Page::default();
    let left = 100.0 * found.relative_error;
    let sentence =
        format!("{} explains all but {left:.2}&nbsp;% of the force (rms) of both axes.", headline(found));
    identified(&mut page, &found.name, &sentence, &found.faults);
    page.heading("Level of friction by direction");
    if let Ok(svg) = picture::svg(&polar(found)) {
        page.html(format!(r#"<figure>{svg}<figcaption>Each point is the friction of one sample: the force with inertia, viscous friction and offset taken off. The line is the ellipse that was fitted.</figcaption></figure>"#));
    }
    page.heading("Direction of friction against direction of motion");
    page.chart(&directions(found));
    identified_parameters(&mut page, &found.parameters, &found.undetermined);
    method(&mut page, &found.how);
    page.finish(&format!("tribos identification of {}", found.name), "")
}

fn headline(found: &PlanarIdentified) -> String {
    let get = |name: &str| found.parameters.get(name).map(|q| q.value);
    match (get("level_along"), get("level_across"), get("angle")) {
        (Some(along), Some(across), Some(angle)) => format!(
            "A level of {}&nbsp;N along a grain at {:.0}° and {}&nbsp;N across it",
            number(along, 3),
            angle.to_degrees(),
            number(across, 3)
        ),
        _ => format!("One level of {}&nbsp;N in every direction", number(get("level").unwrap_or(0.0), 3)),
    }
}

/// Friction in the plane of forces.
fn polar(found: &PlanarIdentified) -> Picture {
    let every = every(found.friction.len(), MOST);
    let pairs = |all: &[[f64; 2]]| all.iter().step_by(every).map(|f| (f[0], f[1])).collect::<Vec<_>>();
    let mut ring: Vec<(f64, f64)> = pairs(&found.fitted);
    ring.sort_by(|a, b| a.1.atan2(a.0).total_cmp(&b.1.atan2(b.0)));
    ring.extend(ring.first().copied());
    let most = found.friction.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs())).max(1e-9);
    let cross = |x: bool| {
        let ends = [-most, most].map(|at| if x { (at, 0.0) } else { (0.0, at) });
        Line::new("", GREY, ends.to_vec())
    };
    let measured = Line::new("measured", ORANGE, pairs(&found.friction)).dots();
    let panel = Panel {
        title: "friction".into(),
        axes: ["along x, N", "along y, N"],
        lines: vec![cross(true), cross(false), measured, Line::new("fitted", BLUE, ring)],
        ..Panel::default()
    };
    Picture::of(vec![panel])
}

/// How far friction points beside the motion.
fn directions(found: &PlanarIdentified) -> Chart {
    let every = every(found.motion.len(), MOST);
    let angle = |v: &[f64; 2]| v[1].atan2(v[0]).to_degrees();
    let beside = |f: &[f64; 2], v: &[f64; 2]| {
        let by = angle(f) - angle(v);
        by - 360.0 * (by / 360.0).round()
    };
    let mut points: Vec<(f64, f64, f64)> = (0..found.motion.len())
        .step_by(every)
        .map(|i| {
            let v = &found.motion[i];
            (angle(v), beside(&found.friction[i], v), beside(&found.fitted[i], v))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let column = |of: fn(&(f64, f64, f64)) -> f64| points.iter().map(of).collect::<Vec<_>>();
    Chart::new("friction beside the motion, °", "direction of motion, °", column(|p| p.0))
        .height(320)
        .series("measured", Ink::Measured, Stroke::Points, column(|p| p.1))
        .series("fitted", Ink::After, Stroke::Line, column(|p| p.2))
        .caption("Zero where friction points straight against the motion, as on a surface without grain.")
}
