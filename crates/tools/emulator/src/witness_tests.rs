//! The chip by two descriptions that the models were not written from: the vendor's registers (`svd`), and the tables of
//! `stm32-metapac`.

use super::*;
use crate::svd::{self, Register};
use crate::{adc, dac};
use plant::RigConfig;
use std::sync::LazyLock;
use stm32_metapac::metadata::ir::{BitOffset, BlockItemInner};
use stm32_metapac::metadata::{METADATA, Peripheral};

static REGISTERS: LazyLock<Vec<Register>> = LazyLock::new(|| svd::registers().expect("the sources"));

/// Peripherals that are modelled, with the source of the model.
const MODELS: [(&str, &str); 21] = [
    ("TIM2", include_str!("tim.rs")),
    ("TIM3", include_str!("tim.rs")),
    ("TIM4", include_str!("tim.rs")),
    ("TIM5", include_str!("tim.rs")),
    ("TIM6", include_str!("tim.rs")),
    ("TIM7", include_str!("tim.rs")),
    ("SPI2", include_str!("spi.rs")),
    ("SPI3", include_str!("spi.rs")),
    ("DMA1", include_str!("dma.rs")),
    ("IWDG", include_str!("iwdg.rs")),
    ("PWR", include_str!("supply.rs")),
    ("EXTI", include_str!("supply.rs")),
    ("LPUART1", include_str!("lpuart.rs")),
    ("RCC", include_str!("rcc.rs")),
    ("FLASH", include_str!("flash.rs")),
    ("GPIOA", include_str!("gpio.rs")),
    ("GPIOB", include_str!("gpio.rs")),
    ("GPIOC", include_str!("gpio.rs")),
    ("ADC1", include_str!("adc.rs")),
    ("ADC12_COMMON", include_str!("adc.rs")),
    ("DAC1", include_str!("dac.rs")),
];

fn of(peripheral: &str) -> impl Iterator<Item = &'static Register> {
    REGISTERS.iter().filter(move |register| register.peripheral == peripheral)
}

/// A chip after power-on.
fn chip() -> Soc {
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    Soc::new(World::new(RigConfig::free_handle(), no_block, 1).expect("thesis rig"))
}

/// A chip whose clocks to the peripherals are on.
fn clocked() -> Soc {
    let mut soc = chip();
    let clocks = [
        (AHB1ENR, 1 | 1 << 2),
        (AHB2ENR, 1 << 13 | 1 << 16 | 0x7f),
        (APB1ENR1, 0x3f | 3 << 14 | 1 << 28),
        (APB1ENR2, 1),
    ];
    for (offset, bits) in clocks {
        soc.write(RCC + offset, bits, 0);
    }
    soc
}

#[test]
fn registers_are_reset_to_the_values_of_the_vendor() {
    let mut wrong = Vec::new();
    let mut compared = 0;
    for (peripheral, _) in MODELS {
        let mut soc = if peripheral == "RCC" { chip() } else { clocked() };
        for register in of(peripheral) {
            // copies of option bytes, of which only OPTR is modelled; levels of pins
            let beside = ["PCROP", "WRP", "SEC", "IDR"].iter().any(|part| register.name.starts_with(part));
            if beside {
                continue;
            }
            let value = soc.read(register.address, 0);
            compared += 1;
            if value != register.reset {
                wrong.push(format!("{peripheral} {}: {value:#x}, {:#x}", register.name, register.reset));
            }
        }
    }
    println!("{compared} registers");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Constants of the models that are neither a register nor bits of a field.
const OTHER_NAMES: [&str; 7] =
    ["CALIBRATED", "CHANNEL_0", "LINE", "OPTR_BOR", "OPTR_RESET", "SR_FLAGS", "STRIDE"];

#[test]
fn names_and_bits_of_the_models_are_those_of_the_vendor() {
    let (mut compared, mut wrong) = (BTreeSet::new(), Vec::new());
    let mut other = BTreeSet::new();
    for (peripheral, source) in MODELS {
        let base = of(peripheral).map(|register| register.address & !0x3ff).min().expect("listed");
        for line in source.lines() {
            let Some((name, rest)) = line.strip_prefix("const ").and_then(|l| l.split_once(": u32 = "))
            else {
                continue;
            };
            let Some(value) = rest.strip_suffix(';').and_then(value) else { continue };
            let short = name.strip_prefix(&format!("{peripheral}_")).unwrap_or(name);
            let names = [short.to_owned(), format!("{short}_INPUT"), format!("{short}R1")];
            if let Some(register) = of(peripheral).find(|register| names.contains(&register.name)) {
                compared.insert(name);
                if register.address - base != value {
                    wrong.push(format!("{peripheral} {name}: {value:#x}, {:#x}", register.address - base));
                }
            } else if let Some((register, field)) = short.split_once('_')
                && let Some(register) = of(peripheral).find(|r| r.name == register)
                && let Some(field) =
                    register.fields.iter().find(|f| f.name.replace('_', "") == field.replace('_', ""))
            {
                compared.insert(name);
                if field.mask & value != value || value == 0 {
                    wrong.push(format!("{peripheral} {name}: {value:#x}, {:#x}", field.mask));
                }
            } else {
                other.insert(name);
            }
        }
    }
    println!("{} names", compared.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(other.difference(&compared).copied().collect::<Vec<_>>(), OTHER_NAMES);
}

/// Value of a constant's expression: a number, or a bit.
fn value(text: &str) -> Option<u32> {
    let number = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(&digits.replace('_', ""), 16).ok(),
        None => text.parse().ok(),
    };
    match text.split_once(" << ") {
        Some((bits, place)) => Some(number(bits)? << number(place)?),
        None => number(text),
    }
}

fn metapac(name: &str) -> &'static Peripheral {
    METADATA.peripherals.iter().find(|peripheral| peripheral.name == name).expect("in the table")
}

#[test]
fn triggers_are_those_of_metapac() {
    for (peripheral, prefix, model) in
        [("ADC1", "ADC_JEXT_TRG", &adc::TRIGGERS[..]), ("DAC1", "DAC_CHX_TRG", &dac::TRIGGERS)]
    {
        let mut told = BTreeSet::new();
        for trigger in metapac(peripheral).triggers {
            let code = trigger.signal.strip_prefix(prefix).and_then(|code| code.parse::<u32>().ok());
            let timer = trigger.source.strip_prefix("TIM").and_then(|name| name.strip_suffix("_TRGO"));
            if let Some((code, timer)) = code.zip(timer.and_then(|timer| timer.parse::<u8>().ok())) {
                told.insert((code, timer));
            }
        }
        assert_eq!(model.iter().copied().collect::<BTreeSet<_>>(), told, "{peripheral}");
    }
}

#[test]
fn addresses_clocks_and_interrupts_are_those_of_metapac() {
    let gates = [
        ("ADC1", ADC1, ADC_GATE),
        ("DAC1", DAC1, DAC_GATE),
        ("LPUART1", LPUART1, LPUART_GATE),
        ("PWR", PWR, PWR_GATE),
        ("SPI2", SPI2, SPI2_GATE),
        ("SPI3", SPI3, SPI3_GATE),
        ("DMA1", DMA1, DMA_GATE),
        ("DMAMUX1", DMA1 + dma::MUX, DMAMUX_GATE),
        ("TIM2", TIM2, (APB1ENR1, 0)),
        ("TIM3", TIM2 + 0x400, (APB1ENR1, 1)),
        ("TIM4", TIM2 + 0x800, (APB1ENR1, 2)),
        ("TIM5", TIM2 + 0xc00, (APB1ENR1, 3)),
        ("TIM6", TIM2 + 0x1000, (APB1ENR1, 4)),
        ("TIM7", TIM2 + 0x1400, (APB1ENR1, 5)),
        ("GPIOA", GPIOA, (AHB2ENR, 0)),
        ("GPIOB", GPIOA + 0x400, (AHB2ENR, 1)),
        ("GPIOC", GPIOA + 0x800, (AHB2ENR, 2)),
    ];
    let block = metapac("RCC").registers.as_ref().expect("it has some").ir;
    for (name, address, (offset, bit)) in gates {
        let told = metapac(name);
        assert_eq!(told.address, u64::from(address), "{name}");
        let enable = told.rcc.as_ref().and_then(|rcc| rcc.enable.as_ref()).expect("a clock");
        let mut registers = block.blocks[0].items.iter();
        let register =
            registers.find(|r| r.name.eq_ignore_ascii_case(enable.register)).expect("a register of RCC");
        let BlockItemInner::Register(set) = &register.inner else { panic!("{name}") };
        let set = block.fieldsets.iter().find(|s| Some(s.name) == set.fieldset).expect("fields");
        let field = set.fields.iter().find(|f| f.name.eq_ignore_ascii_case(enable.field)).expect("a field");
        let BitOffset::Regular(place) = &field.bit_offset else { panic!("{name}") };
        assert_eq!((register.byte_offset, place.offset), (offset, bit), "{name}");
    }
    for (name, address) in [("RCC", RCC), ("FLASH", FLASH), ("EXTI", EXTI), ("IWDG", IWDG)] {
        assert_eq!(metapac(name).address, u64::from(address), "{name}");
    }
    let number = |name: &str| METADATA.interrupts.iter().find(|i| i.name == name).map(|i| i.number as u16);
    let timers = ["TIM2", "TIM3", "TIM4", "TIM5", "TIM6_DAC", "TIM7_DAC"];
    assert_eq!(timers.map(number), IRQ_TIMERS.map(Some));
    for (name, irq) in [
        ("ADC1_2", IRQ_ADC1_2),
        ("PVD_PVM", IRQ_PVD),
        ("LPUART1", IRQ_LPUART1),
        ("DMA1_CHANNEL7", IRQ_DMA1_CHANNEL7),
    ] {
        assert_eq!(number(name), Some(irq), "{name}");
    }
}

#[test]
fn requests_of_the_dma_are_those_of_metapac() {
    for (peripheral, signal, request) in [
        ("TIM6", "UP", UPDATE_REQUESTS[0].1),
        ("TIM7", "UP", UPDATE_REQUESTS[1].1),
        ("SPI2", "RX", SPI2_REQUESTS[0]),
        ("SPI2", "TX", SPI2_REQUESTS[1]),
        ("SPI3", "RX", SPI3_REQUESTS[0]),
        ("SPI3", "TX", SPI3_REQUESTS[1]),
        ("LPUART1", "TX", LPUART1_TX_REQUEST),
    ] {
        let mut channels = metapac(peripheral).dma_channels.iter();
        let told = channels.find(|channel| channel.signal == signal).and_then(|channel| channel.request);
        assert_eq!(told, Some(request), "{peripheral} {signal}");
    }
}

#[test]
fn pins_are_those_of_metapac() {
    for (peripheral, signal, pin, function) in [
        ("TIM2", "CH1", "PA0", Some(1)),
        ("TIM2", "CH2", "PA1", Some(1)),
        ("LPUART1", "TX", "PA2", Some(12)),
        ("LPUART1", "RX", "PA3", Some(12)),
        ("TIM3", "CH2", "PB5", Some(ENABLE_FUNCTION as u8)),
        ("SPI2", "NSS", "PB12", Some(SPI2_FUNCTION as u8)),
        ("SPI2", "SCK", "PB13", Some(SPI2_FUNCTION as u8)),
        ("SPI2", "MISO", "PB14", Some(SPI2_FUNCTION as u8)),
        ("SPI2", "MOSI", "PB15", Some(SPI2_FUNCTION as u8)),
        ("SPI3", "NSS", "PA15", Some(SPI3_FUNCTION as u8)),
        ("SPI3", "SCK", "PC10", Some(SPI3_FUNCTION as u8)),
        ("SPI3", "MISO", "PC11", Some(SPI3_FUNCTION as u8)),
        ("SPI3", "MOSI", "PC12", Some(SPI3_FUNCTION as u8)),
        ("DAC1", "OUT1", "PA4", None),
        ("ADC1", "IN6", "PC0", None),
        ("ADC1", "IN7", "PC1", None),
    ] {
        let told =
            metapac(peripheral).pins.iter().any(|p| (p.signal, p.pin, p.af) == (signal, pin, function));
        assert!(told, "{peripheral} {signal} on {pin}");
    }
}
