//! The grid as a picture: for every renderer, which couplings come to rest.

use crate::grid::{Outcome, Verdict};
use haptics::RendererKind;
use report::picture::{Colour, DrawError, Field, Key, Panel, Picture, Scale, svg};
use std::ops::Range;

/// Stiffness shown, N/m.
const STIFFNESS: Range<f64> = 500.0..60_000.0;
/// Mass shown, kg.
const MASS: Range<f64> = 0.01..2.0;
/// Cells along stiffness and mass.
const CELLS: [usize; 2] = [30, 24];
const RESTS: (f64, f64, f64) = (196.0, 219.0, 233.0);
const CYCLES: (f64, f64, f64) = (190.0, 30.0, 20.0);

/// The colour of a cell in which this share does not come to rest: any at all shows.
fn shade(share: f64) -> Colour {
    let u = if share > 0.0 { 0.25 + 0.75 * share.min(1.0) } else { 0.0 };
    let mix = |from: f64, to: f64| (from + u * (to - from)) as u8;
    Colour(mix(RESTS.0, CYCLES.0), mix(RESTS.1, CYCLES.1), mix(RESTS.2, CYCLES.2))
}

/// Which of `cells` of the range this value is in.
fn cell(range: &Range<f64>, value: f64, cells: usize) -> usize {
    let share = (value / range.start).ln() / (range.end / range.start).ln();
    ((share * cells as f64) as usize).min(cells - 1)
}

/// Cells of the renderer at this place of [`RendererKind::ALL`].
fn field(outcomes: &[Outcome], renderer: usize) -> Field {
    let mut counted = vec![(0_u32, 0_u32); CELLS[0] * CELLS[1]];
    for o in outcomes {
        let (verdict, stable) = o.verdicts[renderer];
        if verdict == Verdict::Refused || !stable {
            continue;
        }
        let row = cell(&MASS, o.point.mass, CELLS[1]);
        let (all, not) = &mut counted[row * CELLS[0] + cell(&STIFFNESS, o.point.stiffness, CELLS[0])];
        (*all, *not) = (*all + 1, *not + u32::from(verdict != Verdict::Rests));
    }
    let colour = |(all, not): (u32, u32)| (all > 0).then(|| shade(f64::from(not) / f64::from(all)));
    Field { x: STIFFNESS, y: MASS, columns: CELLS[0], cells: counted.into_iter().map(colour).collect() }
}

/// The map as SVG: block mass over coupling stiffness, the share of each cell that does not come to rest.
///
/// # Errors
/// The drawing library's.
pub fn grid_map(outcomes: &[Outcome]) -> Result<String, DrawError> {
    let panel = |(at, renderer): (usize, &RendererKind)| Panel {
        title: match renderer {
            RendererKind::Impedance => "table 4-1 (impedance)",
            RendererKind::VirtualCoupling => "virtual coupling (4.22-4.24)",
            RendererKind::StoppingForce => "stopping force",
            RendererKind::Admittance => "admittance",
        }
        .into(),
        axes: ["coupling stiffness K, N/m", "block mass M, kg"],
        scale: Scale::Logarithmic,
        field: Some(field(outcomes, at)),
        ..Panel::default()
    };
    let keys = [(0.0, "all come to rest"), (0.01, "some go on to and fro"), (0.5, "half"), (1.0, "all")]
        .map(|(share, what)| Key::area(shade(share), what))
        .to_vec();
    let panels: Vec<Panel> = RendererKind::ALL.iter().enumerate().map(panel).collect();
    svg(&Picture { columns: panels.len(), panels, size: (380, 430), keys })
}
