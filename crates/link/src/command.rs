//! Parser of command lines.

use core::fmt;
use friction::Dimension;
use haptics::{Excitation, Wave};

/// A command to the device.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub enum Command<'a> {
    /// `help`
    Help,
    /// `version`
    Version,
    /// `status`
    Status,
    /// `fault`
    Fault,
    /// `clear`
    Clear,
    /// `preset …`
    Preset(PresetCommand<'a>),
    /// `set PARAM VALUE`
    Set {
        /// Name of the parameter.
        name: &'a str,
        /// Text of the value.
        value: &'a str,
    },
    /// `get [PARAM]`
    Get(Option<&'a str>),
    /// `render on|off`
    Render(bool),
    /// `move WAVE AMP FREQ [SECONDS]`
    Move(Excitation),
    /// `stop`
    Stop,
    /// `off`
    Off,
    /// `zero`
    Zero,
    /// `home`
    Home,
    /// `stream on [DECIMATION]`, control periods per frame; 0 is `stream off`.
    Stream(u32),
    /// `identify`
    Identify,
    /// `selftest`
    SelfTest,
    /// `calibrate …`
    Calibrate(Calibrate),
    /// `device …`
    Device(DeviceCommand<'a>),
    /// `compensate …`: feed-forward of what was found of the device. Its `off` is [`DeviceCommand::Reset`].
    Compensate(DeviceCommand<'a>),
    /// `watch [SECONDS [render]]`: longest silence of the host.
    Watch(Option<Watch>),
    /// `limit [NAME VALUE]`: a limit of the slow checks.
    Limit(Option<(&'a str, f32)>),
    /// `rate [HZ]`: control rate.
    Rate(Option<u32>),
}

/// Limit on the silence of the host.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watch {
    /// Longest time without a byte from the host while the device drives the handle, s. 0 sets no limit.
    pub seconds: f32,
    /// Whether the limit applies while rendering, too.
    pub rendering: bool,
}

/// A sensor that can be calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Load cell, N.
    Load,
    /// Accelerometer, m/s².
    Accel,
}

impl Sensor {
    /// Name as typed.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Accel => "accel",
        }
    }

    /// Dimension of the values.
    #[must_use]
    pub const fn dimension(self) -> Dimension {
        match self {
            Self::Load => Dimension::FORCE,
            Self::Accel => Dimension::ACCELERATION,
        }
    }
}

/// `calibrate …`
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Calibrate {
    /// `calibrate load|accel VALUE`: the true value of the sensor now.
    Point(Sensor, f32),
    /// `calibrate force`: the force command against the load cell.
    Force,
    /// `calibrate save`
    Save,
    /// `calibrate discard`
    Discard,
    /// `calibrate status`
    Status,
}

/// Largest number of settings in one `device set`.
pub const MAX_PAIRS: usize = haptics::DEVICE_SETTINGS.len();

/// `device …`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub enum DeviceCommand<'a> {
    /// `device`
    Show,
    /// `device set NAME VALUE …`: names with their values, checked together.
    Set([Option<(&'a str, &'a str)>; MAX_PAIRS]),
    /// `device reset`
    Reset,
}

/// `preset …`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresetCommand<'a> {
    /// `preset list`
    List,
    /// `preset show NAME`
    Show(&'a str),
    /// `preset use NAME`
    Use(&'a str),
    /// `preset save NAME`
    Save(&'a str),
    /// `preset delete NAME`
    Delete(&'a str),
    /// `preset default NAME`
    Default(&'a str),
}

/// A line that is not a command. Nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BadCommand<'a> {
    /// Unknown first word.
    Unknown(&'a str),
    /// A missing word, with the usage.
    Missing(&'static str),
    /// A word too many, with the usage.
    TooMany(&'a str, &'static str),
    /// A word that is not accepted, with those that are.
    NotOneOf(&'a str, &'static str),
    /// Not a number, or out of range: parameter, text, accepted values.
    NotANumber(&'static str, &'a str, &'static str),
}

impl BadCommand<'_> {
    /// Code of the `err` answer.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Unknown(_) => "UNKNOWN",
            Self::NotANumber(..) => "VALUE",
            _ => "SYNTAX",
        }
    }
}

impl fmt::Display for BadCommand<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(word) => write!(f, "unknown command `{word}`; `help` lists all commands"),
            Self::Missing(usage) => write!(f, "missing word; usage: `{usage}`"),
            Self::TooMany(word, usage) => write!(f, "unexpected word `{word}`; usage: `{usage}`"),
            Self::NotOneOf(word, accepted) => write!(f, "`{word}`: expected one of {accepted}"),
            Self::NotANumber(what, text, accepted) => write!(f, "{what} = `{text}`: expected {accepted}"),
        }
    }
}

impl core::error::Error for BadCommand<'_> {}

/// Words of a line, checked against a usage.
struct Words<'a> {
    rest: core::str::SplitAsciiWhitespace<'a>,
    usage: &'static str,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Result<&'a str, BadCommand<'a>> {
        self.rest.next().ok_or(BadCommand::Missing(self.usage))
    }

    fn end(mut self) -> Result<(), BadCommand<'a>> {
        self.rest.next().map_or(Ok(()), |word| Err(BadCommand::TooMany(word, self.usage)))
    }
}

fn finite<'a>(what: &'static str, text: &'a str, accepted: &'static str) -> Result<f32, BadCommand<'a>> {
    haptics::number::parse(text).ok_or(BadCommand::NotANumber(what, text, accepted))
}

const DECIMATION: &str = "a whole number from 1 to 1000";

impl<'a> Command<'a> {
    /// Parses one line. `None` for an empty one.
    ///
    /// ```
    /// use link::Command;
    /// assert_eq!(Command::parse("render on"), Ok(Some(Command::Render(true))));
    /// let error = Command::parse("render maybe").unwrap_err();
    /// assert_eq!(error.to_string(), "`maybe`: expected one of on, off");
    /// ```
    ///
    /// # Errors
    /// [`BadCommand`]: one line that says what would be accepted.
    pub fn parse(line: &'a str) -> Result<Option<Self>, BadCommand<'a>> {
        let mut rest = line.split_ascii_whitespace();
        let Some(word) = rest.next() else { return Ok(None) };
        let mut words = Words { rest, usage: word_usage(word).ok_or(BadCommand::Unknown(word))? };
        let command = match word {
            "help" => Self::Help,
            "version" => Self::Version,
            "status" => Self::Status,
            "fault" => Self::Fault,
            "clear" => Self::Clear,
            "stop" => Self::Stop,
            "off" => Self::Off,
            "zero" => Self::Zero,
            "home" => Self::Home,
            "identify" => Self::Identify,
            "selftest" => Self::SelfTest,
            "preset" => Self::Preset(preset(&mut words)?),
            "set" => Self::Set { name: words.next()?, value: words.next()? },
            "get" => Self::Get(words.rest.next()),
            "render" => Self::Render(on_off(words.next()?)?),
            "move" => Self::Move(motion(&mut words)?),
            "stream" => Self::Stream(stream(&mut words)?),
            "calibrate" => Self::Calibrate(calibrate(&mut words)?),
            "device" => Self::Device(device(&mut words)?),
            "compensate" => Self::Compensate(compensate(&mut words)?),
            "watch" => Self::Watch(watch(&mut words)?),
            "limit" => Self::Limit(limit(&mut words)?),
            "rate" => Self::Rate(rate(&mut words)?),
            _ => return Err(BadCommand::Unknown(word)),
        };
        words.end()?;
        Ok(Some(command))
    }
}

/// Usage of a command, found by its first word.
fn word_usage(word: &str) -> Option<&'static str> {
    crate::HELP.iter().find(|line| line.word() == word).map(|line| line.usage)
}

fn preset<'a>(words: &mut Words<'a>) -> Result<PresetCommand<'a>, BadCommand<'a>> {
    Ok(match words.next()? {
        "list" => PresetCommand::List,
        "show" => PresetCommand::Show(words.next()?),
        "use" => PresetCommand::Use(words.next()?),
        "save" => PresetCommand::Save(words.next()?),
        "delete" => PresetCommand::Delete(words.next()?),
        "default" => PresetCommand::Default(words.next()?),
        word => return Err(BadCommand::NotOneOf(word, "list, show, use, save, delete, default")),
    })
}

fn on_off(word: &str) -> Result<bool, BadCommand<'_>> {
    match word {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(BadCommand::NotOneOf(word, "on, off")),
    }
}

fn motion<'a>(words: &mut Words<'a>) -> Result<Excitation, BadCommand<'a>> {
    let word = words.next()?;
    let wave =
        Wave::from_id(word).ok_or(BadCommand::NotOneOf(word, "sine, multisine, chirp, triangle, dwell"))?;
    let amplitude_m = finite("AMP", words.next()?, "a finite number of metres")?;
    let frequency_hz = finite("FREQ", words.next()?, "a finite number of hertz")?;
    let seconds = match words.rest.next() {
        Some(text) => finite("SECONDS", text, "a finite number of seconds, or nothing to move until `stop`")?,
        None => 0.0,
    };
    Ok(Excitation { wave, amplitude_m, frequency_hz, seconds })
}

fn stream<'a>(words: &mut Words<'a>) -> Result<u32, BadCommand<'a>> {
    if !on_off(words.next()?)? {
        return Ok(0);
    }
    let Some(text) = words.rest.next() else { return Ok(1) };
    let number = text.parse::<u32>().ok().filter(|n| (1..=1000).contains(n));
    number.ok_or(BadCommand::NotANumber("DECIMATION", text, DECIMATION))
}

fn calibrate<'a>(words: &mut Words<'a>) -> Result<Calibrate, BadCommand<'a>> {
    let sensor = match words.next()? {
        "load" => Sensor::Load,
        "accel" => Sensor::Accel,
        "force" => return Ok(Calibrate::Force),
        "save" => return Ok(Calibrate::Save),
        "discard" => return Ok(Calibrate::Discard),
        "status" => return Ok(Calibrate::Status),
        word => return Err(BadCommand::NotOneOf(word, "load, accel, force, save, discard, status")),
    };
    let value = finite("VALUE", words.next()?, "a finite number of N or m/s²")?;
    Ok(Calibrate::Point(sensor, value))
}

fn device<'a>(words: &mut Words<'a>) -> Result<DeviceCommand<'a>, BadCommand<'a>> {
    Ok(match words.rest.next() {
        None => DeviceCommand::Show,
        Some("reset") => DeviceCommand::Reset,
        Some("set") => {
            let name = words.next()?;
            DeviceCommand::Set(pairs(name, words)?)
        }
        Some(word) => return Err(BadCommand::NotOneOf(word, "set, reset, or nothing")),
    })
}

/// Names with their values, of which the first name was read.
fn pairs<'a>(
    first: &'a str,
    words: &mut Words<'a>,
) -> Result<[Option<(&'a str, &'a str)>; MAX_PAIRS], BadCommand<'a>> {
    let mut pairs = [None; MAX_PAIRS];
    pairs[0] = Some((first, words.next()?));
    for pair in &mut pairs[1..] {
        let Some(name) = words.rest.next() else { break };
        *pair = Some((name, words.next()?));
    }
    Ok(pairs)
}

fn compensate<'a>(words: &mut Words<'a>) -> Result<DeviceCommand<'a>, BadCommand<'a>> {
    Ok(match words.rest.next() {
        None => DeviceCommand::Show,
        Some("off") => DeviceCommand::Reset,
        Some(name) => DeviceCommand::Set(pairs(name, words)?),
    })
}

const WATCH: &str = "a number of seconds from 1 to 3600, or 0 for no watch";

fn watch<'a>(words: &mut Words<'a>) -> Result<Option<Watch>, BadCommand<'a>> {
    let Some(text) = words.rest.next() else { return Ok(None) };
    let seconds = finite("SECONDS", text, WATCH)?;
    if !(seconds == 0.0 || (1.0..=3600.0).contains(&seconds)) {
        return Err(BadCommand::NotANumber("SECONDS", text, WATCH));
    }
    let rendering = match words.rest.next() {
        None => false,
        Some("render") => true,
        Some(word) => return Err(BadCommand::NotOneOf(word, "render, or nothing")),
    };
    Ok(Some(Watch { seconds, rendering }))
}

fn limit<'a>(words: &mut Words<'a>) -> Result<Option<(&'a str, f32)>, BadCommand<'a>> {
    let Some(name) = words.rest.next() else { return Ok(None) };
    Ok(Some((name, finite("VALUE", words.next()?, "a finite number of N or s")?)))
}

const RATE: &str = "1000, 2000, 5000, 10000 or 20000";

fn rate<'a>(words: &mut Words<'a>) -> Result<Option<u32>, BadCommand<'a>> {
    let Some(text) = words.rest.next() else { return Ok(None) };
    let number = text.parse::<u32>().ok().filter(|hz| haptics::RATES.contains(hz));
    number.map(Some).ok_or(BadCommand::NotANumber("HZ", text, RATE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_command_is_parsed() {
        let sine = Excitation { wave: Wave::Sine, amplitude_m: 0.01, frequency_hz: 2.0, seconds: 0.0 };
        for (line, expected) in [
            ("help", Command::Help),
            ("version", Command::Version),
            ("status", Command::Status),
            (" fault \t", Command::Fault),
            ("clear", Command::Clear),
            ("preset list", Command::Preset(PresetCommand::List)),
            ("preset show rubber", Command::Preset(PresetCommand::Show("rubber"))),
            ("preset use rubber", Command::Preset(PresetCommand::Use("rubber"))),
            ("preset save mine", Command::Preset(PresetCommand::Save("mine"))),
            ("preset delete mine", Command::Preset(PresetCommand::Delete("mine"))),
            ("preset default brass", Command::Preset(PresetCommand::Default("brass"))),
            ("set f_static 2.5", Command::Set { name: "f_static", value: "2.5" }),
            ("get", Command::Get(None)),
            ("get dv", Command::Get(Some("dv"))),
            ("render on", Command::Render(true)),
            ("render off", Command::Render(false)),
            ("move sine 0.01 2", Command::Move(sine)),
            ("move sine 0.01 2 12", Command::Move(Excitation { seconds: 12.0, ..sine })),
            ("stop", Command::Stop),
            ("off", Command::Off),
            ("zero", Command::Zero),
            ("home", Command::Home),
            ("stream on", Command::Stream(1)),
            ("stream on 10", Command::Stream(10)),
            ("stream off", Command::Stream(0)),
            ("identify", Command::Identify),
            ("selftest", Command::SelfTest),
            ("calibrate load 4.905", Command::Calibrate(Calibrate::Point(Sensor::Load, 4.905))),
            ("calibrate save", Command::Calibrate(Calibrate::Save)),
            ("calibrate force", Command::Calibrate(Calibrate::Force)),
            ("device", Command::Device(DeviceCommand::Show)),
            ("device reset", Command::Device(DeviceCommand::Reset)),
            (
                "device set stroke 2 mass 1e-4",
                Command::Device(DeviceCommand::Set(core::array::from_fn(|k| {
                    [("stroke", "2"), ("mass", "1e-4")].get(k).copied()
                }))),
            ),
            ("compensate", Command::Compensate(DeviceCommand::Show)),
            ("compensate off", Command::Compensate(DeviceCommand::Reset)),
            (
                "compensate friction_p 1.04",
                Command::Compensate(DeviceCommand::Set(core::array::from_fn(|k| {
                    [("friction_p", "1.04")].get(k).copied()
                }))),
            ),
            ("watch", Command::Watch(None)),
            ("watch 0", Command::Watch(Some(Watch { seconds: 0.0, rendering: false }))),
            ("watch 2.5", Command::Watch(Some(Watch { seconds: 2.5, rendering: false }))),
            ("watch 2 render", Command::Watch(Some(Watch { seconds: 2.0, rendering: true }))),
            ("limit", Command::Limit(None)),
            ("limit heating 30", Command::Limit(Some(("heating", 30.0)))),
            ("rate", Command::Rate(None)),
            ("rate 5000", Command::Rate(Some(5000))),
        ] {
            assert_eq!(Command::parse(line), Ok(Some(expected)), "{line}");
        }
        assert_eq!(Command::parse("   "), Ok(None));
    }

    #[test]
    fn errors_say_what_would_be_accepted() {
        for (line, code, says) in [
            ("rendre on", "UNKNOWN", "unknown command `rendre`; `help` lists all commands"),
            ("render", "SYNTAX", "missing word; usage: `render on|off`"),
            ("render maybe", "SYNTAX", "`maybe`: expected one of on, off"),
            ("stop now", "SYNTAX", "unexpected word `now`; usage: `stop`"),
            ("move sine 0.01 NaN", "VALUE", "FREQ = `NaN`: expected a finite number of hertz"),
            (
                "move square 1 1",
                "SYNTAX",
                "`square`: expected one of sine, multisine, chirp, triangle, dwell",
            ),
            ("stream on 0", "VALUE", "DECIMATION = `0`: expected a whole number from 1 to 1000"),
            (
                "watch -1",
                "VALUE",
                "SECONDS = `-1`: expected a number of seconds from 1 to 3600, or 0 for no watch",
            ),
            (
                "device set stroke",
                "SYNTAX",
                "missing word; usage: `device [set NAME VALUE [NAME VALUE …] | reset]`",
            ),
            ("device sett", "SYNTAX", "`sett`: expected one of set, reset, or nothing"),
            (
                "compensate share",
                "SYNTAX",
                "missing word; usage: `compensate [NAME VALUE [NAME VALUE …] | off]`",
            ),
            ("watch 2 rendre", "SYNTAX", "`rendre`: expected one of render, or nothing"),
            ("limit heating", "SYNTAX", "missing word; usage: `limit [NAME VALUE]`"),
            ("limit heating NaN", "VALUE", "VALUE = `NaN`: expected a finite number of N or s"),
            ("rate 3000", "VALUE", "HZ = `3000`: expected 1000, 2000, 5000, 10000 or 20000"),
            ("set dv", "SYNTAX", "missing word; usage: `set PARAM VALUE`"),
        ] {
            let bad = Command::parse(line).unwrap_err();
            assert_eq!((bad.code(), bad.to_string().as_str()), (code, says), "{line}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_line_panics(line in ".{0,200}") {
            let _ = Command::parse(&line).map_err(|bad| bad.to_string());
        }
    }
}
