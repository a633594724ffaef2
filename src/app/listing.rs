//! Answers of several lines, produced one line at a time.

use crate::board::Board;
use core::fmt::{self, Write};
use friction::Geometry;
use friction::Unit;
use friction::effects::{EffectKind, EffectName};
use haptics::number::Text;
use haptics::{DEVICE_SETTINGS, Device, DeviceValue, Settings, settings};
use link::HELP;

/// An answer of several lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub(super) enum Listing {
    /// `help`
    Help,
    /// `get` and `preset show`
    Parameters(Settings),
    /// `selftest`
    Checks([super::selftest::Check; 5]),
    /// `device`
    Device,
}

impl Listing {
    /// Number of lines.
    pub fn lines(&self, board: &impl Board) -> usize {
        match self {
            Self::Help => {
                HELP.len() + board.help().len() + 1 + settings::PARAMETERS.len() + settings::ALIASES.len() + 1
            }
            Self::Parameters(settings) => {
                settings::PARAMETERS.len() + effect_parameters(settings, Geometry::Linear).count()
            }
            Self::Checks(checks) => checks.len(),
            Self::Device => DEVICE_SETTINGS.len(),
        }
    }

    /// Writes line `at`, from 0.
    pub fn write(&self, at: usize, device: &Device, board: &impl Board, out: &mut impl Write) -> fmt::Result {
        match self {
            Self::Help => help(at, device.geometry, board, out),
            Self::Parameters(settings) => parameter(settings, at, device.geometry, out),
            Self::Checks(checks) => {
                checks.get(at).map_or(Ok(()), |check| write!(out, "  {}", check.on(device.geometry)))
            }
            Self::Device => setting(device, at, out),
        }
    }
}

fn help(at: usize, geometry: Geometry, board: &impl Board, out: &mut impl Write) -> fmt::Result {
    let mut commands = HELP.iter().chain(board.help());
    let count = HELP.len() + board.help().len();
    if let Some(line) = commands.nth(at) {
        return write!(out, "  {:<52} {}", line.usage, line.what);
    }
    let Some(at) = at.checked_sub(count + 1) else { return write!(out, "  parameters:") };
    match settings::PARAMETERS.iter().chain(settings::ALIASES).nth(at) {
        Some(p) => match p.unit(geometry) {
            Some(unit) => write!(out, "    {:<18} {unit:<6} {}", p.name, p.what),
            None => write!(out, "    {:<18} {:<6} {}", p.name, "-", p.what),
        },
        None => {
            write!(
                out,
                "    EFFECT.PARAMETER   besides, e.g. stribeck.force_p, of a second wavelength cogging_2.sine_1; `set EFFECT off` removes; effects:"
            )?;
            EffectKind::ALL.iter().try_for_each(|kind| write!(out, " {}", kind.id()))
        }
    }
}

/// Name and unit of every parameter of the effects in use.
fn effect_parameters(
    settings: &Settings,
    geometry: Geometry,
) -> impl Iterator<Item = (EffectName, &'static str, Unit, f32)> {
    EffectName::of(settings.effects.iter().flatten()).flat_map(move |(effect, of)| {
        let gains = of.kind.gains().iter().zip(of.gains);
        gains
            .chain(of.kind.shape().iter().zip(of.shape))
            .map(move |(p, x)| (effect, p.name, p.unit(geometry), x))
    })
}

fn parameter(settings: &Settings, at: usize, geometry: Geometry, out: &mut impl Write) -> fmt::Result {
    let Some(p) = settings::PARAMETERS.get(at) else {
        let besides = effect_parameters(settings, geometry).nth(at - settings::PARAMETERS.len());
        return besides
            .map_or(Ok(()), |(effect, name, unit, x)| write!(out, "  {effect}.{name} {} {unit}", Text(x)));
    };
    match (settings.get(p.name), p.unit(geometry)) {
        (Some(value), None) => write!(out, "  {} {value}", p.name),
        (Some(value), Some(unit)) => write!(out, "  {} {value} {unit}", p.name),
        (None, _) => Ok(()),
    }
}

/// One setting of the device.
fn setting(device: &Device, at: usize, out: &mut impl Write) -> fmt::Result {
    let Some(setting) = DEVICE_SETTINGS.get(at) else { return Ok(()) };
    write!(out, "  {:<10} ", setting.name)?;
    value(device, setting.name, out)?;
    write!(out, "; {}", setting.what)
}

/// Value of a setting of the device with its unit.
#[inline(never)]
pub(super) fn value(device: &Device, name: &str, out: &mut impl Write) -> fmt::Result {
    match device.get(name) {
        Some(DeviceValue::Geometry(Geometry::Linear)) => out.write_str("linear"),
        Some(DeviceValue::Geometry(Geometry::Rotary)) => out.write_str("rotary"),
        Some(DeviceValue::Number(x)) => {
            let setting = DEVICE_SETTINGS.iter().find(|setting| setting.name == name);
            write!(out, "{}", Text(x))?;
            match setting.and_then(|setting| Some((setting, setting.unit(device.geometry)?))) {
                Some((setting, unit)) => write!(out, " {unit}{}", if setting.per_volt { "/V" } else { "" }),
                None => Ok(()),
            }
        }
        None => Ok(()),
    }
}
