//! `tribos design`: stability bounds and limit cycles of chapter 4, before anything runs.

use super::design_args::{Args, built_in};
use crate::failure::{Failure, Outcome, Result};
use crate::files;
use design::{Change, Design, Given};
use haptics::Device;
use report::Table;
use report::number::number;
use serde_json::{Value, json};
use std::path::Path;

/// A preset on the device, and the nearest one that is right.
struct Checked {
    name: String,
    changes: Option<Vec<Change>>,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    for path in [&args.map, &args.json].into_iter().flatten() {
        files::check_writable(path)?;
    }
    if args.renderers {
        return super::design_grid::compared(args);
    }
    if let Some(points) = args.grid {
        return super::design_grid::grid(args, points as usize);
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
        files::write(path, design::map(&given)?.as_bytes())?;
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
                json!({ "parameter": c.parameter, "from": c.from, "to": c.to, "refused": c.unsafe_before, "why": c.why.to_string() })
            };
            changes.iter().map(one).collect::<Vec<_>>()
        });
        out.insert("nearest".into(), json!(changes));
    }
    Value::Object(out)
}
