//! The report of perception experiments.

use crate::escape::escape;
use crate::page::Page;
use crate::picture::DrawError;
use crate::sessions_pictures::{psychometric_curves, quadrants};
use perception::study::{Analysis, POOLED, Shown, mean_throughput, surfaces};
use perception::{Count, Counts, Resistance, Threshold};
use std::fmt::Write;

/// A threshold in words.
#[must_use]
pub fn threshold(threshold: &Threshold) -> String {
    match threshold {
        Threshold::Estimated { jnd, ci95 } => format!("{jnd:.2} N ({:.2} to {:.2})", ci95.0, ci95.1),
        Threshold::AboveLevels { at_least, largest } => format!(
            "cannot be estimated from these levels: it may lie above the largest, {largest:.2} N; above {at_least:.2} N with 95 %"
        ),
        Threshold::BelowLevels { at_most, smallest } => format!(
            "cannot be estimated from these levels: it may lie below the smallest, {smallest:.2} N; below {at_most:.2} N with 95 %"
        ),
        Threshold::TooFew => "cannot be estimated from so few answers".into(),
    }
}

/// The report of an analysis of sessions, as one HTML document.
///
/// # Errors
/// Errors of the drawing library.
pub fn sessions(analysis: &Analysis) -> Result<String, DrawError> {
    let mut page = Page::wide();
    let n = analysis.subjects.len();
    let (model, plural) = (if analysis.simulated { "simulated " } else { "" }, analysis.plural());
    page.html(format!(
        r#"<header><p class="overline">{n} {model}subject{plural}</p><h1>Perception experiments</h1></header>"#
    ));
    if analysis.simulated {
        page.html(
            r#"<p class="model">Simulated subjects: a model made all of these data, no human did.</p>"#,
        );
    }
    for note in analysis.models.iter().chain(&analysis.notes) {
        page.html(format!(r#"<p class="soft">{}</p>"#, escape(note)));
    }
    if !analysis.counts.is_empty() {
        targeting(analysis, &mut page)?;
    }
    if !analysis.rings.is_empty() {
        page.heading("Targeting in the plane");
        page.html("<p>Mean over subjects and circles (ISO 9241-411).</p>");
        let rows = surfaces(analysis).into_iter().map(|(surface, bits, width)| {
            vec![surface.to_owned(), format!("{bits:.2}"), format!("{width:.2}")]
        });
        page.html(table(&["surface", "bit/s", "effective width, mm"], rows));
    }
    if !analysis.psychometric.is_empty() {
        forced_choice(analysis, &mut page)?;
    }
    Ok(page.finish("Perception experiments", &format!("schema {}", analysis.schema)))
}

/// A table that may exceed the page width. All columns except the first are numbers.
fn table(heads: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut out = String::from(r#"<div class="scroll"><table><tr>"#);
    let class = |k: usize| if k == 0 { "" } else { r#" class="n""# };
    for (k, head) in heads.iter().enumerate() {
        let _ = write!(out, "<th{}>{}</th>", class(k), escape(head));
    }
    for row in rows {
        out.push_str("</tr>\n<tr>");
        for (k, cell) in row.iter().enumerate() {
            let _ = write!(out, "<td{}>{}</td>", class(k), escape(cell));
        }
    }
    out.push_str("</tr></table></div>");
    out
}

fn targeting(analysis: &Analysis, page: &mut Page) -> Result<(), DrawError> {
    page.heading("Targeting task");
    page.html(
        "<p>Each subject against its own baseline. What the thesis reports, asked of these sessions, on the narrow targets (indices 1, 4, 7):</p>",
    );
    let claims = analysis.claims.iter().map(|c| {
        let shown = match c.shown {
            Shown::Yes => "shown",
            Shown::Open => "not shown",
            Shown::Contradicted => "contradicted",
        };
        let (mean, [low, high]) = (c.mean, c.ci95);
        vec![
            c.claim.to_owned(),
            format!("{mean:+.1} {}", c.unit),
            format!("{low:+.1} to {high:+.1}"),
            shown.to_owned(),
        ]
    });
    page.html(table(&["", "mean change", "95 %", ""], claims));
    page.picture(
        &quadrants(analysis)?,
        "As figures 5-5 to 5-7: below zero is fewer or smaller errors, left of zero is faster. Magnitudes in mm of handle travel.",
    );
    type Cell = fn(&Counts) -> Count;
    let m = &analysis.margins;
    let tables: [(String, Cell); 3] = [
        (format!("Completion time, by more than {} s (table 5-7)", m.time_s), |c| c.time),
        (format!("Errors, by {} or more (table 5-8)", m.errors), |c| c.errors),
        (format!("Error magnitude, by {} mm or more (table 5-9)", m.error_mm), |c| c.error_mm),
    ];
    let others = &Resistance::ALL[1..];
    let mut heads = vec!["index".to_owned()];
    heads.extend(others.iter().flat_map(|r| [format!("{}: better", r.name()), "worse".to_owned()]));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut indices: Vec<u32> = analysis.counts.iter().map(|c| c.index).collect();
    indices.dedup();
    for (title, of) in tables {
        page.html(format!("<h3>{}</h3>", escape(&title)));
        let rows = indices.iter().map(|index| {
            let mut row = vec![index.to_string()];
            for r in others {
                match analysis.counts.iter().find(|c| c.index == *index && c.resistance == *r) {
                    Some(c) => {
                        let Count { better, worse } = of(c);
                        row.extend([better.to_string(), worse.to_string()]);
                    }
                    None => row.extend(["–".to_owned(), "–".to_owned()]),
                }
            }
            row
        });
        page.html(table(&heads, rows));
    }
    page.html("<h3>Throughput (ISO 9241-411), mean over subjects and indices</h3>");
    let rows = Resistance::ALL.into_iter().filter_map(|r| {
        let (bits, width) = mean_throughput(analysis, r)?;
        Some(vec![r.name().to_owned(), format!("{bits:.2}"), format!("{width:.2}")])
    });
    page.html(table(&["", "bit/s", "effective width, mm"], rows));
    Ok(())
}

fn forced_choice(analysis: &Analysis, page: &mut Page) -> Result<(), DrawError> {
    page.heading("Forced choice");
    page.html("<p>The just noticeable difference is where three of four answers are right.</p>");
    page.picture(
        &psychometric_curves(analysis)?,
        "All subjects together. A pooled curve mixes subjects of different JND and counts every answer as independent: it is flatter than theirs, and its interval too narrow for people in general.",
    );
    let rows = analysis.psychometric.iter().map(|f| {
        let answers: u32 = f.fit.levels.iter().map(|l| l.answers).sum();
        let subject = if f.subject == POOLED { "all together" } else { &f.subject };
        vec![
            f.batch.clone(),
            subject.to_owned(),
            answers.to_string(),
            threshold(&f.fit.threshold),
            format!("{:.1}", f.fit.curve.slope),
            format!("{:.3}", f.fit.curve.lapse),
        ]
    });
    page.html(table(&["batch", "subject", "answers", "JND, 95 %", "slope", "lapse"], rows));
    Ok(())
}
