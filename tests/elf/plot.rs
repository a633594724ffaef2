//! Line charts as SVG: into the directory `PLOTS` names, else below the target directory.

use std::fmt::Write;
use std::path::{Path, PathBuf};

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 340.0;
/// Of the frame within a panel: left, right, top, bottom.
const MARGIN: [f64; 4] = [62.0, 12.0, 30.0, 44.0];

pub struct Series {
    pub name: &'static str,
    pub colour: &'static str,
    /// Points instead of a line.
    pub dots: bool,
    pub points: Vec<(f64, f64)>,
}

pub struct Panel {
    pub title: String,
    /// What is along the axes, with units.
    pub axes: [&'static str; 2],
    /// Both axes logarithmic.
    pub log: bool,
    pub series: Vec<Series>,
}

/// An axis: its ends, and where they are on the page.
struct Axis {
    from: f64,
    to: f64,
    start: f64,
    end: f64,
    log: bool,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, log: bool, [start, end]: [f64; 2]) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (from, to) = if log {
            (10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil()))
        } else {
            let room = 0.04 * (high - low).max(1e-12);
            (low - room, high + room)
        };
        Self { from, to, start, end, log }
    }

    fn at(&self, x: f64) -> f64 {
        let f = |x: f64| if self.log { x.log10() } else { x };
        self.start + (f(x) - f(self.from)) / (f(self.to) - f(self.from)) * (self.end - self.start)
    }

    fn ticks(&self) -> Vec<f64> {
        if self.log {
            let decades = (self.to / self.from).log10().round() as i32;
            return (0..=decades).map(|k| self.from * 10f64.powi(k)).collect();
        }
        let rough = (self.to - self.from) / 5.0;
        let decade = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= rough).unwrap_or(decade);
        let first = (self.from / step).ceil() as i64;
        (first..).map(|k| k as f64 * step).take_while(|x| *x <= self.to).collect()
    }
}

fn panel(out: &mut String, at: f64, panel: &Panel) {
    let [left, right, top, bottom] = MARGIN;
    let all = || panel.series.iter().flat_map(|s| &s.points);
    let x = Axis::new(all().map(|p| p.0), panel.log, [at + left, at + WIDTH - right]);
    // the legend is above what is drawn
    let room = 15.0 * panel.series.len() as f64 + 6.0;
    let y = Axis::new(all().map(|p| p.1), panel.log, [HEIGHT - bottom, top + room]);
    let number = |v: f64| {
        if v != 0.0 && v.abs() < 0.009 { format!("{v:.0e}") } else { format!("{}", (v * 1e9).round() / 1e9) }
    };
    for tick in x.ticks() {
        let (p, low, high) = (x.at(tick), y.start, top);
        let _ = writeln!(
            out,
            r#"<path class="g" d="M{p:.1} {low}V{high}"/><text x="{p:.1}" y="{:.1}" text-anchor="middle">{}</text>"#,
            low + 15.0,
            number(tick)
        );
    }
    for tick in y.ticks() {
        let (p, low, high) = (y.at(tick), x.start, x.end);
        let _ = writeln!(
            out,
            r#"<path class="g" d="M{low} {p:.1}H{high}"/><text x="{:.1}" y="{:.1}" text-anchor="end">{}</text>"#,
            low - 5.0,
            p + 4.0,
            number(tick)
        );
    }
    for s in &panel.series {
        let mut d = String::new();
        for (k, (px, py)) in s.points.iter().map(|p| (x.at(p.0), y.at(p.1))).enumerate() {
            let _ = match (s.dots, k) {
                (true, _) => write!(d, "M{px:.1} {py:.1}h0"),
                (false, 0) => write!(d, "M{px:.1} {py:.1}L"),
                (false, _) => write!(d, "{px:.1} {py:.1} "),
            };
        }
        let width = if s.dots { 3.0 } else { 1.4 };
        let _ = writeln!(
            out,
            r#"<path d="{d}" fill="none" stroke="{}" stroke-width="{width}" stroke-linecap="round"/>"#,
            s.colour
        );
    }
    for (k, s) in panel.series.iter().enumerate() {
        let line = top + 14.0 + 15.0 * k as f64;
        let _ = writeln!(
            out,
            r#"<path d="M{:.1} {:.1}h14" stroke="{}" stroke-width="3"/><text x="{:.1}" y="{line:.1}">{}</text>"#,
            x.start + 8.0,
            line - 4.0,
            s.colour,
            x.start + 27.0,
            s.name
        );
    }
    let (middle, centre) = (0.5 * (x.start + x.end), 0.5 * (y.start + top));
    let _ = writeln!(
        out,
        r#"<rect x="{}" y="{top}" width="{}" height="{}" fill="none" stroke="currentColor"/>
<text x="{middle}" y="18" text-anchor="middle" font-weight="bold">{}</text>
<text x="{middle}" y="{}" text-anchor="middle">{}</text>
<text transform="translate({} {centre}) rotate(-90)" text-anchor="middle">{}</text>"#,
        x.start,
        x.end - x.start,
        y.start - top,
        panel.title,
        HEIGHT - 8.0,
        panel.axes[0],
        at + 13.0,
        panel.axes[1]
    );
}

/// Writes panels side by side; where to.
pub fn write(name: &str, panels: &[Panel]) -> PathBuf {
    let directory = std::env::var_os("PLOTS").map_or_else(
        || PathBuf::from(env!("CARGO_TARGET_TMPDIR")),
        |plots| Path::new(env!("CARGO_MANIFEST_DIR")).join(plots),
    );
    let width = WIDTH * panels.len() as f64;
    // black on white, so that it reads on a dark page, too
    let mut out = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HEIGHT}" width="{width}" height="{HEIGHT}" font-family="sans-serif" font-size="11" color="black">
<style>.g{{stroke:#ddd;fill:none}}</style><rect width="100%" height="100%" fill="white"/>
"#
    );
    for (k, p) in panels.iter().enumerate() {
        panel(&mut out, WIDTH * k as f64, p);
    }
    out.push_str("</svg>\n");
    std::fs::create_dir_all(&directory).expect("a directory for the plots");
    let path = directory.join(format!("{name}.svg"));
    std::fs::write(&path, out).expect("room for a plot");
    path
}
