//! Data of the charts. uPlot draws them (assets/report.js).

use crate::escape::escape;
use serde_json::{Value, json};
use std::fmt::Write;

/// Points of a reduced long series, enough for zooming in.
const MAX_POINTS: usize = 5000;

/// Colour of a series, a CSS variable of assets/report.css.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    Measured,
    Before,
    After,
    Band,
}

impl Ink {
    fn css(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Before => "before",
            Self::After => "after",
            Self::Band => "band",
        }
    }
}

/// Style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stroke {
    Line,
    Dashed,
    Points,
    Both,
    /// Edge of a band: only the area between two edges shows.
    Edge,
}

#[derive(Debug, Clone)]
struct Series {
    label: String,
    ink: Ink,
    stroke: Stroke,
    values: Vec<f64>,
}

/// A chart with its caption.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    title: String,
    caption: String,
    x_label: String,
    x: Vec<f64>,
    series: Vec<Series>,
    bands: Vec<[usize; 2]>,
    band_label: Option<String>,
    regions: Vec<[f64; 2]>,
    region_label: Option<String>,
    height: u32,
    sync: Option<&'static str>,
    /// The axis of x is logarithmic.
    log: bool,
}

impl Chart {
    /// An empty chart over `x`, which must ascend.
    pub(crate) fn new(title: impl Into<String>, x_label: impl Into<String>, x: Vec<f64>) -> Self {
        Self {
            title: title.into(),
            caption: String::new(),
            x_label: x_label.into(),
            x,
            series: Vec::new(),
            bands: Vec::new(),
            band_label: None,
            regions: Vec::new(),
            region_label: None,
            height: 300,
            sync: None,
            log: false,
        }
    }

    pub(crate) fn height(mut self, height: u32) -> Self {
        self.height = height;
        self
    }

    /// Charts with the same key share their cursor.
    pub(crate) fn sync(mut self, key: &'static str) -> Self {
        self.sync = Some(key);
        self
    }

    /// Uses a logarithmic x axis if all x are positive and at least half of them lie in its first quarter.
    pub(crate) fn log_where_crowded(mut self) -> Self {
        let x = &self.x;
        let [first, middle, last] =
            [x.first(), x.get(x.len() / 2), x.last()].map(|x| x.copied().unwrap_or(0.0));
        self.log = first > 0.0 && middle - first < 0.25 * (last - first);
        self
    }

    /// HTML below the chart.
    pub(crate) fn caption(mut self, html: impl Into<String>) -> Self {
        self.caption = html.into();
        self
    }

    pub(crate) fn series(mut self, label: &str, ink: Ink, stroke: Stroke, values: Vec<f64>) -> Self {
        if values.len() == self.x.len() && values.iter().any(|v| v.is_finite()) {
            self.series.push(Series { label: label.into(), ink, stroke, values });
        }
        self
    }

    /// A shaded band ±`half_width` about zero.
    pub(crate) fn band(self, label: &str, half_width: Vec<f64>) -> Self {
        let lower = half_width.iter().map(|v| -v).collect();
        self.band_between(label, half_width, lower)
    }

    /// A shaded band between two edges.
    pub(crate) fn band_between(mut self, label: &str, upper: Vec<f64>, lower: Vec<f64>) -> Self {
        let drawn = |edge: &[f64]| edge.len() == self.x.len() && edge.iter().any(|v| v.is_finite());
        if drawn(&upper) && drawn(&lower) {
            let first = self.series.len() + 1;
            self = self.series("", Ink::Band, Stroke::Edge, upper);
            self = self.series("", Ink::Band, Stroke::Edge, lower);
            self.bands.push([first, first + 1]);
            self.band_label = Some(label.into());
        }
        self
    }

    /// Marks stretches of x.
    pub(crate) fn regions(mut self, label: &str, regions: Vec<[f64; 2]>) -> Self {
        if !regions.is_empty() {
            self.regions = regions;
            self.region_label = Some(label.into());
        }
        self
    }

    /// Whether there is nothing to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.x.len() < 2 || self.series.is_empty()
    }

    /// The figure element; `id` ties it to its data.
    pub(crate) fn figure(&self, id: &str) -> String {
        let mut keys = String::new();
        let key = |class: &str, colour: &str, label: &str| {
            format!(r#"<span class="key {class}" style="--c:var(--{colour})">{}</span>"#, escape(label))
        };
        for s in self.series.iter().filter(|s| s.stroke != Stroke::Edge && !s.label.is_empty()) {
            let class = if s.stroke == Stroke::Points { "points" } else { "line" };
            keys.push_str(&key(class, s.ink.css(), &s.label));
        }
        if let Some(label) = &self.band_label {
            keys.push_str(&key("area", "band", label));
        }
        if let Some(label) = &self.region_label {
            keys.push_str(&key("area", "where", label));
        }
        let mut out = format!(
            r#"<figure><div class="figtitle"><b>{}</b>{keys}</div><div class="chart" id="{id}" role="img" aria-label="{}"></div>"#,
            escape(&self.title),
            escape(&self.title)
        );
        if !self.caption.is_empty() {
            let _ = write!(out, "<figcaption>{}</figcaption>", self.caption);
        }
        out.push_str("</figure>\n");
        out
    }

    /// Data for assets/report.js.
    pub(crate) fn spec(&self, id: &str) -> Value {
        let sparse = self.series.iter().any(|s| s.values.iter().any(|v| !v.is_finite()));
        let (x, columns) = if self.x.len() <= MAX_POINTS {
            (self.x.clone(), self.series.iter().map(|s| s.values.clone()).collect())
        } else {
            decimate(&self.x, &self.series.iter().map(|s| &s.values[..]).collect::<Vec<_>>(), MAX_POINTS)
        };
        let mut data = vec![Value::Array(x.iter().map(|&v| short(v, 7)).collect())];
        data.extend(columns.iter().map(|c| Value::Array(c.iter().map(|&v| short(v, 5)).collect())));
        let series: Vec<Value> = self
            .series
            .iter()
            .map(|s| {
                let (kind, width) = match s.stroke {
                    Stroke::Line | Stroke::Dashed => ("line", 1.6),
                    Stroke::Points => ("points", 3.0),
                    Stroke::Both => ("both", 2.2),
                    Stroke::Edge => ("edge", 0.0),
                };
                // gaps between recordings remain; holes from points on another grid are bridged
                json!({ "label": s.label, "color": s.ink.css(), "kind": kind, "width": width,
                        "dash": s.stroke == Stroke::Dashed, "span_gaps": sparse && self.sync.is_none() })
            })
            .collect();
        json!({ "id": id, "x": self.x_label, "height": self.height, "series": series, "bands": self.bands,
                "regions": self.regions, "sync": self.sync, "log": self.log, "data": data })
    }
}

/// A number with `digits` significant digits; null if not finite.
fn short(value: f64, digits: usize) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    json!(rounded)
}

/// Min-max decimation: two points per bucket, each series at its extremes in order of occurrence, so that no peak is lost. All
/// series share the two abscissae of a bucket.
fn decimate(x: &[f64], columns: &[&[f64]], points: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let buckets = (points / 2).max(1);
    let mut times = Vec::with_capacity(points);
    let mut out = vec![Vec::with_capacity(points); columns.len()];
    for bucket in 0..buckets {
        let (from, to) = (bucket * x.len() / buckets, (bucket + 1) * x.len() / buckets);
        let Some(slot) = x.get(from..to).filter(|s| !s.is_empty()) else { continue };
        times.push(slot[0]);
        let middle = slot[slot.len() / 2];
        let split = middle > slot[0];
        if split {
            times.push(middle);
        }
        for (column, out) in columns.iter().zip(&mut out) {
            let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
            let mut hole = false;
            for (i, &v) in column[from..to].iter().enumerate() {
                hole |= !v.is_finite();
                if v < low.0 {
                    low = (v, i);
                }
                if v > high.0 {
                    high = (v, i);
                }
            }
            let (first, second) = if low.1 <= high.1 { (low.0, high.0) } else { (high.0, low.0) };
            out.push(if hole { f64::NAN } else { first });
            if split {
                out.push(if hole { f64::NAN } else { second });
            }
        }
    }
    (times, out)
}

/// Time axis through several recordings end to end, and the last sample of each. Each recording keeps its rate; half a second
/// separates two.
pub(crate) fn laid_end_to_end(time: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let mut out = Vec::with_capacity(time.len());
    let mut starts = Vec::new();
    let mut shift = 0.0;
    for (i, &t) in time.iter().enumerate() {
        let previous = if i == 0 { f64::NEG_INFINITY } else { out[i - 1] };
        let mut at = t + shift;
        if !at.is_finite() {
            at = if previous.is_finite() { previous + 1e-6 } else { 0.0 };
        }
        if at <= previous {
            shift += previous - at + 0.5;
            at = previous + 0.5;
            starts.push(i);
        }
        out.push(at);
    }
    (out, starts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimation_keeps_every_peak() {
        let n = 100_000;
        let x: Vec<f64> = (0..n).map(|i| i as f64 * 1e-3).collect();
        let mut y: Vec<f64> = x.iter().map(|t| t.sin()).collect();
        y[54_321] = 9.0;
        y[54_322] = -7.0;
        let (t, c) = decimate(&x, &[&y], MAX_POINTS);
        assert_eq!(t.len(), c[0].len());
        assert!(t.len() <= MAX_POINTS && t.windows(2).all(|w| w[0] < w[1]));
        assert!(c[0].contains(&9.0) && c[0].contains(&-7.0));
    }

    #[test]
    fn what_happened_beside_a_reversal_was_one_vertical_line() {
        let log = |x: Vec<f64>| Chart::new("", "", x).log_where_crowded().spec("f1")["log"].as_bool();
        let distance: Vec<f64> = (0..24).map(|i| 1e-4 * 1.3_f64.powi(i)).collect();
        let time: Vec<f64> = (1..24).map(f64::from).collect();
        let both_ways = distance.iter().rev().map(|x| -x).chain(distance.clone()).collect();
        assert_eq!([distance, time, both_ways, Vec::new()].map(log), [true, false, false, false].map(Some));
    }

    #[test]
    fn several_recordings_are_laid_end_to_end() {
        let (t, starts) = laid_end_to_end(&[0.0, 1.0, 2.0, 0.0, 1.0, 0.5]);
        assert_eq!(starts, [3, 5]);
        assert_eq!(t, [0.0, 1.0, 2.0, 2.5, 3.5, 4.0]);
        let (t, _) = laid_end_to_end(&[f64::NAN, 0.0, f64::INFINITY, 1.0]);
        assert!(t.iter().all(|t| t.is_finite()) && t.windows(2).all(|w| w[0] < w[1]));
    }
}
