//! Cost of one control period of the simulated rig, 20 integration steps, by what is attached to it.
//!
//! `cargo bench -p plant`; an item is one control period.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use friction::{Custom, FrictionLaw, Motion};
use plant::{Coupling, Hand, HandImpedance, NoHand, Rig, RigConfig, Target, materials};

const STEPS: u32 = 2_000;

fn hold() -> HandImpedance {
    HandImpedance::relaxed(Target::Hold { position: 0.002 })
}

fn sine() -> HandImpedance {
    HandImpedance::relaxed(Target::Sine { centre: 0.0, amplitude: 0.008, frequency: 1.0 })
}

fn none() -> Custom<fn(&Motion<f64>) -> f64> {
    Custom(|_| 0.0)
}

fn ticks<L: FrictionLaw<f64>>(bencher: Bencher, config: RigConfig, law: L, hand: &mut dyn Hand) {
    let mut rig = Rig::new(config, law, 1).expect("within range");
    let mut k = 0_u32;
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for _ in 0..STEPS {
            // pushes back and forth: slides, reverses and sticks
            k = k.wrapping_add(1);
            let command = if k & 256 == 0 { 3.0 } else { -3.0 };
            black_box(rig.tick(black_box(command), hand));
        }
    });
}

#[divan::bench]
fn a_free_handle_nobody_holds(bencher: Bencher) {
    ticks(bencher, RigConfig::free_handle(), none(), &mut NoHand);
}

#[divan::bench]
fn b_held_still(bencher: Bencher) {
    ticks(bencher, RigConfig::free_handle(), none(), &mut hold());
}

#[divan::bench]
fn c_hand_on_a_sine(bencher: Bencher) {
    ticks(bencher, RigConfig::free_handle(), none(), &mut sine());
}

#[divan::bench]
fn d_with_friction_of_the_guide(bencher: Bencher) {
    ticks(bencher, RigConfig { block_mass: 0.0, ..RigConfig::default() }, none(), &mut sine());
}

#[divan::bench]
fn e_with_a_block_on_brass(bencher: Bencher) {
    let material = materials::BRASS;
    ticks(
        bencher,
        RigConfig { block_mass: material.mass, ..RigConfig::default() },
        material.law,
        &mut sine(),
    );
}

#[divan::bench]
fn f_with_a_compliant_coupling(bencher: Bencher) {
    let material = materials::BRASS;
    let coupling = Coupling::Compliant { stiffness: 1e5, damping: 20.0 };
    let config = RigConfig { block_mass: material.mass, coupling, ..RigConfig::default() };
    ticks(bencher, config, material.law, &mut sine());
}

#[divan::bench]
fn g_without_noise(bencher: Bencher) {
    ticks(bencher, RigConfig { block_mass: 0.0, ..RigConfig::noiseless() }, none(), &mut sine());
}

fn main() {
    divan::main();
}
