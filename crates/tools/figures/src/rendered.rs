//! Real against rendered: a block that is there, and the device's control step that pretends there is one.

use crate::figure::{Error, Figure, Result, number};
use friction::{Coulomb, Custom, Law, Motion};
use haptics::{Control, Device, LawKind, Request, Settings};
use plant::{Coupling, Hand, Rig, RigConfig};
use report::picture::{GREY, Line, ORANGE, Panel};
use tribos_firmware::board::simulated::inputs;

/// [thesis, fig. 4-15]: 1 kg and roughly 2 N.
const MASS: f64 = 1.0;
const FRICTION: f64 = 2.0;
const SECONDS: f64 = 3.0;
/// After the hand has taken the handle and the motion has become periodic, s.
const SETTLED: f64 = 1.0;

/// A hand that moves 10 mm to and fro, once a second, and gives way.
fn hand(t: f64, x: f64, v: f64) -> f64 {
    let since = (t - 0.2).max(0.0);
    let grown = (since / 0.3).min(1.0);
    let to = 0.01 * grown * grown * (std::f64::consts::TAU * since).sin();
    1_500.0 * (to - x) - 15.0 * v
}

fn coulomb() -> Coulomb<f64> {
    Coulomb {
        level_p: FRICTION,
        level_n: FRICTION,
        static_p: FRICTION,
        static_n: FRICTION,
        viscous_p: 0.0,
        viscous_n: 0.0,
    }
}

/// Velocity and force at the load cell of a real block bolted to the handle.
fn real() -> Result<Vec<(f64, f64)>> {
    let config = RigConfig { block_mass: MASS, coupling: Coupling::Rigid, ..RigConfig::noiseless() };
    let mut rig = Rig::new(config, Law::Coulomb(coulomb()), 1)?;
    let mut felt = Vec::new();
    while rig.truth().time < SECONDS {
        rig.tick(0.0, &mut hand as &mut dyn Hand);
        let t = rig.truth();
        if t.time > SETTLED {
            felt.push((t.velocity, t.force_at_load_cell));
        }
    }
    Ok(felt)
}

/// Velocity and force of the renderer, its sign turned: what the hand has to overcome.
fn simulated() -> Result<Vec<(f64, f64)>> {
    let device = Device { delay: 20e-6, ..Device::default() };
    let settings = Settings {
        law: LawKind::Coulomb,
        f_static_p: FRICTION as f32,
        f_static_n: FRICTION as f32,
        f_dynamic_p: FRICTION as f32,
        f_dynamic_n: FRICTION as f32,
        damping_p: 0.0,
        damping_n: 0.0,
        mass: MASS as f32,
        ..Settings::teflon()
    };
    let config = RigConfig { actuation_delay: 0, ..RigConfig::free_handle() };
    let free = Custom(|_: &Motion<f64>| 0.0);
    let mut rig = Rig::new(config, free, 2)?;
    let mut control = Control::referenced(settings.build(&device)?);
    let mut sensors = rig.sensors();
    let mut felt = Vec::new();
    let mut step = 0_u32;
    while rig.truth().time < SECONDS {
        let request = (step == 100).then_some(Request::Render(true));
        let out = control.step(request.as_ref(), &inputs(&sensors));
        if let Some(kind) = out.fault {
            return Err(Error::Stopped(kind));
        }
        let t = rig.truth();
        if t.time > SETTLED {
            felt.push((t.velocity, -f64::from(out.force)));
        }
        sensors = rig.tick(f64::from(out.force), &mut hand);
        step += 1;
    }
    Ok(felt)
}

/// Half the mean distance of the branches above half the top speed, N.
fn level(felt: &[(f64, f64)]) -> f64 {
    let top = felt.iter().map(|p| p.0.abs()).fold(0.0, f64::max);
    let fast: Vec<f64> = felt.iter().filter(|p| p.0.abs() > 0.8 * top).map(|p| p.1 * p.0.signum()).collect();
    fast.iter().sum::<f64>() / fast.len().max(1) as f64
}

/// [thesis, fig. 4-15].
pub(crate) fn real_and_simulated() -> Result<Figure> {
    let (real, simulated) = (real()?, simulated()?);
    let numbers = vec![
        number("friction of the real block, N", "roughly 2", format!("{:.2}", level(&real))),
        number("friction of the rendered block, N", "roughly 2", format!("{:.2}", level(&simulated))),
    ];
    Ok(Figure {
        id: "4-15",
        caption: "Force velocity plots of real friction and simulated friction. These results are for Aluminum sliding on Teflon. The inertia of the system is 1kg and the friction force is roughly 2N.",
        panels: vec![Panel {
            title: "1 kg, 2 N, moved 10 mm at 1 Hz".into(),
            axes: ["velocity, m/s", "force, N"],
            lines: vec![
                Line::new("real block (simulated rig)", GREY, real),
                Line::new("rendered by the control step", ORANGE, simulated).dots(),
            ],
            ..Panel::default()
        }],
        numbers,
    })
}
