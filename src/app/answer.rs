//! Answers to requests that the control loop has handled, and the wording of single answers.

use super::calibrate::{Fits, describe};
use super::line::{self, Line, err};
use super::{FaultReport, Telemetry};
use core::fmt::{self, Write};
use friction::{Dimension, Geometry, Unit};
use haptics::number::Text;
use haptics::{Denied, Device, Excitation, FaultKind, Homed, Identified, ModeId, Ramp, Settings, Warning};
use heapless::String;
use link::Name;

/// Pending change and answer of a request to the control loop.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub(super) enum Pending {
    /// New settings: a preset, or one changed parameter.
    Settings { settings: Settings, name: Named, warning: Option<Warning> },
    /// Settings of the device, what changed, and the parameters that replace a contact which it cannot render.
    Device { device: Device, what: String<200>, scaled: Option<Settings> },
    /// What the device feeds forward.
    Compensation(Device),
    /// A calibration: the device with its channels, and their description.
    Calibrated(Device, Fits),
    /// The push of the self-test, which has no answer of its own.
    Push,
    /// `calibrate force`
    Ramp,
    /// A new control rate: the device with its period.
    Rate(Device),
    /// `render`, with the largest force of an unreferenced device, N
    Render(bool, Option<f32>),
    /// `zero`
    Zero,
    /// The middle of the stroke from an index pulse, which nobody asked for.
    Middle,
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
    pub fn write(&self, during: ModeId, device: &Device, out: &mut Line) -> fmt::Result {
        let unit = |dimension: Dimension| dimension.unit(device.geometry);
        match self {
            Self::Settings { settings, name, warning } => {
                out.write_str("ok ")?;
                if let Some(warning) = warning {
                    return write!(out, "warn: {}", warning.on(device.geometry));
                }
                match name {
                    Named::Preset(name) => write!(out, "{name}"),
                    Named::Parameter(name) => value(settings, name, device.geometry, out),
                }
            }
            Self::Device { what, scaled, .. } => {
                write!(out, "device{what}; unreferenced: `home`, or `zero` in the middle")?;
                match scaled {
                    Some(_) => out.write_str("; the preset does not fit it: brass at its scale"),
                    None => Ok(()),
                }
            }
            Self::Compensation(device) => {
                write!(out, "ok compensate {}", device.compensation.on(device.geometry))
            }
            Self::Calibrated(device, fits) => {
                out.write_str("calibrate")?;
                describe(device, fits, out)
            }
            Self::Push => Ok(()),
            Self::Ramp => {
                let (most, seconds) = (Text(Ramp::peak(device)), Text(Ramp::SECONDS));
                write!(
                    out,
                    "ok calibrate force: up to {most:.2} {} both ways for {seconds:.0} s, hold the handle; the result follows",
                    unit(Dimension::FORCE)
                )
            }
            Self::Rate(device) => write!(out, "ok rate {:.0} Hz", Text(1.0 / device.period)),
            Self::Render(true, Some(most)) => write!(
                out,
                "ok warn: unreferenced: at most {:.2} {}; `home`, or `zero` in the middle, gives all of it",
                Text(*most),
                unit(Dimension::FORCE)
            ),
            Self::Render(on, _) => write!(out, "ok render {}", if *on { "on" } else { "off" }),
            Self::Zero => out.write_str("ok zero: the handle is in the middle of its stroke"),
            Self::Middle => out.write_str("! index: the middle of the stroke is known"),
            Self::Home => out.write_str("ok home: slowly to both stops, hands off; the result follows"),
            Self::Move(e, watch) => {
                let (wave, amplitude, frequency) = (e.wave.id(), Text(e.amplitude_m), Text(e.frequency_hz));
                write!(out, "ok move {wave} {amplitude} {} {frequency} Hz", unit(Dimension::LENGTH))?;
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
pub(super) fn value(settings: &Settings, name: &str, geometry: Geometry, out: &mut Line) -> fmt::Result {
    let unit = unit(name, geometry);
    match (settings.get(name), unit) {
        (Some(value), Some(unit)) => write!(out, "{name} {value} {unit}"),
        (Some(value), None) => write!(out, "{name} {value}"),
        (None, _) => write!(out, "{name} off"),
    }
}

fn unit(name: &str, geometry: Geometry) -> Option<Unit> {
    use friction::effects::EffectName;
    use haptics::settings::{ALIASES, PARAMETERS};
    if let Some((effect, parameter)) = name.split_once('.') {
        let kind = EffectName::parse(effect)?.kind;
        return kind
            .gains()
            .iter()
            .chain(kind.shape())
            .find(|p| p.name == parameter)
            .map(|p| p.unit(geometry));
    }
    PARAMETERS.iter().chain(ALIASES).find(|p| p.name == name)?.unit(geometry)
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
#[inline(never)]
pub(super) fn handle(t: &Telemetry, device: &Device, out: &mut Line) -> fmt::Result {
    let o = &t.outputs;
    let load = Text(device.load.to_si(t.inputs.load_code));
    let unit = |dimension: Dimension| dimension.unit(device.geometry);
    let (m, m_s, n) = (unit(Dimension::LENGTH), unit(Dimension::VELOCITY), unit(Dimension::FORCE));
    write!(
        out,
        "handle {:.6} {m} {:.4} {m_s}, block {:.6} {m} {}, load {load:.places$} {n}, force {:.places$} {n}",
        Text(o.position),
        Text(o.velocity),
        Text(o.block_position),
        if o.stuck { "stuck" } else { "free" },
        Text(o.force),
        places = force_places(device),
    )
}

/// The result of a search for the stops in one line.
#[inline(never)]
pub(super) fn homed(homed: Homed, device: &Device, out: &mut Line) -> fmt::Result {
    let (scale, unit) = line::travel(device.geometry);
    let millimetre = |metre: f32| Text(scale * metre);
    if let Homed::Middle { stroke } = homed {
        let stroke = millimetre(stroke);
        return write!(out, "! home: stroke {stroke:.2} {unit}, the handle is in the middle");
    }
    out.write_str("! no home: ")?;
    match homed {
        Homed::Stroke { measured } => {
            let (least, most) = Homed::accepted(device);
            let (measured, least, most) = (millimetre(measured), millimetre(least), millimetre(most));
            write!(
                out,
                "stops {measured:.2} {unit} apart: accepted from {least:.2} to {most:.2}; remove what blocks the handle, hands off"
            )?;
        }
        Homed::NoStop => {
            let (_, most) = Homed::accepted(device);
            write!(out, "no stop within {:.2} {unit}: this is not the device's stroke", millimetre(most))?;
        }
        Homed::TooFast => out.write_str(
            "the handle moved faster than a search; hands off, and check the wiring by `zero` and `selftest`",
        )?,
        Homed::TooLong => out.write_str("it took too long; remove what blocks the handle, hands off")?,
        Homed::Interrupted | Homed::Middle { .. } => out.write_str("interrupted")?,
    }
    out.write_str("; still unreferenced")
}

/// 10 to this power.
fn powi(places: usize) -> f32 {
    (0..places).fold(1.0, |power, _| 10.0 * power)
}

/// Places of a printed force: those of millinewtons, or more for a device of less than 1 N.
fn force_places(device: &Device) -> usize {
    if device.force_max < 1.0 { 5 } else { 3 }
}

/// The result of an identification in one line.
#[inline(never)]
pub(super) fn identified(found: &Identified, geometry: Geometry, out: &mut Line) -> fmt::Result {
    out.write_str("! identified: ")?;
    let levels = [("D_p", found.static_p), ("D_n", found.static_n)];
    for (name, estimate, dimension) in [
        ("mass", found.mass, Dimension::MASS),
        ("C_p", found.coulomb_p, Dimension::FORCE),
        ("C_n", found.coulomb_n, Dimension::FORCE),
        ("b_p", found.viscous_p, Dimension::DAMPING),
        ("b_n", found.viscous_n, Dimension::DAMPING),
        ("dv", found.delta_v, Dimension::VELOCITY),
    ]
    .into_iter()
    .chain(levels.into_iter().filter_map(|(name, level)| Some((name, level?, Dimension::FORCE))))
    {
        // a deviation shows a digit that is not 0
        let places = (4..9).find(|places| estimate.std * powi(*places) >= 1.0).unwrap_or(4);
        write!(
            out,
            "{name} {:.*} ± {:.*} {}, ",
            places,
            Text(estimate.value),
            places,
            Text(estimate.std),
            dimension.unit(geometry)
        )?;
    }
    for (name, level) in levels {
        if level.is_none() {
            write!(out, "{name} not seen, ")?;
        }
    }
    write!(out, "relative error {:.2} %, {} samples", Text(100.0 * found.relative_error), found.used)
}

/// A fault with its motion.
#[inline(never)]
pub(super) fn moment(f: &FaultReport, device: &Device, line: &mut Line) -> fmt::Result {
    let unit = |dimension: Dimension| dimension.unit(device.geometry);
    let (m, m_s, n) = (unit(Dimension::LENGTH), unit(Dimension::VELOCITY), unit(Dimension::FORCE));
    let (kind, step, during) = (f.kind, f.step, f.during.id());
    write!(line, "{kind} at step {step} while {during}: ")?;
    let (position, velocity, force) = (Text(f.position), Text(f.velocity), Text(f.force));
    let places = force_places(device);
    write!(line, "handle {position:.6} {m} {velocity:.4} {m_s}, force {force:.places$} {n}")
}
