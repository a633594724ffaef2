//! Identification: the experiment of 3.5 on the rig with the parameters of [thesis, table 3-3] and the errors of [thesis, table 3-2].

use crate::figure::{Figure, Number, Result, number};
use identify::{
    DahlOptions, Identification, KarnoppOptions, Model, Preprocess, Signals, identify_dahl, identify_karnopp,
    prepare,
};
use plant::materials::{self, Material, WEIGHED_BLOCK_MASS};
use plant::{Series, thesis_recording};
use report::number::number as digits;
use report::picture::{BLUE, GREEN, GREY, Line, ORANGE, Panel};
use signals::Recording;

/// Seed of the noise.
const SEED: u64 = 1;

fn recorded(material: &Material) -> Result<Series> {
    Ok(thesis_recording(material, SEED)?)
}

fn over(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

/// [thesis, fig. 3-3].
pub(crate) fn signals() -> Result<Figure> {
    let s = recorded(&materials::RUBBER)?;
    let panel = |title: &str, y: &'static str, column: &[f64]| Panel {
        title: title.into(),
        axes: ["time, s", y],
        lines: vec![Line::new("", BLUE, over(&s.time, column))],
        ..Panel::default()
    };
    Ok(Figure {
        id: "3-3",
        caption: "Typical velocity, acceleration, and force data",
        panels: vec![
            panel("velocity", "m/s", &s.velocity),
            panel("acceleration", "m/s²", &s.acceleration),
            panel("force", "N", &s.force),
        ],
        numbers: vec![number("samples in 2 s, four cycles", "2000", s.len().to_string())],
    })
}

/// [thesis, fig. 3-4].
pub(crate) fn directions() -> Result<Figure> {
    let s = recorded(&materials::RUBBER)?;
    let part = |keep: fn(f64) -> bool| -> Vec<f64> {
        s.velocity.iter().map(|v| if keep(*v) { *v } else { 0.0 }).collect()
    };
    let panel = |title: &str, column: &[f64]| Panel {
        title: title.into(),
        axes: ["time, s", "m/s"],
        lines: vec![Line::new("", BLUE, over(&s.time, column))],
        y: Some(-0.16..0.16),
        ..Panel::default()
    };
    Ok(Figure {
        id: "3-4",
        caption: "Example of how velocity is split into positive and negative components",
        panels: vec![
            panel("vel", &s.velocity),
            panel("vel_p", &part(|v| v > 0.0)),
            panel("vel_n", &part(|v| v < 0.0)),
        ],
        numbers: Vec::new(),
    })
}

/// A law and the signals it was fitted to.
struct Fitted {
    signals: Signals,
    found: Identification,
}

struct Both {
    karnopp: Fitted,
    dahl: Fitted,
}

/// Karnopp's law as fitted in [thesis, ch. 3.6]; Dahl's after the filter of tribos, because the encoder error is as long as a bristle.
fn fitted(material: &Material) -> Result<Both> {
    let s = recorded(material)?;
    let recording = Recording {
        name: material.name.into(),
        time: s.time,
        position: s.position,
        velocity: Some(s.velocity),
        acceleration: Some(s.acceleration),
        force: s.force,
        ..Recording::default()
    };
    let signals = prepare(&recording, &Preprocess::Thesis)?;
    let options = KarnoppOptions { delta_v: Some(material.law.delta_v), ..KarnoppOptions::default() };
    let karnopp = identify_karnopp(&signals, &options)?;
    let karnopp = Fitted { signals, found: karnopp };
    let signals = prepare(&recording, &Preprocess::default())?;
    let found = identify_dahl(&signals, &DahlOptions::default())?;
    Ok(Both { karnopp, dahl: Fitted { signals, found } })
}

/// Force without the inertia of the mass found.
fn friction(f: &Fitted) -> Vec<f64> {
    let mass = f.found.value("mass").unwrap_or(WEIGHED_BLOCK_MASS);
    f.signals.force.iter().zip(&f.signals.acceleration).map(|(force, a)| force - mass * a).collect()
}

/// Friction of a model along the recording.
fn modelled(f: &Fitted) -> Vec<f64> {
    Model { mass: 1e-9, ..Model::from(&f.found) }.predict_signals(&f.signals)
}

fn material_figure(
    id: &'static str,
    caption: &'static str,
    material: &Material,
    table_3_4: [&str; 5],
) -> Result<Figure> {
    let Both { karnopp, dahl } = fitted(material)?;
    let panel = |title: &str, f: &Fitted, y: &[f64], fit: Option<(&str, Vec<f64>)>| {
        let v = &f.signals.velocity;
        let mut lines = vec![Line::new("measured", GREY, over(v, y)).dots()];
        if let Some((name, fit)) = fit {
            lines.push(Line::new(name, ORANGE, over(v, &fit)).dots());
        }
        Panel { title: title.into(), axes: ["velocity, m/s", "N"], lines, ..Panel::default() }
    };
    let fit = |name, f: &Fitted| Some((name, modelled(f)));
    Ok(Figure {
        id,
        caption,
        panels: vec![
            panel("a) force", &karnopp, &karnopp.signals.force, None),
            panel("b) without inertia", &karnopp, &friction(&karnopp), fit("Karnopp", &karnopp)),
            panel("c) without inertia", &dahl, &friction(&dahl), fit("Dahl", &dahl)),
        ],
        numbers: numbers(material, [&karnopp.found, &dahl.found], table_3_4),
    })
}

fn numbers(material: &Material, [first, second]: [&Identification; 2], table_3_4: [&str; 5]) -> Vec<Number> {
    let told = |found: &Identification, name: &str| {
        found.parameters.get(name).map_or("not identifiable".to_owned(), |p| {
            format!("{} ± {}", digits(p.value, 4), digits(p.std, 2))
        })
    };
    let law = material.law;
    let karnopp = [
        ("mass", "m, kg", material.mass),
        ("coulomb_p", "C_p, N", law.c_p),
        ("viscous_p", "b_p, N·s/m", law.b_p),
        ("coulomb_n", "C_n, N", law.c_n),
        ("viscous_n", "b_n, N·s/m", law.b_n),
        ("static_p", "D_p, N", law.d_p),
        ("static_n", "D_n, N", law.d_n),
    ];
    let dahl = [
        ("mass", "Dahl m, kg"),
        ("viscous", "Dahl b, N·s/m"),
        ("limit_p", "Dahl D_p, N"),
        ("limit_n", "Dahl D_n, N"),
        ("sigma", "Dahl σ, N/m (thesis: by hand)"),
    ];
    let upper = karnopp.map(|(name, what, printed)| number(what, printed.to_string(), told(first, name)));
    let lower =
        dahl.iter().zip(table_3_4).map(|((name, what), printed)| number(*what, printed, told(second, name)));
    upper.into_iter().chain(lower).collect()
}

/// [thesis, fig. 3-5].
pub(crate) fn brass() -> Result<Figure> {
    let caption = "Aluminum sliding on brass. a) Measured force versus velocity. b) Force adjusted by inertia with Karnopp fit overlaid. c) Force adjusted by inertia with Dahl fit overlaid.";
    material_figure("3-5", caption, &materials::BRASS, ["0.4489", "-2.6071", "1.9078", "1.7296", "30000"])
}

/// [thesis, fig. 3-6].
pub(crate) fn teflon() -> Result<Figure> {
    let caption = "Aluminum sliding on Teflon. a) Measured force versus velocity. b) Force adjusted by inertia with Karnopp fit overlaid. c) Force adjusted by inertia with Dahl fit overlaid.";
    material_figure("3-6", caption, &materials::TEFLON, ["0.4633", "0.3838", "0.6389", "0.5774", "10000"])
}

/// [thesis, fig. 3-7].
pub(crate) fn rubber() -> Result<Figure> {
    let caption = "Aluminum sliding on rubber. a) Measured force versus velocity. b) Force adjusted by inertia with Karnopp fit overlaid. c) Force adjusted by inertia with Dahl fit overlaid.";
    material_figure("3-7", caption, &materials::RUBBER, ["0.3820", "9.9812", "3.3122", "2.4238", "50000"])
}

fn over_velocity(id: &'static str, caption: &'static str, f: &Fitted) -> Figure {
    let predicted = Model::from(&f.found).predict_signals(&f.signals);
    let v = &f.signals.velocity;
    Figure {
        id,
        caption,
        panels: vec![Panel {
            title: "aluminium on rubber, four cycles".into(),
            axes: ["velocity, m/s", "force, N"],
            lines: vec![
                Line::new("measured", GREY, over(v, &f.signals.force)).dots(),
                Line::new("predicted", GREEN, over(v, &predicted)).dots(),
            ],
            ..Panel::default()
        }],
        numbers: vec![number("relative error", "–", format!("{:.1} %", 100.0 * f.found.relative_error))],
    }
}

/// [thesis, fig. 3-8].
pub(crate) fn karnopp_over_velocity() -> Result<Figure> {
    let caption = "Typical measured force and Karnopp model predicted force versus velocity (aluminum on rubber) over four cycles of motion.";
    Ok(over_velocity("3-8", caption, &fitted(&materials::RUBBER)?.karnopp))
}

/// [thesis, fig. 3-9].
pub(crate) fn dahl_over_velocity() -> Result<Figure> {
    let caption = "Typical measured force and Dahl model predicted force versus velocity (aluminum on rubber) over four cycles of motion.";
    Ok(over_velocity("3-9", caption, &fitted(&materials::RUBBER)?.dahl))
}
