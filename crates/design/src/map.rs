//! The safe region over stiffness and damping, as a picture.

use crate::Given;
use haptics::bounds;
use report::picture::{BLACK, Colour, DrawError, Field, Key, Line, Panel, Picture, Scale, Stroke, svg};
use std::ops::Range;

/// Cells a side.
const CELLS: usize = 90;
/// Stiffness shown, N/m.
const STIFFNESS: Range<f64> = 1e2..1e6;
/// Damping shown, N·s/m.
const DAMPING: Range<f64> = 1e-1..2e3;
const OSCILLATES: Colour = Colour(214, 214, 214);
const STABLE: Colour = Colour(122, 180, 200);

/// Dark blue through green to yellow: reads in grey and with any colour vision (viridis, six points).
const VIRIDIS: [(f64, f64, f64); 6] = [
    (68.0, 1.0, 84.0),
    (65.0, 68.0, 135.0),
    (42.0, 120.0, 142.0),
    (34.0, 168.0, 132.0),
    (122.0, 209.0, 81.0),
    (253.0, 231.0, 37.0),
];

/// The colour of a smallest DV: three decades from 10⁻⁴ m/s.
fn shade(dv: f64) -> Colour {
    let share = (dv.log10() + 4.0) / 3.0;
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    let u = at - k as f64;
    let mix = |a: f64, b: f64| (a + u * (b - a)) as u8;
    let ((r, g, b), (s, h, c)) = (VIRIDIS[k], VIRIDIS[k + 1]);
    Colour(mix(r, s), mix(g, h), mix(b, c))
}

fn cell(given: &Given, k: f64, b: f64) -> Colour {
    let design = Given { stiffness: Some(k), damping: Some(b), ..*given }.design();
    match design.get("dv_min") {
        _ if design.stable == Some(false) => OSCILLATES,
        Some(dv) => shade(dv),
        None => STABLE,
    }
}

/// The map as SVG.
///
/// # Errors
/// The drawing library's.
pub fn map(given: &Given) -> Result<String, DrawError> {
    let scale = Scale::Logarithmic;
    let mut lines = Vec::new();
    let mut keys: Vec<Key> = if given.mass.is_some() && given.friction.is_some() {
        [(1e-4, "0.1"), (3e-4, "0.3"), (1e-3, "1"), (3e-3, "3"), (1e-2, "10"), (1e-1, "100")]
            .map(|(dv, what)| Key::area(shade(dv), format!("DV from {what} mm/s")))
            .to_vec()
    } else {
        vec![Key::area(STABLE, "stable")]
    };
    keys.push(Key::area(OSCILLATES, "oscillates"));
    if let Some(device) = given.device_damping {
        let edge = (0..=400).map(|k| scale.at(&STIFFNESS, f64::from(k) / 400.0)).filter_map(|k| {
            let b = bounds::passivity_margin(device, k, 0.0, given.period);
            (b > DAMPING.start && b < DAMPING.end).then_some((k, b))
        });
        lines.push(Line::new("", BLACK, edge.collect()).stroke(Stroke::Line(2)));
        let text = ["below: passive with", "any hand while stuck"].map(str::to_owned).to_vec();
        keys.push(Key { stroke: Some(Stroke::Line(2)), colour: BLACK, text });
    }
    if let (Some(k), Some(b)) = (given.stiffness, given.damping) {
        let ring = Stroke::Rings(6);
        if (STIFFNESS.start..=STIFFNESS.end).contains(&k) {
            lines.push(Line::new("", BLACK, vec![(k, b)]).stroke(ring));
        }
        keys.push(Key { stroke: Some(ring), colour: BLACK, text: vec!["K and B given".to_owned()] });
    }
    let field = Field::new(STIFFNESS, DAMPING, [CELLS; 2], scale, |k, b| Some(cell(given, k, b)));
    let panel = Panel {
        title: "Where the virtual coupling is safe".into(),
        axes: ["coupling stiffness K, N/m", "coupling damping B, N·s/m"],
        scale,
        lines,
        field: Some(field),
        y: None,
    };
    svg(&Picture { panels: vec![panel], columns: 1, size: (670, 520), keys })
}
