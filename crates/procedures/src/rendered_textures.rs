//! Texture presets against what the device renders of them, with every renderer for a block and with passivity control.

use crate::Unwatched;
use crate::library;
use crate::rendered::feel;
use compare::{Comparison, MARGIN, Measured, asked, compare};
use signals::Recording;
use std::path::Path;

/// A hand feels the preset, rendered by `renderer`.
fn felt(preset: &str, renderer: &str, passivity: &str, times: f64, seed: u64) -> Recording {
    let mut model = library::read(Path::new(preset)).unwrap_or_else(|e| panic!("{preset}: {e}"));
    model.coupling.renderer = Some(renderer.into());
    model.coupling.passivity = Some(passivity.into());
    for effect in &mut model.effects {
        effect.gains.iter_mut().for_each(|gain| *gain *= times);
    }
    let dir = tempfile::tempdir().expect("a folder");
    feel(&model, &dir.path().join("felt.csv"), seed, &Unwatched)
        .unwrap_or_else(|e| panic!("{preset}, {renderer}, passivity {passivity}: {e}"))
}

fn judged(preset: &str, rendered: &Recording) -> Comparison {
    let model = library::read(Path::new(preset)).expect("a preset");
    let real = asked(&model, rendered).unwrap_or_else(|e| panic!("{preset}: {e}"));
    let measured =
        |recording: &Recording| Measured::new(recording).unwrap_or_else(|e| panic!("{preset}: {e}"));
    compare(&measured(&real), &measured(rendered), None, MARGIN).unwrap_or_else(|e| panic!("{preset}: {e}"))
}

#[test]
fn explore() {
    for preset in [
        "washboard",
        "ratchet",
        "volume-knob",
        "selector",
        "corduroy",
        "wood-grain",
        "linen",
        "ice-with-grit",
        "file",
        "ball-slide",
    ] {
        for (renderer, passivity) in [
            ("stopping_force", "off"),
            ("stopping_force", "on"),
            ("admittance", "off"),
            ("admittance", "on"),
            ("virtual_coupling", "off"),
        ] {
            let r = std::panic::catch_unwind(|| judged(preset, &felt(preset, renderer, passivity, 1.0, 1)));
            match r {
                Ok(c) => {
                    println!(
                        "{preset:12} {renderer:16} {passivity:3} friction {:.3?} {:?} D {:.2}",
                        c.ratio.ci95, c.verdict, c.distance.value
                    );
                    if let Some(t) = &c.texture {
                        println!(
                            "     texture {:.2} JND {:.2?} {:?} periods {:?} {:?} kind {:?}",
                            t.distance.value,
                            t.distance.ci95,
                            t.verdict,
                            t.period,
                            t.period_ratio.map(|r| r.ci95),
                            t.kind
                        );
                        for d in &t.directions {
                            println!(
                                "     {} real {:.3} rendered {:.3} jnd {:.3} ratio {:.3?} overlap {:.4?}",
                                d.direction,
                                d.real,
                                d.rendered,
                                d.jnd,
                                d.ratio.map(|r| r.ci95),
                                d.overlap.map(|o| o.ci95)
                            );
                        }
                    } else {
                        println!("     no texture: {:?}", c.notes);
                    }
                }
                Err(_) => println!("{preset:12} {renderer:16} {passivity:3} FAILED"),
            }
        }
    }
}

#[test]
fn masses() {
    for preset in ["washboard", "corduroy", "wood-grain"] {
        for (mass, k, b) in [(0.5, 8000.0, 60.0), (0.5, 16000.0, 120.0), (1.0, 8000.0, 60.0), (1.0, 8000.0, 120.0), (1.0, 16000.0, 120.0), (1.0, 30000.0, 200.0)] {
            let r = std::panic::catch_unwind(|| {
                let mut model = library::read(Path::new(preset)).expect("it");
                model.coupling.renderer = Some("admittance".into());
                model.mass = mass;
                (model.coupling.k_vc, model.coupling.b_vc) = (Some(k), Some(b));
                let dir = tempfile::tempdir().expect("a folder");
                let rec = feel(&model, &dir.path().join("felt.csv"), 1, &Unwatched)
                    .unwrap_or_else(|e| panic!("{preset} {mass}: {e}"));
                let real = asked(&model, &rec).unwrap_or_else(|e| panic!("{preset}: {e}"));
                let measured = |recording: &Recording| {
                    Measured::new(recording).unwrap_or_else(|e| panic!("{preset} {mass}: {e}"))
                };
                compare(&measured(&real), &measured(&rec), None, MARGIN)
                    .unwrap_or_else(|e| panic!("{preset}: {e}"))
            });
            match r {
                Ok(c) => {
                    println!(
                        "OUT {preset:12} {mass} {k} {b} friction {:.3?} {:?} D {:.2} mass {:?}",
                        c.ratio.ci95, c.verdict, c.distance.value, c.mass
                    );
                    if let Some(t) = &c.texture {
                        println!(
                            "OUT     texture {:.2} JND {:.2?} {:?} periods {:?} kind {:?}",
                            t.distance.value, t.distance.ci95, t.verdict, t.period, t.kind
                        );
                        for d in &t.directions {
                            println!(
                                "OUT     {} real {:.3} rendered {:.3} jnd {:.3} ratio {:.3?} overlap {:.4?}",
                                d.direction,
                                d.real,
                                d.rendered,
                                d.jnd,
                                d.ratio.map(|r| r.ci95),
                                d.overlap.map(|o| o.ci95)
                            );
                        }
                    }
                }
                Err(e) => println!("OUT {preset:12} {mass} {k} {b} FAILED {:?}", e.downcast_ref::<String>()),
            }
        }
    }
}
