//! A real and a rendered block in one picture.

use crate::picture::{BLUE, DrawError, GREEN, GREY, Line, ORANGE, Panel, Picture, svg};
use compare::{Bins, Comparison, Levels, Measured, PlanarComparison, PlanarPoint, Row};

/// Number of dots per recording.
const DOTS: usize = 1500;
/// Length of the comparison over time, s.
const SPAN: f64 = 2.5;

/// Friction over velocity, friction over time, and the difference in JND, as SVG.
///
/// # Errors
/// Errors of the drawing library.
pub fn overlay(comparison: &Comparison, real: &Measured, rendered: &Measured) -> Result<String, DrawError> {
    let c = &comparison.curves;
    let own = |velocity: f64| c.bare.as_ref().map_or(0.0, |bare| bare.at(&c.bins, velocity));
    let none = |_: f64| 0.0;
    let real_rows = rows(real, &c.real, &none);
    let rendered_rows = rows(rendered, &c.rendered, &own);
    let curve = |levels: &Levels, own: &dyn Fn(f64) -> f64, sign: f64| curve(levels, &c.bins, own, sign);
    let over_velocity = Panel {
        title: "friction against velocity".into(),
        axes: ["velocity / m/s", "friction / N"],
        lines: vec![
            Line::new("", BLUE, thinned(&real_rows, |r| (r.velocity, r.friction))).dots(),
            Line::new("", ORANGE, thinned(&rendered_rows, |r| (r.velocity, r.friction))).dots(),
            Line::new("real", BLUE, curve(&c.real, &none, 1.0)),
            Line::new("", BLUE, curve(&c.real, &none, -1.0)),
            Line::new("rendered", ORANGE, curve(&c.rendered, &own, 1.0)),
            Line::new("", ORANGE, curve(&c.rendered, &own, -1.0)),
        ],
        ..Panel::default()
    };
    let over_time = Panel {
        title: "friction while it slides steadily".into(),
        axes: ["time since a first stroke forward / s", "friction / N"],
        lines: vec![
            Line::new("real", BLUE, from_first_stroke(&real_rows)).dots(),
            Line::new("rendered", ORANGE, from_first_stroke(&rendered_rows)).dots(),
        ],
        ..Panel::default()
    };
    let off = |sign: f64| {
        let of = comparison.points.iter().filter(|p| p.velocity * sign > 0.0);
        let mut points: Vec<_> = of.map(|p| (p.velocity, (p.rendered - p.real) / p.jnd)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let most = comparison.points.iter().map(|p| ((p.rendered - p.real) / p.jnd).abs()).fold(1.1, f64::max);
    let ends: Vec<f64> = comparison.points.iter().map(|p| p.velocity).collect();
    let (low, high) = ends.iter().fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    let level = |y: f64| vec![(low, y), (high, y)];
    let in_jnd = Panel {
        title: format!("difference: {:.2} JND in all", comparison.distance.value),
        axes: ["velocity / m/s", "rendered − real / JND"],
        lines: vec![
            Line::new("what a hand notices", GREY, level(1.0)),
            Line::new("", GREY, level(-1.0)),
            Line::new("difference", GREEN, off(1.0)),
            Line::new("", GREEN, off(-1.0)),
        ],
        y: Some(-1.1 * most..1.1 * most),
        ..Panel::default()
    };
    svg(&Picture::of(vec![over_velocity, over_time, in_jnd]))
}

struct Dot {
    time: f64,
    velocity: f64,
    friction: f64,
}

fn rows(measured: &Measured, levels: &Levels, own: &dyn Fn(f64) -> f64) -> Vec<Dot> {
    let dot = |row: &Row| Dot {
        time: row.time,
        velocity: row.velocity,
        friction: levels.friction(row) - own(row.velocity),
    };
    measured.rows().iter().map(dot).collect()
}

fn thinned(rows: &[Dot], point: impl Fn(&Dot) -> (f64, f64)) -> Vec<(f64, f64)> {
    rows.iter().step_by(rows.len().div_ceil(DOTS).max(1)).map(point).collect()
}

/// First forward slide after a backward one.
fn from_first_stroke(rows: &[Dot]) -> Vec<(f64, f64)> {
    let first = rows.windows(2).find(|w| w[0].velocity < 0.0 && w[1].velocity > 0.0).map(|w| w[1].time);
    let first = first.or(rows.first().map(|row| row.time)).unwrap_or(0.0);
    let of = rows.iter().filter(|row| row.time >= first && row.time < first + SPAN);
    of.map(|row| (row.time - first, row.friction)).collect()
}

fn curve(levels: &Levels, bins: &Bins, own: &dyn Fn(f64) -> f64, sign: f64) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = bins
        .speeds()
        .iter()
        .filter(|v| **v * sign > 0.0)
        .map(|v| (*v, levels.at(bins, *v) - own(*v)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Friction in the plane, and the difference in JND over the direction of motion, as SVG; at the middle of the speeds.
///
/// # Errors
/// Errors of the drawing library.
pub fn planar_overlay(comparison: &PlanarComparison) -> Result<String, DrawError> {
    let count = comparison.points.len();
    let mut points: Vec<&PlanarPoint> = comparison.points[count / 3..2 * count / 3].iter().collect();
    points.sort_by(|a, b| a.direction.total_cmp(&b.direction));
    let ring = |of: fn(&PlanarPoint) -> [f64; 2]| {
        let closed = points.iter().chain(points.first());
        closed.map(|p| of(p)).map(|[x, y]| (x, y)).collect::<Vec<_>>()
    };
    let plane = Panel {
        title: "friction in every direction".into(),
        axes: ["along x / N", "along y / N"],
        lines: vec![
            Line::new("real", BLUE, ring(|p| p.real)),
            Line::new("rendered", ORANGE, ring(|p| p.rendered)),
        ],
        ..Panel::default()
    };
    let over = |of: fn(&PlanarPoint) -> f64| {
        points.iter().map(|p| (p.direction.to_degrees(), of(p))).collect::<Vec<_>>()
    };
    let largest =
        points.iter().flat_map(|p| [p.level_jnd, p.turned_jnd]).fold(1.1, |m: f64, x| m.max(x.abs()));
    let level = |y: f64| vec![(-180.0, y), (180.0, y)];
    let in_jnd = Panel {
        title: format!("difference: {:.2} JND in all", comparison.distance.value),
        axes: ["direction of motion / °", "rendered − real / JND"],
        lines: vec![
            Line::new("what a hand notices", GREY, level(1.0)),
            Line::new("", GREY, level(-1.0)),
            Line::new("size", GREEN, over(|p| p.level_jnd)),
            Line::new("direction of the force", ORANGE, over(|p| p.turned_jnd)),
        ],
        y: Some(-1.1 * largest..1.1 * largest),
        ..Panel::default()
    };
    svg(&Picture::of(vec![plane, in_jnd]))
}
