//! The safe region over stiffness and damping, as a picture.

use super::Given;
use crate::failure::{Failure, Result};
use haptics::bounds;
use plotters::prelude::*;

/// Cells a side.
const CELLS: usize = 90;
/// Stiffness shown, N/m, and damping, N·s/m.
const STIFFNESS: (f64, f64) = (1e2, 1e6);
const DAMPING: (f64, f64) = (1e-1, 2e3);
const SIZE: (u32, u32) = (860, 520);

/// Dark blue through green to yellow: reads in grey and with any colour vision (viridis, six points).
const VIRIDIS: [(f64, f64, f64); 6] = [
    (68.0, 1.0, 84.0),
    (65.0, 68.0, 135.0),
    (42.0, 120.0, 142.0),
    (34.0, 168.0, 132.0),
    (122.0, 209.0, 81.0),
    (253.0, 231.0, 37.0),
];

fn shade(share: f64) -> RGBColor {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    let u = at - k as f64;
    let mix = |a: f64, b: f64| (a + u * (b - a)) as u8;
    let ((r, g, b), (s, h, c)) = (VIRIDIS[k], VIRIDIS[k + 1]);
    RGBColor(mix(r, s), mix(g, h), mix(b, c))
}

/// What a cell is.
enum Cell {
    Unstable,
    /// Stable; the share of the colour scale where a friction was given.
    Stable(Option<f64>),
}

/// Decades of DV that the colours span, from 10⁻⁴ m/s.
fn of_dv(dv: f64) -> f64 {
    (dv.log10() + 4.0) / 3.0
}

fn cell(given: &Given, k: f64, b: f64) -> Cell {
    let design = Given { stiffness: Some(k), damping: Some(b), ..*given }.design();
    if design.stable == Some(false) {
        return Cell::Unstable;
    }
    Cell::Stable(design.get("dv_min").map(of_dv))
}

fn at(range: (f64, f64), share: f64) -> f64 {
    range.0 * (range.1 / range.0).powf(share)
}

/// The map as SVG.
///
/// # Errors
/// The drawing library's.
pub(crate) fn draw(given: &Given) -> Result<String> {
    let mut svg = String::new();
    drawn(given, &mut svg).map_err(|e| Failure::new(format!("the map cannot be drawn: {e}")))?;
    Ok(svg)
}

fn drawn(given: &Given, svg: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let page = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    page.fill(&WHITE)?;
    let (left, right) = page.split_horizontally(SIZE.0 - 190);
    let mut chart = ChartBuilder::on(&left)
        .caption("Where the virtual coupling is safe", ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d((STIFFNESS.0..STIFFNESS.1).log_scale(), (DAMPING.0..DAMPING.1).log_scale())?;
    let n = CELLS as f64;
    for column in 0..CELLS {
        for row in 0..CELLS {
            let (u, w) = (column as f64 / n, row as f64 / n);
            let half = 0.5 / n;
            let colour = match cell(given, at(STIFFNESS, u + half), at(DAMPING, w + half)) {
                Cell::Unstable => RGBColor(214, 214, 214),
                Cell::Stable(None) => RGBColor(122, 180, 200),
                Cell::Stable(Some(share)) => shade(share),
            };
            let corners =
                [(at(STIFFNESS, u), at(DAMPING, w)), (at(STIFFNESS, u + 1.0 / n), at(DAMPING, w + 1.0 / n))];
            chart.draw_series([Rectangle::new(corners, colour.filled())])?;
        }
    }
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("coupling stiffness K, N/m")
        .y_desc("coupling damping B, N·s/m")
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&|x| format!("{x}"))
        .draw()?;
    if let Some(device) = given.device_damping {
        let edge = (0..=400).map(|k| at(STIFFNESS, f64::from(k) / 400.0)).filter_map(|k| {
            let b = bounds::passivity_margin(device, k, 0.0, given.period);
            (b > DAMPING.0 && b < DAMPING.1).then_some((k, b))
        });
        chart.draw_series(LineSeries::new(edge, BLACK.stroke_width(2)))?;
    }
    if let (Some(k), Some(b)) = (given.stiffness, given.damping) {
        let inside = |x: f64, range: (f64, f64)| x >= range.0 && x <= range.1;
        if inside(k, STIFFNESS) && inside(b, DAMPING) {
            chart.draw_series([Circle::new((k, b), 6, WHITE.filled())])?;
            chart.draw_series([Circle::new((k, b), 6, BLACK.stroke_width(2))])?;
        }
    }
    legend(given, &right)?;
    page.present()?;
    Ok(())
}

type Area<'a, 'b> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn legend(given: &Given, area: &Area<'_, '_>) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let text = ("sans-serif", 13).into_font().color(&BLACK);
    let mut y = 60;
    let mut entry = |colour: RGBColor, what: &str| -> std::result::Result<(), Box<dyn std::error::Error>> {
        area.draw(&Rectangle::new([(0, y), (16, y + 12)], colour.filled()))?;
        area.draw(&Text::new(what.to_owned(), (24, y), text.clone()))?;
        y += 22;
        Ok(())
    };
    if given.mass.is_some() && given.friction.is_some() {
        for (dv, what) in
            [(1e-4, "0.1"), (3e-4, "0.3"), (1e-3, "1"), (3e-3, "3"), (1e-2, "10"), (1e-1, "100")]
        {
            entry(shade(of_dv(dv)), &format!("DV from {what} mm/s"))?;
        }
    } else {
        entry(RGBColor(122, 180, 200), "stable")?;
    }
    entry(RGBColor(214, 214, 214), "oscillates")?;
    if given.device_damping.is_some() {
        area.draw(&PathElement::new([(0, y + 6), (16, y + 6)], BLACK.stroke_width(2)))?;
        area.draw(&Text::new("below: passive with", (24, y), text.clone()))?;
        area.draw(&Text::new("any hand while stuck", (24, y + 16), text.clone()))?;
        y += 38;
    }
    if given.stiffness.is_some() && given.damping.is_some() {
        area.draw(&Circle::new((8, y + 6), 6, BLACK.stroke_width(2)))?;
        area.draw(&Text::new("K and B given", (24, y), text.clone()))?;
    }
    Ok(())
}
