//! Answers to requests that the control loop has handled, and the wording of single answers.

use super::Telemetry;
use super::calibrate::{Fits, describe};
use super::line::{Line, err};
use core::fmt::{self, Write};
use friction::Unit;
use haptics::number::Text;
use haptics::{Denied, Device, Excitation, FaultKind, Homed, Identified, ModeId, Settings, Warning};
use heapless::String;
use link::{Name, Sensor};

/// Pending change and answer of a request to the control loop.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub(super) enum Pending {
    /// New settings: a preset, or one changed parameter.
    Settings { settings: Settings, name: Named, warning: Option<Warning> },
    /// A calibration: the device with its channels, and their description.
    Calibrated(Device, Fits),
    /// The push of the self-test, which has no answer of its own.
    Push,
    /// A new control rate: the device with its period.
    Rate(Device),
    /// `render`, with the largest force of an unreferenced device, N
    Render(bool, Option<f32>),
    /// `zero`
    Zero,
    /// `home`
    Home,
    /// `move`, with the longest silence of the host, s
    Move(Excitation, f32),
    /// `identify`, with its length, s
    Identify(f32),
    /// `stop`
    Stop,
    /// `off`
    Off,
    /// `clear`
    Clear,
}

/// Name of the new settings.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Named {
    /// A preset.
    Preset(Name),
    /// A parameter of the present settings.
    Parameter(String<48>),
}

impl Pending {
    /// The `ok` line. `during` is the mode before the request.
    pub fn write(&self, during: ModeId, out: &mut Line) -> fmt::Result {
        match self {
            Self::Settings { settings, name, warning } => {
                out.write_str("ok ")?;
                if let Some(warning) = warning {
                    return write!(out, "warn: {warning}");
                }
                match name {
                    Named::Preset(name) => write!(out, "{name}"),
                    Named::Parameter(name) => value(settings, name, out),
                }
            }
            Self::Calibrated(device, fits) => {
                out.write_str("calibrate")?;
                describe(Sensor::Load, &device.load, fits[0].as_ref(), out)?;
                describe(Sensor::Accel, &device.accel, fits[1].as_ref(), out)
            }
            Self::Push => Ok(()),
            Self::Rate(device) => write!(out, "ok rate {:.0} Hz", Text(1.0 / device.period)),
            Self::Render(true, Some(most)) => write!(
                out,
                "ok warn: unreferenced: at most {:.2} N; `home`, or `zero` in the middle, gives all of it",
                Text(*most)
            ),
            Self::Render(on, _) => write!(out, "ok render {}", if *on { "on" } else { "off" }),
            Self::Zero => out.write_str("ok zero: the handle is in the middle of its stroke"),
            Self::Home => out.write_str("ok home: slowly to both stops, hands off; the result follows"),
            Self::Move(e, watch) => {
                let (wave, amplitude, frequency) = (e.wave.id(), Text(e.amplitude_m), Text(e.frequency_hz));
                write!(out, "ok move {wave} {amplitude} m {frequency} Hz")?;
                if e.seconds > 0.0 {
                    write!(out, " for {} s", Text(e.seconds))?;
                } else {
                    out.write_str(" until `stop`")?;
                }
                if *watch > 0.0 && !(e.seconds > 0.0 && e.seconds < *watch) {
                    write!(out, "; send a line at least every {} s", Text(*watch))?;
                }
                Ok(())
            }
            Self::Identify(seconds) => {
                let seconds = Text(*seconds);
                write!(out, "ok identify: {seconds:.0} s of motion, hands off; the result follows")
            }
            Self::Stop => write!(out, "ok stop: {}", stopped(during)),
            Self::Off => write!(out, "ok off: {}", switched_off(during)),
            Self::Clear => out.write_str("ok clear"),
        }
    }
}

/// What `stop` did.
fn stopped(during: ModeId) -> &'static str {
    match during {
        ModeId::Idle => "nothing was running",
        ModeId::Rendering => "rendering has ended, the amplifier is off",
        ModeId::Exciting | ModeId::Identifying => "the motion ramps out within 0.6 s",
        ModeId::Homing => "the search has ended, the amplifier is off",
        ModeId::Fault => "the amplifier is off already, by a fault",
    }
}

/// What `off` did.
fn switched_off(during: ModeId) -> &'static str {
    match during {
        ModeId::Idle => "the amplifier is off, nothing was running",
        ModeId::Rendering => "the amplifier is off, rendering has ended",
        ModeId::Exciting => "the amplifier is off, the motion has ended",
        ModeId::Homing => "the amplifier is off, the search has ended",
        ModeId::Identifying => "the amplifier is off, the identification has ended without a result",
        ModeId::Fault => "the amplifier is off already, by a fault",
    }
}

/// `dv 0.007 m/s`
pub(super) fn value(settings: &Settings, name: &str, out: &mut Line) -> fmt::Result {
    let unit = unit(name);
    match (settings.get(name), unit) {
        (Some(value), Some(unit)) => write!(out, "{name} {value} {unit}"),
        (Some(value), None) => write!(out, "{name} {value}"),
        (None, _) => write!(out, "{name} off"),
    }
}

fn unit(name: &str) -> Option<Unit> {
    use friction::Geometry::Linear;
    use friction::effects::EffectKind;
    use haptics::settings::{ALIASES, PARAMETERS};
    if let Some((id, parameter)) = name.split_once('.') {
        let kind = EffectKind::from_id(id)?;
        return kind.gains().iter().chain(kind.shape()).find(|p| p.name == parameter).map(|p| p.unit(Linear));
    }
    PARAMETERS.iter().chain(ALIASES).find(|p| p.name == name)?.unit()
}

/// A request that was denied.
pub(super) fn denied(why: Denied, fault: Option<FaultKind>, out: &mut Line) {
    match fault {
        Some(kind) if why == Denied::FaultLatched => {
            err(why.id(), format_args!("{} ({kind})", why.explain()), out);
        }
        _ => err(why.id(), why.explain(), out),
    }
}

/// `status` without its first word.
pub(super) fn handle(t: &Telemetry, device: &Device, out: &mut Line) -> fmt::Result {
    let o = &t.outputs;
    let load = Text(device.load.to_si(t.inputs.load_code));
    write!(
        out,
        "handle {:.6} m {:.4} m/s, block {:.6} m {}, load {load:.3} N, force {:.3} N",
        Text(o.position),
        Text(o.velocity),
        Text(o.block_position),
        if o.stuck { "stuck" } else { "free" },
        Text(o.force),
    )
}

/// The result of a search for the stops in one line.
pub(super) fn homed(homed: Homed, device: &Device, out: &mut Line) -> fmt::Result {
    let millimetre = |metre: f32| Text(1e3 * metre);
    if let Homed::Middle { stroke } = homed {
        let stroke = millimetre(stroke);
        return write!(out, "! home: stroke {stroke:.2} mm, the handle is in the middle");
    }
    out.write_str("! no home: ")?;
    match homed {
        Homed::Stroke { measured } => {
            let (least, most) = Homed::accepted(device);
            let (measured, least, most) = (millimetre(measured), millimetre(least), millimetre(most));
            write!(
                out,
                "stops {measured:.2} mm apart: accepted from {least:.2} to {most:.2}; remove what blocks the handle, hands off"
            )?;
        }
        Homed::NoStop => {
            let (_, most) = Homed::accepted(device);
            write!(out, "no stop within {:.2} mm: this is not the device's stroke", millimetre(most))?;
        }
        Homed::TooFast => out.write_str(
            "the handle moved faster than a search; hands off, and check the wiring by `zero` and `selftest`",
        )?,
        Homed::TooLong => out.write_str("it took too long; remove what blocks the handle, hands off")?,
        Homed::Interrupted | Homed::Middle { .. } => out.write_str("interrupted")?,
    }
    out.write_str("; still unreferenced")
}

/// The result of an identification in one line.
pub(super) fn identified(found: &Identified, out: &mut Line) -> fmt::Result {
    out.write_str("! identified: ")?;
    let levels = [("D_p", found.static_p), ("D_n", found.static_n)];
    for (name, estimate, unit) in [
        ("mass", found.mass, "kg"),
        ("C_p", found.coulomb_p, "N"),
        ("C_n", found.coulomb_n, "N"),
        ("b_p", found.viscous_p, "N s/m"),
        ("b_n", found.viscous_n, "N s/m"),
        ("dv", found.delta_v, "m/s"),
    ]
    .into_iter()
    .chain(levels.into_iter().filter_map(|(name, level)| Some((name, level?, "N"))))
    {
        write!(out, "{name} {:.4} ± {:.4} {unit}, ", Text(estimate.value), Text(estimate.std))?;
    }
    for (name, level) in levels {
        if level.is_none() {
            write!(out, "{name} not seen, ")?;
        }
    }
    write!(out, "relative error {:.2} %, {} samples", Text(100.0 * found.relative_error), found.used)
}
