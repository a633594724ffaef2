//! Random lines, valid and invalid, as a person, a script or noise types them.

/// SplitMix64: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn pick<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len())]
    }
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
    "law",
    "renderer",
    "passivity",
    "stribeck.force_p",
    "cogging",
    "nothing",
];
const WORDS: &[&str] =
    &["karnopp", "dahl", "lugre", "coulomb", "on", "off", "impedance", "stopping_force", "virtual_coupling"];
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
    let number = |r: &mut Random| r.pick(NUMBERS);
    match r.below(26) {
        0 | 1 => "render on".into(),
        2 => "render off".into(),
        3 => "home".into(),
        4 => "zero".into(),
        5 => "clear".into(),
        6 => format!("set {} {}", r.pick(PARAMETERS), number(r)),
        7 => format!("set {} {}", r.pick(PARAMETERS), r.pick(WORDS)),
        8 => format!("preset use {}", r.pick(PRESETS)),
        9 => format!("preset {} {}", r.pick(&["show", "default", "use"]), r.pick(PRESETS)),
        10 | 11 => {
            let wave = r.pick(&["sine", "multisine", "chirp", "triangle", "dwell", "square"]);
            let (amplitude, frequency) =
                (r.pick(&["0.01", "0.005", "0.014", "1", "-1"]), r.pick(&["0.5", "2", "5", "100"]));
            format!("move {wave} {amplitude} {frequency} {}", number(r))
        }
        12 => "identify".into(),
        13 => "selftest".into(),
        14 => r.pick(&["stop", "off", "status", "fault", "version", "get", "help", "device", "limit"]).into(),
        15 => format!("stream {} {}", r.pick(&["on", "off"]), number(r)),
        16 => format!("rate {}", number(r)),
        17 => format!("calibrate {} {}", r.pick(&["load", "accel", "save", "discard", "status"]), number(r)),
        18 => format!("watch {} {}", number(r), r.pick(&["", "render", "x"])),
        19 => format!(
            "limit {} {}",
            r.pick(&["unexplained_force", "continuous_force", "heating", "x"]),
            number(r)
        ),
        20 => format!("device set {} {}", r.pick(SETTINGS), number(r)),
        // near the device that is there
        21 => format!(
            "device set {}",
            r.pick(&["mass 0.7", "damping 7", "overspeed 0.9", "force_max 9", "stroke 0.0322"])
        ),
        22 => format!(
            "sim hand {}",
            r.pick(&["off", "hold", "at 0.01", "at -0.005", "push 3", "push -15", "sine 0.01 2"])
        ),
        23 => format!("sim block {}", r.pick(&["none", "brass", "teflon", "rubber"])),
        24 => {
            let wire = r.pick(&["encoder", "load", "accel", "amplifier", "command"]);
            format!("sim wire {wire} {}", r.pick(&["right", "right", "swapped", "dead", "floating"]))
        }
        _ => (0..r.below(40)).map(|_| char::from(b' ' + (r.next() % 95) as u8)).collect(),
    }
}
