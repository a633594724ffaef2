//! What a rendered block feels like: the ELF against an independent run of the loop on this machine, and against a real
//! block on a real spring, in continuous time and without noise.

use crate::board::Board;
use crate::plot;
use crate::track::{Track, run_to, seconds};
use friction::{Karnopp, Law};
use haptics::{Control, Device, Request, Settings};
use link::Sample;
use plant::{Coupling, Hand, Rig, RigConfig, Sensor};
use report::picture::{BLUE, GREEN, GREY, Line, ORANGE, Panel};
use tribos_firmware::board::simulated::inputs;

const COUNT: f64 = 2.57e-6;
/// Measurement error of force and of velocity [thesis, table 3-2]: N, m/s.
const FORCE_NOISE: f64 = 0.062;
const VELOCITY_NOISE: f64 = 3.18e-3;
/// The hand takes the handle, s; the block is on it by then.
const START: f64 = 0.3;
const END: f64 = 2.8;
/// After the motion has become periodic, s.
const SETTLED: f64 = 0.8;

/// A hand that moves 8 mm to and fro, once and a half a second, and gives way.
fn hand(t: f64, x: f64, v: f64) -> f64 {
    let since = t - START;
    if since < 0.0 {
        return 0.0;
    }
    let grown = (since / 0.3).min(1.0);
    let to = 0.008 * grown * grown * (std::f64::consts::TAU * 1.5 * since).sin();
    1_500.0 * (to - x) - 15.0 * v
}

/// Time s, velocity m/s, force on the handle N.
type Felt = (f64, f64, f64);

/// The value at a time, between samples.
fn at(series: &[Felt], t: f64) -> Option<(f64, f64)> {
    let k = series.partition_point(|s| s.0 <= t);
    let (a, b) = (series.get(k.checked_sub(1)?)?, series.get(k)?);
    let u = (t - a.0) / (b.0 - a.0);
    Some((a.1 + u * (b.1 - a.1), a.2 + u * (b.2 - a.2)))
}

/// What the ELF made of it, from what it streamed.
fn on_the_device(preset: &str) -> Vec<Felt> {
    let mut board = Board::ready();
    board.ok(&format!("preset use {preset}"));
    board.ok("render on");
    board.ok("stream on");
    let track = Track::default();
    board.machine.set_hand(track.of(hand));
    run_to(&mut board, END + 0.05);
    let samples: Vec<Sample> = board.samples().map(|(_, s)| s).collect();
    assert!(samples.windows(2).all(|w| w[1].step == w[0].step.wrapping_add(1)), "a frame was lost");
    let moving: Vec<Sample> = samples.iter().copied().filter(|s| seconds(s) > START).collect();
    let shift = track.shift(&moving, COUNT);
    let felt = moving.iter().filter_map(|s| {
        let t = seconds(s) + shift;
        Some((t, track.at(t)?.1, f64::from(s.force)))
    });
    felt.collect()
}

/// The same crates against the rig on this machine: another seed, other sampling instants.
fn on_the_host(preset: &str) -> Vec<Felt> {
    let config = RigConfig { actuation_delay: 0, ..RigConfig::free_handle() };
    let mut rig =
        Rig::new(config, friction::Custom(|_: &friction::Motion<f64>| 0.0), 4_711).expect("the rig");
    let settings = Settings::preset(preset).expect("built in");
    let mut control = Control::referenced(settings.build(&Device::default()).expect("fits the rig"));
    let mut felt = Vec::new();
    let mut sensors = rig.sensors();
    while rig.truth().time < END + 0.05 {
        let request = (felt.len() == 100).then_some(Request::Render(true));
        let outputs = control.step(request.as_ref(), &inputs(&sensors));
        assert_eq!((outputs.denied, outputs.fault), (None, None));
        felt.push((rig.truth().time, rig.truth().velocity, f64::from(outputs.force)));
        sensors = rig.tick(f64::from(outputs.force), &mut hand);
    }
    felt
}

/// A block that is there, on a spring and a damper like the virtual coupling's: no sampling, no counts, no noise.
fn for_real(preset: &str) -> (Vec<Felt>, Karnopp<f64>) {
    let s = Settings::preset(preset).expect("built in");
    let wide = |x: f32| f64::from(x);
    let law = Karnopp {
        c_p: wide(s.f_dynamic_p),
        c_n: wide(s.f_dynamic_n),
        b_p: wide(s.damping_p),
        b_n: wide(s.damping_n),
        d_p: wide(s.f_static_p),
        d_n: wide(s.f_static_n),
        delta_v: wide(s.dv),
    };
    let ideal = Sensor { noise: 0.0, gain: 1.0, offset: 0.0 };
    let config = RigConfig {
        block_mass: wide(s.mass),
        coupling: Coupling::Compliant { stiffness: wide(s.k_vc), damping: wide(s.b_vc) },
        // steps of 2 µs: continuous beside a loop of 1 ms
        period_ticks: 17_000,
        substeps: 50,
        load: ideal,
        accel: ideal,
        ..RigConfig::free_handle()
    };
    let mut rig = Rig::new(config, Law::Karnopp(law), 1).expect("the rig");
    let mut felt = Vec::new();
    while rig.truth().time < END + 0.05 {
        rig.tick(0.0, &mut hand as &mut dyn Hand);
        let t = rig.truth();
        felt.push((t.time, t.velocity, -t.force_at_load_cell));
    }
    (felt, law)
}

/// How far two runs are apart.
struct Apart {
    /// rms of the difference in force at equal times, N.
    force: f64,
    /// rms of the distance between the curves of force over velocity, in sensor noises of both.
    overlay: f64,
    /// Largest such distance.
    worst: f64,
}

fn apart(these: &[Felt], those: &[Felt]) -> Apart {
    let (mut force, mut overlay, mut worst, mut n) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for (t, v, f) in these.iter().filter(|s| s.0 > START + SETTLED && s.0 < END) {
        let (_, other) = at(those, *t).expect("longer");
        force += (f - other) * (f - other);
        // the nearest point of the other curve, less than two periods away
        let nearest = (-20..=20)
            .filter_map(|k| at(those, t + 1e-4 * f64::from(k)))
            .map(|(w, g)| ((v - w) / VELOCITY_NOISE).hypot((f - g) / FORCE_NOISE))
            .fold(f64::INFINITY, f64::min);
        overlay += nearest * nearest;
        worst = worst.max(nearest);
        n += 1.0;
    }
    Apart { force: (force / n).sqrt(), overlay: (overlay / n).sqrt(), worst }
}

pub fn elf_rendering_matches_host_and_continuous_block() {
    let mut panels = Vec::new();
    println!("           | ELF and host: at equal times, curves apart | ELF and a block on a spring");
    for name in ["rubber", "brass", "teflon"] {
        let elf = on_the_device(name);
        let host = on_the_host(name);
        let (real, law) = for_real(name);
        let (to_host, to_real) = (apart(&elf, &host), apart(&elf, &real));
        println!(
            "{name:10} | {:.3} N rms, {:.2} sensor noises rms, {:.1} at most | {:.3} N rms, {:.2} sensor noises rms, {:.1} at most",
            to_host.force, to_host.overlay, to_host.worst, to_real.force, to_real.overlay, to_real.worst
        );
        let points = |felt: &[Felt], every: usize| -> Vec<(f64, f64)> {
            let shown = felt.iter().filter(|s| s.0 > START + SETTLED && s.0 < START + SETTLED + 2.0 / 1.5);
            shown.step_by(every).map(|s| (1e3 * s.1, -s.2)).collect()
        };
        let reach = elf.iter().filter(|s| s.0 > START + SETTLED).fold(0.0_f64, |m, s| m.max(s.1.abs()));
        let sliding = |v: f64| if v > 0.0 { law.c_p + law.b_p * v } else { -law.c_n + law.b_n * v };
        let lawful = [-reach, -law.delta_v, law.delta_v, reach].map(|v| (1e3 * v, sliding(v)));
        panels.push(Panel {
            title: format!("{name}, rendered"),
            axes: ["velocity of the handle, mm/s", "force against the hand, N"],
            lines: vec![
                Line::new("law (sliding)", GREY, lawful.to_vec()),
                Line::new("block on a spring, no noise", GREEN, points(&real, 20)),
                Line::new("host", ORANGE, points(&host, 2)),
                Line::new("ELF in the emulator", BLUE, points(&elf, 4)).dots(),
            ],
            ..Panel::default()
        });
        assert!(to_host.force < FORCE_NOISE && to_host.overlay < 1.0, "{name}: ELF and host");
        assert!(to_real.force < FORCE_NOISE && to_real.overlay < 1.0, "{name}: ELF and a block on a spring");
    }
    println!("{}", plot::write("rendering", panels).display());
}
