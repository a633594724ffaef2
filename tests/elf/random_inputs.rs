//! The control step on the target and on this machine, bit for bit, over inputs nobody would think of: 100 000 of them,
//! under every law, every renderer and every effect.
//!
//! The readings are made up in the emulated registers, so the ELF reads them as it reads a rig. What it did with each
//! comes back in its telemetry: force, reference (the handle's position where nothing is driven), state and fault.
//! Readings are integers, so no input carries NaN, infinity or a subnormal number; `set` refuses the first two
//! (tests/elf/main.rs), and the third comes of decay and of tiny gains, in a test of its own.
//!
//! The first difference ends a test: what is printed was without one.

use crate::board::Board;
use crate::random_readings::{PERIOD, Source, Style};
use friction::effects::EffectKind;
use haptics::{Control, Device, FaultKind, Inputs, LawKind, RendererKind, Request, Settings};
use link::Sample;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

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
    referenced: bool,
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
            referenced: false,
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
        // what the slow checks of the board find in readings without physics comes as a request of a task
        let found = FaultKind::from_code(sample.fault).filter(|kind| {
            self.last.1 == 0
                && matches!(kind, FaultKind::ForceContradicted | FaultKind::SensorDead | FaultKind::MotorHot)
        });
        let raised = found.map(Request::Raise);
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
                    None => raised.as_ref(),
                };
                let outputs = control.step(request, &inputs);
                let here = (
                    outputs.force.to_bits(),
                    outputs.reference.to_bits(),
                    outputs.mode.code(),
                    outputs.fault.map_or(0, |fault| fault.code()),
                    outputs.referenced,
                );
                let there = (
                    sample.force.to_bits(),
                    sample.reference.to_bits(),
                    sample.mode,
                    sample.fault,
                    sample.referenced,
                );
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
        self.referenced = sample.referenced;
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
    fn boot(seed: u64) -> Self {
        let mut board = Board::boot();
        let source = Source::at_rest(seed);
        let source = Arc::new(Mutex::new(source));
        let readings = Arc::clone(&source);
        board.machine.inject(move || readings.lock().expect("no panic").next());
        let settings = Settings::preset("brass").expect("built in");
        let mut pair = Self { board, follower: Follower::new(), source, settings };
        pair.board.ok("stream on");
        pair.run(20.0);
        assert!(pair.say("zero", Some(Typed::Ask(Request::Zero))));
        // the clock of the edges wraps two seconds from now
        pair.source.lock().expect("no panic").skew = 0x8000_0000;
        pair.run(2.0);
        let now = pair.follower.last.2;
        pair.source.lock().expect("no panic").skew = 0_u32.wrapping_sub(now).wrapping_sub(2_000 * PERIOD);
        pair.run(2.0);
        pair
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
        // random readings leave wrong offsets of load cell and accelerometer, which the loop forgets with 4 s
        for _ in 0..120 {
            self.style(Style::Rest);
            self.run(100.0);
            if self.follower.last.1 != 0 && !self.say("clear", Some(Typed::Ask(Request::ClearFault))) {
                continue;
            }
            // refused while the handle still moves
            if !self.follower.referenced && !self.say("zero", Some(Typed::Ask(Request::Zero))) {
                continue;
            }
            if self.say("render on", Some(Typed::Ask(Request::Render(true)))) {
                return;
            }
        }
        let told = ["fault", "status", "clear", "zero", "render on"].map(|line| self.board.ask(line));
        panic!("the fault cannot be left: {told:?}");
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

/// 25 000 random samples under one law: every renderer, four effects at a time out of all of them, a swap in mid-motion.
fn law(law: LawKind, seed: u64) {
    let mut pair = Pair::boot(seed);
    let mut effects = 0;
    for (round, renderer) in ["virtual_coupling", "impedance", "stopping_force"].into_iter().enumerate() {
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
        pair.ride(Style::Hand, 4_000);
        pair.style(Style::Hand);
        let swapped = pair.set("damping", "2.5");
        pair.ride(Style::Hand, 2_300);
        assert!(swapped || pair.follower.last.1 != 0);
        pair.ride(Style::Trips, 1_200);
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

pub fn target_and_host_agree_over_random_inputs_under_karnopp() {
    law(LawKind::Karnopp, 0);
}

pub fn target_and_host_agree_over_random_inputs_under_dahl() {
    law(LawKind::Dahl, 1);
}

pub fn target_and_host_agree_over_random_inputs_under_coulomb() {
    law(LawKind::Coulomb, 2);
}

pub fn target_and_host_agree_over_random_inputs_under_lugre() {
    law(LawKind::LuGre, 3);
}

/// 4 000 random samples under each law that has no test of its own, with a swap to the next one in mid-motion.
pub fn target_and_host_agree_over_random_inputs_under_the_other_laws() {
    let mut pair = Pair::boot(4);
    let renderers = RendererKind::ON_BOARD.iter().cycle();
    for (law, renderer) in LawKind::ALL[4..].iter().zip(renderers) {
        pair.use_preset("teflon");
        for (name, value) in [
            ("f_static", "0.9"),
            ("f_dynamic", "0.6"),
            ("damping", "1.1"),
            ("sigma", "2000"),
            ("dv", "0.02"),
            ("stribeck_velocity", "0.1"),
            ("memory", "0.003"),
            ("dwell", "0.05"),
            ("adhesion", "stick_slip_slide"),
        ] {
            assert!(pair.set(name, value), "{name}");
        }
        assert!(pair.set("law", law.id()) && pair.set("renderer", renderer.id()), "{}", law.id());
        pair.render();
        pair.ride(Style::Hand, 4_000);
        pair.style(Style::Hand);
        assert!(pair.set("damping", "2.5") || pair.follower.last.1 != 0, "{}", law.id());
        pair.ride(Style::Hand, 1_000);
        pair.say("render off", Some(Typed::Ask(Request::Render(false))));
        pair.told(law.id());
    }
    let f = &pair.follower;
    assert!(f.compared >= pair.random_given() && f.sliding > 4_000, "{} of it sliding", f.sliding);
}

pub fn target_and_host_agree_on_subnormals() {
    let mut pair = Pair::boot(7);
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
