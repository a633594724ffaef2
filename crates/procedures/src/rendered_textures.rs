//! Texture presets against what the device renders of them: with each renderer of a block, and with passivity control.

use crate::rendered::feel_with;
use crate::{Unwatched, library};
use compare::{Comparison, Kind, MARGIN, Measured, TextureComparison, Verdict, asked, compare};
use identify::Model;
use signals::Recording;
use std::path::Path;

/// A slow hand, for grain: m, Hz. A coupling passes what is slow against its own swing.
const SLOW: (f64, f64) = (0.012, 0.3);
/// A hand that runs through detents: a slow one halts in each of them.
const QUICK: (f64, f64) = (0.012, 0.6);

fn preset(name: &str) -> Model {
    library::read(Path::new(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn felt(model: &Model, hand: (f64, f64), seed: u64) -> Recording {
    let dir = tempfile::tempdir().expect("a folder");
    feel_with(hand, model, &dir.path().join("felt.csv"), seed, &Unwatched)
        .unwrap_or_else(|e| panic!("{}: {e}", model.name))
}

/// What `model` asks for against what was recorded.
fn judged(model: &Model, rendered: &Recording, bare: Option<&Measured>) -> Comparison {
    let real = asked(model, rendered).unwrap_or_else(|e| panic!("{}: {e}", model.name));
    let measured =
        |recording: &Recording| Measured::new(recording).unwrap_or_else(|e| panic!("{}: {e}", model.name));
    let c = compare(&measured(&real), &measured(rendered), bare, MARGIN)
        .unwrap_or_else(|e| panic!("{}: {e}", model.name));
    println!(
        "{}: friction {:.3} ({:.3?}), {:.2} JND, {:?}",
        model.name, c.ratio.value, c.ratio.ci95, c.distance.value, c.verdict
    );
    if let Some(t) = &c.texture {
        println!(
            "  texture {:.2} JND ({:.2?}), {:?}, periods {:.6?}, {:?}",
            t.distance.value, t.distance.ci95, t.verdict, t.period, t.kind
        );
        for d in &t.directions {
            println!(
                "  {}: asked {:.3} N, rendered {:.3} N, JND {:.3} N, ratio {:.3?}, overlap {:.4?}",
                d.direction,
                d.real,
                d.rendered,
                d.jnd,
                d.ratio.map(|r| r.ci95),
                d.overlap.map(|o| o.ci95)
            );
        }
    }
    c
}

fn texture(c: Comparison) -> TextureComparison {
    c.texture.expect("a texture")
}

fn ratio(t: &TextureComparison) -> f64 {
    let ratios: Vec<f64> = t.directions.iter().map(|d| d.ratio.expect("a ratio").value).collect();
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

#[test]
fn presets_are_felt_as_asked() {
    for (hand, names) in [(QUICK, ["washboard", "volume-knob", "ratchet", "selector"].as_slice()), (SLOW, &["corduroy", "wood-grain", "linen"])] {
    let bare = Measured::new(&felt(&preset("baseline"), hand, 77)).expect("the device alone");
    for name in names {
        for seed in [1, 2] {
            judged(&preset(name), &felt(&preset(name), hand, seed), Some(&bare));
        }
    }
    }
}

#[test]
fn twice_the_texture_is_different() {
    for (name, hand) in [("washboard", QUICK), ("volume-knob", QUICK), ("corduroy", SLOW), ("wood-grain", SLOW)] {
        let model = preset(name);
        let mut twice = model.clone();
        for effect in &mut twice.effects {
            effect.gains.iter_mut().for_each(|gain| *gain *= 2.0);
        }
        judged(&model, &felt(&twice, hand, 3), None);
    }
}

#[test]
fn the_admittance_renderer_is_judged() {
    for (name, hand) in [("corduroy", SLOW), ("wood-grain", SLOW), ("volume-knob", QUICK), ("brass-1", QUICK), ("rubber-1", QUICK)] {
        let mut model = preset(name);
        model.mass = 1.0;
        model.coupling.renderer = Some("admittance".into());
        (model.coupling.k_vc, model.coupling.b_vc) = (Some(30_000.0), Some(200.0));
        for seed in [1, 2] {
            judged(&model, &felt(&model, hand, seed), None);
        }
    }
}

#[test]
fn passivity_control_is_judged() {
    for (name, hand) in [("washboard", QUICK), ("volume-knob", QUICK), ("wood-grain", SLOW), ("brass-1", QUICK)] {
        let model = preset(name);
        for on in ["off", "on"] {
            let mut passive = model.clone();
            passive.coupling.passivity = Some(on.into());
            judged(&model, &felt(&passive, hand, 4), None);
        }
    }
}
