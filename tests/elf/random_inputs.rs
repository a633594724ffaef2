//! The control step on the target and on this machine, bit for bit, over inputs nobody would think of: 100 000 of them,
//! under every law, both renderers and every effect.
//!
//! The readings are made up in the emulated registers, so the ELF reads them as it reads a rig. What it did with each
//! comes back in its telemetry: force, reference (the handle's position where nothing is driven), state and fault.
//! Readings are integers, so no input carries NaN, infinity or a subnormal number; `set` refuses the first two
//! (tests/elf/main.rs), and the third comes of decay and of tiny gains, in a test of its own.
//!
//! The first difference ends a test: what is printed was without one.

use crate::board::Board;
use emulator::Injected;
use friction::effects::EffectKind;
use haptics::{Control, Device, FaultKind, Inputs, LawKind, Request, Settings};
use link::Sample;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// Ticks in a period.
const PERIOD: u32 = 170_000;
const MID: u16 = 32_768;
/// Counts from the middle to where the made-up handle turns round: 12 mm.
const TURN: i32 = 4_700;

/// splitmix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// −`most` … `most`.
    fn within(&mut self, most: i32) -> i32 {
        (self.next() % (2 * most as u64 + 1)) as i32 - most
    }

    fn share(&mut self) -> f64 {
        self.next() as f64 / u64::MAX as f64
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Style {
    /// At count 0, no edges, sensors at mid-scale.
    Rest,
    /// Slowly to count 0, and there at rest.
    Home,
    /// Motion a hand might make: smooth, jerky, slow, dithering, none.
    Hand,
    /// Any bits at all.
    Any,
    /// A hand, and once in a while a reading that must trip a check.
    Trips,
}

/// Where the readings come from.
struct Source {
    random: Random,
    style: Style,
    count: i32,
    speed: i32,
    /// How the hand moves, and for how many samples yet.
    motion: (u32, u32),
    /// Random readings so far: all but those at rest and on the way there.
    random_given: u32,
    /// Samples at a rail to come.
    rails: u32,
    skew: u32,
}

impl Source {
    fn next(&mut self) -> Injected {
        self.random_given += u32::from(!matches!(self.style, Style::Rest | Style::Home));
        let r = &mut self.random;
        let skew_ticks = std::mem::take(&mut self.skew);
        match self.style {
            Style::Rest => {
                (self.count, self.speed) = (0, 0);
                Injected { load_code: MID, accel_code: MID, count: 0, edge_age: None, skew_ticks }
            }
            Style::Home => {
                // an edge after which the count has not changed was crossed both ways: the speed is exactly 0
                let moved = self.count != 0 || self.speed != 0;
                (self.speed, self.count) =
                    (self.count.clamp(-20, 20), self.count - self.count.clamp(-20, 20));
                let edge_age = moved.then(|| r.next() as u32 % (PERIOD / 2));
                Injected { load_code: MID, accel_code: MID, count: self.count as u32, edge_age, skew_ticks }
            }
            Style::Any => Injected {
                load_code: r.next() as u16,
                accel_code: [0, u16::MAX, r.next() as u16][(r.next() % 3) as usize],
                count: [0, i32::MAX as u32, i32::MIN as u32, u32::MAX, r.next() as u32]
                    [(r.next() % 5) as usize],
                edge_age: Some(
                    [0, u32::MAX, r.next() as u32, r.next() as u32 % PERIOD][(r.next() % 4) as usize],
                ),
                // the second: the stamp of the sample before, again
                skew_ticks: [0, PERIOD.wrapping_neg(), r.next() as u32][(r.next() % 3) as usize],
            },
            Style::Hand => self.hand(),
            Style::Trips => {
                let hand = self.hand();
                let r = &mut self.random;
                if self.rails > 0 {
                    // three in a row are a fault
                    self.rails -= 1;
                    return Injected { load_code: [0, u16::MAX][(r.next() % 2) as usize], ..hand };
                }
                match r.next() % 600 {
                    0 => Injected { count: r.next() as u32, ..hand },
                    1 => Injected { skew_ticks: r.next() as u32, ..hand },
                    2..5 => {
                        self.rails = 4;
                        hand
                    }
                    12 => Injected { edge_age: Some(PERIOD - 1), ..hand },
                    13 => Injected { skew_ticks: PERIOD.wrapping_neg(), ..hand },
                    14 => Injected {
                        count: [i32::MAX as u32, i32::MIN as u32][(r.next() % 2) as usize],
                        ..hand
                    },
                    _ => hand,
                }
            }
        }
    }

    fn hand(&mut self) -> Injected {
        let r = &mut self.random;
        if self.motion.1 == 0 {
            self.motion = (r.next() as u32 % 6, 50 + r.next() as u32 % 300);
        }
        self.motion.1 -= 1;
        let before = self.count;
        let (most, jerk) = match self.motion.0 {
            0 => (100, 12),
            1 => (100, 100),
            2 => (3, 1),
            3 => (12, 3),
            _ => (0, 0),
        };
        self.speed = (self.speed + r.within(jerk)).clamp(-most, most);
        if self.count.abs() > TURN {
            self.speed = -self.count.signum() * most.max(1);
        }
        self.count += self.speed;
        if self.motion.0 == 4 {
            // dither across an edge
            self.count = before + r.within(1);
        }
        let moved = self.count != before;
        let age = match r.next() % 50 {
            // the capture failed, or is of another edge
            0 => Some(r.next() as u32),
            1 => Some(r.next() as u32 % (PERIOD / 2)),
            // the stamp of the edge before, again
            2 => None,
            _ => moved.then(|| r.next() as u32 % (PERIOD / 2)),
        };
        let noise = |r: &mut Random| (i32::from(MID) + r.within(700)) as u16;
        let (load_code, accel_code) = (noise(r), noise(r));
        Injected { load_code, accel_code, count: self.count as u32, edge_age: age, skew_ticks: 0 }
    }
}

/// What was typed and takes effect in a period that is to be found out.
#[derive(Clone)]
enum Typed {
    Ask(Request),
    Configure(Box<haptics::Config>),
}

/// The same loop on this machine, in every state it may be in while it is open when a command took effect.
struct Follower {
    candidates: Vec<(Control, bool)>,
    typed: Option<Typed>,
    next: Option<u32>,
    compared: u32,
    subnormal: u32,
    sliding: u32,
    wrapped: u32,
    repeated: u32,
    faults: Vec<u8>,
    last: (u8, u8, u32),
}

impl Follower {
    fn new() -> Self {
        let settings = Settings::preset("brass").expect("built in");
        Self {
            candidates: vec![(Control::new(settings.build(&device()).expect("fits")), false)],
            typed: None,
            next: None,
            compared: 0,
            subnormal: 0,
            sliding: 0,
            wrapped: 0,
            repeated: 0,
            faults: Vec::new(),
            last: (0, 0, 0),
        }
    }

    fn follow(&mut self, sample: &Sample) {
        let inputs = Inputs {
            sample_ticks: sample.sample_ticks,
            count: sample.count as u32,
            edge_ticks: sample.edge_ticks(),
            load_code: sample.load_code,
            accel_code: sample.accel_code,
        };
        let step = sample.step;
        match self.next {
            Some(next) => assert_eq!(step, next, "a sample was lost"),
            // before the stream began the board was at rest
            None => {
                for k in (1..=step).rev() {
                    let sample_ticks = inputs.sample_ticks.wrapping_sub(k.wrapping_mul(PERIOD));
                    self.candidates[0].0.step(None, &Inputs { sample_ticks, ..inputs });
                }
            }
        }
        self.next = Some(step + 1);
        let mut alike: Vec<(Control, bool)> = Vec::new();
        let mut wrong = String::new();
        for (before, done) in &self.candidates {
            let variants = [None, self.typed.clone().filter(|_| !done)];
            for (k, typed) in variants.into_iter().enumerate() {
                if k == 1 && typed.is_none() {
                    continue;
                }
                let mut control = *before;
                let request = match &typed {
                    Some(Typed::Ask(request)) => Some(request),
                    Some(Typed::Configure(config)) => {
                        control.configure(**config);
                        None
                    }
                    None => None,
                };
                let outputs = control.step(request, &inputs);
                let here = (
                    outputs.force.to_bits(),
                    outputs.reference.to_bits(),
                    outputs.mode.code(),
                    outputs.fault.map_or(0, |fault| fault.code()),
                );
                let there = (sample.force.to_bits(), sample.reference.to_bits(), sample.mode, sample.fault);
                let next = (control, *done || typed.is_some());
                if here == there && !alike.contains(&next) {
                    self.sliding += u32::from(alike.is_empty() && outputs.amplifier && !outputs.stuck);
                    alike.push(next);
                } else if here != there {
                    wrong = format!(
                        "step {step}: host {} N at {} m, mode {}, fault {}; target {} N at {} m, mode {}, fault {}",
                        outputs.force,
                        outputs.reference,
                        here.2,
                        here.3,
                        sample.force,
                        sample.reference,
                        there.2,
                        there.3
                    );
                }
            }
        }
        assert!(!alike.is_empty(), "{wrong} ({inputs:?})");
        self.candidates = alike;
        self.compared += 1;
        self.subnormal += u32::from(sample.force.is_subnormal());
        self.wrapped += u32::from(sample.sample_ticks < self.last.2);
        self.repeated += u32::from(sample.sample_ticks == self.last.2);
        if sample.fault != 0 && self.last.1 == 0 {
            self.faults.push(sample.fault);
        }
        self.last = (sample.mode, sample.fault, sample.sample_ticks);
    }

    /// The command was answered, and its period is past.
    fn settle(&mut self, obeyed: bool) {
        if self.typed.take().is_some() {
            self.candidates.retain(|(_, done)| *done == obeyed);
            assert!(!self.candidates.is_empty(), "answered, but not seen in any period");
            for (_, done) in &mut self.candidates {
                *done = false;
            }
        }
    }
}

/// The device as the board describes it.
fn device() -> Device {
    Device { delay: 20e-6, ..Device::default() }
}

struct Pair {
    board: Board,
    follower: Follower,
    source: Arc<Mutex<Source>>,
    settings: Settings,
}

impl Pair {
    fn boot(seed: u64) -> Option<Self> {
        let mut board = Board::boot()?;
        let source = Source {
            random: Random(seed),
            style: Style::Rest,
            count: 0,
            speed: 0,
            motion: (0, 0),
            random_given: 0,
            rails: 0,
            skew: 0,
        };
        let source = Arc::new(Mutex::new(source));
        let readings = Arc::clone(&source);
        board.machine.inject(move || readings.lock().expect("no panic").next());
        let settings = Settings::preset("brass").expect("built in");
        let mut pair = Self { board, follower: Follower::new(), source, settings };
        pair.board.ok("stream on");
        pair.run(20.0);
        // the clock of the edges wraps two seconds from now
        pair.source.lock().expect("no panic").skew = 0x8000_0000;
        pair.run(2.0);
        let now = pair.follower.last.2;
        pair.source.lock().expect("no panic").skew = 0_u32.wrapping_sub(now).wrapping_sub(2_000 * PERIOD);
        pair.run(2.0);
        Some(pair)
    }

    fn run(&mut self, ms: f64) {
        self.board.run(ms);
        for (_, frame) in std::mem::take(&mut self.board.frames) {
            if let link::Frame::Sample(sample) = frame {
                self.follower.follow(&sample);
            }
        }
        assert_eq!(self.board.corrupt, 0);
    }

    fn style(&self, style: Style) {
        self.source.lock().expect("no panic").style = style;
    }

    /// Types a command; true when it was obeyed.
    fn say(&mut self, command: &str, typed: Option<Typed>) -> bool {
        self.follower.typed = typed;
        let answer = self.board.ask(command).swap_remove(0);
        // what was in the queue of frames when it was answered
        self.run(40.0);
        let obeyed = answer.starts_with("ok");
        self.follower.settle(obeyed);
        obeyed
    }

    /// Sets a parameter on both; they must agree whether it may be.
    fn set(&mut self, name: &str, value: &str) -> bool {
        let mut settings = self.settings;
        let config = settings
            .set(name, value)
            .ok()
            .and_then(|()| settings.validate(&device()).ok().and_then(|_| settings.build(&device()).ok()));
        let typed = config.map(|config| Typed::Configure(Box::new(config)));
        let (fits, obeyed) = (typed.is_some(), self.say(&format!("set {name} {value}"), typed));
        assert_eq!(obeyed, fits, "set {name} {value}");
        if fits {
            self.settings = settings;
        }
        fits
    }

    fn use_preset(&mut self, name: &str) {
        self.settings = Settings::preset(name).expect("built in");
        let config = self.settings.build(&device()).expect("fits");
        assert!(self.say(&format!("preset use {name}"), Some(Typed::Configure(Box::new(config)))));
    }

    /// Renders, after a fault again.
    fn render(&mut self) {
        for _ in 0..20 {
            self.style(Style::Rest);
            self.run(100.0);
            if self.follower.last.1 != 0 && !self.say("clear", Some(Typed::Ask(Request::ClearFault))) {
                continue;
            }
            if self.say("render on", Some(Typed::Ask(Request::Render(true)))) {
                return;
            }
        }
        panic!("the fault cannot be left: {:?}", self.board.ask("fault"));
    }

    /// So many samples under a style, rendering again after each fault.
    fn ride(&mut self, style: Style, samples: u32) {
        let mut left = samples;
        while left > 0 {
            self.style(style);
            let slice = left.min(50);
            self.run(f64::from(slice));
            left -= slice;
            if self.follower.last.1 != 0 {
                self.render();
            }
        }
        self.style(Style::Home);
    }

    fn random_given(&self) -> u32 {
        self.source.lock().expect("no panic").random_given
    }

    fn told(&self, what: &str) {
        let f = &self.follower;
        let kinds: BTreeSet<_> =
            f.faults.iter().filter_map(|code| FaultKind::from_code(*code)).map(FaultKind::id).collect();
        println!(
            "{what}: {} samples compared, {} of them random, {} sliding; {} forces subnormal, clock wrapped {} times, \
             stood still {} times; {} faults of {kinds:?}; 0 mismatches",
            f.compared,
            self.random_given(),
            f.sliding,
            f.subnormal,
            f.wrapped,
            f.repeated,
            f.faults.len(),
        );
    }
}

/// 25 000 random samples under one law: both renderers, four effects at a time out of all of them, a swap in mid-motion.
fn law(law: LawKind, seed: u64) {
    let Some(mut pair) = Pair::boot(seed) else { return };
    let mut effects = 0;
    for (round, renderer) in ["virtual_coupling", "impedance"].into_iter().enumerate() {
        pair.use_preset("teflon");
        for (name, value) in
            [("f_static", "0.9"), ("f_dynamic", "0.6"), ("damping", "1.1"), ("sigma", "2000")]
        {
            assert!(pair.set(name, value), "{name}");
        }
        assert!(pair.set("law", law.id()) && pair.set("renderer", renderer));
        for k in 0..4 {
            let kind = EffectKind::ALL[(seed as usize * 8 + 4 * round + k) % EffectKind::ALL.len()];
            let mut any = false;
            for parameter in kind.gains() {
                let value = 0.05 + 0.4 * pair.source.lock().expect("no panic").random.share();
                any |= pair.set(&format!("{}.{}", kind.id(), parameter.name), &format!("{value:.3}"));
            }
            effects += u32::from(any);
        }
        pair.render();
        pair.ride(Style::Hand, 6_500);
        pair.style(Style::Hand);
        let swapped = pair.set("damping", "2.5");
        pair.ride(Style::Hand, 4_300);
        assert!(swapped || pair.follower.last.1 != 0);
        pair.ride(Style::Trips, 1_500);
        let off = pair.say("render off", Some(Typed::Ask(Request::Render(false))));
        // a latched fault refuses it
        assert!(off || pair.follower.last.1 != 0);
        pair.style(Style::Any);
        pair.run(500.0);
    }
    pair.told(&format!("{} with {effects} effects", law.id()));
    let f = &pair.follower;
    // four of these tests: 100 000
    assert!(pair.random_given() >= 25_000 && f.compared >= pair.random_given());
    assert!(f.sliding > 5_000 && f.wrapped > 0 && f.repeated > 0);
    assert!(f.faults.len() > 2, "no check was tripped");
    assert!(effects >= 5, "{effects} effects");
}

#[test]
fn target_and_host_agree_over_random_inputs_under_karnopp() {
    law(LawKind::Karnopp, 0);
}

#[test]
fn target_and_host_agree_over_random_inputs_under_dahl() {
    law(LawKind::Dahl, 1);
}

#[test]
fn target_and_host_agree_over_random_inputs_under_coulomb() {
    law(LawKind::Coulomb, 2);
}

#[test]
fn target_and_host_agree_over_random_inputs_under_lugre() {
    law(LawKind::LuGre, 3);
}

#[test]
fn target_and_host_agree_on_numbers_too_small_to_be_normal() {
    let Some(mut pair) = Pair::boot(7) else { return };
    pair.use_preset("viscous");
    // without a band of speeds taken for zero nothing ends the decay
    assert!(pair.set("law", "coulomb"));
    pair.render();
    for _ in 0..2 {
        pair.ride(Style::Hand, 300);
        // the block comes to rest where the handle is exactly 0: its distance shrinks by a factor every period
        pair.ride(Style::Home, 2_500);
    }
    let decayed = pair.follower.subnormal;
    pair.told("decay to rest");
    // effects whose gains are subnormal themselves, and nothing beside them
    assert!(pair.set("renderer", "impedance") && pair.set("damping", "0"));
    for (name, value) in [
        ("offset.force", "-3e-40"),
        ("quadratic_drag.c_p", "5e-38"),
        ("quadratic_drag.c_n", "1e-44"),
        ("spring.stiffness", "2e-37"),
    ] {
        assert!(pair.set(name, value), "{name}");
    }
    pair.render();
    pair.ride(Style::Hand, 1_500);
    pair.told("and gains next to nothing");
    let by_gains = pair.follower.subnormal - decayed;
    assert!(decayed > 10, "{decayed} by decay");
    assert!(by_gains > 500, "{by_gains} by gains");
}
