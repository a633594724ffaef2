//! The rig as a board, and the virtual device: the firmware application on it, in virtual time.

pub mod flash;

use super::{Board, RealTime, RealTimeLoop};
use crate::app::{Command, ControlLoop, Desk, Listener, Queues};
use crate::presets::{Library, NotStored};
use core::fmt::Write;
use embassy_futures::block_on;
use flash::SimulatedFlash;
use friction::effects::{Effect, EffectKind};
use friction::{Coulomb, Dimension, Invalid, Karnopp, Law};
use haptics::{Channel, Device, Inputs, ModeId, Outputs, Sheet};
use link::HelpLine;
use plant::{
    Bench, Hand, HandForce, HandImpedance, Layered, NoHand, Rig, RigConfig, Sensors, Target, Truth, Wire,
    materials::material,
};
use std::collections::VecDeque;

/// Bytes per control period on the serial line: 921 600 baud, ten bits per byte.
const BYTES_PER_PERIOD: usize = 92;
/// Largest number of unread bytes. Beyond it the line stops, as on a device without a cable.
const UNREAD: usize = 1 << 20;
/// Natural frequency of a pointed hand, rad/s: smooths the 16 ms steps of a mouse without a noticeable lag.
const POINTING: f64 = 100.0;
/// Longest wait for a search of the stops, ms.
const LONGEST_SEARCH_MS: u32 = 60_000;
/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;

/// Friction of the block.
pub type Slide = Layered<Law<f64>>;

/// Converts sensor readings of the rig into inputs of the control step.
#[must_use]
pub fn inputs(sensors: &Sensors) -> Inputs {
    Inputs {
        sample_ticks: sensors.sample_ticks,
        count: sensors.count,
        edge_ticks: sensors.edge_ticks,
        load_code: sensors.load_code,
        accel_code: sensors.accel_code,
    }
}

/// Configuration of the virtual device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualConfig {
    /// Seed of all noise.
    pub seed: u64,
    /// Configuration of the rig. With block mass 0 the handle is free.
    pub rig: RigConfig,
}

impl Default for VirtualConfig {
    /// The rig of [thesis, table 3-1] with a free handle.
    fn default() -> Self {
        Self { seed: 1, rig: RigConfig::free_handle() }
    }
}

/// Hand on the handle.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Holder {
    /// No hand.
    #[default]
    Nobody,
    /// A source of force.
    Force(HandForce),
    /// A hand with stiffness, damping and mass around a moving target.
    Hand(HandImpedance),
}

impl Holder {
    /// A relaxed hand that moves the handle back and forth: `amplitude`, m, and `frequency`, Hz.
    #[must_use]
    pub fn to_and_fro(amplitude: f64, frequency: f64) -> Self {
        Self::Hand(HandImpedance {
            stiffness: 1_500.0,
            damping: 15.0,
            ..HandImpedance::relaxed(Target::Sine { centre: 0.0, amplitude, frequency })
        })
    }

    /// A hand that moves to `to`, m, from time `t`, s, on. It starts from its present target, or from the handle at `position`,
    /// m.
    fn pointed(&self, to: f64, t: f64, position: f64) -> Self {
        let (from, velocity) = match self {
            Self::Hand(hand) => hand.target.at(t),
            Self::Nobody | Self::Force(_) => (position, 0.0),
        };
        let target = Target::Pursuit { from, velocity, to, at: t, rate: POINTING };
        Self::Hand(HandImpedance { stiffness: 1_500.0, damping: 15.0, ..HandImpedance::relaxed(target) })
    }
}

impl Holder {
    /// The same hand, as small or as strong as the device.
    fn of_size(self, device: &Device) -> Self {
        let Self::Hand(hand) = self else { return self };
        let inertia = f64::from(device.inertia(1.0));
        Self::Hand(HandImpedance {
            stiffness: inertia * hand.stiffness,
            damping: inertia * hand.damping,
            mass: inertia * hand.mass,
            ..hand
        })
    }
}

/// A block with its friction at the scale of a device.
fn block_of_size(mass: f64, law: Karnopp<f64>, device: &Device) -> (f64, Karnopp<f64>) {
    let (force, inertia) = (f64::from(device.force(1.0)), f64::from(device.inertia(1.0)));
    let law = Karnopp {
        c_p: force * law.c_p,
        c_n: force * law.c_n,
        d_p: force * law.d_p,
        d_n: force * law.d_n,
        b_p: inertia * law.b_p,
        b_n: inertia * law.b_n,
        delta_v: f64::from(device.speed(1.0)) * law.delta_v,
    };
    (inertia * mass, law)
}

/// The device that a firmware for this rig expects.
fn expected(rig: &RigConfig) -> Device {
    let c = &rig.calibration;
    let channel = |c: &plant::Channel| Channel {
        offset_code: c.offset_code as f32,
        unit_per_code: c.unit_per_code as f32,
    };
    let (load, accel) = (channel(&c.load), channel(&c.accel));
    Device {
        tick_hz: c.tick_hz,
        metre_per_count: c.metre_per_count as f32,
        load,
        accel,
        sheet: Sheet { load, accel, ..Sheet::RIG },
        ..Device::default()
    }
}

/// A rig that is this device. Sensors keep their noise in codes, the stops their time constants.
fn rig_of(device: &Device, rig: &RigConfig) -> RigConfig {
    let (normal, wide) = (RigConfig::default(), |x: f32| f64::from(x));
    let sensor = |channel: &Channel, normal: &plant::Sensor, of: &Channel| plant::Sensor {
        noise: normal.noise * wide(channel.unit_per_code.abs() / of.unit_per_code),
        gain: if channel.unit_per_code < 0.0 { -1.0 } else { 1.0 },
        offset: 0.0,
    };
    let channel = |channel: &Channel| plant::Channel {
        offset_code: wide(channel.offset_code),
        unit_per_code: wide(channel.unit_per_code.abs()),
    };
    let (stiffness, inertia) = (wide(device.stiffness(1.0)), wide(device.inertia(1.0)));
    RigConfig {
        stroke: Some(wide(device.stroke)),
        device_mass: wide(device.mass),
        device_damping: wide(device.damping),
        handle_mass: inertia * RigConfig::free_handle().handle_mass,
        force_max: Some(wide(device.force_max)),
        stop_stiffness: stiffness * normal.stop_stiffness,
        stop_damping: (stiffness * inertia).sqrt() * normal.stop_damping,
        load: sensor(&device.sheet.load, &normal.load, &Sheet::RIG.load),
        accel: sensor(&device.sheet.accel, &normal.accel, &Sheet::RIG.accel),
        calibration: plant::Calibration {
            metre_per_count: wide(device.metre_per_count),
            load: channel(&device.sheet.load),
            accel: channel(&device.sheet.accel),
            ..rig.calibration
        },
        ..*rig
    }
}

impl Hand for Holder {
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64 {
        match self {
            Self::Nobody => NoHand.force(t, x, v),
            Self::Force(hand) => hand.force(t, x, v),
            Self::Hand(hand) => hand.force(t, x, v),
        }
    }

    fn mass(&self) -> f64 {
        match self {
            Self::Hand(hand) => hand.mass,
            Self::Nobody | Self::Force(_) => 0.0,
        }
    }
}

/// The simulated board.
pub struct SimulatedBoard {
    rig: Rig<Slide>,
    /// Count of the rig at power-up. The counter of a board begins at 0, wherever the handle is.
    counted_from: u32,
    hand: Holder,
    /// Force that the amplifier would put out, N, and whether it is on.
    force: f64,
    amplifier: bool,
    /// Outputs of the last control step.
    outputs: Outputs,
    /// The device that the firmware expects, and the one that is there.
    nominal: Device,
    plant: Device,
    /// The wire of the command is broken: 0 V, the full negative force.
    command_broken: bool,
    milliseconds: u64,
    library: Library<SimulatedFlash>,
    stored: Option<Result<(), NotStored>>,
    lasting: String,
}

/// A surface without friction, for the rig without a block.
const NOTHING: Slide = Layered::new(Law::Coulomb(Coulomb {
    level_p: 0.0,
    level_n: 0.0,
    static_p: 0.0,
    static_n: 0.0,
    viscous_p: 0.0,
    viscous_n: 0.0,
}));

const HELP: &[HelpLine] = &[
    HelpLine {
        usage: "sim hand off|hold|at METRE|push NEWTON|sine AMP FREQ",
        what: "simulated hand: m, N, Hz",
    },
    HelpLine { usage: "sim block none|brass|teflon|rubber", what: "a real block on the handle (table 3-3)" },
    HelpLine {
        usage: "sim wire encoder|load|accel|amplifier|command right|swapped|dead|floating",
        what: "a wiring error, for `selftest` or the safety checks to find",
    },
    HelpLine {
        usage: "sim device NAME VALUE [NAME VALUE …]",
        what: "the device that is there, in the names of `device`",
    },
    HelpLine {
        usage: "sim friction NEWTON [NEWTON]",
        what: "friction of the device itself: both directions, or + and -",
    },
    HelpLine {
        usage: "sim cogging NEWTON METRE",
        what: "its motor prefers positions: amplitude and wavelength",
    },
    HelpLine { usage: "sim hang NEWTON", what: "a weight on the load cell, for `calibrate`" },
    HelpLine { usage: "sim tilt up|down|level", what: "gravity on the accelerometer, for `calibrate`" },
    HelpLine { usage: "sim truth", what: "the true state of the rig" },
];

impl SimulatedBoard {
    fn new(
        config: &VirtualConfig,
        flash: SimulatedFlash,
        each: &mut dyn FnMut(u8, &[u8]),
    ) -> Result<Self, Unfit> {
        let rig = Rig::new(config.rig, NOTHING, config.seed).map_err(Unfit::Rig)?;
        let lasting = flash.lasting();
        let library = block_on(Library::open(flash, each)).map_err(Unfit::Presets)?;
        let counted_from = rig.sensors().count;
        let nominal = expected(&config.rig);
        Ok(Self {
            nominal,
            plant: nominal,
            rig,
            counted_from,
            hand: Holder::Nobody,
            force: 0.0,
            amplifier: false,
            outputs: Outputs::default(),
            command_broken: false,
            milliseconds: 0,
            library,
            stored: None,
            lasting,
        })
    }

    fn periods_in_ms(&self) -> u32 {
        let config = self.rig.config();
        (config.calibration.tick_hz / 1_000).checked_div(config.period_ticks).unwrap_or(1).max(1)
    }

    /// Puts another device in place of the one that is there.
    fn replace(&mut self, plant: &Device) -> Result<(), Invalid> {
        self.rig.reconfigure(rig_of(plant, self.rig.config()))?;
        self.plant = *plant;
        Ok(())
    }

    fn sim(&mut self, words: &[&str], out: &mut dyn Write) -> Result<(), &'static str> {
        let wrong = |out: &mut dyn Write, word: &str, accepted: &str| {
            // writing to a String cannot fail
            let _ = write!(out, "`{word}`: expected one of {accepted}");
            "SYNTAX"
        };
        let number = |out: &mut dyn Write, what: &str, text: &str, most: f64| {
            let number = text.parse::<f64>().ok().filter(|x| x.abs() <= most);
            number.ok_or_else(|| {
                let _ = write!(out, "{what} = `{text}`: expected a number from -{most} to {most}");
                "VALUE"
            })
        };
        let plant = self.plant;
        // of the default device; exact for that one
        let length = |metre: f64| metre * f64::from(plant.length(1.0));
        let unit = |dimension: Dimension| dimension.unit(plant.geometry);
        match words {
            ["device", pairs @ ..] if !pairs.is_empty() && pairs.len().is_multiple_of(2) => {
                let mut plant = self.plant;
                for pair in pairs.chunks_exact(2) {
                    if let Err(wrong) = plant.set(pair[0], pair[1]) {
                        let _ = write!(out, "{wrong}");
                        return Err("VALUE");
                    }
                }
                if let Err(invalid) = self.replace(&plant) {
                    let _ = write!(out, "{invalid}");
                    return Err("REFUSED");
                }
                let _ = write!(out, "device {}", pairs.join(" "));
            }
            ["device", ..] => return Err(wrong(out, &words.join(" "), "device NAME VALUE …")),
            ["hand", "off"] => {
                self.hand = Holder::Nobody;
                let _ = write!(out, "hand off");
            }
            ["hand", "hold"] => {
                let position = self.rig.truth().position;
                self.hand = Holder::Hand(HandImpedance::relaxed(Target::Hold { position })).of_size(&plant);
                let _ = write!(out, "hand holds at {position:.4} {}", unit(Dimension::LENGTH));
            }
            ["hand", "at", text] => {
                let to = number(out, "METRE", text, length(0.016))?;
                let t = self.rig.truth();
                self.hand = self.hand.pointed(to, t.time, t.position).of_size(&plant);
                let _ = write!(out, "hand moves to {to} {}", unit(Dimension::LENGTH));
            }
            ["hand", "push", text] => {
                let force = number(out, "NEWTON", text, 20.0 * f64::from(plant.force(1.0)))?;
                self.hand = Holder::Force(HandForce::Steps(vec![(0.0, force)]));
                let _ = write!(out, "hand pushes with {force} {}", unit(Dimension::FORCE));
            }
            ["hand", "sine", amplitude, frequency] => {
                let amplitude = number(out, "AMP", amplitude, length(0.015))?;
                let frequency = number(out, "FREQ", frequency, 10.0)?;
                self.hand = Holder::to_and_fro(amplitude, frequency).of_size(&plant);
                let _ = write!(out, "hand moves {amplitude} {} at {frequency} Hz", unit(Dimension::LENGTH));
            }
            ["hand", word, ..] => {
                return Err(wrong(out, word, "off, hold, at METRE, push NEWTON, sine AMP FREQ"));
            }
            ["block", "none"] => {
                let _ = self.rig.set_block(0.0, NOTHING);
                let _ = write!(out, "block off: the handle is free");
            }
            ["block", name] => {
                let Some(material) = material(name) else {
                    return Err(wrong(out, name, "none, brass, teflon, rubber"));
                };
                let (mass, law) = block_of_size(material.mass, material.law, &plant);
                let _ = self.set_block(mass, law, &[]);
                let _ = write!(out, "block of {mass} {} on {}", unit(Dimension::MASS), material.name);
            }
            ["truth"] => {
                let t = self.rig.truth();
                let (m, n) = (unit(Dimension::LENGTH), unit(Dimension::FORCE));
                let _ = write!(
                    out,
                    "t {:.3} s, handle {:.6} {m} {:.4} {m}/s {:.3} {m}/s2, block friction {:.3} {n}, hand {:.3} {n}, actuator {:.3} {n}",
                    t.time,
                    t.position,
                    t.velocity,
                    t.acceleration,
                    t.friction,
                    t.hand_force,
                    t.actuator_force
                );
            }
            ["wire", "command", how @ ("right" | "dead")] => {
                self.command_broken = *how == "dead";
                let _ = write!(out, "wire of command {how}");
            }
            ["wire", "command", how] => return Err(wrong(out, how, "right, dead")),
            ["wire", signal @ ("encoder" | "load" | "accel" | "amplifier"), how] => {
                let Some(wire) = Wire::from_id(how) else {
                    return Err(wrong(out, how, "right, swapped, dead, floating"));
                };
                let mut config = *self.rig.config();
                match *signal {
                    "encoder" => config.wiring.encoder = wire,
                    "load" => config.wiring.load = wire,
                    "accel" => config.wiring.accel = wire,
                    _ => config.wiring.amplifier = wire,
                }
                let _ = self.rig.reconfigure(config);
                let _ = write!(out, "wire of {signal} {how}");
            }
            ["wire", word, ..] => return Err(wrong(out, word, "encoder, load, accel, amplifier, command")),
            ["friction", p, rest @ ..] if rest.len() < 2 => {
                let most = 0.3 * f64::from(plant.force_max);
                let p = number(out, "NEWTON", p, most)?.abs();
                let n = rest.first().map_or(Ok(p), |n| number(out, "NEWTON", n, most))?.abs();
                let friction = RigConfig { device_friction_p: p, device_friction_n: n, ..*self.rig.config() };
                let _ = self.rig.reconfigure(friction);
                let _ = write!(out, "device friction {p} {n} {}", unit(Dimension::FORCE));
            }
            [word, amplitude, wavelength] if *word == EffectKind::Cogging.id() => {
                let amplitude = number(out, "NEWTON", amplitude, 0.3 * f64::from(plant.force_max))?.abs();
                let every = number(out, "METRE", wavelength, length(0.032))?;
                let cogging = RigConfig {
                    device_cogging: amplitude,
                    device_cogging_wavelength: every,
                    ..*self.rig.config()
                };
                if let Err(invalid) = self.rig.reconfigure(cogging) {
                    let _ = write!(out, "{invalid}");
                    return Err("REFUSED");
                }
                let (n, m) = (unit(Dimension::FORCE), unit(Dimension::LENGTH));
                let _ = write!(out, "cogging {amplitude} {n} every {every} {m}");
            }
            ["hang", text] => {
                let weight = number(out, "NEWTON", text, 44.0 * f64::from(plant.force(1.0)))?;
                let bench = Bench { weight, ..self.rig.config().bench };
                let _ = self.rig.reconfigure(RigConfig { bench, ..*self.rig.config() });
                let _ = write!(
                    out,
                    "{weight} {} hang on the load cell, the slide is locked",
                    unit(Dimension::FORCE)
                );
            }
            ["tilt", word @ ("up" | "down" | "level")] => {
                let gravity = match *word {
                    "up" => GRAVITY,
                    "down" => -GRAVITY,
                    _ => 0.0,
                };
                let bench = Bench { gravity, ..self.rig.config().bench };
                let _ = self.rig.reconfigure(RigConfig { bench, ..*self.rig.config() });
                let _ = write!(out, "accelerometer {word}, the slide is locked");
            }
            ["tilt", word, ..] => return Err(wrong(out, word, "up, down, level")),
            _ => {
                return Err(wrong(
                    out,
                    &words.join(" "),
                    "device …, hand …, block …, wire …, friction …, cogging …, hang …, tilt …, truth",
                ));
            }
        }
        Ok(())
    }

    fn set_block(&mut self, mass: f64, law: Karnopp<f64>, effects: &[Effect<f64>]) -> Result<(), Invalid> {
        let mut slide = Layered::with(Law::Karnopp(law), effects)?;
        slide.block_mass = Some(mass);
        self.rig.set_block(mass, slide)
    }
}

impl RealTime for SimulatedBoard {
    /// One period of the rig under the last force.
    fn sample(&mut self) -> Inputs {
        let force = if self.amplifier { self.force } else { 0.0 };
        let sensors = self.rig.tick(force, &mut self.hand);
        let count = sensors.count.wrapping_sub(self.counted_from);
        let count = if self.plant.encoder_reversed { count.wrapping_neg() } else { count };
        Inputs { count, ..inputs(&sensors) }
    }

    fn output(&mut self, force: Option<f32>, command: &Command) {
        let amplifier = &self.plant.command;
        let (zero, gain) = (f64::from(amplifier.offset_code), f64::from(amplifier.unit_per_code));
        self.force = if self.command_broken {
            // 0 V
            -zero * gain
        } else {
            let apart = gain / f64::from(command.newton_per_code);
            f64::from(force.unwrap_or(0.0)) * apart + (f64::from(command.zero) - zero) * gain
        };
    }

    fn enable(&mut self, on: bool) {
        self.amplifier = on;
    }

    fn end(&mut self, _: u32, _: &Inputs, outputs: &Outputs) -> bool {
        self.outputs = *outputs;
        false
    }

    fn pace(&mut self, period_ticks: u32) {
        // an invalid length keeps the old one, and the loop latches a missed deadline
        let _ = self.rig.set_period_ticks(period_ticks);
    }
}

impl Board for SimulatedBoard {
    fn name(&self) -> &'static str {
        "the simulated rig"
    }

    fn device(&self) -> Device {
        Device { period: self.rig.config().period() as f32, ..self.nominal }
    }

    fn now_ms(&self) -> u32 {
        // wraps as on the board
        self.milliseconds as u32
    }

    fn clock(&self) -> &'static str {
        "virtual time"
    }

    fn late_steps(&self) -> u32 {
        0
    }

    fn store(&mut self, key: u8, item: &[u8]) {
        self.stored = Some(block_on(self.library.store(key, item)));
    }

    fn stored(&mut self) -> Option<Result<(), NotStored>> {
        self.stored.take()
    }

    fn lasting(&self) -> &str {
        &self.lasting
    }

    fn help(&self) -> &'static [HelpLine] {
        HELP
    }

    fn command(&mut self, line: &str, out: &mut dyn Write) -> Option<Result<(), &'static str>> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.split_first() {
            Some((&"sim", rest)) => Some(self.sim(rest, out)),
            _ => None,
        }
    }
}

/// The firmware application on the simulated rig, in virtual time, as fast as it is called.
///
/// ```
/// let mut device = tribos_firmware::VirtualDevice::new(&Default::default())?;
/// device.write(b"preset use rubber\n");
/// let mut answer = Vec::new();
/// for _ in 0..10 {
///     device.tick();
///     device.read(&mut answer);
/// }
/// assert_eq!(answer, b"ok rubber\r\n");
/// # Ok::<(), tribos_firmware::board::simulated::Unfit>(())
/// ```
pub struct VirtualDevice {
    real_time: RealTimeLoop<SimulatedBoard>,
    desk: Desk,
    queues: Queues,
    listener: Listener,
    input: VecDeque<u8>,
    output: Vec<u8>,
}

/// An invalid configuration of the virtual device.
#[derive(Debug, Clone, PartialEq)]
pub enum Unfit {
    /// A parameter of the rig is out of range.
    Rig(Invalid),
    /// The first preset cannot be rendered on it.
    Preset(haptics::Refused),
    /// The flash for its presets cannot be used.
    Presets(NotStored),
}

impl std::fmt::Display for Unfit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rig(invalid) => write!(f, "the simulated rig: {invalid}"),
            Self::Preset(refused) => write!(f, "the first preset on this rig: {refused}"),
            Self::Presets(why) => write!(f, "the presets: {why}"),
        }
    }
}

impl std::error::Error for Unfit {}

impl VirtualDevice {
    /// Boots the device.
    ///
    /// # Errors
    /// A parameter of the rig is out of range, or the first preset cannot be rendered on it.
    pub fn new(config: &VirtualConfig) -> Result<Self, Unfit> {
        Self::with_flash(config, SimulatedFlash::default())
    }

    /// Boots the device with the presets of a flash.
    ///
    /// # Errors
    /// As [`Self::new`], or the flash cannot be repaired.
    pub fn with_flash(config: &VirtualConfig, flash: SimulatedFlash) -> Result<Self, Unfit> {
        let mut items = Vec::new();
        let mut board =
            SimulatedBoard::new(config, flash, &mut |key, item| items.push((key, item.to_vec())))?;
        let mut desk = Desk::new(board.device());
        for (key, item) in &items {
            desk.load(*key, item);
        }
        desk.loaded(None, &mut board);
        let control = ControlLoop::new(desk.config().map_err(Unfit::Preset)?);
        Ok(Self {
            real_time: RealTimeLoop::new(board, control, None),
            desk,
            queues: Queues::default(),
            listener: Listener::new(),
            input: VecDeque::new(),
            output: Vec::new(),
        })
    }

    /// The same on another device than the firmware expects, as the command `sim device` makes one.
    ///
    /// # Errors
    /// As [`Self::with_flash`].
    pub fn on_device(config: &VirtualConfig, flash: SimulatedFlash, plant: &Device) -> Result<Self, Unfit> {
        let mut device = Self::with_flash(config, flash)?;
        device.real_time.board.replace(plant).map_err(Unfit::Rig)?;
        Ok(device)
    }

    /// Cuts the power. The flash with the presets remains.
    #[must_use]
    pub fn power_off(self) -> SimulatedFlash {
        self.real_time.board.library.close()
    }

    /// Sends bytes to the device.
    pub fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.listener.hear(*byte, self.queues.off(), |byte| {
                self.input.push_back(byte);
                true
            });
        }
    }

    /// Appends bytes that the device sent since the last call.
    pub fn read(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.output);
    }

    /// Whether every byte is read and every command answered.
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.input.is_empty()
            && !self.desk.is_busy()
            && self.output.is_empty()
            && self.desk.waiting_output() == 0
    }

    /// Advances by one millisecond of virtual time, with as many control periods as the rate has.
    pub fn tick(&mut self) {
        let (mut control_ends, mut desk_ends) = self.queues.split();
        for _ in 0..self.real_time.board.periods_in_ms() {
            let before = self.real_time.board.rig.config().period_ticks;
            self.real_time.step(&mut control_ends);
            if self.real_time.board.rig.config().period_ticks != before {
                break;
            }
        }
        self.real_time.board.milliseconds += 1;
        let (bytes, _) = self.input.as_slices();
        let taken = self.desk.receive(bytes, &mut desk_ends, &mut self.real_time.board);
        self.input.drain(..taken);
        self.desk.poll(&mut desk_ends, &mut self.real_time.board);
        let mut room = BYTES_PER_PERIOD.min(UNREAD.saturating_sub(self.output.len()));
        while room > 0 {
            let front = self.desk.output().front();
            let count = front.len().min(room);
            if count == 0 {
                break;
            }
            self.output.extend_from_slice(&front[..count]);
            self.desk.output().sent(count);
            room -= count;
        }
    }

    /// Searches both stops, as the command `home` does. The answer and the result are not left to read.
    ///
    /// # Errors
    /// The line of the device that says why not.
    pub fn home(&mut self) -> Result<(), String> {
        self.write(b"home\n");
        let mut said = Vec::new();
        for _ in 0..LONGEST_SEARCH_MS {
            self.tick();
            self.read(&mut said);
            if self.is_quiet() && !self.mode().is_driven() {
                break;
            }
        }
        if self.real_time.board.outputs.referenced {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&said);
        Err(said.lines().last().unwrap_or("`home` was not answered").to_owned())
    }

    /// Outputs of the last control step.
    #[must_use]
    pub fn outputs(&self) -> &Outputs {
        &self.real_time.board.outputs
    }

    /// State of the control loop.
    #[must_use]
    pub fn state(&self) -> &haptics::State {
        self.real_time.control().state()
    }

    /// Mode of the control loop.
    #[must_use]
    pub fn mode(&self) -> ModeId {
        self.real_time.board.outputs.mode
    }

    /// Name of the active preset.
    #[must_use]
    pub fn preset(&self) -> &str {
        self.desk.preset()
    }

    /// True state of the rig.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.real_time.board.rig.truth()
    }

    /// Control period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.real_time.board.rig.config().period()
    }

    /// The device as the firmware knows it: its settings and calibration.
    #[must_use]
    pub fn device(&self) -> Device {
        *self.desk.device()
    }

    /// Puts a hand on the handle.
    pub fn hold(&mut self, hand: Holder) {
        self.real_time.board.hand = hand;
    }

    /// Mounts a real block of `mass`, kg, with friction by `law` and concealed effects. Mass 0 removes it.
    ///
    /// # Errors
    /// A parameter out of range, or too many effects. The old block stays.
    pub fn set_block(
        &mut self,
        mass: f64,
        law: Karnopp<f64>,
        concealed: &[Effect<f64>],
    ) -> Result<(), Invalid> {
        self.real_time.board.set_block(mass, law, concealed)
    }
}
