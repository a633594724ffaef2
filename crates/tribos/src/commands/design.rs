//! `tribos design`: stability bounds and limit cycles of chapter 4, before anything runs.

use crate::design::{self, Change, Design, Given};
use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::options;
use crate::table::{Table, number};
use haptics::bounds::Grasp;
use haptics::{Device, Settings};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Options of `design`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  tribos design --mass 0.5 --friction 4 --stiffness 10000 --damping 10
  tribos design --device-mass 1 --device-damping 10 --dv 0.02
  tribos design --preset rubber --map rubber.svg
  tribos design --grid --map grid.svg
  tribos design --renderers")]
pub struct Args {
    /// Mass of the virtual block M, kg
    #[arg(long, value_name = "KG", value_parser = options::above_zero, allow_hyphen_values = true)]
    mass: Option<f64>,
    /// Dynamic friction F, N
    #[arg(long, value_name = "N", value_parser = options::not_negative, allow_hyphen_values = true)]
    friction: Option<f64>,
    /// Control period T, s
    #[arg(long, value_name = "S", default_value = "0.001", value_parser = options::above_zero, allow_hyphen_values = true)]
    period: f64,
    /// Coupling stiffness K, N/m
    #[arg(long, value_name = "N/m", value_parser = options::above_zero, allow_hyphen_values = true)]
    stiffness: Option<f64>,
    /// Coupling damping B, N·s/m
    #[arg(long, value_name = "N·s/m", value_parser = options::not_negative, allow_hyphen_values = true)]
    damping: Option<f64>,
    /// Mass of the handle m, kg
    #[arg(long, value_name = "KG", value_parser = options::above_zero, allow_hyphen_values = true)]
    device_mass: Option<f64>,
    /// Damping of the handle b, N·s/m
    #[arg(long, value_name = "N·s/m", value_parser = options::not_negative, allow_hyphen_values = true)]
    device_damping: Option<f64>,
    /// From sample to force, s; up to one period
    #[arg(long, value_name = "S", default_value = "0", value_parser = options::not_negative, allow_hyphen_values = true)]
    delay: f64,
    /// Speed taken for zero DV, m/s
    #[arg(long, value_name = "m/s", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) dv: Option<f64>,
    /// Travel of one encoder count, m
    #[arg(long, value_name = "M", value_parser = options::above_zero, allow_hyphen_values = true)]
    encoder: Option<f64>,
    /// Dominant frequency of the force to be followed, Hz
    #[arg(long, value_name = "HZ", value_parser = options::above_zero, allow_hyphen_values = true)]
    frequency: Option<f64>,
    /// Hand on the handle: mass kg, damping N·s/m, stiffness N/m (released when not given)
    #[arg(long, value_name = "KG,N·s/m,N/m", value_parser = grasp, allow_hyphen_values = true)]
    hand: Option<Grasp>,
    /// Check a preset on this device instead, and find the nearest that is right: a built-in name
    #[arg(long, value_name = "NAME", conflicts_with_all = ["mass", "friction", "stiffness", "damping", "dv"])]
    pub(super) preset: Option<String>,
    /// Run so many couplings (10 000 when no number is given) through the simulated device under every renderer: which
    /// come to rest, which chatter; with --map as a picture. --dv is the thesis's renderers'
    #[arg(long, value_name = "POINTS", num_args = 0..=1, default_missing_value = "10000", value_parser = clap::value_parser!(u32).range(1..=1_000_000), conflicts_with_all = ["mass", "friction", "stiffness", "damping", "device_mass", "device_damping", "preset", "renderers"])]
    grid: Option<u32>,
    /// Compare the renderers through the sensors of the device: force errors, creep and noise at rest; of --preset, or
    /// of table 5-3 and the materials
    #[arg(long, conflicts_with_all = ["mass", "friction", "stiffness", "damping", "dv", "device_mass", "device_damping", "map"])]
    renderers: bool,
    /// Draw the safe region over K and B
    #[arg(long, value_name = "FILE.svg")]
    pub(super) map: Option<PathBuf>,
    /// Write the numbers as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
}

fn grasp(text: &str) -> std::result::Result<Grasp, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| options::not_negative(part).ok()).collect();
    match numbers.as_deref() {
        Some(&[mass, damping, stiffness]) => Ok(Grasp { mass, damping, stiffness }),
        _ => Err("three numbers from 0 on are accepted: kg,N·s/m,N/m, e.g. 0.3,5,400".into()),
    }
}

/// A preset on the device, and the nearest one that is right.
struct Checked {
    name: String,
    changes: Option<Vec<Change>>,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    for path in [&args.map, &args.json].into_iter().flatten() {
        files::check_writable(path)?;
    }
    if let Some(points) = args.grid {
        return super::design_grid::grid(args, points as usize);
    }
    if args.renderers {
        return super::design_grid::compared(args);
    }
    let mut given = Given {
        period: args.period,
        mass: args.mass,
        friction: args.friction,
        stiffness: args.stiffness,
        damping: args.damping,
        device_mass: args.device_mass,
        device_damping: args.device_damping,
        delay: args.delay,
        dv: args.dv,
        encoder: args.encoder,
        frequency: args.frequency,
        grasp: args.hand.unwrap_or_default(),
    };
    if given.delay > given.period {
        return Err(Failure::new(format!(
            "--delay {} s is more than one period; accepted up to {} s",
            given.delay, given.period
        )));
    }
    let checked = args.preset.as_deref().map(|name| check(name, &mut given)).transpose()?;
    let design = given.design();
    if design.figures.is_empty() {
        return Err(Failure::new("nothing to design from").help(
            "give --mass, --stiffness and --damping of a block, --device-mass and --device-damping of a handle, or --preset NAME",
        ));
    }
    if let Some(path) = &args.map {
        files::write(path, design::draw(&given)?.as_bytes())?;
    }
    if let Some(path) = &args.json {
        files::write_json(path, &json_of(&design, checked.as_ref()))?;
    }
    if args.json.as_deref() != Some(Path::new("-")) {
        print!("{}", text(&design, checked.as_ref()));
        for (what, path) in [("map", &args.map), ("json", &args.json)] {
            if let Some(path) = path {
                println!("  {what}: {}", path.display());
            }
        }
    }
    Ok(Outcome::Done)
}

/// The built-in preset of this name.
pub(super) fn built_in(name: &str) -> Result<Settings> {
    Settings::preset(name).ok_or_else(|| {
        let known: Vec<&str> = Settings::PRESETS.iter().map(|(name, _)| *name).collect();
        Failure::new(format!("--preset {name}: no such preset; there are {}", known.join(", ")))
    })
}

/// Takes what the preset says into `given`, and finds the nearest one that is right.
fn check(name: &str, given: &mut Given) -> Result<Checked> {
    let preset = built_in(name)?;
    let own = Device::default();
    let device = Device {
        period: given.period as f32,
        delay: given.delay as f32,
        mass: given.device_mass.map_or(own.mass, |x| x as f32),
        damping: given.device_damping.map_or(own.damping, |x| x as f32),
        metre_per_count: given.encoder.map_or(own.metre_per_count, |x| x as f32),
        ..own
    };
    // to the digits that were written
    let wide = |x: f32| format!("{x}").parse::<f64>().unwrap_or(f64::from(x));
    given.device_mass = Some(wide(device.mass));
    given.device_damping = Some(wide(device.damping));
    given.encoder = Some(wide(device.metre_per_count));
    given.stiffness = Some(wide(preset.k_vc));
    given.damping = Some(wide(preset.b_vc));
    given.friction = Some(wide(preset.f_dynamic_p.max(preset.f_dynamic_n)));
    given.dv = Some(wide(preset.dv));
    given.mass = preset.renderer.has_block().then(|| wide(preset.mass));
    Ok(Checked {
        name: name.to_owned(),
        changes: design::nearest(&preset, &device).map(|(changes, _)| changes),
    })
}

fn text(design: &Design, checked: Option<&Checked>) -> String {
    let mut table = Table::new(&["", ">value", "unit", "from"]);
    for f in &design.figures {
        table.row([f.what.to_owned(), number(f.value, 6), f.unit.to_owned(), f.source.to_owned()]);
    }
    let mut out = table.render();
    match design.stable {
        Some(true) => out.push_str("  stable\n"),
        Some(false) => out.push_str("  NOT stable\n"),
        None => {}
    }
    match design.passive {
        Some(true) => out.push_str("  passive with any hand while the block is stuck\n"),
        Some(false) => out.push_str("  not passive while stuck: some hand could make it oscillate\n"),
        None => {}
    }
    for violation in &design.violations {
        out.push_str(&format!("  ! {violation}\n"));
    }
    let Some(Checked { name, changes }) = checked else { return out };
    match changes {
        None => out.push_str(&format!("  {name}: no preset near it is accepted\n")),
        Some(changes) if changes.is_empty() => {
            out.push_str(&format!("  {name}: taken by the device as it is\n"));
        }
        Some(changes) => {
            out.push_str(&format!("  nearest to {name} that is right:\n"));
            for c in changes {
                let verdict = if c.unsafe_before { "refused" } else { "unfaithful" };
                out.push_str(&format!(
                    "    set {} {}   ({} is {verdict}: {})\n",
                    c.parameter, c.to, c.from, c.why
                ));
            }
        }
    }
    out
}

fn json_of(design: &Design, checked: Option<&Checked>) -> Value {
    let mut out = design.json();
    if let Some(Checked { name, changes }) = checked {
        out.insert("preset".into(), json!(name));
        let changes = changes.as_ref().map(|changes| {
            let one = |c: &Change| {
                json!({ "parameter": c.parameter, "from": c.from, "to": c.to, "refused": c.unsafe_before, "why": c.why })
            };
            changes.iter().map(one).collect::<Vec<_>>()
        });
        out.insert("nearest".into(), json!(changes));
    }
    Value::Object(out)
}
