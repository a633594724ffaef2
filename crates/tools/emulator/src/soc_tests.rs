//! Wiring of the board, register by register: correct settings work, and any single wrong setting is detected.

use super::*;
use crate::UNITS_PER_MS;
use plant::RigConfig;

const TIM5: u32 = TIM2 + 0xc00;
const TIM6: u32 = TIM2 + 0x1000;
const TIM7: u32 = TIM2 + 0x1400;
const CR1: u32 = 0;
const CR2: u32 = 4;
const SMCR: u32 = 8;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const ARR: u32 = 0x2c;
const CCR1: u32 = 0x34;
const ADC_ON: u32 = 1 << 28;

/// Register values of the firmware, at the initial clock of 16 MHz.
const BOARD: &[(u32, u32)] = &[
    (RCC + AHB2ENR, 1 << 13 | 1 << 16 | 7),
    (RCC + APB1ENR1, 1 | 1 << 3 | 1 << 4 | 1 << 5),
    (RCC + 0x88, 2 << 28),
    // PA0 and PA1 are TIM2's, everything else analog
    (GPIOA, 0xffff_fffa),
    (GPIOA + 0x20, 0x11),
    (TIM2 + CCMR1, 1 | 1 << 8),
    (TIM2 + SMCR, 3),
    (TIM2 + CR2, 1 << 25),
    (TIM2 + CR1, 1),
    (TIM5 + SMCR, 1 << 4),
    (TIM5 + CCMR1, 3),
    (TIM5 + CCER, 1),
    (TIM5 + CR1, 1),
    (DAC1, 3 | 2 << 2),
    (ADC1 + 0x08, ADC_ON),
    (ADC1 + 0x08, ADC_ON | 1),
    (ADC1 + 0x4c, 2 | 14 << 2 | 1 << 7 | 6 << 9 | 6 << 15 | 7 << 21),
    (ADC1 + 0x04, 1 << 6),
    (ADC1 + 0x08, ADC_ON | 9),
    (TIM6 + ARR, 15_999),
    (TIM6 + CR2, 2 << 4),
    (TIM7 + ARR, 15_999),
    (TIM7 + CNT, 8_000),
    (TIM7 + CR2, 2 << 4),
    (TIM6 + CR1, 1),
    (TIM7 + CR1, 1),
];

#[derive(Debug, PartialEq, Clone, Copy)]
enum Works {
    Interrupt,
    Encoder,
    EdgeTime,
    LoadCell,
    Output,
}
use Works::*;

/// Runs 30 ms with a pushed handle, and serves the converter like the firmware.
fn run(settings: &[(u32, u32)]) -> Vec<Works> {
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    let mut world = World::new(RigConfig::free_handle(), no_block, 1).expect("thesis rig");
    world.set_hand(Box::new(|_: f64, _: f64, _: f64| 3.0));
    let mut soc = Soc::new(world);
    for (address, value) in settings {
        soc.write(*address, *value, 0);
    }
    let mut works = Vec::new();
    let mut saw = |what, yes| {
        if yes && !works.contains(&what) {
            works.push(what);
        }
    };
    for tenth in 1..=300 {
        let now = tenth * UNITS_PER_MS / 10;
        soc.advance(now);
        if soc.interrupts().contains(&(IRQ_ADC1_2, true)) {
            saw(Interrupt, true);
            let told = f64::from(soc.read(TIM2 + CNT, now)) * 2.57e-6;
            saw(Encoder, told > 1e-4 && (told - soc.world.truth().position).abs() < 2e-5);
            saw(EdgeTime, soc.read(TIM5 + CCR1, now) > 1_000);
            // 16 conversions of zero force are half scale; one is 2048, unless it is the first after a pause
            saw(LoadCell, (1_900..2_200).contains(&soc.read(ADC1 + 0x84, now)));
            soc.write(ADC1, 1 << 5 | 1 << 6, now);
            soc.write(DAC1 + 0x08, 2_500, now);
        }
        saw(Output, (1.0..600.0).contains(&soc.stats.latency_us.max) && soc.read(DAC1 + 0x2c, now) == 2_500);
    }
    works
}

#[test]
fn the_board_as_it_is_wired_works() {
    let works = run(BOARD);
    println!("{works:?}");
    for what in [Interrupt, Encoder, EdgeTime, LoadCell, Output] {
        assert!(works.contains(&what), "{what:?}");
    }
}

#[test]
fn every_wrong_setting_shows() {
    for (address, wrong, broken, why) in [
        (RCC + AHB2ENR, 7, Interrupt, "converters without a clock"),
        (RCC + APB1ENR1, 1 | 1 << 3 | 1 << 5, Interrupt, "TIM6 without a clock"),
        (RCC + 0x88, 0, Interrupt, "ADC without a kernel clock"),
        (GPIOA, 0xffff_ffff, Encoder, "encoder pins left analog"),
        (GPIOA + 0x20, 0x22, Encoder, "encoder pins given to another function"),
        (TIM2 + CCMR1, 1, Encoder, "channel 2 is not an input"),
        (TIM2 + SMCR, 0, Encoder, "not in encoder mode"),
        (TIM2 + CR1, 0, Encoder, "counter not started"),
        (TIM2 + CR2, 2 << 4, EdgeTime, "trigger output is not the encoder's clock"),
        (TIM5 + SMCR, 2 << 4, EdgeTime, "another timer's trigger"),
        (TIM5 + CCMR1, 1, EdgeTime, "captures its own pin"),
        (TIM5 + CCER, 0, EdgeTime, "capture not enabled"),
        (TIM5 + CR1, 0, EdgeTime, "time base not started"),
        (DAC1, 3 | 7 << 2, Output, "latched by TIM6, a period late"),
        (DAC1, 3 | 4 << 2, Output, "latched by a stopped timer"),
        (DAC1, 2 | 2 << 2, Output, "channel off"),
        (
            ADC1 + 0x4c,
            2 | 12 << 2 | 1 << 7 | 6 << 9 | 6 << 15 | 7 << 21,
            Interrupt,
            "another timer's trigger",
        ),
        (ADC1 + 0x4c, 2 | 14 << 2 | 6 << 9 | 6 << 15 | 7 << 21, Interrupt, "no trigger edge"),
        (ADC1 + 0x4c, 2 | 14 << 2 | 1 << 7 | 6 << 9 | 5 << 15 | 7 << 21, LoadCell, "another input"),
        (ADC1 + 0x04, 1 << 2, Interrupt, "interrupt of the regular sequence"),
        (TIM6 + CR2, 0, Interrupt, "TIM6 triggers nothing"),
        (TIM7 + CR2, 0, Output, "TIM7 triggers nothing"),
    ] {
        let settings: Vec<_> =
            BOARD.iter().map(|&(a, v)| if a == address { (a, wrong) } else { (a, v) }).collect();
        let works = run(&settings);
        println!("{why}: {works:?}");
        assert!(!works.contains(&broken), "{why}: {broken:?} still works");
    }
}
