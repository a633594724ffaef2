//! Times one step of every law on the microcontroller by its own cycle counter. `cargo test --test elf -- --nocapture
//! cycles_of_every_law` builds it, runs it on the emulated board and prints the table.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(unsafe_code)]

#[cfg(target_os = "none")]
#[path = "../tests/elf/law_names.rs"]
mod law_names;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("runs on the board: cargo test --test elf -- --nocapture cycles_of_every_law");
}

#[cfg(target_os = "none")]
mod board {
    use crate::law_names::{COLUMNS, DONE, NAMES};
    use core::hint::black_box;
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use cortex_m::peripheral::DWT;
    use defmt_rtt as _;
    use embassy_stm32 as _;
    use friction::*;
    // what copies the functions in CCM SRAM at the start
    use tribos_firmware as _;

    /// What the test reads out of RAM.
    #[used] // in one piece
    static LAW_CYCLES: [AtomicU32; COLUMNS * NAMES.len() + 1] =
        [const { AtomicU32::new(0) }; COLUMNS * NAMES.len() + 1];
    const STEPS: u32 = 1_500;
    const DT: f32 = 1e-3;

    /// A stroke at 2 Hz with a ripple that reverses within it, and a rest of 0.2 s: every branch is taken.
    fn position(k: u32) -> f32 {
        let t = DT * k.min(700).max(k.saturating_sub(200)) as f32;
        0.01 * Scalar::sin(12.566_f32 * t) + 2e-4 * Scalar::sin(301.0_f32 * t)
    }

    /// Mean and worst cycles from call to return, measuring included.
    #[inline(never)]
    fn timed<L: FrictionLaw<f32>>(law: &L) -> (u32, u32) {
        let mut state = L::State::default();
        let (mut sum, mut worst, mut before) = (0, 0, position(0));
        for k in 1..=STEPS {
            let position = position(k);
            let displacement = position - before;
            before = position;
            let motion = Motion {
                dt: DT,
                position,
                displacement,
                velocity: displacement / DT,
                applied: 4.0 * Scalar::sin(0.017 * k as f32),
                mass: 0.4,
                normal: None,
            };
            let (law, motion) = (black_box(law), black_box(&motion));
            let began = DWT::cycle_count();
            black_box(law.step(&mut state, motion));
            let cycles = DWT::cycle_count().wrapping_sub(began);
            sum += cycles;
            worst = worst.max(cycles);
        }
        (sum / STEPS, worst)
    }

    /// A law in the plane on the same stroke, slanted and with a load across it.
    struct InThePlane<L>(L);

    impl<L: planar::FrictionLaw<f32>> FrictionLaw<f32> for InThePlane<L> {
        type State = L::State;

        fn step(&self, state: &mut L::State, m: &Motion<f32>) -> f32 {
            let at = |x: f32, y: f32| planar::Vector { x, y };
            let motion = planar::Motion {
                dt: m.dt,
                position: at(m.position, 0.6 * m.position),
                displacement: at(m.displacement, 0.6 * m.displacement),
                velocity: at(m.velocity, 0.6 * m.velocity),
                applied: at(m.applied, 2.0 - m.applied),
                mass: m.mass,
                normal: m.normal,
            };
            let force = self.0.step(state, &motion);
            force.x + force.y
        }

        fn validate(&self) -> Result<(), Invalid> {
            self.0.validate()
        }
    }

    struct Table {
        row: usize,
        /// Cycles of measuring itself.
        nothing: u32,
    }

    impl Table {
        fn add<L: FrictionLaw<f32>>(&mut self, law: L) {
            let (mean, worst) = timed(&law);
            let place = LAW_CYCLES.iter().skip(COLUMNS * self.row);
            for (into, cycles) in place.zip([mean, worst]) {
                into.store(cycles.saturating_sub(self.nothing), Relaxed);
            }
            self.row += 1;
        }
    }

    /// Rubber, as far as each law knows it.
    fn every_law(table: &mut Table) {
        table.add(Viscous { damping_p: 8.7, damping_n: 8.0 });
        table.add(Coulomb {
            level_p: 3.5,
            level_n: 2.6,
            static_p: 3.9,
            static_n: 2.9,
            viscous_p: 8.7,
            viscous_n: 8.0,
        });
        table.add(Classic { stiction: 3.9, dynamic: 3.5, viscous: 8.7, knee: 1e-3, fallen: 0.02 });
        table.add(Karnopp { c_p: 3.5, c_n: 2.6, b_p: 8.7, b_n: 8.0, d_p: 3.9, d_n: 2.9, delta_v: 0.02 });
        table.add(MajdSimaan {
            viscous: 8.7,
            coulomb: 3.0,
            stribeck: 0.9,
            critical_velocity: 0.01,
            steepness: 10.0,
        });
        table.add(Armstrong {
            coulomb: 3.0,
            viscous: 8.7,
            stribeck: 0.9,
            stiffness: 5e4,
            stribeck_velocity: 0.01,
            memory: 5e-3,
            dwell: 0.1,
        });
        let dahl = Dahl { limit_p: 3.3, limit_n: 2.4, sigma: 5e4, exponent: 1.0, viscous: 10.0 };
        table.add(dahl);
        table.add(Dahl { exponent: 1.5, ..dahl });
        let lugre = LuGre {
            sigma_0: 5e4,
            sigma_1: 60.0,
            sigma_2: 9.0,
            coulomb: 3.0,
            stiction: 3.4,
            stribeck_velocity: 0.01,
        };
        table.add(lugre);
        table.add(ElastoPlastic::of(lugre, 0.7));
        table.add(MaxwellSlip { stiction: 3.4, viscous: 8.7, ..MaxwellSlip::new(3.0, 6e-5) });
        for adhesion in [Adhesion::StickSlide, Adhesion::StickSlipSlide, Adhesion::StickCreepSlipSlide] {
            table.add(HaywardArmstrong {
                stiffness: 5e4,
                dynamic: 3.0,
                stiction: 3.9,
                viscous: 8.7,
                adhesion,
            });
        }
        // 1.8 times the friction across the grain
        let grain = planar::Grain::at(0.4, 1.8);
        let coulomb = planar::Coulomb { level: 3.5, stiction: 3.9, viscous: 8.7, grain };
        table.add(InThePlane(planar::Karnopp { c: 3.5, b: 8.7, d: 3.9, delta_v: 0.02, grain }));
        table.add(InThePlane(planar::Coulomb { grain: planar::Grain::default(), ..coulomb }));
        table.add(InThePlane(coulomb));
        table.add(InThePlane(planar::Dahl { limit: 3.3, sigma: 5e4, exponent: 1.0, viscous: 10.0, grain }));
        table.add(InThePlane(planar::LuGre { contact: lugre, grain }));
        table.add(InThePlane(planar::ElastoPlastic { contact: ElastoPlastic::of(lugre, 0.7), grain }));
        table.add(Bristle::<f32, 10> { stiffness: 5e4, level: 3.0, viscous: 8.7 });
        table.add(Bristle::<f32, 20> { stiffness: 5e4, level: 3.0, viscous: 8.7 });
        table.add(Bristle::<f32, 50> { stiffness: 5e4, level: 3.0, viscous: 8.7 });
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        if let Some(mut core) = cortex_m::Peripherals::take() {
            core.DCB.enable_trace();
            core.DWT.enable_cycle_counter();
            let (nothing, _) = timed(&Custom(|_: &Motion<f32>| 0.0));
            let mut table = Table { row: 0, nothing };
            every_law(&mut table);
            if let (Some(last), true) = (LAW_CYCLES.last(), table.row == NAMES.len()) {
                last.store(DONE, Relaxed);
            }
        }
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }
}
