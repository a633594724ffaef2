//! Readings made up for the ELF: what a hand might do, what must trip a check, and any bits at all.

use emulator::Injected;
use emulator::random::Random;

/// Ticks in a period.
pub const PERIOD: u32 = 170_000;
const MID: u16 = 32_768;
/// Codes of the accelerometer for a change of speed by a count a period: 2.57 m/s².
const PER_CHANGE: i32 = 172;
/// Counts from the middle to where the made-up handle turns round: 12 mm.
const TURN: i32 = 4_700;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Style {
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
pub struct Source {
    pub random: Random,
    pub style: Style,
    count: i32,
    speed: i32,
    /// How the hand moves, and for how many samples yet.
    motion: (u32, u32),
    /// Random readings so far: all but those at rest and on the way there.
    pub random_given: u32,
    /// Samples at a rail to come.
    rails: u32,
    /// Samples so far.
    given: u16,
    pub skew: u32,
}

impl Source {
    pub fn at_rest(seed: u64) -> Self {
        Self {
            random: Random(seed),
            style: Style::Rest,
            count: 0,
            speed: 0,
            motion: (0, 0),
            random_given: 0,
            rails: 0,
            given: 0,
            skew: 0,
        }
    }

    pub fn next(&mut self) -> Injected {
        self.given = self.given.wrapping_add(1);
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
                let edge_age = moved.then(|| r.draw() as u32 % (PERIOD / 2));
                // the noise of a sensor that lives
                let code = MID + (self.given & 1);
                Injected { load_code: code, accel_code: code, count: self.count as u32, edge_age, skew_ticks }
            }
            Style::Any => Injected {
                load_code: r.draw() as u16,
                accel_code: [0, u16::MAX, r.draw() as u16][(r.draw() % 3) as usize],
                count: [0, i32::MAX as u32, i32::MIN as u32, u32::MAX, r.draw() as u32]
                    [(r.draw() % 5) as usize],
                edge_age: Some(
                    [0, u32::MAX, r.draw() as u32, r.draw() as u32 % PERIOD][(r.draw() % 4) as usize],
                ),
                // the second: the stamp of the sample before, again
                skew_ticks: [0, PERIOD.wrapping_neg(), r.draw() as u32][(r.draw() % 3) as usize],
            },
            Style::Hand => self.hand(),
            Style::Trips => {
                let hand = self.hand();
                let r = &mut self.random;
                if self.rails > 0 {
                    // three in a row are a fault
                    self.rails -= 1;
                    return Injected { load_code: [0, u16::MAX][(r.draw() % 2) as usize], ..hand };
                }
                match r.draw() % 600 {
                    0 => Injected { count: r.draw() as u32, ..hand },
                    1 => Injected { skew_ticks: r.draw() as u32, ..hand },
                    2..5 => {
                        self.rails = 4;
                        hand
                    }
                    12 => Injected { edge_age: Some(PERIOD - 1), ..hand },
                    13 => Injected { skew_ticks: PERIOD.wrapping_neg(), ..hand },
                    14 => Injected {
                        count: [i32::MAX as u32, i32::MIN as u32][(r.draw() % 2) as usize],
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
            self.motion = (r.draw() as u32 % 6, 50 + r.draw() as u32 % 300);
        }
        self.motion.1 -= 1;
        let (before, speed) = (self.count, self.speed);
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
        let age = match r.draw() % 50 {
            // the capture failed, or is of another edge
            0 => Some(r.draw() as u32),
            1 => Some(r.draw() as u32 % (PERIOD / 2)),
            // the stamp of the edge before, again
            2 => None,
            _ => moved.then(|| r.draw() as u32 % (PERIOD / 2)),
        };
        // What contradicts itself is a fault, and most samples after a fault are for nothing: the accelerometer follows, and at
        // rest there is only the noise of a sensor.
        let most = if self.motion.0 > 3 { 20 } else { 700 };
        let noise = |r: &mut Random| i32::from(MID) + r.within(most);
        let load_code = noise(r) as u16;
        let accel_code = (noise(r) + PER_CHANGE * (self.speed - speed)).clamp(100, 65_400) as u16;
        Injected { load_code, accel_code, count: self.count as u32, edge_age: age, skew_ticks: 0 }
    }
}
