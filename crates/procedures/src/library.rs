//! The presets that come with `tribos`: the files of the `presets` folder, inside the program.

use crate::error::{Error, Result};
use identify::Model;
use std::path::Path;

/// A preset as a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// Name, here and on the device.
    pub name: &'static str,
    /// The file, comments included.
    pub text: &'static str,
}

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// All of them, in the order people look for them.
        pub const PRESETS: &[Preset] = &[
            $(Preset { name: $name, text: include_str!(concat!("../../../presets/", $name, ".toml")) },)*
        ];
    };
}

presets![
    "brass-1",
    "brass-2",
    "teflon-1",
    "teflon-2",
    "rubber-1",
    "rubber-2",
    "ice",
    "viscous-damping",
    "volume-knob",
    "selector",
    "ratchet",
    "washboard",
    "corduroy",
    "linen",
    "wood-grain",
    "ice-with-grit",
    "file",
    "ball-slide",
    "baseline",
    "real-friction",
    "simulated-friction",
    "high-stiction",
    "jnd-reference",
    "jnd-1-1",
    "jnd-1-2",
    "jnd-1-3",
    "jnd-1-4",
    "jnd-1-5",
    "jnd-2-1",
    "jnd-2-2",
    "jnd-2-3",
    "jnd-2-4",
    "jnd-2-5",
    "jnd-3-1",
    "jnd-3-2",
    "jnd-3-3",
    "jnd-3-4",
    "jnd-3-5",
];

impl Preset {
    /// What it is, in a line: the first sentence of the file.
    #[must_use]
    pub fn about(&self) -> String {
        let lines = self.text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
        let comment = lines.collect::<Vec<_>>().join(" ");
        match comment.find(". ") {
            Some(end) => comment[..end].to_owned(),
            None => comment.trim_end_matches('.').to_owned(),
        }
    }

    /// The model in it.
    ///
    /// # Errors
    /// A file that is none; a test reads all of them.
    pub fn model(&self) -> Result<Model> {
        Ok(Model::from_toml(&format!("presets/{}.toml", self.name), self.text)?)
    }
}

/// The preset of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// A preset from a file, or by its name; a file that is there comes first.
///
/// # Errors
/// Neither a file nor a name; a file that is no preset.
pub fn read(what: &Path) -> Result<Model> {
    let named = what.to_str().filter(|_| !what.exists()).and_then(find);
    match named {
        Some(preset) => preset.model(),
        None => Model::read(what).map_err(|error| {
            let is_name = what.extension().is_none() && what.components().count() == 1 && !what.exists();
            if is_name { Error::NoPreset { error } } else { error.into() }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use client::Session;
    use haptics::{Device, Settings};
    use perception::{Batch, Procedure, Resistance, Stimulus};

    /// What a device makes of the file's lines, one after another.
    fn settings(model: &Model) -> Settings {
        let mut settings = Settings::viscous();
        for (name, value) in model.preset_lines() {
            settings.set(&name, &value).unwrap_or_else(|e| panic!("set {name} {value}: {e}"));
        }
        settings
    }

    #[test]
    fn every_preset_builds_and_only_table_5_3_is_warned_of() {
        let device = Device::default();
        let mut warned = Vec::new();
        for preset in PRESETS {
            let model = preset.model().expect("a model");
            assert_eq!(model.name, preset.name);
            let settings = settings(&model);
            let warning = settings.validate(&device).unwrap_or_else(|e| panic!("{}: {e}", preset.name));
            settings.build(&device).unwrap_or_else(|e| panic!("{}: {e}", preset.name));
            let said = warning.map_or("taken".into(), |w| format!("taken with the warning {w}"));
            println!("{:<19} {said}\n{:<19} {}", preset.name, "", preset.about());
            if warning.is_some() {
                warned.push(preset.name);
            }
            // a share of the file is a share of all that is in it
            assert_eq!(Model::from_toml(preset.name, &model.to_toml()).expect("a model"), model);
        }
        assert!(!warned.is_empty() && warned.iter().all(|name| name.starts_with("jnd-")), "{warned:?}");
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../presets")).expect("it");
        assert_eq!(folder.count(), PRESETS.len(), "a file in presets/ is not in the program");
    }

    #[test]
    fn textures_are_rendered_as_asked_and_smoothly() {
        println!(
            "{:14}{:>7} {:>18} {:>10} {:>22}",
            "", "rate", "asked, rendered", "error rms", "largest step, asked"
        );
        let (mut textures, mut failed) = (0, Vec::new());
        for preset in PRESETS {
            let model = preset.model().expect("a model");
            if model.effects.is_empty() {
                continue;
            }
            textures += 1;
            for rate in [1e3, 1e4] {
                let settings = settings(&model);
                let t = design::texture::measure(&settings, rate)
                    .unwrap_or_else(|e| panic!("{}: {e}", preset.name));
                println!(
                    "{:14}{:>5.0} k {:>8.3} {:>6.3} N {:>8.1} mN {:>10.1} {:>6.1} mN",
                    preset.name,
                    rate / 1e3,
                    t.asked,
                    t.rendered,
                    1e3 * t.error,
                    1e3 * t.step,
                    1e3 * t.step_asked
                );
                // a period late at most, and no click beyond what is asked for
                let exact = t.error < 20.0 * t.asked / rate;
                let whole = (t.rendered / t.asked - 1.0).abs() < 0.02;
                let smooth = t.step < 1.15 * t.step_asked;
                if !(exact && whole && smooth) {
                    failed.push(format!(
                        "{} at {rate} Hz: exact {exact}, whole {whole}, smooth {smooth}",
                        preset.name
                    ));
                }
            }
        }
        assert!(textures == 10 && failed.is_empty(), "{textures} textures; {failed:#?}");
    }

    #[test]
    fn a_device_takes_every_preset_over_its_line() {
        let mut session = Session::open("sim", 1).expect("a virtual device");
        for preset in PRESETS {
            let settled = session.set_all(&preset.model().expect("a model").preset_lines()).expect("a line");
            assert_eq!(settled.refused, Vec::<String>::new(), "{}", preset.name);
            let warned = settled.warning.is_some_and(|warning| warning.contains("4.35"));
            assert_eq!(warned, preset.name.starts_with("jnd-"), "{}", preset.name);
            session.command("render on").expect("rendered");
            session.command("render off").expect("stopped");
        }
    }

    #[test]
    fn the_files_are_the_tables_of_the_thesis() {
        for material in plant::materials::TABLE_3_3 {
            let name = material.name.to_lowercase().replace(' ', "-");
            let model = find(&name).expect("a preset").model().expect("a model");
            assert_eq!((model.mass, model.law), (material.mass, friction::Law::Karnopp(material.law)));
        }
        let same = |name: &str, stimulus: &Stimulus| {
            let model = find(name).expect("a preset").model().expect("a model");
            let lines = model.preset_lines();
            for (parameter, value) in stimulus.parameters() {
                let of = |suffix: &str| lines.iter().find(|(n, _)| *n == format!("{parameter}{suffix}"));
                for (_, text) in [of(""), of("_p"), of("_n")].into_iter().flatten() {
                    assert_eq!(text.parse::<f64>(), Ok(value), "{name}: {parameter}");
                }
                assert!(of("").or(of("_p")).is_some(), "{name}: {parameter}");
            }
        };
        same("jnd-reference", &Stimulus::REFERENCE);
        for batch in 1..=3 {
            let printed = Batch::printed(batch).expect("a batch");
            let Procedure::Constant { comparisons, .. } = printed.procedure else { panic!("constant") };
            for (k, stimulus) in comparisons.iter().enumerate() {
                same(&format!("jnd-{batch}-{}", k + 1), stimulus);
            }
        }
        for (resistance, name) in [
            (Resistance::Simulated, "simulated-friction"),
            (Resistance::HighStiction, "high-stiction"),
            (Resistance::Viscous, "viscous-damping"),
        ] {
            same(name, &resistance.rendered().expect("rendered"));
        }
    }

    #[test]
    fn the_baseline_adds_no_force() {
        use client::{Event, Virtual};
        use tribos_firmware::board::simulated::Holder;
        let mut device = Virtual::new(3).expect("a virtual device");
        device.device().hold(Holder::to_and_fro(0.008, 1.0));
        let mut session = Session::over("sim", Box::new(device));
        let model = find("baseline").expect("it").model().expect("a model");
        assert_eq!(session.set_all(&model.preset_lines()).expect("a line").refused, Vec::<String>::new());
        session.command("render on").expect("rendered");
        session.command("stream on").expect("streams");
        let (mut most, mut travel, mut count) = (0.0_f64, 0.0_f64, 0);
        while count < 1500 {
            for event in session.poll().expect("a line") {
                if let Event::Sample(sample) = event {
                    most = most.max(sample.command.abs());
                    travel = travel.max(sample.position.abs());
                    count += 1;
                }
            }
        }
        println!("baseline: at most {most} N on {:.1} mm of travel", 1e3 * travel);
        assert!(most == 0.0 && travel > 5e-3);
    }
}
