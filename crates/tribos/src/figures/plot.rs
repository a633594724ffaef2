//! Panels as SVG.

use super::Figure;
use crate::failure::{Failure, Result};
use plotters::prelude::*;
use std::ops::Range;

const PANEL: (u32, u32) = (430, 360);
/// Panels in a row.
const ROW: usize = 3;

/// Colours that stay apart with any colour vision (Okabe and Ito).
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const ORANGE: RGBColor = RGBColor(213, 94, 0);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(crate) const GREY: RGBColor = RGBColor(120, 120, 120);

/// What is drawn of one thing.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub name: String,
    pub colour: RGBColor,
    /// Points instead of a line.
    pub dots: bool,
    /// Of a point, pixels.
    pub radius: u32,
    pub points: Vec<(f64, f64)>,
}

impl Line {
    pub(crate) fn new(name: impl Into<String>, colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), colour, dots: false, radius: 1, points }
    }

    pub(crate) fn dots(self) -> Self {
        Self { dots: true, ..self }
    }

    /// Few points, each to be seen.
    pub(crate) fn marks(self) -> Self {
        Self { dots: true, radius: 4, ..self }
    }
}

/// A field over two coordinates, as coloured cells.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Cells a side.
    pub cells: usize,
    /// 0 to 1, row by row from the bottom; NaN is left white.
    pub shade: Vec<f64>,
}

/// One set of axes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Panel {
    pub title: String,
    /// Along x and y, with units.
    pub axes: [&'static str; 2],
    pub lines: Vec<Line>,
    pub field: Option<Field>,
    /// Ends of the y axis, where the data are not to say.
    pub y: Option<Range<f64>>,
}

fn ends(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if !(high >= low) {
        return 0.0..1.0;
    }
    let room = 0.05 * (high - low).max(1e-9 * high.abs()).max(1e-12);
    low - room..high + room
}

/// The figure as SVG.
///
/// # Errors
/// The drawing library's.
pub(crate) fn svg(figure: &Figure) -> Result<String> {
    let mut out = String::new();
    drawn(figure, &mut out)
        .map_err(|e| Failure::new(format!("figure {} cannot be drawn: {e}", figure.id)))?;
    Ok(out)
}

fn drawn(figure: &Figure, out: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let columns = figure.panels.len().clamp(1, ROW);
    let rows = figure.panels.len().div_ceil(columns).max(1);
    let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32);
    let page = SVGBackend::with_string(out, size).into_drawing_area();
    page.fill(&WHITE)?;
    for (panel, area) in figure.panels.iter().zip(page.split_evenly((rows, columns))) {
        one(panel, &area)?;
    }
    page.present()?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn one(panel: &Panel, area: &Area<'_>) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let points = || panel.lines.iter().flat_map(|l| &l.points);
    let (x, y) = match &panel.field {
        Some(field) => (field.x.clone(), field.y.clone()),
        None => {
            let mut y = panel.y.clone().unwrap_or_else(|| ends(points().map(|p| p.1)));
            // the legend is above what is drawn
            let named = panel.lines.iter().filter(|l| !l.name.is_empty()).count();
            y.end += 0.08 * named as f64 * (y.end - y.start);
            (ends(points().map(|p| p.0)), y)
        }
    };
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 15))
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(x, y.clone())?;
    chart
        .configure_mesh()
        .x_labels(6)
        .y_labels(6)
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(225, 225, 225))
        .x_desc(panel.axes[0])
        .y_desc(panel.axes[1])
        .label_style(("sans-serif", 12))
        .draw()?;
    if let Some(field) = &panel.field {
        let (w, h) = (
            (field.x.end - field.x.start) / field.cells as f64,
            (field.y.end - field.y.start) / field.cells as f64,
        );
        for (k, shade) in field.shade.iter().enumerate().filter(|(_, s)| s.is_finite()) {
            let (i, j) = ((k % field.cells) as f64, (k / field.cells) as f64);
            let from = (field.x.start + i * w, field.y.start + j * h);
            let grey = (245.0 - 215.0 * shade.clamp(0.0, 1.0)) as u8;
            let colour = RGBColor(grey, grey, 245_u8.saturating_sub((255 - grey) / 4));
            chart.draw_series([Rectangle::new([from, (from.0 + w, from.1 + h)], colour.filled())])?;
        }
    }
    for line in &panel.lines {
        let colour = line.colour;
        // what has no name is not in the legend
        let named = !line.name.is_empty();
        if line.dots {
            let inside = line.points.iter().filter(|p| y.contains(&p.1));
            let dots = inside.map(|p| Circle::new(*p, line.radius, colour.mix(0.55).filled()));
            let drawn = chart.draw_series(dots)?;
            if named {
                drawn
                    .label(line.name.as_str())
                    .legend(move |(x, y)| Circle::new((x + 8, y), 3, colour.filled()));
            }
        } else {
            let clipped = line.points.iter().map(|p| (p.0, p.1.clamp(y.start, y.end)));
            let drawn = chart.draw_series(LineSeries::new(clipped, colour.stroke_width(1)))?;
            if named {
                drawn
                    .label(line.name.as_str())
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
            }
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
