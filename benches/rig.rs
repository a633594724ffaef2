//! How fast the simulated rig and the renderer run together: control steps a second on one core.
//!
//! `cargo bench --bench rig` prints every variant (an item is one control period: sensors with noise, the
//! control step, and 10 or 20 integration steps of the rig) and a closing line against the bar of the design,
//! 1 000 000 a second. `cargo bench --bench rig -- --test` runs each once.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use friction::{Custom, Motion};
use haptics::{Control, Device, Request, Settings};
use plant::{HandImpedance, Rig, RigConfig, Target};
use std::time::Instant;
use tribos_firmware::board::simulated::inputs;

/// Control periods in one run: 10 s of the rig's time.
const STEPS: u32 = 10_000;
const BAR: f64 = 1e6;

type Surface = fn(&Motion<f64>) -> f64;

/// The rig with a hand on it, and the firmware's control step rendering brass by virtual coupling.
struct Rendered {
    rig: Rig<Custom<Surface>>,
    control: Control,
    hand: HandImpedance,
    force: f64,
}

impl Rendered {
    fn new(substeps: u32) -> Self {
        let device = Device::default();
        let config = Settings::brass().build(&device).expect("preset within the bounds");
        let rig_config = RigConfig { substeps, block_mass: 0.0, ..RigConfig::default() };
        let rig = Rig::new(rig_config, Custom((|_| 0.0) as Surface), 1).expect("thesis rig");
        let mut control = Control::referenced(config);
        control.step(Some(&Request::Render(true)), &inputs(&rig.sensors()));
        // slides, turns and sticks: 8 mm to and fro, once a second
        let target = Target::Sine { centre: 0.0, amplitude: 0.008, frequency: 1.0 };
        let hand = HandImpedance { stiffness: 1500.0, damping: 15.0, ..HandImpedance::relaxed(target) };
        Self { rig, control, hand, force: 0.0 }
    }

    /// One run; returns how often the virtual block was stuck.
    fn run(&mut self) -> u32 {
        let mut stuck = 0;
        for _ in 0..STEPS {
            let sensors = self.rig.tick(self.force, &mut self.hand);
            let outputs = self.control.step(None, &inputs(&sensors));
            self.force = f64::from(outputs.force);
            stuck += u32::from(outputs.stuck);
        }
        let fault = self.control.state().fault();
        assert!(fault.is_none(), "the loop stopped rendering: {fault:?}");
        stuck
    }
}

#[divan::bench(args = [10, 20])]
fn rig_and_renderer(bencher: Bencher, substeps: u32) {
    let mut rendered = Rendered::new(substeps);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| black_box(rendered.run()));
}

/// A real block on a sliding surface, driven open loop: the plant without the renderer.
#[divan::bench(args = [10, 20])]
fn rig_with_block(bencher: Bencher, substeps: u32) {
    let material = plant::materials::BRASS;
    let config = RigConfig { substeps, block_mass: material.mass, ..RigConfig::default() };
    let mut rig = Rig::new(config, material.law, 1).expect("thesis rig");
    let mut hand = HandImpedance::relaxed(Target::Sine { centre: 0.0, amplitude: 0.01, frequency: 1.0 });
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for _ in 0..STEPS {
            black_box(rig.tick(black_box(1.0), &mut hand));
        }
    });
}

/// Drawing a 2 s recording with the noise of [thesis, table 3-2] from an experiment simulated once.
#[divan::bench]
fn thesis_recording(bencher: Bencher) {
    let experiment = plant::ThesisExperiment::on(&plant::materials::RUBBER).expect("printed parameters");
    let mut seed = 0;
    bencher.counter(ItemsCount::new(1u32)).bench_local(|| {
        seed += 1;
        black_box(experiment.recording(seed))
    });
}

fn main() {
    divan::main();
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    for substeps in [10, 20] {
        let mut rendered = Rendered::new(substeps);
        let mut stuck = 0;
        // the best of ten: a shared machine only ever makes it slower
        let best = (0..10)
            .map(|_| {
                let began = Instant::now();
                stuck = rendered.run();
                f64::from(STEPS) / began.elapsed().as_secs_f64()
            })
            .fold(0.0, f64::max);
        println!(
            "{substeps} integration steps: {:.2} million control steps a second on one core, bar {:.0} million ({}); block stuck {:.0} % of the time",
            best / 1e6,
            BAR / 1e6,
            if best > BAR { "met" } else { "NOT met" },
            100.0 * f64::from(stuck) / f64::from(STEPS),
        );
    }
}
