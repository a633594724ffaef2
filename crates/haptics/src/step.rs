//! The control step: a pure function of configuration, state and inputs. Time comes in as stamps.
//!
//! Order: measure, handle the request, run the mode, check, clamp. A check judges the force of its own step, so a rejected
//! force never leaves it.

use crate::compensation::feed_forward::FeedForward;
use crate::drive::Drive;
use crate::estimator::Estimator;
use crate::homing::{Homed, Homing, Progress};
use crate::machine::{Fault, Mode, Request};
use crate::passivity::Passivity;
use crate::renderer::{Contact, Handle, Rendered};
use crate::safety::{self, Guard};
use crate::silence::Bounds;
use crate::streaming_identify::{Procedure, Recorder};
use crate::{Config, Denied, Device, FaultKind, Inputs, Outputs, Probe, Ramp};

/// State of the loop between steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    estimator: Estimator,
    guard: Guard,
    mode: Mode,
    previous_ticks: Option<u32>,
    /// Force of the previous step, N.
    force: f32,
    /// Encoder count at position 0: the middle of the stroke once `referenced`.
    origin: u32,
    /// Whether the middle of the stroke is known.
    referenced: bool,
    /// Largest force, N. Less while unreferenced.
    force_limit: f32,
    /// Largest distance from position 0 with the force on, m.
    reach: f32,
    /// Result of the last search.
    homed: Homed,
    /// Decaying force difference after a swap of the configuration, N.
    blend: f32,
    /// A configuration was swapped and the force difference is not yet known.
    swapped: bool,
    /// The contact or drive was constructed in this period, which leaves no time for its first step.
    fresh: bool,
    /// An identification that began. Its sums are cleared in the next period, for the same reason.
    begun: Option<Procedure>,
    /// The next step runs with a new configuration.
    reconfigured: bool,
    recorder: Recorder,
    passivity: Passivity,
    feed_forward: FeedForward,
}

impl State {
    /// Idle, at rest, unreferenced, no fault.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        Self {
            origin: 0,
            referenced: false,
            force_limit: device.unreferenced_force(),
            reach: device.stroke + device.held_margin(),
            homed: Homed::Interrupted,
            estimator: Estimator::default(),
            guard: Guard::default(),
            mode: Mode::Idle,
            previous_ticks: None,
            force: 0.0,
            blend: 0.0,
            swapped: false,
            fresh: false,
            begun: None,
            reconfigured: false,
            recorder: Recorder::default(),
            passivity: Passivity::default(),
            feed_forward: FeedForward::default(),
        }
    }

    /// The same, referenced: count 0 is the middle of the stroke.
    #[must_use]
    pub fn referenced(device: &Device) -> Self {
        let reach = 0.5 * device.stroke + device.held_margin();
        Self { referenced: true, force_limit: device.force_max, reach, ..Self::new(device) }
    }

    /// Announces a new configuration for the next step, which continues without a jump in force. If the period changes, the
    /// time since the last step is not checked.
    pub fn reconfigured(&mut self, period_changes: bool) {
        self.reconfigured = true;
        if period_changes {
            self.previous_ticks = None;
            self.guard.period_changes();
        }
    }

    /// Replaces a contact whose state does not fit the configuration.
    fn take_up(&mut self, config: &Config, inputs: &Inputs, handle: &Handle) {
        if config.new_device {
            // counts and codes have another meaning now
            (self.guard, self.estimator) = (Guard::default(), Estimator::default());
            if !matches!(self.mode, Mode::Fault(_)) {
                self.mode = Mode::Idle;
            }
            self.refer(config, inputs.count, false);
            return;
        }
        self.limit(config);
        if let Mode::Rendering { contact, .. } = &mut self.mode {
            if !contact.fits(config) {
                *contact = Contact::new(config, &handle.after(config.device.period));
                self.fresh = true;
            }
            // the difference is computed once the new force is known
            self.swapped = true;
        }
    }

    /// Sets the limits of force and position. They change with a request, with a configuration, and with the reference.
    fn limit(&mut self, config: &Config) {
        let device = &config.device;
        // a search limits its force itself
        let full = self.referenced || matches!(self.mode, Mode::Homing(_));
        self.force_limit = if full { device.force_max } else { config.unreferenced_force };
        let margin = if matches!(self.mode, Mode::Exciting { .. }) { config.driven } else { config.held };
        self.reach = self.stops(device) + margin;
    }

    /// Largest distance of a stop from position 0, m.
    fn stops(&self, device: &Device) -> f32 {
        // the count began between the stops, so that both are within one stroke of it
        if self.referenced { 0.5 * device.stroke } else { device.stroke }
    }

    /// The middle of the stroke is at this count, or is unknown and the position counts from there.
    fn refer(&mut self, config: &Config, origin: u32, referenced: bool) {
        (self.origin, self.referenced) = (origin, referenced);
        self.limit(config);
    }

    /// Whether the middle of the stroke is known.
    #[must_use]
    pub fn is_referenced(&self) -> bool {
        self.referenced
    }

    /// Encoder count at position 0.
    #[must_use]
    pub fn origin(&self) -> u32 {
        self.origin
    }

    /// Result of the last search.
    #[must_use]
    pub fn homed(&self) -> Homed {
        self.homed
    }

    /// State of the machine.
    #[must_use]
    pub fn mode(&self) -> &Mode {
        &self.mode
    }

    /// The latched fault.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        match &self.mode {
            Mode::Fault(fault) => Some(fault),
            _ => None,
        }
    }

    /// Sums of the last identification. Solve them outside the control interrupt.
    #[must_use]
    pub fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Change of speed that only the accelerometer shows, as a share of the bound of the fault `encoder_silent`.
    #[must_use]
    pub fn unseen_motion(&self, device: &Device) -> f32 {
        self.guard.unseen(&Bounds::new(device))
    }

    /// The velocity estimator.
    #[must_use]
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    fn latch(&mut self, config: &Config, kind: FaultKind, ticks: u32, handle: &Handle) {
        if !matches!(self.mode, Mode::Fault(_)) {
            let doubts_the_count = match kind {
                FaultKind::EncoderJump | FaultKind::EncoderSilent | FaultKind::BrownOut => true,
                // further than the stroke from where the count began
                FaultKind::EndOfStroke => !self.referenced,
                _ => false,
            };
            if doubts_the_count {
                self.refer(config, self.estimator.counts() as u32, false);
            }
            let (position, velocity) = (handle.position, handle.velocity);
            self.mode = Mode::Fault(Fault { kind, at_ticks: ticks, position, velocity, force: self.force });
        }
    }

    /// Handles a request, or returns the reason why it is denied.
    fn obey(
        &mut self,
        config: &Config,
        request: &Request,
        inputs: &Inputs,
        handle: &Handle,
    ) -> Result<(), Denied> {
        let idle = matches!(self.mode, Mode::Idle);
        let result = self.handle(config, request, inputs, handle);
        if idle && !matches!(self.mode, Mode::Idle) {
            // a promise that came with a denied request has run out meanwhile
            self.guard.watch(0);
        }
        self.limit(config);
        result
    }

    fn handle(
        &mut self,
        config: &Config,
        request: &Request,
        inputs: &Inputs,
        handle: &Handle,
    ) -> Result<(), Denied> {
        let device = &config.device;
        let faulty = matches!(self.mode, Mode::Fault(_));
        let running = matches!(self.mode, Mode::Exciting { .. } | Mode::Probing(_) | Mode::Homing(_));
        let drives =
            matches!(request, Request::Probe | Request::Ramp | Request::Excite(_) | Request::Identify(_));
        // a hand may lean on a stop; what the checks would trip on is denied
        let room = if drives { 0.0 } else { config.held };
        match request {
            Request::Raise(kind) => {
                if *kind == FaultKind::BrownOut {
                    self.guard.forget_offsets();
                }
                self.latch(config, *kind, inputs.sample_ticks, handle);
                Ok(())
            }
            Request::HostWatch { seconds } => {
                // `as` saturates, NaN becomes 0
                self.guard.watch((seconds * config.timing.rate) as u32);
                Ok(())
            }
            Request::Off => {
                if !faulty {
                    self.mode = Mode::Idle;
                }
                self.guard.watch(0);
                Ok(())
            }
            Request::ClearFault => self.clear(config, inputs, handle),
            Request::Stop => {
                match &mut self.mode {
                    Mode::Idle | Mode::Fault(_) => {}
                    Mode::Rendering { .. } | Mode::Probing(_) | Mode::Homing(_) => self.mode = Mode::Idle,
                    Mode::Exciting { drive, identifying } => {
                        drive.stop();
                        *identifying = false;
                    }
                }
                Ok(())
            }
            _ if faulty => Err(Denied::FaultLatched),
            Request::Render(false) if running => Err(Denied::Driven),
            Request::Render(false) => {
                self.mode = Mode::Idle;
                Ok(())
            }
            _ if running => Err(Denied::Busy),
            // under a contact, positions would jump
            Request::Zero | Request::Middle(_) if !matches!(self.mode, Mode::Idle) => Err(Denied::Busy),
            Request::Zero => {
                if !self.rests(config, handle) {
                    return Err(Denied::Moving);
                }
                self.refer(config, inputs.count, true);
                Ok(())
            }
            Request::Middle(origin) => {
                self.refer(config, *origin, true);
                Ok(())
            }
            _ if safety::at_rail(device, inputs) => Err(Denied::SensorRail),
            Request::Home => {
                if !self.rests(config, handle) {
                    return Err(Denied::NotAtRest);
                }
                self.refer(config, inputs.count, false);
                self.homed = Homed::Interrupted;
                self.mode = Mode::Homing(Homing::start(inputs.count));
                Ok(())
            }
            _ if drives && !self.referenced => Err(Denied::Unreferenced),
            _ if !(handle.position.abs() <= self.stops(device) + room) => Err(Denied::OutsideStroke),
            Request::Probe => {
                if !(handle.position.abs() <= 0.5 * device.stroke - Probe::room(device)) {
                    return Err(Denied::NoRoom);
                }
                self.mode = Mode::Probing(Probe::push(inputs.count));
                Ok(())
            }
            Request::Ramp => {
                if !(handle.position.abs() <= 0.5 * device.stroke - Ramp::far(device)) {
                    return Err(Denied::NoRoom);
                }
                if !self.rests(config, handle) {
                    return Err(Denied::Moving);
                }
                self.mode = Mode::Probing(Probe::ramp(inputs.count));
                Ok(())
            }
            Request::Render(true) => {
                if !matches!(self.mode, Mode::Rendering { .. }) {
                    let contact = Contact::new(config, &handle.after(device.period));
                    (self.blend, self.swapped, self.fresh) = (0.0, false, true);
                    (self.passivity, self.feed_forward) = (Passivity::default(), FeedForward::default());
                    self.mode = Mode::Rendering { since_ticks: inputs.sample_ticks, contact };
                }
                Ok(())
            }
            Request::Excite(excitation) => {
                excitation.validate(device).map_err(|_| Denied::BadExcitation)?;
                let drive = Drive::start(config, excitation, handle.position);
                self.fresh = true;
                self.begun = None;
                self.mode = Mode::Exciting { drive, identifying: false };
                Ok(())
            }
            Request::Identify(procedure) => {
                procedure.validate(device).map_err(|_| Denied::BadExcitation)?;
                let drive = Drive::start(config, &procedure.excitation(), handle.position);
                self.fresh = true;
                self.begun = Some(*procedure);
                self.mode = Mode::Exciting { drive, identifying: true };
                Ok(())
            }
        }
    }

    fn clear(&mut self, config: &Config, inputs: &Inputs, handle: &Handle) -> Result<(), Denied> {
        let device = &config.device;
        if !matches!(self.mode, Mode::Fault(_)) {
            return Ok(());
        }
        if safety::at_rail(device, inputs) {
            return Err(Denied::SensorRail);
        }
        // an unreferenced position may come from a count that jumped
        if self.referenced && !(handle.position.abs() <= self.stops(device)) {
            return Err(Denied::OutsideStroke);
        }
        let load = device.load.to_si(inputs.load_code);
        if !(self.rests(config, handle) && load.abs() <= device.rest_force) {
            return Err(Denied::NotAtRest);
        }
        self.guard.watch(0);
        self.mode = Mode::Idle;
        if !self.referenced {
            self.refer(config, inputs.count, false);
        }
        Ok(())
    }

    /// Whether the handle is at rest, held or not.
    fn rests(&self, config: &Config, handle: &Handle) -> bool {
        handle.velocity.abs() <= config.device.rest_speed && !self.guard.moves_unseen(&config.silence)
    }
}

/// One control period.
///
/// Pure: the same configuration, state, request and inputs give the same outputs and state, bit for bit, on every machine.
/// Never panics. For any input the outputs are finite and |force| ≤ `force_max`.
///
/// After replacing `config`, call [`State::reconfigured`] before the next step.
pub fn step(config: &Config, state: &mut State, request: Option<&Request>, inputs: &Inputs) -> Outputs {
    let device = &config.device;
    let elapsed = state.previous_ticks.map(|previous| inputs.sample_ticks.wrapping_sub(previous));
    state.previous_ticks = Some(inputs.sample_ticks);
    state.estimator.sample(inputs.sample_ticks, inputs.count, inputs.edge_ticks);
    let counts = state.estimator.counts().wrapping_sub(state.origin as i32);
    let handle = Handle {
        position: counts as f32 * device.metre_per_count,
        velocity: state.estimator.counts_per_tick() * config.metre_per_second,
        displacement: state.estimator.step() as f32 * device.metre_per_count,
        // the cell shows the reaction
        #[cfg(feature = "admittance")]
        push: -device.load.to_si(inputs.load_code),
    };
    if core::mem::take(&mut state.reconfigured) {
        state.take_up(config, inputs, &handle);
    }
    let denied = request.and_then(|request| state.obey(config, request, inputs, &handle).err());

    let mut outputs = Outputs {
        position: finite_or_zero(handle.position),
        velocity: finite_or_zero(handle.velocity),
        reference: finite_or_zero(handle.position),
        block_position: finite_or_zero(handle.position),
        denied,
        ..Outputs::default()
    };
    let command = run_mode(config, state, inputs, &handle, &mut outputs);

    let motion = safety::Motion {
        position: handle.position,
        velocity: handle.velocity,
        displacement: handle.displacement,
        elapsed,
        reach: state.reach,
        command: state.force,
    };
    let trip = state.guard.check(device, config.period_ticks, &config.silence, inputs, &motion);
    let command = match (command, trip) {
        (Some(_), Some(kind)) => Err(Some(kind)),
        (Some(force), None) => safety::clamp(force, state.force_limit).ok_or(Some(FaultKind::NonFinite)),
        (None, trip) => {
            // no fault without a force, but the middle is no longer where it was
            if state.referenced && trip == Some(FaultKind::EncoderJump) {
                state.refer(config, state.origin, false);
            }
            Err(None)
        }
    };
    match command {
        Ok(force) => {
            outputs.force = force;
            outputs.amplifier = true;
        }
        Err(fault) => {
            if let Some(kind) = fault {
                state.latch(config, kind, inputs.sample_ticks, &handle);
            }
            outputs.force = 0.0;
            outputs.amplifier = false;
        }
    }
    state.force = outputs.force;
    outputs.mode = state.mode.id();
    outputs.referenced = state.referenced;
    outputs.fault = state.fault().map(|fault| fault.kind);
    outputs
}

/// The force the present mode asks for, before checks and clamp; `None` where force is off.
fn run_mode(
    config: &Config,
    state: &mut State,
    inputs: &Inputs,
    handle: &Handle,
    outputs: &mut Outputs,
) -> Option<f32> {
    match &mut state.mode {
        Mode::Rendering { .. } | Mode::Exciting { .. } if core::mem::take(&mut state.fresh) => {
            Some(state.force)
        }
        Mode::Exciting { .. } if state.begun.is_some() => {
            if let Some(procedure) = state.begun.take() {
                state.recorder.start(config, &procedure);
            }
            Some(state.force)
        }
        Mode::Probing(probe) => {
            let command = probe.step(&config.device, inputs.count);
            if command.is_none() {
                state.mode = Mode::Idle;
            }
            command
        }
        Mode::Rendering { contact, .. } => {
            let rendered = contact.step(config, handle);
            let held = state.force - state.feed_forward.force;
            // its effects have a phase that only a referenced device knows
            let fed = if config.feed_forward.is_on && state.referenced {
                state.feed_forward.step(config, handle, inputs.load_code, rendered.force)
            } else {
                state.feed_forward.force = 0.0;
                0.0
            };
            if core::mem::take(&mut state.swapped) {
                state.blend = state.force - rendered.force - fed;
            }
            // a NaN difference is dropped; the force itself raises the fault
            state.blend = if state.blend.abs() > 1e-4 { state.blend * config.blend_decay } else { 0.0 };
            describe(&rendered, outputs);
            let force = rendered.force + state.blend;
            let force = if config.passivity {
                // of the contact alone: what compensates friction gives energy that friction takes
                state.passivity.step(config, contact, handle, held, force)
            } else {
                force
            };
            Some(force + fed)
        }
        Mode::Exciting { drive, identifying } => {
            let command = drive.step(config, handle.position, handle.velocity);
            outputs.reference = finite_or_zero(drive.reference());
            if *identifying {
                let (accel, load) = (inputs.accel_code, inputs.load_code);
                let complete = state.recorder.sample(drive.elapsed(), handle.velocity, accel, load);
                outputs.identified = complete;
                *identifying = !complete;
            }
            if command.is_none() {
                // the promise applied to this motion
                state.guard.watch(0);
                state.mode = Mode::Idle;
            }
            command
        }
        Mode::Homing(search) => match search.step(&config.homing, inputs.count, handle.velocity) {
            Progress::Force(force) => {
                outputs.reference = finite_or_zero(handle.position + search.lead());
                Some(force)
            }
            Progress::End(homed, middle) => {
                end_search(config, state, homed, middle);
                None
            }
        },
        // a wildcard: with all modes spelled out the compiler adds a trap for an impossible one
        _ => None,
    }
}

/// Ends a search. Out of the way of a contact.
#[inline(never)]
fn end_search(config: &Config, state: &mut State, homed: Homed, middle: u32) {
    state.guard.watch(0);
    state.mode = Mode::Idle;
    state.homed = homed;
    if matches!(homed, Homed::Middle { .. }) {
        state.refer(config, middle, true);
    }
}

fn describe(rendered: &Rendered, outputs: &mut Outputs) {
    outputs.block_position = finite_or_zero(rendered.block_position);
    outputs.block_velocity = finite_or_zero(rendered.block_velocity);
    outputs.friction = finite_or_zero(rendered.friction);
    outputs.stuck = rendered.stuck;
}

/// Replaces NaN in telemetry by 0. A NaN force raises its own fault.
fn finite_or_zero(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}
