//! What `help` says.

/// One command as `help` shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HelpLine {
    /// How it is typed.
    pub usage: &'static str,
    /// What it does.
    pub what: &'static str,
}

impl HelpLine {
    /// First word of the usage.
    #[must_use]
    pub fn word(&self) -> &'static str {
        self.usage.split(' ').next().unwrap_or(self.usage)
    }
}

const fn line(usage: &'static str, what: &'static str) -> HelpLine {
    HelpLine { usage, what }
}

/// Every command, in the order people need them.
pub const HELP: &[HelpLine] = &[
    line("help", "this list, and the parameters with their units"),
    line("preset list|show|use|save|delete|default [NAME]", "sets of parameters by name"),
    line("render on|off", "friction on the handle"),
    line("set PARAM VALUE", "one parameter; a refused value leaves the old one"),
    line("get [PARAM]", "one parameter, or all of them"),
    line(
        "move WAVE AMP FREQ [SECONDS]",
        "drives the handle by sine, multisine, chirp, triangle, dwell; m, Hz, s; see `watch`",
    ),
    line("stop", "ends what runs; a motion ramps out"),
    line("stream on|off [DECIMATION]", "binary frames, one every so many control periods"),
    line("identify", "the thesis's procedure on the device: 12 s, keep off the handle"),
    line("watch [SECONDS]", "how long the host may say nothing while it drives the handle; 0: for ever"),
    line("status", "state, preset, handle, force, losses"),
    line("fault", "the latched fault and what to do"),
    line("clear", "leaves the fault state; handle at rest, hands off"),
    line("selftest", "sensors, loop and amplifier; pushes the handle by a millimetre: hands off"),
    line(
        "calibrate load|accel VALUE | save|discard|status",
        "what the sensor should read now, N or m/s2; two values or more, then save",
    ),
    line("rate [HZ]", "control periods in a second; 1000 after a start"),
    line("version", "what runs here"),
];
