//! One self-contained page: style, script and data inlined, nothing fetched.

use super::chart::Chart;
use super::text::escape;
use serde_json::Value;

const STYLE: &str = include_str!("../../assets/report.css");
const DRAW: &str = include_str!("../../assets/report.js");
const UPLOT: &str = include_str!("../../assets/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../assets/uPlot.min.css");
const UPLOT_LICENSE: &str = include_str!("../../assets/uPlot.LICENSE");

/// A page being written from top to bottom.
#[derive(Debug, Default)]
pub(super) struct Page {
    body: String,
    figures: Vec<Value>,
}

impl Page {
    /// Appends HTML.
    pub(super) fn html(&mut self, html: impl AsRef<str>) -> &mut Self {
        self.body.push_str(html.as_ref());
        self.body.push('\n');
        self
    }

    /// Appends a section heading.
    pub(super) fn heading(&mut self, text: &str) -> &mut Self {
        self.html(format!("<h2>{}</h2>", escape(text)))
    }

    /// Appends a chart, or nothing if it has nothing to show.
    pub(super) fn chart(&mut self, chart: &Chart) -> &mut Self {
        if !chart.is_empty() {
            let id = format!("f{}", self.figures.len());
            self.figures.push(chart.spec(&id));
            self.body.push_str(&chart.figure(&id));
        }
        self
    }

    /// The whole document.
    pub(super) fn finish(self, title: &str) -> String {
        let Self { body, figures } = self;
        // A `<` inside JSON could close the script element; as an escape it cannot.
        let data = Value::Array(figures).to_string().replace('<', "\\u003c");
        let title = escape(title);
        format!(
            r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{UPLOT_STYLE}
{STYLE}</style>
</head>
<body>
<main>
{body}
<noscript><p class="fault">The charts are drawn by a script inside this file; it is switched off here.</p></noscript>
</main>
<script>
/* uPlot, inlined:
{UPLOT_LICENSE}*/
{UPLOT}</script>
<script type="application/json" id="figures">{data}</script>
<script>
{DRAW}</script>
</body>
</html>
"#
        )
    }
}
