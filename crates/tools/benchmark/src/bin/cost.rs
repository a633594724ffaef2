//! Time and memory of a diagnosis from 25 000 to 1 000 000 samples, each in a process of its own:
//! `cargo run --release -p benchmark --bin cost -- cost.svg`
//!
//! The recording is a slide under Coulomb and Stribeck friction with a spring, driven by four sines, at 1 kHz.

use diagnose::{Options, diagnose};
use report::picture::{BLUE, GREY, Line, ORANGE, Panel, Picture, Scale, svg};
use signals::Recording;
use std::process::Command;
use std::time::Instant;

const SIZES: [usize; 6] = [25_000, 50_000, 100_000, 250_000, 500_000, 1_000_000];

fn recording(samples: usize) -> Recording {
    let mut r = Recording { name: format!("{samples} samples"), ..Recording::default() };
    let mut seed = 1u64;
    let mut noise = || {
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / 2f64.powi(24) - 0.5
        };
        draw() + draw() + draw() + draw()
    };
    let waves = [(8e-3, 5.1, 0.0), (4e-3, 11.3, 1.0), (1.5e-3, 23.9, 2.0), (4e-4, 67.0, 0.4)];
    for i in 0..samples {
        let t = i as f64 * 1e-3;
        let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, w, p) in waves {
            let (s, c) = (w * t + p).sin_cos();
            x += size * s;
            v += size * w * c;
            a -= size * w * w * s;
        }
        let level = 1.5 + 0.6 * (-(v / 0.02f64).powi(2)).exp();
        r.time.push(t);
        r.position.push(x + 5e-7 * noise());
        r.force.push(0.42 * a + level * v.signum() + 4.0 * v + 40.0 * x + 0.06 * noise());
    }
    r
}

/// Largest resident memory of this process, MB; 0 where the system does not say.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kb: Option<f64> = line.and_then(|l| l.split_whitespace().next()).and_then(|n| n.parse().ok());
    kb.unwrap_or(0.0) / 1000.0
}

/// CPU time of this process so far, s.
fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> = after.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    // the state, a letter, is not among them
    ticks.get(10).zip(ticks.get(11)).map_or(0.0, |(user, system)| (user + system) / 100.0)
}

fn one(samples: usize) {
    let recordings = [recording(samples)];
    let (began, before) = (Instant::now(), cpu());
    let found = diagnose(&recordings, &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
    let names: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
    let seconds = began.elapsed().as_secs_f64();
    println!("{seconds:.3} {:.3} {:.1} {}", cpu() - before, peak(), names.join("+"));
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(samples) = arguments.get(1).and_then(|a| a.parse().ok()) {
        return one(samples);
    }
    println!("   samples     wall s   on 2 cores s   n log n, s     MB   found");
    let mut rows: Vec<(f64, f64, f64)> = Vec::new();
    for samples in SIZES {
        let run = Command::new(&arguments[0]).arg(samples.to_string()).output().expect("this program again");
        let text = String::from_utf8_lossy(&run.stdout).into_owned();
        let mut words = text.split_whitespace();
        let mut number = || words.next().and_then(|w| w.parse::<f64>().ok()).unwrap_or(f64::NAN);
        let (wall, cpu, mb) = (number(), number(), number());
        // a machine that does other things gives fewer than two cores: the work done, spread over two
        let two = (0.5 * cpu).max(f64::MIN_POSITIVE);
        let n = samples as f64;
        rows.push((n, two, mb));
        let fair = rows[0].1 * n * n.ln() / (rows[0].0 * rows[0].0.ln());
        println!("{samples:10} {wall:10.2} {two:14.2} {fair:12.2} {mb:6.0}   {}", words.next().unwrap_or(""));
    }
    if let Some(path) = arguments.get(1) {
        std::fs::write(path, svg(&plot(&rows)).expect("a drawing")).expect("room for the plot");
        println!("{path}");
    }
}

/// Time and memory over samples.
fn plot(rows: &[(f64, f64, f64)]) -> Picture {
    let first = rows.first().copied().unwrap_or((1.0, 1.0, 1.0));
    let fair = |n: f64| first.1 * n * n.ln() / (first.0 * first.0.ln());
    let line = |name, colour, of: &dyn Fn(&(f64, f64, f64)) -> f64| {
        Line::new(name, colour, rows.iter().map(|r| (r.0, of(r))).collect())
    };
    let panel = |title: &str, y, lines| Panel {
        title: title.into(),
        axes: ["samples", y],
        scale: Scale::Logarithmic,
        lines,
        ..Panel::default()
    };
    Picture::of(vec![
        panel(
            "time of a diagnosis",
            "s on two cores",
            vec![line("measured", BLUE, &|r| r.1), line("n log n", GREY, &|r| fair(r.0))],
        ),
        panel("largest memory of a diagnosis", "MB", vec![line("measured", ORANGE, &|r| r.2)]),
    ])
}
