//! The report of a feed-forward of a device's own friction: what a hand felt before and after.

use crate::escape::escape;
use crate::page::Page;
use crate::picture::{BLUE, DrawError, GREY, Line, ORANGE, Panel, Picture, svg};

/// Largest number of points drawn of a recording.
const POINTS: usize = 1500;

/// Contents of the report.
#[derive(Debug, Clone, Default)]
pub struct Compensated {
    /// Device, as a user named it.
    pub name: String,
    /// The result in one sentence.
    pub headline: String,
    /// What is felt, before, after, unit.
    pub rows: Vec<[String; 4]>,
    /// Sentences about stability and what is left out.
    pub notes: Vec<String>,
    /// Units of velocity and of force.
    pub units: [String; 2],
    /// Velocity and push of the hand, before and after.
    pub felt: [Vec<(f64, f64)>; 2],
}

/// The report, as one HTML document that fetches nothing.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn compensation(found: &Compensated) -> Result<String, DrawError> {
    let mut page = Page::default();
    page.html(format!(
        r#"<header><p class="overline"><span class="chip no_mismatch">Compensated</span>device <b>{}</b></p><h1>{}</h1></header>"#,
        escape(&found.name),
        escape(&found.headline)
    ));
    let mut table = String::from("<table><tr><th>felt</th><th>before</th><th>after</th><th></th></tr>");
    for row in &found.rows {
        let cells: String = row.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
        table += &format!("<tr>{cells}</tr>");
    }
    page.html(table + "</table>");
    let [before, after] = &found.felt;
    let thinned = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().copied().step_by(points.len().div_ceil(POINTS).max(1)).collect()
    };
    let reach = before.iter().chain(after).fold(0.0_f64, |most, (v, _)| most.max(v.abs()));
    let panel = Panel {
        title: "push of the hand against velocity".to_owned(),
        axes: ["velocity of the handle", "push of the hand"],
        lines: vec![
            Line::new("nothing", GREY, vec![(-reach, 0.0), (reach, 0.0)]),
            Line::new("before", ORANGE, thinned(before)).dots(),
            Line::new("after", BLUE, thinned(after)).dots(),
        ],
        ..Panel::default()
    };
    let [velocity, force] = &found.units;
    let caption = format!("Velocity in {}, push in {}.", escape(velocity), escape(force));
    page.picture(&svg(&Picture::of(vec![panel]))?, &caption);
    page.heading("Stability");
    for note in &found.notes {
        page.html(format!("<p>{}</p>", escape(note)));
    }
    Ok(page.finish("Compensation", ""))
}
