//! The rig connected to the pins.

use crate::UNITS_PER_SECOND;
use friction::FrictionLaw;
use plant::{Bench, Hand, NoHand, Rig, RigConfig, Sensors, Truth, Wiring};
use std::collections::VecDeque;

/// The amplifier: code of the DAC without force, and force per code, N.
const AMPLIFIER: (f64, f64) = (2048.0, 11.0 / 2048.0);
/// Length of a chunk of the rig, 170 MHz ticks: 10 µs.
const CHUNK_TICKS: u32 = 1_700;
const UNITS_PER_TICK: u64 = UNITS_PER_SECOND / 170_000_000;
/// Chunks whose levels are kept.
const LOADS: usize = 100;
const CHUNK: u64 = CHUNK_TICKS as u64 * UNITS_PER_TICK;

/// A rig with any law, and the hand on it.
trait AnyRig: Send {
    fn tick(&mut self, force: f64, hand: &mut dyn Hand) -> Sensors;
    fn truth(&self) -> Truth;
    fn config(&self) -> RigConfig;
    fn reconfigure(&mut self, config: RigConfig) -> Result<(), friction::Invalid>;
}

impl<L> AnyRig for Rig<L>
where
    L: FrictionLaw<f64> + Send,
    L::State: Send,
{
    fn tick(&mut self, force: f64, hand: &mut dyn Hand) -> Sensors {
        Rig::tick(self, force, hand)
    }

    fn truth(&self) -> Truth {
        Rig::truth(self)
    }

    fn config(&self) -> RigConfig {
        *Rig::config(self)
    }

    fn reconfigure(&mut self, config: RigConfig) -> Result<(), friction::Invalid> {
        Rig::reconfigure(self, config)
    }
}

/// The rig, computed one chunk ahead, so that edges occur at their time within it.
pub(crate) struct World {
    rig: Box<dyn AnyRig>,
    hand: Box<dyn Hand + Send>,
    /// End of the computed chunk.
    until: u64,
    sensors: Sensors,
    /// Future edges: (time, forward).
    edges: VecDeque<(u64, bool)>,
    /// Time and direction of the last edge.
    last_edge: (u64, bool),
    /// Count of the rig after the edges that were taken.
    place: i32,
    /// Count of the rig at which the encoder's index is high.
    index: Option<i32>,
    /// Present levels, and those at the end of the chunk.
    levels: (u16, u16),
    /// Levels of the load cell in the chunks up to the present one, which is the last.
    loads: VecDeque<u16>,
    force: f64,
    /// As [`AMPLIFIER`].
    amplifier: (f64, f64),
    /// The wire of the command is broken: the amplifier's input is at 0 V.
    pub command_broken: bool,
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World").field("until", &self.until).finish_non_exhaustive()
    }
}

impl World {
    /// A world whose rig advances in small steps, with the actuation delay of the emulated board.
    pub fn new<L>(config: RigConfig, law: L, seed: u64) -> Result<Self, friction::Invalid>
    where
        L: FrictionLaw<f64> + Send + 'static,
        L::State: Send,
    {
        let config = RigConfig {
            period_ticks: CHUNK_TICKS,
            substeps: 10,
            actuation_delay: 0,
            clock_jitter_ticks: 0.0,
            ..config
        };
        let rig = Rig::new(config, law, seed)?;
        let sensors = rig.sensors();
        Ok(Self {
            levels: (sensors.load_code, sensors.accel_code),
            loads: VecDeque::from([sensors.load_code; LOADS]),
            rig: Box::new(rig),
            hand: Box::new(NoHand),
            until: 0,
            sensors,
            edges: VecDeque::new(),
            last_edge: (0, true),
            place: sensors.count as i32,
            index: None,
            force: 0.0,
            amplifier: AMPLIFIER,
            command_broken: false,
        })
    }

    pub fn set_hand(&mut self, hand: Box<dyn Hand + Send>) {
        self.hand = hand;
    }

    pub fn rewire(&mut self, wiring: Wiring) {
        // nothing else changes, so this cannot fail
        let _ = self.rig.reconfigure(RigConfig { wiring, ..self.rig.config() });
    }

    pub fn put_on_bench(&mut self, bench: Bench) -> Result<(), friction::Invalid> {
        self.rig.reconfigure(RigConfig { bench, ..self.rig.config() })
    }

    /// Replaces the amplifier: its gain as a share of the normal one, and the force at the normal code of zero, N.
    pub fn set_amplifier(&mut self, gain: f64, at_zero: f64) {
        let (zero, newton_per_code) = AMPLIFIER;
        self.amplifier = (zero - at_zero / (gain * newton_per_code), gain * newton_per_code);
    }

    pub fn truth(&self) -> Truth {
        self.rig.truth()
    }

    /// Position of the handle at a time shortly before the end of the computed chunk, m.
    pub fn position_at(&self, at: u64) -> f64 {
        let truth = self.rig.truth();
        let ahead = (self.until as f64 - at as f64) / UNITS_PER_SECOND as f64;
        truth.position - truth.velocity * ahead
    }

    /// 16-bit level of the load cell at a time of the last millisecond.
    pub fn load_at(&self, at: u64) -> u16 {
        let back = (self.until.saturating_sub(at) / CHUNK).saturating_sub(1) as usize;
        self.loads.iter().rev().nth(back).or(self.loads.front()).copied().unwrap_or(0)
    }

    pub fn force(&self) -> f64 {
        self.force
    }

    /// 16-bit level of an ADC input at 3.3 V.
    pub fn level(&self, channel: u32) -> u16 {
        match channel {
            6 => self.levels.0,
            7 => self.levels.1,
            _ => 0,
        }
    }

    pub fn next_event(&self) -> u64 {
        self.edges.front().map_or(self.until, |(at, _)| (*at).min(self.until))
    }

    /// Next due edge.
    pub fn edge(&mut self, now: u64) -> Option<(u64, bool)> {
        let due = self.edges.front().is_some_and(|(at, _)| *at <= now);
        let edge = if due { self.edges.pop_front() } else { None };
        if let Some((_, up)) = edge {
            self.place = self.place.wrapping_add(if up { 1 } else { -1 });
        }
        edge
    }

    /// Puts the encoder's index to a place of the stroke, m.
    pub fn set_index(&mut self, position: f64) {
        self.index = Some((position / self.rig.config().calibration.metre_per_count).round() as i32);
    }

    /// Whether the index is high.
    pub fn at_index(&self) -> bool {
        self.index == Some(self.place)
    }

    /// Computes the next chunk if it is due. `code` is the DAC's output at 3.3 V while the amplifier is on.
    pub fn advance(&mut self, now: u64, code: Option<f64>) {
        while now >= self.until {
            let code = code.map(|code| if self.command_broken { 0.0 } else { code });
            let (zero, newton_per_code) = self.amplifier;
            self.force = code.map_or(0.0, |code| (code - zero) * newton_per_code);
            self.levels = (self.sensors.load_code, self.sensors.accel_code);
            self.loads.pop_front();
            self.loads.push_back(self.levels.0);
            let before = self.sensors;
            let start = self.until;
            self.sensors = self.rig.tick(self.force, &mut *self.hand);
            self.until += CHUNK;
            self.schedule(before, start);
        }
    }

    /// Spreads the edges of a chunk evenly from the previous edge to the last one, whose time comes from the rig. After a pause
    /// or a reversal they are spread over the chunk.
    fn schedule(&mut self, before: Sensors, start: u64) {
        let moved = self.sensors.count.wrapping_sub(before.count) as i32;
        let (edges, up) = (u64::from(moved.unsigned_abs()), moved > 0);
        if edges == 0 {
            return;
        }
        let start_ticks = (start / UNITS_PER_TICK) as u32;
        let ticks = u64::from(self.sensors.edge_ticks.wrapping_sub(start_ticks)).min(u64::from(CHUNK_TICKS));
        let last = start + ticks * UNITS_PER_TICK;
        let (previous, was_up) = self.last_edge;
        let even = was_up == up && previous + last.saturating_sub(previous) / edges >= start;
        let from = if even { previous.min(last) } else { start };
        for k in 1..=edges {
            self.edges.push_back((from + (last - from) * k / edges, up));
        }
        self.last_edge = (last, up);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_come_at_the_pace_of_the_motion() {
        let law = friction::Custom(|_: &friction::Motion<f64>| 0.0);
        let mut world = World::new(RigConfig::free_handle(), law, 1).expect("a rig");
        world.set_hand(Box::new(|_: f64, _: f64, _: f64| 40.0));
        let (mut last, mut worst, mut now) = (0_u64, 0.0_f64, 0_u64);
        while world.truth().velocity < 0.9 {
            now += CHUNK / 7;
            world.advance(now, None);
            while let Some((at, up)) = world.edge(now) {
                let v = world.truth().velocity;
                if v > 0.2 {
                    assert!(up);
                    let interval = (at - last) as f64 / crate::UNITS_PER_SECOND as f64;
                    worst = worst.max((interval * v / 2.57e-6 - 1.0).abs());
                }
                last = at;
            }
        }
        println!("edges at most {worst:.2} of a count from where the motion has them");
        assert!(worst < 0.02);
    }
}
