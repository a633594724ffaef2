//! The control step: a pure function of configuration, state and inputs. Time comes in as stamps.
//!
//! Order: measure, handle the request, run the mode, check, clamp. A check judges the force of its own step, so a rejected
//! force never leaves it.

use crate::estimator::Estimator;
use crate::excitation::Drive;
use crate::machine::{Fault, Mode, Request};
use crate::renderer::{Contact, Handle, Rendered};
use crate::safety::{self, Guard};
use crate::silence::Bounds;
use crate::streaming_identify::{Procedure, Recorder};
use crate::{Config, Denied, Device, FaultKind, Inputs, Outputs, Probe};

/// State of the loop between steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    estimator: Estimator,
    guard: Guard,
    mode: Mode,
    previous_ticks: Option<u32>,
    /// Force of the previous step, N.
    force: f32,
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
}

impl State {
    /// Idle, at rest, no fault.
    #[must_use]
    pub fn new(_device: &Device) -> Self {
        Self {
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
        }
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
    fn take_up(&mut self, config: &Config, handle: &Handle) {
        if let Mode::Rendering { contact, .. } = &mut self.mode {
            if !contact.fits(config) {
                *contact = Contact::new(config, &handle.after(config.device.period));
                self.fresh = true;
            }
            // the difference is computed once the new force is known
            self.swapped = true;
        }
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

    fn latch(&mut self, kind: FaultKind, ticks: u32, handle: &Handle) {
        if !matches!(self.mode, Mode::Fault(_)) {
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
        let device = &config.device;
        let faulty = matches!(self.mode, Mode::Fault(_));
        let running = matches!(self.mode, Mode::Exciting { .. } | Mode::Probing(_));
        match request {
            Request::Raise(kind) => {
                self.latch(*kind, inputs.sample_ticks, handle);
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
                    Mode::Rendering { .. } | Mode::Probing(_) => self.mode = Mode::Idle,
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
            _ if safety::at_rail(device, inputs) => Err(Denied::SensorRail),
            _ if !(handle.position.abs() <= 0.5 * device.stroke) => Err(Denied::OutsideStroke),
            Request::Probe => {
                if !(handle.position.abs() <= 0.5 * device.stroke - Probe::ROOM) {
                    return Err(Denied::NoRoom);
                }
                self.mode = Mode::Probing(Probe::start(inputs.count));
                Ok(())
            }
            Request::Render(true) => {
                if !matches!(self.mode, Mode::Rendering { .. }) {
                    let contact = Contact::new(config, &handle.after(device.period));
                    (self.blend, self.swapped, self.fresh) = (0.0, false, true);
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
        if !(handle.position.abs() <= 0.5 * device.stroke) {
            return Err(Denied::OutsideStroke);
        }
        let load = device.load.to_si(inputs.load_code);
        let still = handle.velocity.abs() <= device.rest_speed && !self.guard.moves_unseen(&config.silence);
        if !(still && load.abs() <= device.rest_force) {
            return Err(Denied::NotAtRest);
        }
        self.guard.watch(0);
        self.mode = Mode::Idle;
        Ok(())
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
    let handle = Handle {
        position: state.estimator.counts() as f32 * device.metre_per_count,
        velocity: state.estimator.counts_per_tick() * config.metre_per_second,
        displacement: state.estimator.step() as f32 * device.metre_per_count,
    };
    if core::mem::take(&mut state.reconfigured) {
        state.take_up(config, &handle);
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
    let driven = matches!(state.mode, Mode::Exciting { .. });
    let command = run_mode(config, state, inputs, &handle, &mut outputs);

    let motion = safety::Motion {
        position: handle.position,
        velocity: handle.velocity,
        displacement: handle.displacement,
        elapsed,
        driven,
        command: state.force,
    };
    let trip = state.guard.check(device, config.period_ticks, &config.silence, inputs, &motion);
    let command = match (command, trip) {
        (Some(_), Some(kind)) => Err(Some(kind)),
        (Some(force), None) => safety::clamp(force, device.force_max).ok_or(Some(FaultKind::NonFinite)),
        (None, _) => Err(None),
    };
    match command {
        Ok(force) => {
            outputs.force = force;
            outputs.amplifier = true;
        }
        Err(fault) => {
            if let Some(kind) = fault {
                state.latch(kind, inputs.sample_ticks, &handle);
            }
            outputs.force = 0.0;
            outputs.amplifier = false;
        }
    }
    state.force = outputs.force;
    outputs.mode = state.mode.id();
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
            if core::mem::take(&mut state.swapped) {
                state.blend = state.force - rendered.force;
            }
            // a NaN difference is dropped; the force itself raises the fault
            state.blend = if state.blend.abs() > 1e-4 { state.blend * config.blend_decay } else { 0.0 };
            describe(&rendered, outputs);
            Some(rendered.force + state.blend)
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
        // a wildcard: with all modes spelled out the compiler adds a trap for an impossible one
        _ => None,
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
