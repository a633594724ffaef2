//! The device's control step around the simulated rig: encoder, edge times, clock jitter, and a force that changes 20 µs
//! after the sample, as the board's does.

use friction::{Custom, Invalid, Motion};
use haptics::{Control, Device, FaultKind, Outputs, Refused, Request, Settings};
use plant::{Hand, Rig, RigConfig, Truth};
use tribos_firmware::board::simulated::inputs;

/// A simulation that cannot run to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The simulated rig cannot be built.
    #[error("{0}")]
    Rig(Invalid),
    /// The device refuses the settings.
    #[error("{0}")]
    Refused(Refused),
    /// A fault ended the rendering.
    #[error("the simulated device let go: {0:?}")]
    LetGo(FaultKind),
}

/// From sample to force on the device, s.
pub(crate) const DELAY: f64 = 20e-6;
/// Integration steps in a period: one of them is the delay.
const SUBSTEPS: u32 = 50;
/// Standard deviation of the sampling instant, ticks of 170 MHz: 0.1 µs.
const JITTER: f64 = 17.0;

/// A hand, and the actuator's force with its delay.
struct Held<F> {
    mass: f64,
    force: F,
    before: f64,
    now: f64,
    began: f64,
}

impl<F: FnMut(f64, f64, f64) -> f64> Hand for Held<F> {
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64 {
        let actuator = if t - self.began < DELAY { self.before } else { self.now };
        (self.force)(t, x, v) + actuator
    }

    fn mass(&self) -> f64 {
        self.mass
    }
}

/// Renders from the fifth period on and shows every period to `see`, with what the handle really does. The hand has
/// this mass and gives the force of time, position and velocity.
///
/// # Errors
/// Settings that the device refuses, and the fault that ended the rendering.
pub(crate) fn run(
    settings: &Settings,
    device: &Device,
    seconds: f64,
    mass: f64,
    hand: impl FnMut(f64, f64, f64) -> f64,
    mut see: impl FnMut(&Outputs, &Truth),
) -> Result<(), Error> {
    let config = RigConfig {
        actuation_delay: 0,
        period_ticks: device.period_ticks(),
        substeps: SUBSTEPS,
        device_damping: f64::from(device.damping),
        clock_jitter_ticks: JITTER,
        ..RigConfig::free_handle()
    };
    let mut rig = Rig::new(config, Custom(|_: &Motion<f64>| 0.0), 1).map_err(Error::Rig)?;
    let mut control = Control::referenced(settings.build(device).map_err(Error::Refused)?);
    let mut held = Held { mass, force: hand, before: 0.0, now: 0.0, began: 0.0 };
    let mut sensors = rig.sensors();
    let mut period = 0_u32;
    while rig.truth().time < seconds {
        // the rig takes the actuator for a part of the hand: the load cell does not carry it
        let code = f64::from(sensors.load_code) + held.now / f64::from(device.load.unit_per_code);
        sensors.load_code = code.round() as u16;
        let out = control.step((period == 5).then_some(&Request::Render(true)), &inputs(&sensors));
        period += 1;
        if let Some(kind) = out.fault {
            return Err(Error::LetGo(kind));
        }
        let truth = rig.truth();
        see(&out, &Truth { hand_force: truth.hand_force - held.now, ..truth });
        (held.before, held.now, held.began) = (held.now, f64::from(out.force), rig.truth().time);
        sensors = rig.tick(0.0, &mut held);
    }
    Ok(())
}
