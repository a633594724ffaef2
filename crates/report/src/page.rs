//! A self-contained page: inlined style, script and data, nothing fetched; light and dark, printable, readable on a phone.

use crate::chart::Chart;
use crate::escape::escape;
use serde_json::Value;

const STYLE: &str = include_str!("../assets/report.css");
const DRAW: &str = include_str!("../assets/report.js");
const UPLOT: &str = include_str!("../assets/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../assets/uPlot.min.css");
const UPLOT_LICENSE: &str = include_str!("../assets/uPlot.LICENSE");

/// A page being written from top to bottom.
#[derive(Debug, Default)]
pub struct Page {
    body: String,
    figures: Vec<Value>,
    wide: bool,
}

impl Page {
    /// A page for wide pictures.
    #[must_use]
    pub fn wide() -> Self {
        Self { wide: true, ..Self::default() }
    }

    /// Appends HTML.
    pub fn html(&mut self, html: impl AsRef<str>) -> &mut Self {
        self.body.push_str(html.as_ref());
        self.body.push('\n');
        self
    }

    /// Appends a section heading.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.html(format!("<h2>{}</h2>", escape(text)))
    }

    /// Appends a chart, unless it is empty.
    pub(crate) fn chart(&mut self, chart: &Chart) -> &mut Self {
        if !chart.is_empty() {
            let id = format!("f{}", self.figures.len());
            self.figures.push(chart.spec(&id));
            self.body.push_str(&chart.figure(&id));
        }
        self
    }

    /// Appends a picture with its caption, both as HTML.
    pub fn picture(&mut self, svg: &str, caption: &str) -> &mut Self {
        self.html(format!("<figure>{svg}<figcaption>{caption}</figcaption></figure>"))
    }

    /// The complete document, with `about` in the footer.
    #[must_use]
    pub fn finish(mut self, title: &str, about: &str) -> String {
        let title = escape(title);
        let inlined = if self.figures.is_empty() { "" } else { "; uPlot (MIT) is inlined" };
        let footer = format!(
            "<footer>tribos {} · {}this file needs no network{inlined}.</footer>",
            env!("CARGO_PKG_VERSION"),
            if about.is_empty() { String::new() } else { format!("{} · ", escape(about)) }
        );
        self.html(footer);
        let Self { body, figures, wide } = self;
        let main = if wide { r#"<main class="wide">"# } else { "<main>" };
        let (style, scripts) = if figures.is_empty() {
            (String::new(), "</main>\n".to_owned())
        } else {
            (format!("{UPLOT_STYLE}\n"), scripts(figures))
        };
        format!(
            r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{style}{STYLE}</style>
</head>
<body>
{main}
{body}
{scripts}</body>
</html>
"#
        )
    }
}

/// The scripts of a page with charts, as a content security policy hashes them.
#[must_use]
pub fn scripts_of_charts() -> [String; 2] {
    [format!("\n/* uPlot, inlined:\n{UPLOT_LICENSE}*/\n{UPLOT}"), format!("\n{DRAW}")]
}

/// End of `main`, and the scripts that draw these figures.
fn scripts(figures: Vec<Value>) -> String {
    // a `<` inside JSON could close the script element; an escape cannot
    let data = Value::Array(figures).to_string().replace('<', "\\u003c");
    let [uplot, draw] = scripts_of_charts();
    format!(
        r#"<noscript><p class="fault">The charts are drawn by a script inside this file; it is switched off here.</p></noscript>
</main>
<script>{uplot}</script>
<script type="application/json" id="figures">{data}</script>
<script>{draw}</script>
"#
    )
}

/// An id such as `distance_since_reversal` as words.
pub(crate) fn words(id: &str) -> String {
    escape(&id.replace('_', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_a_recording_says_becomes_markup() {
        let hostile = "<script>alert('x')</script> & \"quoted\"\u{0}";
        let safe = escape(hostile);
        assert!(!safe.contains(['<', '>', '"', '\'', '\u{0}']));
        assert_eq!(escape("a & b"), "a &amp; b");
    }
}
