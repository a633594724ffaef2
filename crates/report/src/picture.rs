//! Pictures as SVG: panels of lines, points and coloured cells, side by side.
//!
//! ```
//! use report::picture::{BLUE, Line, Panel, Picture, svg};
//! let line = Line::new("square", BLUE, (0..50).map(|k| (f64::from(k), f64::from(k * k))).collect());
//! let panel = Panel { title: "growth".into(), axes: ["x", "x²"], lines: vec![line], ..Panel::default() };
//! let drawn = svg(&Picture::of(vec![panel]))?;
//! assert!(drawn.starts_with("<svg") && drawn.contains("x²"));
//! # Ok::<(), report::picture::DrawError>(())
//! ```

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;
use std::ops::Range;

/// Red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

// colours for any colour vision (Okabe and Ito)
/// Blue.
pub const BLUE: Colour = Colour(0, 114, 178);
/// Orange.
pub const ORANGE: Colour = Colour(213, 94, 0);
/// Green.
pub const GREEN: Colour = Colour(0, 158, 115);
/// Purple.
pub const PURPLE: Colour = Colour(204, 121, 167);
/// Grey.
pub const GREY: Colour = Colour(120, 120, 120);
/// Black.
pub const BLACK: Colour = Colour(0, 0, 0);

impl From<Colour> for RGBColor {
    fn from(c: Colour) -> Self {
        Self(c.0, c.1, c.2)
    }
}

/// The drawing library failed.
#[derive(Debug, Clone, thiserror::Error)]
#[error("the picture cannot be drawn: {0}")]
pub struct DrawError(String);

/// Style of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A line of this width, pixels.
    Line(u32),
    /// Dots of this radius, pixels.
    Dots(u32),
    /// White discs with an edge, of this radius, pixels.
    Rings(u32),
}

/// A series of points.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name in the legend; none without.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// A line, or points.
    pub stroke: Stroke,
    /// x and y.
    pub points: Vec<(f64, f64)>,
}

impl Line {
    /// A thin line.
    pub fn new(name: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), colour, stroke: Stroke::Line(1), points }
    }

    /// The series with this stroke.
    #[must_use]
    pub fn stroke(self, stroke: Stroke) -> Self {
        Self { stroke, ..self }
    }

    /// A cloud of many points.
    #[must_use]
    pub fn dots(self) -> Self {
        self.stroke(Stroke::Dots(1))
    }

    /// A few large points.
    #[must_use]
    pub fn marks(self) -> Self {
        self.stroke(Stroke::Dots(4))
    }
}

/// A field over two coordinates, as coloured cells. Equal steps of a logarithmic axis are equal ratios.
#[derive(Debug, Clone)]
pub struct Field {
    /// Range along x.
    pub x: Range<f64>,
    /// Range along y.
    pub y: Range<f64>,
    /// Cells along x.
    pub columns: usize,
    /// Cells row by row from the bottom. Absent cells are white.
    pub cells: Vec<Option<Colour>>,
}

impl Field {
    /// A field coloured by its centre points' values; `at` gives the colour at x and y.
    pub fn new(
        x: Range<f64>,
        y: Range<f64>,
        [columns, rows]: [usize; 2],
        scale: Scale,
        at: impl Fn(f64, f64) -> Option<Colour>,
    ) -> Self {
        let centre = |range: &Range<f64>, k: usize, of: usize| scale.at(range, (k as f64 + 0.5) / of as f64);
        let cells = (0..columns * rows)
            .map(|k| at(centre(&x, k % columns, columns), centre(&y, k / columns, rows)))
            .collect();
        Self { x, y, columns, cells }
    }
}

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal ratios.
    Logarithmic,
}

impl Scale {
    /// The value at this share of the range.
    #[must_use]
    pub fn at(self, range: &Range<f64>, share: f64) -> f64 {
        match self {
            Self::Linear => range.start + share * (range.end - range.start),
            Self::Logarithmic => range.start * (range.end / range.start).powf(share),
        }
    }
}

/// One set of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// Labels of x and y with units.
    pub axes: [&'static str; 2],
    /// Scales of both axes.
    pub scale: Scale,
    /// Series, drawn in this order.
    pub lines: Vec<Line>,
    /// Cells below the series.
    pub field: Option<Field>,
    /// Range of the y axis, if not from the data.
    pub y: Option<Range<f64>>,
}

/// Legend entry of a picture.
#[derive(Debug, Clone)]
pub struct Key {
    /// Stroke; none is an area.
    pub stroke: Option<Stroke>,
    /// Colour.
    pub colour: Colour,
    /// Text of one or several lines.
    pub text: Vec<String>,
}

impl Key {
    /// Key of an area.
    pub fn area(colour: Colour, text: impl Into<String>) -> Self {
        Self { stroke: None, colour, text: vec![text.into()] }
    }
}

/// Panels with their legend.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Row by row.
    pub panels: Vec<Panel>,
    /// Panels per row.
    pub columns: usize,
    /// Width and height of a panel, pixels.
    pub size: (u32, u32),
    /// Keys to the right of a single row, or below several panels. Legends of lines are inside their panels.
    pub keys: Vec<Key>,
}

impl Picture {
    /// Panels of default size, three per row.
    #[must_use]
    pub fn of(panels: Vec<Panel>) -> Self {
        Self { panels, columns: 3, size: (430, 360), keys: Vec::new() }
    }
}

/// The picture as SVG.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(picture: &Picture) -> Result<String, DrawError> {
    let mut out = String::new();
    draw(picture, &mut out).map_err(|e| DrawError(e.to_string()))?;
    Ok(out)
}

type Drawn = Result<(), Box<dyn std::error::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Width of the keys beside a panel, and height of those below, pixels.
const BESIDE: u32 = 190;
const BELOW: u32 = 40;

fn draw(picture: &Picture, out: &mut String) -> Drawn {
    let columns = picture.panels.len().clamp(1, picture.columns.max(1));
    let rows = picture.panels.len().div_ceil(columns).max(1);
    let (width, height) = (picture.size.0 * columns as u32, picture.size.1 * rows as u32);
    let room = match (picture.keys.len(), picture.panels.len()) {
        (0, _) => (0, 0),
        (_, 1) => (BESIDE, 0),
        _ => (0, BELOW),
    };
    let page = SVGBackend::with_string(out, (width + room.0, height + room.1)).into_drawing_area();
    page.fill(&WHITE)?;
    let (panels, beside) = page.split_horizontally(width);
    let (panels, below) = panels.split_vertically(height);
    for (panel, area) in picture.panels.iter().zip(panels.split_evenly((rows, columns))) {
        one(panel, &area)?;
    }
    match room {
        (0, 0) => {}
        (_, 0) => {
            let mut y = 60;
            for key in &picture.keys {
                entry(key, &beside, (0, y))?;
                y += 6 + 16 * key.text.len() as i32;
            }
        }
        _ => {
            for (k, key) in picture.keys.iter().enumerate() {
                entry(key, &below, (70 + 210 * k as i32, 8))?;
            }
        }
    }
    page.present()?;
    Ok(())
}

/// One key with its text, at the upper left.
fn entry(key: &Key, area: &Area<'_>, (x, y): (i32, i32)) -> Drawn {
    let colour = RGBColor::from(key.colour);
    match key.stroke {
        None => area.draw(&Rectangle::new([(x, y), (x + 16, y + 12)], colour.filled()))?,
        Some(Stroke::Line(width)) => {
            area.draw(&PathElement::new([(x, y + 6), (x + 16, y + 6)], colour.stroke_width(width)))?;
        }
        Some(Stroke::Dots(radius)) => area.draw(&Circle::new((x + 8, y + 6), radius, colour.filled()))?,
        Some(Stroke::Rings(radius)) => {
            area.draw(&Circle::new((x + 8, y + 6), radius, colour.stroke_width(2)))?;
        }
    }
    let text = ("sans-serif", 13).into_font().color(&RGBColor::from(BLACK));
    for (k, line) in key.text.iter().enumerate() {
        area.draw(&Text::new(line.clone(), (x + 24, y + 16 * k as i32), text.clone()))?;
    }
    Ok(())
}

/// Range of an axis that shows all values.
fn ends(values: impl Iterator<Item = f64>, scale: Scale) -> Range<f64> {
    let logarithmic = scale == Scale::Logarithmic;
    let (low, high) = values
        .filter(|v| v.is_finite() && (!logarithmic || *v > 0.0))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if !(high >= low) {
        return if logarithmic { 1.0..10.0 } else { 0.0..1.0 };
    }
    if logarithmic {
        let decade = |x: f64| 10f64.powf(x);
        return decade(low.log10().floor())..decade((high.log10() + 1e-9).ceil());
    }
    let room = 0.05 * (high - low).max(1e-9 * high.abs()).max(1e-12);
    low - room..high + room
}

fn one(panel: &Panel, area: &Area<'_>) -> Drawn {
    let points = || panel.lines.iter().flat_map(|l| &l.points);
    let (x, y) = match &panel.field {
        Some(field) => (field.x.clone(), field.y.clone()),
        None => {
            let mut y = panel.y.clone().unwrap_or_else(|| ends(points().map(|p| p.1), panel.scale));
            // the legend is above the drawing
            let named = panel.lines.iter().filter(|l| !l.name.is_empty()).count();
            y.end = match panel.scale {
                Scale::Linear => y.end + 0.08 * named as f64 * (y.end - y.start),
                Scale::Logarithmic => y.end * (y.end / y.start).powf(0.08 * named as f64),
            };
            (ends(points().map(|p| p.0), panel.scale), y)
        }
    };
    let mut builder = ChartBuilder::on(area);
    builder.caption(&panel.title, ("sans-serif", 15)).margin(8).x_label_area_size(40).y_label_area_size(56);
    match panel.scale {
        Scale::Linear => fill(panel, builder.build_cartesian_2d(x, y.clone())?, &y),
        Scale::Logarithmic => {
            let (x, range) = (x.log_scale(), y.clone().log_scale());
            fill(panel, builder.build_cartesian_2d(x, range)?, &y)
        }
    }
}

/// Mesh, cells, series and legend of a panel whose axes are set.
fn fill<'a, 'b: 'a, X, Y>(
    panel: &Panel,
    mut chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>,
    y: &Range<f64>,
) -> Drawn
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    // a decade is computed, and is a digit off in its last place
    let plain = |x: &f64| if *x < 0.01 { format!("{x:.0e}") } else { format!("{}", (x * 1e6).round() / 1e6) };
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(225, 225, 225))
        .x_desc(panel.axes[0])
        .y_desc(panel.axes[1])
        .label_style(("sans-serif", 12));
    match panel.scale {
        Scale::Linear => mesh.x_labels(6).y_labels(6),
        Scale::Logarithmic => mesh.x_label_formatter(&plain).y_label_formatter(&plain),
    };
    mesh.draw()?;
    if let Some(field) = &panel.field {
        let rows = field.cells.len() / field.columns.max(1);
        let edge = |range: &Range<f64>, k: usize, of: usize| panel.scale.at(range, k as f64 / of as f64);
        for (k, colour) in field.cells.iter().enumerate().filter_map(|(k, c)| Some((k, (*c)?))) {
            let (i, j) = (k % field.columns, k / field.columns);
            let corner = |i, j| (edge(&field.x, i, field.columns), edge(&field.y, j, rows));
            let cell = [corner(i, j), corner(i + 1, j + 1)];
            chart.draw_series([Rectangle::new(cell, RGBColor::from(colour).filled())])?;
        }
    }
    for line in &panel.lines {
        let colour = RGBColor::from(line.colour);
        let inside = || line.points.iter().filter(|p| y.contains(&p.1)).copied();
        let drawn = match line.stroke {
            Stroke::Line(width) => {
                let clipped = line.points.iter().map(|p| (p.0, p.1.clamp(y.start, y.end)));
                chart.draw_series(LineSeries::new(clipped, colour.stroke_width(width)))?
            }
            Stroke::Dots(radius) => {
                chart.draw_series(inside().map(|p| Circle::new(p, radius, colour.mix(0.55).filled())))?
            }
            Stroke::Rings(radius) => {
                chart.draw_series(inside().map(|p| Circle::new(p, radius, WHITE.filled())))?;
                chart.draw_series(inside().map(|p| Circle::new(p, radius, colour.stroke_width(2))))?
            }
        };
        // a series without a name has no legend entry
        if line.name.is_empty() {
            continue;
        }
        drawn.label(line.name.as_str());
        if let Stroke::Line(_) = line.stroke {
            drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        } else {
            drawn.legend(move |(x, y)| Circle::new((x + 8, y), 3, colour.filled()));
        }
    }
    if panel.lines.iter().any(|l| !l.name.is_empty()) {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.8))
            .label_font(("sans-serif", 12))
            .draw()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_show_every_value() {
        assert_eq!(ends([3.0, 70.0].into_iter(), Scale::Logarithmic), 1.0..100.0);
        assert_eq!(ends([1.0, 100.0, f64::NAN, -1.0].into_iter(), Scale::Logarithmic), 1.0..1000.0);
        let linear = ends([-1.0, 1.0, f64::INFINITY].into_iter(), Scale::Linear);
        assert!(linear.start < -1.0 && linear.end > 1.0 && linear.end < 1.2);
        assert_eq!(ends([f64::NAN].into_iter(), Scale::Linear), 0.0..1.0);
    }

    #[test]
    fn cells_of_a_logarithmic_field_are_equal_ratios() {
        let field = Field::new(1.0..100.0, 1.0..10.0, [2, 1], Scale::Logarithmic, |x, _| {
            (x < 10.0).then_some(Colour(9, 8, 7))
        });
        assert_eq!(field.cells, [Some(Colour(9, 8, 7)), None]);
        let panel = Panel { scale: Scale::Logarithmic, field: Some(field), ..Panel::default() };
        let keys = vec![Key::area(Colour(9, 8, 7), "slow")];
        let drawn = svg(&Picture { keys, ..Picture::of(vec![panel]) }).expect("drawn");
        assert_eq!(drawn.matches("#090807").count(), 2, "the cell and its key");
    }

    #[test]
    fn decades_were_labelled_with_all_the_digits_of_their_rounding_error() {
        let line = Line::new("", BLUE, vec![(0.1, 2e-8), (100.0, 2.0)]);
        let panel = Panel { scale: Scale::Logarithmic, lines: vec![line], ..Panel::default() };
        let drawn = svg(&Picture::of(vec![panel])).expect("drawn");
        assert!(drawn.contains("1e-5") && drawn.contains("1e-8") && !drawn.contains("9999"), "{drawn}");
    }

    #[test]
    fn nothing_finite_is_still_a_picture() {
        let line = Line::new("gone", BLUE, vec![(f64::NAN, f64::NAN)]);
        for scale in [Scale::Linear, Scale::Logarithmic] {
            let panel = Panel { scale, lines: vec![line.clone()], ..Panel::default() };
            assert!(svg(&Picture::of(vec![panel])).expect("drawn").ends_with("</svg>\n"));
        }
    }
}
