//! Rendering: the simulation of 4.4 (m = 1 kg, b = 10 N·s/m, T = 1 ms) around the device's own renderer.

use crate::figure::{Figure, Result, number};
use haptics::renderer::{Contact, Handle};
use haptics::{Config, Device, LawKind, RendererKind, Settings, bounds};
use plant::Zoh;
use report::picture::{BLUE, Colour, Field, GREEN, GREY, Line, ORANGE, Panel, Scale};

const MASS: f64 = 1.0;
const DAMPING: f64 = 10.0;
const PERIOD: f64 = 1e-3;
/// Travel of a count, m: DV = 0.02 m/s is twice the velocity resolution [thesis, fig. 4-10].
const COUNT: f64 = 1e-5;

/// A simulation of 4.4.
struct Run {
    kp: f64,
    /// Virtual damping of the stuck spring, N·s/m.
    kd: f64,
    f_static: f64,
    f_dynamic: f64,
    dv: f64,
    /// Position in counts, velocity by fixed-time differences of it; otherwise both exact.
    quantised: bool,
    seconds: f64,
    /// Force of the hand over time, N.
    hand: fn(f64) -> f64,
}

impl Default for Run {
    /// The parameters of [thesis, fig. 4-10].
    fn default() -> Self {
        Self {
            kp: 1e4,
            kd: 0.0,
            f_static: 3.5,
            f_dynamic: 3.0,
            dv: 0.02,
            quantised: true,
            seconds: 1.0,
            hand: |_| 0.0,
        }
    }
}

#[derive(Clone, Copy)]
struct Sample {
    t: f64,
    x: f64,
    v: f64,
    seen: f64,
    applied: f64,
    friction: f64,
}

fn config(run: &Run) -> Result<Config> {
    let device = Device {
        mass: MASS as f32,
        damping: DAMPING as f32,
        period: PERIOD as f32,
        delay: 0.0,
        metre_per_count: COUNT as f32,
        ..Device::default()
    };
    let settings = Settings {
        law: LawKind::Karnopp,
        renderer: RendererKind::Impedance,
        f_static_p: run.f_static as f32,
        f_static_n: run.f_static as f32,
        f_dynamic_p: run.f_dynamic as f32,
        f_dynamic_n: run.f_dynamic as f32,
        damping_p: 0.0,
        damping_n: 0.0,
        dv: run.dv as f32,
        k_vc: run.kp as f32,
        b_vc: run.kd as f32,
        ..Settings::brass()
    };
    Ok(settings.build(&device)?)
}

fn simulate(run: &Run) -> Result<Vec<Sample>> {
    let config = config(run)?;
    let zoh = Zoh::new(MASS, DAMPING, PERIOD);
    let mut contact = Contact::new(&config, &Handle::default());
    let (mut x, mut v, mut before) = (0.0, 0.0, 0.0);
    let steps = (run.seconds / PERIOD).round() as usize;
    let mut out = Vec::with_capacity(steps);
    for k in 0..steps {
        let t = k as f64 * PERIOD;
        let place = if run.quantised { (x / COUNT).round() * COUNT } else { x };
        let moved = place - before;
        before = place;
        let seen = if run.quantised { moved / PERIOD } else { v };
        let handle = Handle {
            position: place as f32,
            velocity: seen as f32,
            displacement: moved as f32,
            ..Handle::default()
        };
        let force = f64::from(contact.step(&config, &handle).force);
        let applied = (run.hand)(t);
        out.push(Sample { t, x, v, seen, applied, friction: -force });
        let (dx, next) = zoh.advance(v, applied + force);
        x += dx;
        v = next;
    }
    Ok(out)
}

fn series(samples: &[Sample], x: fn(&Sample) -> f64, y: fn(&Sample) -> f64) -> Vec<(f64, f64)> {
    samples.iter().map(|s| (x(s), y(s))).collect()
}

/// Colours of a family of curves.
const FAMILY: [Colour; 4] = [GREY, GREEN, ORANGE, BLUE];

/// [thesis, fig. 4-3].
pub(crate) fn step_responses() -> Result<Figure> {
    let mut lines = Vec::new();
    for (kp, colour) in [1_000.0, 5_000.0, 10_000.0, 20_000.0].into_iter().zip(FAMILY) {
        let run = Run { kp, quantised: false, seconds: 0.4, hand: |_| 1.0, ..Run::default() };
        let samples = simulate(&run)?;
        let points = samples.iter().map(|s| (s.t, s.x * kp)).collect();
        lines.push(Line::new(format!("K_p = {kp} N/m"), colour, points));
    }
    let limit = bounds::kp_max(MASS, DAMPING, PERIOD);
    Ok(Figure {
        id: "4-3",
        caption: "Step responses for various gains K_p",
        panels: vec![Panel {
            title: "1 N on the stuck handle".into(),
            axes: ["time, s", "K_p x, N"],
            lines,
            ..Panel::default()
        }],
        numbers: vec![number("largest K_p, N/m", "about 20,000", format!("{limit:.1}"))],
    })
}

/// [thesis, fig. 4-4].
pub(crate) fn virtual_damping() -> Result<Figure> {
    let mut panels = Vec::new();
    for (title, quantised) in [("exact velocity", false), ("quantised velocity", true)] {
        let mut lines = Vec::new();
        for (kd, colour) in [0.0, 20.0, 50.0].into_iter().zip([GREY, ORANGE, BLUE]) {
            let run = Run { kd, quantised, seconds: 0.3, hand: |_| 2.0, ..Run::default() };
            let samples = simulate(&run)?;
            lines.push(Line::new(
                format!("K_d = {kd} N·s/m"),
                colour,
                series(&samples, |s| s.t, |s| s.friction),
            ));
        }
        panels.push(Panel {
            title: title.into(),
            axes: ["time, s", "friction force, N"],
            lines,
            ..Panel::default()
        });
    }
    Ok(Figure {
        id: "4-4",
        caption: "Effect of virtual damping, K_d, on system response",
        panels,
        numbers: Vec::new(),
    })
}

/// [thesis, fig. 4-5].
pub(crate) fn quantised_velocity() -> Result<Figure> {
    let run = Run { seconds: 0.3, hand: |_| 2.0, ..Run::default() };
    let samples = simulate(&run)?;
    let panel = |title: &str, y: fn(&Sample) -> f64| Panel {
        title: title.into(),
        axes: ["time, s", "velocity, m/s"],
        lines: vec![Line::new("", BLUE, series(&samples, |s| s.t, y))],
        ..Panel::default()
    };
    let smallest = samples.iter().map(|s| s.seen.abs()).filter(|v| *v > 1e-9).fold(f64::INFINITY, f64::min);
    Ok(Figure {
        id: "4-5",
        caption: "Examples of quantized and nonquantized velocity signal.",
        panels: vec![panel("exact", |s| s.v), panel("quantised", |s| s.seen)],
        numbers: vec![number("velocity resolution (eq. 2.10), m/s", "0.01", format!("{smallest:.4}"))],
    })
}

/// A force that grows and changes sign, N.
fn slow_sine(t: f64) -> f64 {
    6.0 * (std::f64::consts::TAU * t).sin()
}

fn too_soft() -> Result<Vec<Sample>> {
    simulate(&Run { kp: 120.0, seconds: 2.0, hand: slow_sine, ..Run::default() })
}

/// [thesis, fig. 4-6].
pub(crate) fn lagging_friction() -> Result<Figure> {
    let samples = too_soft()?;
    Ok(Figure {
        id: "4-6",
        caption: "Applied Force, F_a, and Friction Force, F_f, plotted against time (K_p = 120).",
        panels: vec![Panel {
            title: "K_p = 120 N/m".into(),
            axes: ["time, s", "N"],
            lines: vec![
                Line::new("applied", GREY, series(&samples, |s| s.t, |s| s.applied)),
                Line::new("friction", BLUE, series(&samples, |s| s.t, |s| s.friction)),
            ],
            ..Panel::default()
        }],
        numbers: vec![number(
            "smallest K_p for 1 Hz (20 times as high), N/m",
            "–",
            format!("{:.0}", bounds::kp_min(MASS, 1.0)),
        )],
    })
}

/// [thesis, fig. 4-7].
pub(crate) fn creeping_while_stuck() -> Result<Figure> {
    let samples = too_soft()?;
    Ok(Figure {
        id: "4-7",
        caption: "Friction force versus velocity (K_p = 120). If K_p is too low, then v > DV even in the STUCK region.",
        panels: vec![Panel {
            title: "K_p = 120 N/m, DV = 0.02 m/s".into(),
            axes: ["velocity, m/s", "friction, N"],
            lines: vec![Line::new("", BLUE, series(&samples, |s| s.v, |s| s.friction))],
            ..Panel::default()
        }],
        numbers: Vec::new(),
    })
}

/// A force that rises slowly, N.
fn ramp(t: f64) -> f64 {
    4.5 * t
}

/// [thesis, fig. 4-8].
pub(crate) fn dead_bands() -> Result<Figure> {
    let mut panels = Vec::new();
    let mut numbers = Vec::new();
    for dv in [0.02, 0.04, 0.08] {
        let samples = simulate(&Run { dv, hand: ramp, ..Run::default() })?;
        // from the first break-away to the last return to the static level
        let stuck = |s: &Sample| s.friction > 3.02;
        let first = samples.windows(2).find(|w| stuck(&w[0]) && !stuck(&w[1])).map_or(0.0, |w| w[1].t);
        let last = samples.iter().rev().find(|s| stuck(s)).map_or(0.0, |s| s.t);
        numbers.push(number(
            format!("stick-slip with DV = {dv} m/s, s"),
            "–",
            format!("{:.3}", (last - first).max(0.0)),
        ));
        panels.push(Panel {
            title: format!("DV = {dv} m/s"),
            axes: ["time, s", "friction, N"],
            lines: vec![Line::new("", BLUE, series(&samples, |s| s.t, |s| s.friction))],
            y: Some(0.0..4.0),
            ..Panel::default()
        });
    }
    Ok(Figure {
        id: "4-8",
        caption: "Effect of DV on the duration of the stick-slip regime.",
        panels,
        numbers,
    })
}

/// [thesis, fig. 4-9].
pub(crate) fn stick_slip() -> Result<Figure> {
    let samples = simulate(&Run { dv: 0.04, hand: ramp, ..Run::default() })?;
    let start = samples.iter().position(|s| s.applied > 3.4).unwrap_or(0);
    let detail = &samples[start..(start + 100).min(samples.len())];
    let panel = |title: &str, y: fn(&Sample) -> f64, unit: &'static str| Panel {
        title: title.into(),
        axes: ["time, s", unit],
        lines: vec![Line::new("", BLUE, series(detail, |s| s.t, y))],
        ..Panel::default()
    };
    Ok(Figure {
        id: "4-9",
        caption: "Detail of stick-slip regime",
        panels: vec![panel("friction", |s| s.friction, "N"), panel("velocity", |s| s.v, "m/s")],
        numbers: Vec::new(),
    })
}

/// [thesis, fig. 4-10].
pub(crate) fn tuned() -> Result<Figure> {
    let run = Run { seconds: 2.0, hand: slow_sine, ..Run::default() };
    let samples = simulate(&run)?;
    let most = bounds::friction_max(MASS, DAMPING, PERIOD, run.dv);
    Ok(Figure {
        id: "4-10",
        caption: "A haptic rendering of the Karnopp Model with tuned parameters.",
        panels: vec![Panel {
            title: "K_p = 10 000 N/m, DV = 0.02 m/s".into(),
            axes: ["velocity, m/s", "friction, N"],
            lines: vec![Line::new("", BLUE, series(&samples, |s| s.v, |s| s.friction))],
            ..Panel::default()
        }],
        numbers: vec![number("largest F_d for this DV (eq. 4.21), N", "–", format!("{most:.1}"))],
    })
}

/// Block of 4.6.2: kg, N.
const BLOCK: f64 = 0.5;
const FRICTION: f64 = 4.0;

/// [thesis, eq. 4.35] as printed: on both sides of its singularity.
fn amplitude(k: f64, b: f64) -> f64 {
    2.0 * FRICTION * PERIOD / (4.0 * BLOCK - k * PERIOD * PERIOD - 2.0 * b * PERIOD).abs()
}

/// [thesis, fig. 4-13].
pub(crate) fn limit_cycle_surface() -> Result<Figure> {
    let field = Field::new(0.0..20_000.0, 0.0..2_000.0, [60; 2], Scale::Linear, |k, b| {
        // 1 mm/s white, 1 m/s dark
        let shade = (amplitude(k, b).log10() + 3.0) / 3.0;
        let grey = (245.0 - 215.0 * shade.clamp(0.0, 1.0)) as u8;
        shade.is_finite().then_some(Colour(grey, grey, 245_u8.saturating_sub((255 - grey) / 4)))
    });
    Ok(Figure {
        id: "4-13",
        caption: "Surface representing amplitude (velocity) of the limit cycle as a function of virtual coupling stiffness, K, and damping B.",
        panels: vec![Panel {
            title: "from 1 mm/s (light) to 1 m/s (dark)".into(),
            axes: ["K, N/m", "B, N·s/m"],
            field: Some(field),
            ..Panel::default()
        }],
        numbers: vec![number(
            "at K = 10 000 N/m, B = 10 N·s/m, m/s",
            "0.00406 (eq. 4.35)",
            format!("{:.5}", bounds::limit_cycle_velocity(FRICTION, BLOCK, 1e4, 10.0, PERIOD)),
        )],
    })
}

/// [thesis, fig. 4-14].
pub(crate) fn limit_cycle_sections() -> Result<Figure> {
    let section = |title: &str, x: &'static str, most: f64, at: fn(f64) -> f64| {
        let points = (0..=800).map(|k| f64::from(k) / 800.0 * most).map(|x| (x, at(x))).collect();
        Panel {
            title: title.into(),
            axes: [x, "velocity, m/s"],
            lines: vec![Line::new("", BLUE, points)],
            y: Some(0.0..2.0),
            ..Panel::default()
        }
    };
    Ok(Figure {
        id: "4-14",
        caption: "Cross section of the limit cycle surface for K=10,000 N/m (upper plot) and B=995 Ns/m (lower plot)",
        panels: vec![
            section("K = 10 000 N/m", "B, N·s/m", 2_000.0, |b| amplitude(1e4, b)),
            section("B = 995 N·s/m", "K, N/m", 20_000.0, |k| amplitude(k, 995.0)),
        ],
        numbers: vec![
            number(
                "singular B at K = 10 000 N/m, N·s/m",
                "995",
                format!("{:.1}", bounds::damping_singular(BLOCK, 1e4, PERIOD)),
            ),
            number(
                "singular K at B = 995 N·s/m, N/m",
                "10,000",
                format!("{:.0}", bounds::stiffness_singular(BLOCK, 995.0, PERIOD)),
            ),
        ],
    })
}
