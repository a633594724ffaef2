//! The rig, one control period at a time.

use crate::contact::{Body, Surface, finite};
use crate::encoder::{Encoder, Segment};
use crate::noise::Noise;
use crate::{Coupling, Hand, RigConfig, Sensors, Truth, Wire, Zoh};
use friction::{FrictionLaw, Invalid};

/// Step length with which a law is evaluated at one instant, s.
const INSTANT: f64 = 1e-9;
/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Longest actuation delay, control periods.
const DELAY: usize = 9;

/// Exact coefficients of one step length.
#[derive(Debug, Clone, Copy)]
struct Steps {
    handle: Zoh,
    block: Zoh,
}

/// The simulated rig, with a block that slides by the law `L`.
///
/// ```
/// use plant::{NoHand, Rig, RigConfig};
/// let dry = friction::Custom(|m: &friction::Motion<f64>| 2.0 * friction::Scalar::sgn(m.velocity));
/// let mut rig = Rig::new(RigConfig::default(), dry, 1)?;
/// for _ in 0..100 {
///     rig.tick(2.0, &mut NoHand); // below the break-away of device and block
/// }
/// assert_eq!(rig.truth().position, 0.0);
/// # Ok::<(), friction::Invalid>(())
/// ```
#[derive(Debug, Clone)]
pub struct Rig<L: FrictionLaw<f64>> {
    config: RigConfig,
    law: L,
    state: L::State,
    seed: u64,
    handle: Body,
    block: Body,
    hand_mass: f64,
    normal: f64,
    steps: Steps,
    encoder: Encoder,
    /// The latest commands, the newest at index `newest`.
    commands: [f64; DELAY],
    newest: usize,
    /// Time at which the period got its present length, ticks since the start.
    origin: u64,
    /// Control periods since that time.
    periods: u64,
    /// Offset of the last sample from its nominal time, ticks.
    jitter: i32,
    load_noise: Noise,
    accel_noise: Noise,
    clock_noise: Noise,
    sensors: Sensors,
    truth: Truth,
}

impl<L: FrictionLaw<f64>> Rig<L> {
    /// A rig at rest, its noise drawn from `seed`.
    ///
    /// # Errors
    /// The first parameter of `config` or `law` that is out of range, with the accepted range.
    pub fn new(config: RigConfig, law: L, seed: u64) -> Result<Self, Invalid> {
        config.validate()?;
        law.validate()?;
        let still = Body { mass: 1.0, damping: 0.0, position: config.start_position, velocity: 0.0 };
        let zoh = Zoh::new(1.0, 0.0, config.substep());
        let mut rig = Self {
            law,
            state: L::State::default(),
            seed,
            handle: still,
            block: still,
            hand_mass: 0.0,
            normal: 0.0,
            steps: Steps { handle: zoh, block: zoh },
            encoder: Encoder::new(config.calibration.metre_per_count, config.start_position),
            commands: [0.0; DELAY],
            newest: 0,
            origin: 0,
            periods: 0,
            jitter: 0,
            load_noise: Noise::new(seed, 1),
            accel_noise: Noise::new(seed, 2),
            clock_noise: Noise::new(seed, 3),
            sensors: Sensors::default(),
            truth: Truth {
                position: config.start_position,
                block_position: config.start_position,
                ..Truth::default()
            },
            config,
        };
        rig.rebuild();
        rig.sensors = rig.sample();
        Ok(rig)
    }

    /// Sets the length of a control period from the next tick on, timer ticks.
    ///
    /// # Errors
    /// A length out of range. The old length stays.
    pub fn set_period_ticks(&mut self, ticks: u32) -> Result<(), Invalid> {
        let changed = RigConfig { period_ticks: ticks, ..self.config };
        changed.validate()?;
        self.origin = self.ticks_of(self.periods);
        self.periods = 0;
        self.config = changed;
        self.rebuild();
        Ok(())
    }

    /// Advances one control period and returns the samples at its end.
    ///
    /// `command`, N, acts after the actuation delay, limited to the range of the actuator. The `hand` acts at once. A
    /// non-finite command acts as 0 N and is counted in [`Truth::not_finite`].
    pub fn tick(&mut self, command: f64, hand: &mut dyn Hand) -> Sensors {
        let hand_mass = hand.mass();
        if hand_mass != self.hand_mass {
            self.hand_mass = finite(hand_mass, &mut self.truth.not_finite).max(0.0);
            self.rebuild();
        }
        self.newest = (self.newest + 1) % DELAY;
        self.commands[self.newest] = finite(command, &mut self.truth.not_finite);
        let acting = (self.newest + DELAY - self.config.actuation_delay as usize) % DELAY;
        let mut actuator = self.commands[acting];
        if let Some(limit) = self.config.force_max {
            actuator = actuator.clamp(-limit, limit);
        }
        actuator = self.config.wiring.amplifier.pass(actuator).unwrap_or(0.0);
        self.truth.actuator_force = actuator;

        let h = self.config.substep();
        let tick = 1.0 / f64::from(self.config.calibration.tick_hz);
        let mut start = f64::from(self.jitter) * tick;
        let began = self.time_of(self.periods);
        if self.config.clock_jitter_ticks > 0.0 {
            let limit = 0.25 * h / tick;
            let drawn = self.clock_noise.draw(self.config.clock_jitter_ticks).clamp(-limit, limit);
            self.jitter = libm::round(drawn) as i32;
            // only the first and the last step of a period differ in length
            let last = self.config.substeps - 1;
            for k in 0..self.config.substeps {
                let nominal_end = f64::from(k + 1) * h;
                let end = if k == last { nominal_end + f64::from(self.jitter) * tick } else { nominal_end };
                let steps = if k == 0 || k == last { self.steps_of(end - start) } else { self.steps };
                self.substep(began, start, actuator, hand, &steps);
                start = end;
            }
        } else {
            let steps = self.steps;
            for _ in 0..self.config.substeps {
                self.substep(began, start, actuator, hand, &steps);
                start += h;
            }
        }
        self.periods += 1;
        self.truth.time = self.time_of(self.periods) + f64::from(self.jitter) * tick;
        self.observe(actuator, hand);
        self.sensors = self.sample();
        self.sensors
    }

    /// The samples that [`Self::tick`] returned last; at the start, those of the rig at rest.
    #[must_use]
    pub fn sensors(&self) -> Sensors {
        self.sensors
    }

    /// The true state, without noise.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// The configuration in use.
    #[must_use]
    pub fn config(&self) -> &RigConfig {
        &self.config
    }

    /// The law of the block.
    #[must_use]
    pub fn law(&self) -> &L {
        &self.law
    }

    /// Replaces the surface under the block at once. The contact starts fresh.
    ///
    /// # Errors
    /// The first parameter of `law` that is out of range. The old law stays.
    pub fn set_law(&mut self, law: L) -> Result<(), Invalid> {
        law.validate()?;
        self.law = law;
        self.state = L::State::default();
        Ok(())
    }

    /// Replaces block and surface. Mass 0 removes the block.
    ///
    /// # Errors
    /// The first parameter that is out of range. The old block stays.
    pub fn set_block(&mut self, mass: f64, law: L) -> Result<(), Invalid> {
        law.validate()?;
        self.reconfigure(RigConfig { block_mass: mass, ..self.config })?;
        self.block.position = self.handle.position;
        self.block.velocity = self.handle.velocity;
        self.set_law(law)
    }

    /// Changes the configuration while the rig runs. Position, velocity, time and noise continue.
    ///
    /// # Errors
    /// The first parameter out of range. The old configuration stays.
    pub fn reconfigure(&mut self, config: RigConfig) -> Result<(), Invalid> {
        config.validate()?;
        let encoder_changed = config.calibration.metre_per_count != self.config.calibration.metre_per_count;
        self.config = config;
        if encoder_changed {
            self.encoder = Encoder::new(config.calibration.metre_per_count, self.handle.position);
        }
        self.rebuild();
        Ok(())
    }

    /// Returns to t = 0, at rest at the start position, with the same seed. A run then repeats bit for bit.
    pub fn reset(&mut self)
    where
        L: Clone,
    {
        if let Ok(fresh) = Self::new(self.config, self.law.clone(), self.seed) {
            *self = fresh;
        }
    }

    fn rigid(&self) -> bool {
        self.config.block_mass == 0.0 || self.config.coupling == Coupling::Rigid
    }

    fn time_of(&self, periods: u64) -> f64 {
        self.ticks_of(periods) as f64 / f64::from(self.config.calibration.tick_hz)
    }

    fn ticks_of(&self, periods: u64) -> u64 {
        self.origin.wrapping_add(periods.wrapping_mul(u64::from(self.config.period_ticks)))
    }

    /// Updates masses and coefficients after a change of configuration or hand.
    fn rebuild(&mut self) {
        let block_on_handle = if self.rigid() { self.config.block_mass } else { 0.0 };
        self.handle.mass = self.config.device_mass + block_on_handle + self.hand_mass;
        self.handle.damping = self.config.device_damping;
        self.block.mass = self.config.block_mass.max(1e-9);
        self.normal = self.config.normal_load.unwrap_or(self.config.block_mass * GRAVITY);
        self.steps = self.steps_of(self.config.substep());
    }

    fn steps_of(&self, length: f64) -> Steps {
        Steps {
            handle: Zoh::new(self.handle.mass, self.handle.damping, length),
            block: Zoh::new(self.block.mass, self.block.damping, length),
        }
    }

    /// Force of the hard stops on the handle, N.
    #[inline]
    fn stop_force(&self, position: f64, velocity: f64) -> f64 {
        let Some(stroke) = self.config.stroke else { return 0.0 };
        let half = 0.5 * stroke;
        let depth = position.abs() - half;
        if depth <= 0.0 {
            return 0.0;
        }
        let side = 1.0f64.copysign(position);
        let push = self.config.stop_stiffness * depth + self.config.stop_damping * velocity * side;
        -side * push.max(0.0)
    }

    /// Force of the motor's magnets on the handle, N.
    #[inline]
    fn cogging_force(&self, position: f64) -> f64 {
        if self.config.device_cogging == 0.0 {
            return 0.0;
        }
        -self.config.device_cogging
            * libm::sin(core::f64::consts::TAU * (position / self.config.device_cogging_wavelength))
    }

    /// Force of the handle on the block through a compliant coupling, N.
    #[inline]
    fn coupling_force(&self, handle: f64, block: f64, relative_velocity: f64) -> f64 {
        match self.config.coupling {
            Coupling::Rigid => 0.0,
            Coupling::Compliant { stiffness, damping } => {
                stiffness * (handle - block) + damping * relative_velocity
            }
        }
    }

    /// One integration step. Forces that depend on position are evaluated at the middle of the step. With the force held,
    /// a spring is then conservative on average; evaluated at the start of the step it would gain energy.
    #[inline]
    fn substep(&mut self, began: f64, start: f64, actuator: f64, hand: &mut dyn Hand, steps: &Steps) {
        let h = steps.handle.step;
        let half_way = self.handle.position + 0.5 * h * self.handle.velocity;
        let hand_force = finite(
            hand.force(began + start + 0.5 * h, half_way, self.handle.velocity),
            &mut self.truth.not_finite,
        );
        let mut applied = actuator
            + hand_force
            + self.stop_force(half_way, self.handle.velocity)
            + self.cogging_force(half_way);
        let (rigid, normal) = (self.rigid(), self.normal);
        let before = self.handle.position;
        if !rigid {
            let block_half_way = self.block.position + 0.5 * h * self.block.velocity;
            let relative = self.handle.velocity - self.block.velocity;
            let pull = self.coupling_force(half_way, block_half_way, relative);
            applied -= pull;
            let mut surface = Surface {
                guide_p: 0.0,
                guide_n: 0.0,
                normal,
                law: Some((&self.law, &mut self.state)),
                not_finite: &mut self.truth.not_finite,
            };
            self.truth.friction_work += surface.slide(&mut self.block, &steps.block, pull, |_, _, _, _| ());
        }
        let on_surface = rigid && self.config.block_mass > 0.0;
        let mut surface = Surface {
            guide_p: self.config.device_friction_p,
            guide_n: self.config.device_friction_n,
            normal,
            law: if on_surface { Some((&self.law, &mut self.state)) } else { None },
            not_finite: &mut self.truth.not_finite,
        };
        let encoder = &mut self.encoder;
        let mut position = before;
        let taken = surface.slide(
            &mut self.handle,
            &steps.handle,
            applied,
            |from, length, velocity, displacement| {
                let segment = Segment { start: start + from, length, position, velocity, displacement };
                position += displacement;
                encoder.observe(&segment, position);
            },
        );
        let travelled = self.handle.position - before;
        self.truth.friction_work += taken;
        self.truth.actuator_work += actuator * travelled;
        self.truth.hand_work += hand_force * travelled;
    }

    /// Forces and accelerations at the sampling instant. Does not change the state of the law.
    fn observe(&mut self, actuator: f64, hand: &mut dyn Hand) {
        let (x, v) = (self.handle.position, self.handle.velocity);
        let hand_force = finite(hand.force(self.truth.time, x, v), &mut self.truth.not_finite);
        let stop_force = self.stop_force(x, v);
        let mut applied =
            actuator + hand_force + stop_force + self.cogging_force(x) - self.handle.damping * v;
        let (rigid, normal) = (self.rigid(), self.normal);
        let mut state = self.state;
        let mut coupled = None;
        if !rigid {
            let relative = v - self.block.velocity;
            let pull = self.coupling_force(x, self.block.position, relative);
            applied -= pull;
            let mut surface = Surface {
                guide_p: 0.0,
                guide_n: 0.0,
                normal,
                law: Some((&self.law, &mut state)),
                not_finite: &mut self.truth.not_finite,
            };
            let (position, velocity) = (self.block.position, self.block.velocity);
            let friction =
                surface.friction(INSTANT, position, velocity, velocity * INSTANT, pull, self.block.mass);
            coupled = Some((pull, friction.law));
        }
        let on_surface = rigid && self.config.block_mass > 0.0;
        let mut surface = Surface {
            guide_p: self.config.device_friction_p,
            guide_n: self.config.device_friction_n,
            normal,
            law: if on_surface { Some((&self.law, &mut state)) } else { None },
            not_finite: &mut self.truth.not_finite,
        };
        let friction = surface.friction(INSTANT, x, v, v * INSTANT, applied, self.handle.mass);
        let acceleration = (applied - friction.total()) / self.handle.mass;
        let (at_load_cell, block_friction) =
            coupled.unwrap_or((self.config.block_mass * acceleration + friction.law, friction.law));
        if rigid {
            self.block.position = x;
            self.block.velocity = v;
        }
        let truth = &mut self.truth;
        truth.position = x;
        truth.velocity = v;
        truth.acceleration = acceleration;
        truth.block_position = self.block.position;
        truth.block_velocity = self.block.velocity;
        truth.hand_force = hand_force - self.hand_mass * acceleration;
        // without a block the load cell carries the handle and the hand that holds it
        truth.force_at_load_cell = if self.config.block_mass > 0.0 {
            at_load_cell
        } else {
            self.config.handle_mass * acceleration - truth.hand_force
        };
        truth.friction = block_friction;
        truth.device_friction = friction.guide;
        truth.stop_force = stop_force;
        truth.stuck = self.config.block_mass > 0.0 && self.block.velocity == 0.0;
    }

    /// Codes and time stamps at the sampling instant.
    fn sample(&mut self) -> Sensors {
        let calibration = &self.config.calibration;
        // `as` wraps like the counter
        let nominal = self.ticks_of(self.periods) as u32;
        let period_start = if self.periods == 0 && self.origin == 0 {
            nominal
        } else {
            nominal.wrapping_sub(self.config.period_ticks)
        };
        let wiring = &self.config.wiring;
        let (count, edge_ticks) = self.encoder.read(period_start, f64::from(calibration.tick_hz));
        let (count, edge_ticks) = match wiring.encoder {
            Wire::Right => (count, edge_ticks),
            Wire::Swapped => (count.wrapping_neg(), edge_ticks),
            Wire::Dead | Wire::Floating => (self.sensors.count, self.sensors.edge_ticks),
        };
        let load = (self.truth.force_at_load_cell + self.config.bench.weight) * self.config.load.gain
            + self.config.load.offset;
        let load = wiring.load.sense(load, self.load_noise.draw(self.config.load.noise));
        let accel = (self.truth.acceleration + self.config.bench.gravity) * self.config.accel.gain
            + self.config.accel.offset;
        let accel = wiring.accel.sense(accel, self.accel_noise.draw(self.config.accel.noise));
        Sensors {
            sample_ticks: nominal.wrapping_add(self.jitter as u32),
            count,
            edge_ticks,
            load_code: calibration.load.to_code(load),
            accel_code: calibration.accel.to_code(accel),
        }
    }
}
