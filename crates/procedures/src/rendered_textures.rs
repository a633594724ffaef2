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

/// Rendered over asked period, less one.
fn stretch(t: &TextureComparison) -> f64 {
    t.period_ratio.expect("two periods").value - 1.0
}

/// The coupling passes a texture as its own swing lets it: at ω against ω₀ the block's inertia adds (ω/ω₀)². A washboard at
/// 75 mm/s is felt a tenth too strong, and steep teeth that the hand jumps over too weak.
#[test]
fn presets_are_felt_as_asked() {
    let quick = [
        ("washboard", 1.05, 1.15),
        ("volume-knob", 0.98, 1.1),
        ("ratchet", 0.8, 0.97),
        ("selector", 0.9, 1.0),
    ];
    let slow = [("corduroy", 1.0, 1.08), ("wood-grain", 0.97, 1.05), ("linen", 0.85, 1.1)];
    for (hand, names) in [(QUICK, quick.as_slice()), (SLOW, slow.as_slice())] {
        let bare = Measured::new(&felt(&preset("baseline"), hand, 77)).expect("the device alone");
        for (name, low, high) in names {
            for seed in [1, 2] {
                let model = preset(name);
                let c = judged(&model, &felt(&model, hand, seed), Some(&bare));
                if hand == SLOW {
                    assert_eq!(c.verdict, Verdict::Same, "{name}: {:?}", c.ratio);
                }
                let t = texture(c);
                let ratio = ratio(&t);
                assert!(ratio > *low && ratio < *high, "{name}: {ratio}");
                assert!(stretch(&t).abs() < 0.01 && t.distance.ci95[1] < 1.6, "{name}: {t:?}");
                let [asked, felt] = t.kind;
                assert!(felt.is_none_or(|kind| Some(kind) == asked), "{name}: {:?}", t.kind);
                if name == &"washboard" {
                    assert_eq!((asked, t.verdict), (Some(Kind::Force), Verdict::Different));
                }
            }
        }
    }
}

#[test]
fn presets_without_texture_show_none() {
    for name in ["ice", "teflon-2", "rubber-1", "viscous-damping", "brass-2", "rubber-2"] {
        let model = preset(name);
        let c = judged(&model, &felt(&model, QUICK, 5), None);
        assert!(c.texture.is_none(), "{name}: {:?}", c.texture);
    }
}

#[test]
fn twice_the_texture_is_different() {
    for (name, hand) in [("washboard", QUICK), ("corduroy", SLOW), ("wood-grain", SLOW)] {
        let model = preset(name);
        let mut twice = model.clone();
        for effect in &mut twice.effects {
            effect.gains.iter_mut().for_each(|gain| *gain *= 2.0);
        }
        let c = judged(&model, &felt(&twice, hand, 3), None);
        assert_eq!(c.overall(), Verdict::Different);
        let t = texture(c);
        assert!(
            t.verdict == Verdict::Different && t.distance.ci95[0] > 2.0 && ratio(&t) > 1.9,
            "{name}: {t:?}"
        );
    }
}

/// The load cell moves the block, so the hand does not feel the device, and nothing is to be taken off. The handle follows
/// a block of 1 kg with 30 kN/m; the coupling of the presets, 8 kN/m, shakes below that mass.
#[test]
fn admittance_renderer_is_judged() {
    for (name, hand) in [("corduroy", SLOW), ("wood-grain", SLOW), ("volume-knob", QUICK), ("brass-1", QUICK)]
    {
        let mut model = preset(name);
        model.mass = 1.0;
        model.coupling.renderer = Some("admittance".into());
        (model.coupling.k_vc, model.coupling.b_vc) = (Some(30_000.0), Some(200.0));
        for seed in [1, 2] {
            let c = judged(&model, &felt(&model, hand, seed), None);
            assert_eq!(c.verdict, Verdict::Same, "{name}: {:?}", c.ratio);
            if name == "brass-1" {
                assert!(c.texture.is_none() && c.overall() == Verdict::Same);
                continue;
            }
            let t = texture(c);
            assert!(stretch(&t).abs() < 0.005 && t.distance.ci95[1] < 1.0, "{name}: {t:?}");
            assert!(name != "wood-grain" || t.verdict == Verdict::Same, "{t:?}");
        }
    }
}

/// Energy of a detent is not among what the controller knows to be stored: it takes a detent's for the renderer's own and
/// brakes where the detent pulls. Friction gives none, and stays as it is.
#[test]
fn passivity_control_takes_from_detents_and_leaves_grain() {
    for (name, hand) in
        [("washboard", QUICK), ("volume-knob", QUICK), ("wood-grain", SLOW), ("brass-1", QUICK)]
    {
        let model = preset(name);
        let [off, on] = ["off", "on"].map(|passivity| {
            let mut passive = model.clone();
            passive.coupling.passivity = Some(passivity.into());
            judged(&model, &felt(&passive, hand, 4), None)
        });
        match name {
            "brass-1" => {
                assert!(off.texture.is_none() && on.texture.is_none());
                assert!((on.ratio.value - off.ratio.value).abs() < 0.002);
            }
            "wood-grain" => assert!((ratio(&texture(on)) - ratio(&texture(off))).abs() < 0.005),
            _ => {
                let (on, off) = (texture(on), texture(off));
                assert!(ratio(&on) < 0.9 * ratio(&off), "{name}: {on:?}");
                assert_eq!(on.verdict, Verdict::Different, "{name}");
            }
        }
    }
}
