//! Fragments that several reports share.

use crate::escape::escape;
use crate::number::{html as number, html_with_std as with_std};
use crate::page::{Page, words};
use diagnose::Quantity;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A parameter that the recording does not determine.
#[derive(Debug, Clone, Default)]
pub struct Undetermined {
    /// Name.
    pub parameter: String,
    /// Reason.
    pub because: String,
    /// Move that would determine it.
    pub experiment: String,
}

/// Parameters with standard errors and 95 % intervals.
pub(crate) fn parameters(parameters: &BTreeMap<String, Quantity>) -> String {
    if parameters.is_empty() {
        return String::new();
    }
    let mut out = String::from(
        r#"<div class="scroll"><table><tr><th>parameter</th><th class="n">value</th><th class="n">std</th><th class="n">95 % interval</th><th>unit</th></tr>"#,
    );
    for (name, q) in parameters {
        let (value, std) = with_std(q.value, q.std);
        let interval = if q.std.is_finite() && q.value.is_finite() {
            let (low, high) = (q.value - 1.96 * q.std, q.value + 1.96 * q.std);
            format!("{} … {}", with_std(low, q.std).0, with_std(high, q.std).0)
        } else {
            "not determined".into()
        };
        let _ = write!(
            out,
            r#"<tr><td>{}</td><td class="n">{value}</td><td class="n">{std}</td><td class="n">{interval}</td><td>{}</td></tr>"#,
            words(name),
            escape(&q.unit)
        );
    }
    out.push_str("</table></div>");
    out
}

/// Faults of the recording: `(kind, time, why)`.
pub(crate) fn faults(faults: &[signals::RecordingFault]) -> String {
    let mut out = String::new();
    for fault in faults {
        let json = serde_json::to_value(fault).unwrap_or_default();
        let text = |key: &str| json.get(key).and_then(|v| v.as_str()).unwrap_or_default().to_owned();
        let at = json.get("at_s").and_then(serde_json::Value::as_f64);
        let at = at.map_or(String::new(), |t| format!(" at {} s", number(t, 5)));
        let _ = writeln!(
            out,
            r#"<div class="fault"><b>{}</b>{at}: {}</div>"#,
            words(&text("kind")),
            escape(&text("why"))
        );
    }
    out
}

/// An experiment as a command to paste: `move …` becomes the command that records it.
pub(crate) fn experiment(experiment: &str) -> String {
    let text = experiment.trim();
    if text.is_empty() {
        return String::new();
    }
    match text.find("move ") {
        Some(0) => {
            // up to the punctuation that ends the move; the rest explains it
            let rest = &text[5..];
            let end = rest.find([',', ';', ':', '(', '\n']).unwrap_or(rest.len());
            let (motion, more) = rest.split_at(end);
            let more = more.trim_start_matches([',', ';', ':', ' ']);
            let mut out =
                format!("<pre>tribos record PORT --move \"{}\" --out next.csv</pre>", escape(motion.trim()));
            if !more.is_empty() {
                let _ = write!(out, r#"<p class="soft">{}</p>"#, escape(more));
            }
            out
        }
        _ => format!("<p>{}</p>", escape(text)),
    }
}

/// The head of an identification: what was identified in one sentence, and the faults of the recording.
pub(crate) fn identified(page: &mut Page, name: &str, sentence: &str, found: &[signals::RecordingFault]) {
    page.html(format!(
        r#"<header><p class="overline"><span class="chip no_mismatch">Identified</span>recording <b>{}</b></p><h1>{sentence}</h1></header>"#,
        escape(name)
    ));
    page.html(faults(found));
}

/// Parameters that were identified, and those that the recording does not determine.
pub(crate) fn identified_parameters(
    page: &mut Page,
    found: &BTreeMap<String, Quantity>,
    undetermined: &[Undetermined],
) {
    page.heading("Parameters");
    page.html(parameters(found));
    for u in undetermined {
        page.html(format!(
            r#"<div class="fault"><b>{} is not identifiable</b> from this recording: {}</div>"#,
            words(&u.parameter),
            escape(&u.because)
        ));
        page.html(experiment(&u.experiment));
    }
}

/// How the figures were computed, one sentence a line.
pub(crate) fn method(page: &mut Page, how: &[String]) {
    page.heading("How this was computed");
    let mut list = String::from(r#"<ul class="plain">"#);
    for line in how {
        let _ = write!(list, "<li>{}</li>", escape(line));
    }
    list.push_str("</ul>");
    page.html(list);
}

/// Step from one drawn point to the next, where at most `most` of `count` are drawn.
pub(crate) fn every(count: usize, most: usize) -> usize {
    count.div_ceil(most).max(1)
}
