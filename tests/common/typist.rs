//! Random lines, valid and invalid, as a person, a script or noise types them.

use emulator::random::Random;

fn pick<'a>(r: &mut Random, words: &[&'a str]) -> &'a str {
    words[r.below(words.len())]
}

const NUMBERS: &[&str] = &[
    "0", "1", "-1", "0.5", "2", "0.01", "1e-3", "1e-4", "3.3", "8000", "15", "60", "1e9", "-1e9", "NaN",
    "inf", "x", "", "0.005", "0.02", "30", "1000", "5000", "20000",
];
const PARAMETERS: &[&str] = &[
    "f_static",
    "f_dynamic",
    "f_static_p",
    "damping",
    "dv",
    "mass",
    "k_vc",
    "b_vc",
    "sigma",
    "sigma_1",
    "stribeck_velocity",
    "elastic",
    "attraction",
    "memory",
    "dwell",
    "steepness",
    "adhesion",
    "law",
    "renderer",
    "passivity",
    "stribeck.force_p",
    "cogging",
    "nothing",
];
const WORDS: &[&str] = &[
    "karnopp",
    "dahl",
    "lugre",
    "coulomb",
    "elasto_plastic",
    "maxwell_slip",
    "hayward_armstrong",
    "armstrong",
    "majd_simaan",
    "classic",
    "bristle",
    "viscous",
    "stick_slip_slide",
    "on",
    "off",
    "impedance",
    "stopping_force",
    "virtual_coupling",
];
const PRESETS: &[&str] = &["brass", "rubber", "teflon", "viscous", "a", "b", "identified", "nowhere"];
const SETTINGS: &[&str] = &[
    "stroke",
    "resolution",
    "mass",
    "damping",
    "overspeed",
    "force_max",
    "force_gain",
    "load_gain",
    "accel_gain",
];

/// A line that a person, a script or noise types.
pub fn line(r: &mut Random) -> String {
    let number = |r: &mut Random| pick(r, NUMBERS);
    match r.below(27) {
        0 | 1 => "render on".into(),
        2 => "render off".into(),
        3 => "home".into(),
        4 => "zero".into(),
        5 => "clear".into(),
        6 => format!("set {} {}", pick(r, PARAMETERS), number(r)),
        7 => format!("set {} {}", pick(r, PARAMETERS), pick(r, WORDS)),
        8 => format!("preset use {}", pick(r, PRESETS)),
        9 => format!("preset {} {}", pick(r, &["show", "default", "use"]), pick(r, PRESETS)),
        10 | 11 => {
            let wave = pick(r, &["sine", "multisine", "chirp", "triangle", "dwell", "square"]);
            let (amplitude, frequency) =
                (pick(r, &["0.01", "0.005", "0.014", "1", "-1"]), pick(r, &["0.5", "2", "5", "100"]));
            format!("move {wave} {amplitude} {frequency} {}", number(r))
        }
        12 => "identify".into(),
        13 => "selftest".into(),
        14 => {
            pick(r, &["stop", "off", "status", "fault", "version", "get", "help", "device", "limit"]).into()
        }
        15 => format!("stream {} {}", pick(r, &["on", "off"]), number(r)),
        16 => format!("rate {}", number(r)),
        17 => format!("calibrate {} {}", pick(r, &["load", "accel", "save", "discard", "status"]), number(r)),
        18 => format!("watch {} {}", number(r), pick(r, &["", "render", "x"])),
        19 => format!(
            "limit {} {}",
            pick(r, &["unexplained_force", "continuous_force", "heating", "x"]),
            number(r)
        ),
        20 => format!("device set {} {}", pick(r, SETTINGS), number(r)),
        // near the device that is there
        21 => format!(
            "device set {}",
            pick(r, &["mass 0.7", "damping 7", "overspeed 0.9", "force_max 9", "stroke 0.0322"])
        ),
        22 => format!(
            "sim hand {}",
            pick(r, &["off", "hold", "at 0.01", "at -0.005", "push 3", "push -15", "sine 0.01 2"])
        ),
        23 => format!("sim block {}", pick(r, &["none", "brass", "teflon", "rubber"])),
        24 => {
            let wire = pick(r, &["encoder", "load", "accel", "amplifier", "command"]);
            format!("sim wire {wire} {}", pick(r, &["right", "right", "swapped", "dead", "floating"]))
        }
        25 => "calibrate force".into(),
        _ => (0..r.below(40)).map(|_| char::from(b' ' + (r.draw() % 95) as u8)).collect(),
    }
}
