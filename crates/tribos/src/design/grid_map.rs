//! The grid as a picture: for every renderer, which couplings come to rest.

use super::grid::{Outcome, Verdict};
use crate::failure::{Failure, Result};
use haptics::RendererKind;
use plotters::prelude::*;

const SIZE: (u32, u32) = (1_140, 470);
/// Stiffness and mass shown, and cells along each.
const STIFFNESS: (f64, f64) = (500.0, 60_000.0);
const MASS: (f64, f64) = (0.01, 2.0);
const CELLS: (usize, usize) = (30, 24);
const RESTS: (f64, f64, f64) = (196.0, 219.0, 233.0);
const CYCLES: (f64, f64, f64) = (190.0, 30.0, 20.0);

/// The colour of a cell in which this share does not come to rest: any at all shows.
fn shade(share: f64) -> RGBColor {
    let u = if share > 0.0 { 0.25 + 0.75 * share.min(1.0) } else { 0.0 };
    let mix = |from: f64, to: f64| (from + u * (to - from)) as u8;
    RGBColor(mix(RESTS.0, CYCLES.0), mix(RESTS.1, CYCLES.1), mix(RESTS.2, CYCLES.2))
}

fn edge(range: (f64, f64), share: f64) -> f64 {
    range.0 * (range.1 / range.0).powf(share)
}

/// Which of `cells` of the range this value is in.
fn cell(range: (f64, f64), value: f64, cells: usize) -> usize {
    let share = (value / range.0).ln() / (range.1 / range.0).ln();
    ((share * cells as f64) as usize).min(cells - 1)
}

/// The map as SVG: block mass over coupling stiffness, the share of each cell that does not come to rest.
///
/// # Errors
/// The drawing library's.
pub(crate) fn draw(outcomes: &[Outcome]) -> Result<String> {
    let mut svg = String::new();
    drawn(outcomes, &mut svg).map_err(|e| Failure::new(format!("the map cannot be drawn: {e}")))?;
    Ok(svg)
}

fn drawn(outcomes: &[Outcome], svg: &mut String) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let page = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    page.fill(&WHITE)?;
    let (top, bottom) = page.split_vertically(SIZE.1 - 40);
    let panels = top.split_evenly((1, RendererKind::ALL.len()));
    for ((at, renderer), panel) in RendererKind::ALL.iter().enumerate().zip(&panels) {
        let title = match renderer {
            RendererKind::Impedance => "table 4-1 (impedance)",
            RendererKind::VirtualCoupling => "virtual coupling (4.22-4.24)",
            RendererKind::StoppingForce => "stopping force",
        };
        let mut chart = ChartBuilder::on(panel)
            .caption(title, ("sans-serif", 17))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(52)
            .build_cartesian_2d((STIFFNESS.0..STIFFNESS.1).log_scale(), (MASS.0..MASS.1).log_scale())?;
        let mut counted = vec![(0_u32, 0_u32); CELLS.0 * CELLS.1];
        for o in outcomes {
            let (verdict, stable) = o.verdicts[at];
            if verdict == Verdict::Refused || !stable {
                continue;
            }
            let column = cell(STIFFNESS, o.point.stiffness, CELLS.0);
            let (all, not) = &mut counted[column * CELLS.1 + cell(MASS, o.point.mass, CELLS.1)];
            (*all, *not) = (*all + 1, *not + u32::from(verdict != Verdict::Rests));
        }
        for (k, &(all, not)) in counted.iter().enumerate().filter(|(_, (all, _))| *all > 0) {
            let (u, w) = ((k / CELLS.1) as f64, (k % CELLS.1) as f64);
            let corner =
                |u: f64, w: f64| (edge(STIFFNESS, u / CELLS.0 as f64), edge(MASS, w / CELLS.1 as f64));
            let colour = shade(f64::from(not) / f64::from(all));
            chart.draw_series([Rectangle::new([corner(u, w), corner(u + 1.0, w + 1.0)], colour.filled())])?;
        }
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("coupling stiffness K, N/m")
            .y_desc("block mass M, kg")
            .x_label_formatter(&|x| format!("{x}"))
            .y_label_formatter(&|x| format!("{x}"))
            .draw()?;
    }
    let text = ("sans-serif", 14).into_font().color(&BLACK);
    let mut x = 70;
    for (share, what) in
        [(0.0, "all come to rest"), (0.01, "some go on to and fro"), (0.5, "half"), (1.0, "all")]
    {
        bottom.draw(&Rectangle::new([(x, 8), (x + 16, 20)], shade(share).filled()))?;
        bottom.draw(&Text::new(what, (x + 24, 6), text.clone()))?;
        x += 210;
    }
    page.present()?;
    Ok(())
}
