//! Text of `help`.

/// One line of `help`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HelpLine {
    /// Usage.
    pub usage: &'static str,
    /// Effect of the command.
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

/// Every command, in the order a user needs them.
pub const HELP: &[HelpLine] = &[
    line("help", "commands, and parameters with their units"),
    line("preset list|show|use|save|delete|default [NAME]", "named sets of parameters"),
    line("render on|off", "turns the friction on the handle on or off"),
    line("set PARAM VALUE", "sets one parameter; a rejected value leaves the old one"),
    line("get [PARAM]", "shows one parameter, or all"),
    line(
        "move WAVE AMP FREQ [SECONDS]",
        "drives the handle: sine, multisine, chirp, triangle or dwell; m, Hz, s; see `watch`",
    ),
    line("stop", "stops rendering, a motion or an identification; a motion ramps out"),
    line("off", "switches the amplifier off at once, whatever runs"),
    line("zero", "the handle is in the middle of its stroke: moved there by hand, amplifier off"),
    line("home", "searches both stops and the middle between them, slowly and with little force; hands off"),
    line("stream on|off [DECIMATION]", "binary frames, one every DECIMATION control periods"),
    line("identify", "identifies the block on the device in 12 s; hands off the handle"),
    line(
        "watch [SECONDS [render]]",
        "longest silence of the host while it drives the handle, or renders, too; 0: no limit",
    ),
    line("limit [NAME VALUE]", "limits of force balance and motor heat, until the device restarts"),
    line("status", "state, preset, handle, force, losses"),
    line("fault", "shows the latched fault and its remedy"),
    line("clear", "leaves the fault state; handle at rest, hands off"),
    line("selftest", "tests sensors, loop and amplifier; pushes the handle by a millimetre: hands off"),
    line(
        "calibrate load|accel VALUE | save|discard|status|force",
        "the true value now (SI); two or more, then save; force: hold the handle, 12 s",
    ),
    line(
        "device [set NAME VALUE [NAME VALUE …] | reset]",
        "the device: stroke, resolution, signs, gains …; stored, in use at once, unreferenced then",
    ),
    line(
        "compensate [NAME VALUE [NAME VALUE …] | off]",
        "feeds forward what was found of the device while it renders: its friction, cogging; until it restarts",
    ),
    line("rate [HZ]", "control rate; 1000 after a start"),
    line("version", "firmware version and board"),
];
