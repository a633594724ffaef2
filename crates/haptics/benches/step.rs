//! Time of one control step on this machine, for each renderer and law. Cycles on the target are measured on the ELF.
//!
//! `cargo bench -p haptics` prints the medians, then a summary in ns. An item is one control period. The motion of the exact
//! device [thesis, eq. 4.15] with encoder edges and times is recorded once, so that only the step is timed.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use haptics::{Control, Device, Excitation, Inputs, LawKind, RendererKind, Request, Settings, Wave};
use std::time::Instant;

const STEPS: u32 = 10_000;
/// 170 MHz over 1 ms.
const PERIOD_TICKS: u32 = 170_000;

/// Encoder readings of a hand that moves the handle back and forth by 8 mm once a second.
fn recording() -> Vec<Inputs> {
    let device = Device::default();
    let (tick, count) = (1.0 / f64::from(device.tick_hz), f64::from(device.metre_per_count));
    let x = |t: f64| 8e-3 * (core::f64::consts::TAU * t).sin();
    let speed = |t: f64| 8e-3 * core::f64::consts::TAU * (core::f64::consts::TAU * t).cos();
    let (mut last, mut edge_ticks) = (0_i64, 0_u32);
    (1..=STEPS)
        .map(|k| {
            let t = f64::from(k) * f64::from(PERIOD_TICKS) * tick;
            let now = (x(t) / count).floor() as i64;
            let sample_ticks = k.wrapping_mul(PERIOD_TICKS);
            if now != last {
                // the edge behind the handle, at its present speed
                let behind =
                    if now > last { x(t) - now as f64 * count } else { (now + 1) as f64 * count - x(t) };
                let age = (behind / speed(t).abs().max(1e-4) / tick).min(f64::from(PERIOD_TICKS) - 1.0);
                edge_ticks = sample_ticks.wrapping_sub(age as u32);
                last = now;
            }
            Inputs { sample_ticks, count: now as u32, edge_ticks, load_code: 32_768, accel_code: 32_768 }
        })
        .collect()
}

fn settings(renderer: RendererKind, law: LawKind, effects: u8) -> Settings {
    let mut settings = Settings {
        law,
        renderer,
        f_static_p: 3.5,
        f_static_n: 3.5,
        f_dynamic_p: 3.0,
        f_dynamic_n: 3.0,
        damping_p: 4.0,
        damping_n: 4.0,
        sigma: 8_000.0,
        ..Settings::rubber()
    };
    let four = [
        ("stribeck.force_p", "0.5"),
        ("cogging.cosine_1", "0.2"),
        ("presliding.force_p", "0.3"),
        ("offset.force", "0.1"),
    ];
    for (name, value) in four.iter().take(effects.into()) {
        settings.set(name, value).expect("a gain of the catalogue");
    }
    settings
}

/// Timed configurations by name.
#[derive(Debug, Clone, Copy)]
enum Job {
    Idle,
    Contact(RendererKind, LawKind, u8),
    Excite(Wave),
}

impl Job {
    fn all() -> Vec<Self> {
        let mut all = vec![Self::Idle];
        for &renderer in RendererKind::ALL {
            for &law in LawKind::ALL {
                all.push(Self::Contact(renderer, law, 0));
            }
            all.push(Self::Contact(renderer, LawKind::Karnopp, 4));
        }
        all.extend(Wave::ALL.iter().map(|&wave| Self::Excite(wave)));
        all
    }

    fn control(self, first: &Inputs) -> Control {
        let (settings, request) = match self {
            Self::Idle => (Settings::brass(), Request::Stop),
            Self::Contact(renderer, law, effects) => {
                (settings(renderer, law, effects), Request::Render(true))
            }
            Self::Excite(wave) => {
                let amplitude_m = 0.006;
                let move_ = Excitation { wave, amplitude_m, frequency_hz: 0.7, seconds: 0.0 };
                (Settings::brass(), Request::Excite(move_))
            }
        };
        let mut control = Control::referenced(settings.build(&Device::default()).expect("within the bounds"));
        let outputs = control.step(Some(&request), first);
        assert!(outputs.denied.is_none(), "{self}: {:?}", outputs.denied);
        control
    }
}

impl std::fmt::Display for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Idle => f.write_str("idle"),
            Self::Contact(renderer, law, 0) => write!(f, "{} {}", renderer.id(), law.id()),
            Self::Contact(renderer, law, effects) => {
                write!(f, "{} {} + {effects} effects", renderer.id(), law.id())
            }
            Self::Excite(wave) => write!(f, "excite {}", wave.id()),
        }
    }
}

/// Runs the recording once. Returns the number of steps with the amplifier on.
fn run(mut control: Control, recording: &[Inputs]) -> usize {
    recording.iter().filter(|inputs| control.step(None, black_box(inputs)).amplifier).count()
}

#[divan::bench(args = Job::all())]
fn control_step(bencher: Bencher, job: &Job) {
    let recording = recording();
    let (first, rest) = recording.split_first().expect("not empty");
    let control = job.control(first);
    bencher.counter(ItemsCount::new(STEPS - 1)).bench_local(|| run(black_box(control), rest));
}

#[divan::bench]
fn estimator(bencher: Bencher) {
    let recording = recording();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut estimator = haptics::Estimator::default();
        for i in &recording {
            estimator.sample(black_box(i.sample_ticks), i.count, i.edge_ticks);
        }
        estimator.counts_per_tick()
    });
}

fn main() {
    divan::main();
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let recording = recording();
    let (first, rest) = recording.split_first().expect("not empty");
    for job in Job::all() {
        let control = job.control(first);
        let (mut best, mut on) = (f64::INFINITY, 0);
        // the best of twenty: load on a shared machine only slows it down
        for _ in 0..20 {
            let began = Instant::now();
            on = run(black_box(control), rest);
            best = best.min(began.elapsed().as_secs_f64() * 1e9 / rest.len() as f64);
        }
        let share = 100.0 * on as f64 / rest.len() as f64;
        println!("{:38}: {best:5.1} ns a control step, force on in {share:.0} %", job.to_string());
    }
}
