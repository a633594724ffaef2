//! One self-contained page.

use super::{Analysis, POOLED, Shown, psychometric_curves, quadrants};
use crate::failure::Result;
use perception::{Count, Counts, Resistance, Threshold};
use std::fmt::Write;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:84rem;margin:2rem auto;padding:0 1rem;color:#1b1b1b;background:#fff}
table{border-collapse:collapse;font-size:.9rem;margin:.5rem 0 1.5rem}td,th{padding:.15rem .8rem .15rem 0;text-align:right}
td:first-child,th:first-child{text-align:left}thead th{border-bottom:1px solid #888}svg{max-width:100%;height:auto;background:#fff}
.model{border:2px solid #d55e00;padding:.6rem 1rem;font-weight:600}.note{color:#555;font-size:.9rem}.scroll{overflow-x:auto}
@media(prefers-color-scheme:dark){body{color:#e6e6e6;background:#161616}.note{color:#aaa}}";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// What a threshold says, in words.
pub(crate) fn threshold_text(threshold: &Threshold) -> String {
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

/// The page.
///
/// # Errors
/// The drawing library's.
pub(crate) fn html(analysis: &Analysis) -> Result<String> {
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\"><title>Perception experiments</title><style>{STYLE}</style></head><body><h1>Perception experiments</h1>\n"
    );
    let n = analysis.subjects.len();
    if analysis.simulated {
        let _ = writeln!(
            out,
            "<p class=\"model\">Simulated subjects: a model made all of these data, no human did.</p>"
        );
        for model in &analysis.models {
            let _ = writeln!(out, "<p class=\"note\">{}</p>", escape(model));
        }
    }
    let (model, plural) = (if analysis.simulated { "simulated " } else { "" }, analysis.plural());
    let _ = writeln!(out, "<p>{n} {model}subject{plural}.</p>");
    for note in &analysis.notes {
        let _ = writeln!(out, "<p class=\"note\">{}</p>", escape(note));
    }
    if !analysis.counts.is_empty() {
        targeting(analysis, &mut out)?;
    }
    if !analysis.psychometric.is_empty() {
        forced_choice(analysis, &mut out)?;
    }
    out.push_str("</body></html>\n");
    Ok(out)
}

fn targeting(analysis: &Analysis, out: &mut String) -> Result<()> {
    out.push_str("<h2>Targeting task</h2>\n<p>Each subject against its own baseline. What the thesis reports, asked of these sessions, on the narrow targets (indices 1, 4, 7):</p><div class=\"scroll\"><table><thead><tr><th></th><th>mean change</th><th>95 %</th><th></th></tr></thead>\n");
    for c in &analysis.claims {
        let shown = match c.shown {
            Shown::Yes => "shown",
            Shown::Open => "not shown",
            Shown::Contradicted => "contradicted",
        };
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{:+.1} {}</td><td>{:+.1} to {:+.1}</td><td>{shown}</td></tr>",
            c.claim, c.mean, c.unit, c.ci95[0], c.ci95[1]
        );
    }
    out.push_str("</table></div>\n");
    let _ = writeln!(
        out,
        "{}<p class=\"note\">As figures 5-5 to 5-7: below zero is fewer or smaller errors, left of zero is faster. Magnitudes in mm of handle travel.</p>",
        quadrants(analysis)?
    );
    type Cell = fn(&Counts) -> Count;
    let m = &analysis.margins;
    let tables: [(String, Cell); 3] = [
        (format!("Completion time, by more than {} s (table 5-7)", m.time_s), |c| c.time),
        (format!("Errors, by {} or more (table 5-8)", m.errors), |c| c.errors),
        (format!("Error magnitude, by {} mm or more (table 5-9)", m.error_mm), |c| c.error_mm),
    ];
    let others = &Resistance::ALL[1..];
    for (title, of) in tables {
        let _ = write!(out, "<h3>{title}</h3><div class=\"scroll\"><table><thead><tr><th>index</th>");
        for r in others {
            let _ = write!(out, "<th>{}: better</th><th>worse</th>", r.name());
        }
        out.push_str("</tr></thead>\n");
        let mut indices: Vec<u32> = analysis.counts.iter().map(|c| c.index).collect();
        indices.dedup();
        for index in indices {
            let _ = write!(out, "<tr><td>{index}</td>");
            for r in others {
                match analysis.counts.iter().find(|c| c.index == index && c.resistance == *r) {
                    Some(c) => {
                        let Count { better, worse } = of(c);
                        let _ = write!(out, "<td>{better}</td><td>{worse}</td>");
                    }
                    None => out.push_str("<td>–</td><td>–</td>"),
                }
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</table></div>\n");
    }
    out.push_str("<h3>Throughput (ISO 9241-411), mean over subjects and indices</h3><table><thead><tr><th></th><th>bit/s</th><th>effective width, mm</th></tr></thead>\n");
    for r in Resistance::ALL {
        if let Some((bits, width)) = mean_throughput(analysis, r) {
            let _ = writeln!(out, "<tr><td>{}</td><td>{bits:.2}</td><td>{width:.2}</td></tr>", r.name());
        }
    }
    out.push_str("</table>\n");
    Ok(())
}

/// bit/s and effective width in mm.
pub(crate) fn mean_throughput(analysis: &Analysis, resistance: Resistance) -> Option<(f64, f64)> {
    let of: Vec<_> = analysis.throughput.iter().filter(|s| s.resistance == resistance).collect();
    let n = of.len() as f64;
    let mean = |value: &dyn Fn(&perception::Throughput) -> f64| {
        of.iter().map(|s| value(&s.throughput)).sum::<f64>() / n
    };
    (!of.is_empty()).then(|| (mean(&|t| t.bits_per_s), mean(&|t| t.effective_width_mm)))
}

fn forced_choice(analysis: &Analysis, out: &mut String) -> Result<()> {
    out.push_str("<h2>Forced choice</h2>\n<p>The just noticeable difference is where three of four answers are right.</p>\n");
    let _ = writeln!(out, "{}", psychometric_curves(analysis)?);
    out.push_str("<p class=\"note\">All subjects together. A pooled curve mixes subjects of different JND and counts every answer as independent: it is flatter than theirs, and its interval too narrow for people in general.</p>\n<div class=\"scroll\"><table><thead><tr><th>batch</th><th>subject</th><th>answers</th><th>JND, 95 %</th><th>slope</th><th>lapse</th></tr></thead>\n");
    for f in &analysis.psychometric {
        let answers: u32 = f.fit.levels.iter().map(|l| l.answers).sum();
        let subject = if f.subject == POOLED { "all together".to_owned() } else { escape(&f.subject) };
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{subject}</td><td>{answers}</td><td>{}</td><td>{:.1}</td><td>{:.3}</td></tr>",
            escape(&f.batch),
            threshold_text(&f.fit.threshold),
            f.fit.curve.slope,
            f.fit.curve.lapse
        );
    }
    out.push_str("</table></div>\n");
    Ok(())
}
