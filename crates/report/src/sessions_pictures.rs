//! The figures of [thesis, fig. 5-5 to 5-7 and 5-10 to 5-12] for given sessions.

use crate::picture::{BLUE, DrawError, GREEN, GREY, Line, ORANGE, PURPLE, Panel, Picture, svg};
use perception::study::{Analysis, Fitted, HARD, POOLED};
use perception::{Difference, Resistance, Threshold};

/// Error against time, each subject against its own baseline: number of errors above, their magnitude below, for the
/// three most difficult indices.
///
/// # Errors
/// Errors of the drawing library.
pub(crate) fn quadrants(analysis: &Analysis) -> Result<String, DrawError> {
    let panel = |index: u32, axis: &'static str, value: fn(&Difference) -> f64| {
        let of: Vec<&Difference> = analysis.differences.iter().filter(|d| d.index == index).collect();
        let most =
            |value: &dyn Fn(&Difference) -> f64| of.iter().map(|d| value(d).abs()).fold(0.1, f64::max) * 1.1;
        let (x, y) = (most(&|d| d.time_s), most(&value));
        let mut lines = vec![
            Line::new("", GREY, vec![(-x, 0.0), (x, 0.0)]),
            Line::new("", GREY, vec![(0.0, -y), (0.0, y)]),
        ];
        for (resistance, colour) in [
            (Resistance::Real, BLUE),
            (Resistance::Simulated, GREEN),
            (Resistance::HighStiction, ORANGE),
            (Resistance::Viscous, PURPLE),
        ] {
            let points =
                of.iter().filter(|d| d.resistance == resistance).map(|d| (d.time_s, value(d))).collect();
            lines.push(Line::new(resistance.name(), colour, points).marks());
        }
        Panel {
            title: format!("index {index}"),
            axes: ["time difference / s", axis],
            lines,
            y: Some(-y..y),
            ..Panel::default()
        }
    };
    let row = |axis, value: fn(&Difference) -> f64| HARD.map(|index| panel(index, axis, value));
    let above = row("difference in errors", |d| d.errors);
    let below = row("difference in error magnitude / mm", |d| d.error_mm);
    svg(&Picture::of(above.into_iter().chain(below).collect()))
}

/// Share of correct answers over the difference, for all subjects together, with the fitted curve.
///
/// # Errors
/// Errors of the drawing library.
pub(crate) fn psychometric_curves(analysis: &Analysis) -> Result<String, DrawError> {
    let panel = |fitted: &Fitted| {
        let fit = &fitted.fit;
        let largest = fit.levels.last().map_or(1.0, |l| l.difference_n);
        let curve =
            (0..=100).map(|k| largest * 1.1 * f64::from(k) / 100.0).map(|x| (x, fit.curve.p(x))).collect();
        let shares = fit
            .levels
            .iter()
            .map(|l| (l.difference_n, f64::from(l.correct) / f64::from(l.answers)))
            .collect();
        let end = 1.1 * largest;
        let mut lines = vec![
            Line::new("three of four", GREY, vec![(0.0, 0.75), (end, 0.75)]),
            Line::new("answers", ORANGE, shares).marks(),
            Line::new("fit", BLUE, curve),
        ];
        let title = match fit.threshold {
            Threshold::Estimated { jnd, .. } => {
                lines.push(Line::new("", GREEN, vec![(jnd, 0.4), (jnd, 0.75)]));
                format!("{}: JND {jnd:.2} N", fitted.batch)
            }
            _ => format!("{}: JND not reached", fitted.batch),
        };
        Panel {
            title,
            axes: ["difference / N", "share of right answers"],
            lines,
            y: Some(0.4..1.02),
            ..Panel::default()
        }
    };
    svg(&Picture::of(analysis.psychometric.iter().filter(|f| f.subject == POOLED).map(panel).collect()))
}
