//! `tribos design --grid` and `--renderers`: the renderers against each other, in simulation.

use super::design_args::{Args, built_in};
use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::progress::Progress;
use design::grid::{self, Outcome as Cell, Tally};
use design::{grid_map, renderers};
use haptics::{Accepted, RendererKind, Settings};
use report::Table;
use report::number::number;
use serde_json::{Value, json};
use std::path::Path;

/// DV of the final experiment [thesis, table 5-3], m/s.
const DV: f64 = 1e-3;
/// Couplings of the grid that `--renderers` runs without `--grid`.
const POINTS: usize = 500;

/// The grid.
pub(super) fn grid(args: &Args, points: usize) -> Result<Outcome> {
    let dv = args.dv.unwrap_or(DV);
    let (low, high) = (1e-6, f64::from(haptics::Device::default().overspeed));
    if !(low..=high).contains(&dv) {
        let accepted = Accepted::Between(low as f32, high as f32);
        return Err(Failure::new(format!("--dv {dv} m/s: {accepted}")));
    }
    let bar = Progress::new("grid");
    let cells = grid::run(points, false, dv, &|share| bar.set(share, ""));
    drop(bar);
    if let Some(path) = &args.map {
        files::write(path, grid_map(&cells)?.as_bytes())?;
    }
    if let Some(path) = &args.json {
        files::write_json(path, &grid_json(&cells, dv))?;
    }
    if args.json.as_deref() == Some(Path::new("-")) {
        return Ok(Outcome::Done);
    }
    let mut table = Table::new(&[
        "renderer",
        ">accepted, stable",
        ">come to rest",
        ">limit cycle",
        ">let go",
        ">share, %",
    ]);
    for (at, renderer) in RendererKind::ALL.iter().enumerate() {
        let t = grid::tally(&cells, at);
        table.row([
            renderer.id().to_owned(),
            t.accepted.to_string(),
            t.rests.to_string(),
            t.cycles.to_string(),
            t.let_go.to_string(),
            format!("{:.2}", share(&t)),
        ]);
    }
    print!("{}", table.render());
    println!(
        "  {points} couplings, DV {dv} m/s (stopping_force has none), pushed and left alone in a hand from released to held"
    );
    let beyond: usize = (0..RendererKind::ALL.len()).map(|at| grid::tally(&cells, at).beyond).sum();
    println!("  accepted by the device although the linear loop is unstable: {beyond}");
    if let Some(path) = &args.map {
        println!("  map: {}", path.display());
    }
    Ok(Outcome::Done)
}

/// Percent that do not come to rest.
fn share(t: &Tally) -> f64 {
    100.0 * (t.cycles + t.let_go) as f64 / t.accepted.max(1) as f64
}

fn grid_json(cells: &[Cell], dv: f64) -> Value {
    let renderers: serde_json::Map<String, Value> = RendererKind::ALL
        .iter()
        .enumerate()
        .map(|(at, renderer)| {
            let t = grid::tally(cells, at);
            let value = json!({
                "accepted_stable": t.accepted, "rests": t.rests, "limit_cycle": t.cycles, "let_go": t.let_go,
                "accepted_unstable": t.beyond, "passive": t.passive, "share_percent": share(&t),
            });
            (renderer.id().to_owned(), value)
        })
        .collect();
    json!({ "schema": "tribos.design.grid/1", "points": cells.len(), "dv": dv, "renderers": renderers })
}

/// A name, mass kg, and friction N of a block that shows what each renderer is good for.
const BLOCKS: [(&str, f32, f32); 2] = [("heavy and sticky", 2.0, 4.0), ("light and free", 0.1, 0.1)];

/// What was felt of a block by one renderer.
type FeltBy = (RendererKind, std::result::Result<renderers::Felt, design::Error>);

/// Such a block, and what was felt of it.
type Led = (&'static str, f32, f32, Vec<FeltBy>);

/// A block with a static friction 1.2 times its dynamic one, on the coupling of brass.
fn block(mass: f32, friction: f32) -> Settings {
    let hold = 1.2 * friction;
    Settings {
        mass,
        f_static_p: hold,
        f_static_n: hold,
        f_dynamic_p: friction,
        f_dynamic_n: friction,
        damping_p: 0.0,
        damping_n: 0.0,
        ..Settings::brass()
    }
}

fn felt_table(felt: &[Led]) -> String {
    let mut table = Table::new(&[
        "block",
        "renderer",
        ">felt mass, kg",
        ">felt damping, N·s/m",
        ">felt friction, N",
        ">rest, mN",
    ]);
    for (name, mass, friction, all) in felt {
        let block = format!("{name}: {mass} kg, {friction} N");
        for (renderer, felt) in all {
            let [mass, damping, friction, rest] = match felt {
                Ok(felt) => [felt.mass, felt.damping, felt.friction, 1e3 * felt.rest].map(|x| number(x, 3)),
                Err(why) => [why.to_string(), String::new(), String::new(), String::new()],
            };
            table.row([block.clone(), renderer.id().to_owned(), mass, damping, friction, rest]);
        }
    }
    table.render()
}

fn felt_json(felt: &[Led]) -> Value {
    let row = |(name, mass, friction, all): &Led| -> Vec<Value> {
        let one = |(renderer, felt): &FeltBy| {
            let felt = match felt {
                Ok(f) => {
                    json!({ "mass_kg": f.mass, "damping_n_s_per_m": f.damping, "friction_n": f.friction, "rest_n": f.rest })
                }
                Err(why) => json!({ "failed": why.to_string() }),
            };
            json!({ "block": name, "mass_kg": mass, "friction_n": friction, "renderer": renderer.id(), "felt": felt })
        };
        all.iter().map(one).collect()
    };
    felt.iter().flat_map(row).collect()
}

/// The table of renderers.
pub(super) fn compared(args: &Args) -> Result<Outcome> {
    let presets: Vec<(String, Settings)> = match &args.preset {
        Some(name) => vec![(name.clone(), built_in(name)?)],
        None => vec![
            ("table 5-3".to_owned(), Settings::forced_choice()),
            ("rubber".to_owned(), Settings::rubber()),
            ("brass".to_owned(), Settings::brass()),
            ("teflon".to_owned(), Settings::teflon()),
        ],
    };
    let points = args.grid.map_or(POINTS, |points| points as usize);
    let mut rows = Vec::new();
    for (name, preset) in &presets {
        rows.extend(renderers::measure(preset)?.into_iter().map(|m| (name, m)));
    }
    let bar = Progress::new("grid");
    let without = grid::run(points, false, DV, &|share| bar.set(0.5 * share, ""));
    let with = grid::run(points, true, DV, &|share| bar.set(0.5 + 0.5 * share, ""));
    drop(bar);
    let felt =
        BLOCKS.map(|(name, mass, friction)| (name, mass, friction, renderers::felt(&block(mass, friction))));
    if let Some(path) = &args.json {
        let one = |(name, m): &(&String, renderers::Measured)| {
            json!({
                "preset": name, "renderer": m.renderer.id(), "passivity": m.passivity, "sliding_error_n": m.sliding_error, "felt_error_n": m.felt_error,
                "break_away_error_n": m.break_away_error, "creep_m_per_s": m.creep, "noise_n": m.noise,
                "energy_per_cycle_j": m.energy,
            })
        };
        let value = json!({
            "schema": "tribos.design.renderers/1",
            "felt": felt_json(&felt),
            "measured": rows.iter().map(one).collect::<Vec<_>>(),
            "grid": { "points": points, "without": grid_json(&without, DV)["renderers"], "with": grid_json(&with, DV)["renderers"] },
        });
        files::write_json(path, &value)?;
    }
    if args.json.as_deref() == Some(Path::new("-")) {
        return Ok(Outcome::Done);
    }
    let mut table = Table::new(&[
        "preset",
        "renderer",
        "passivity",
        ">sliding error, mN",
        ">device felt, mN",
        ">break-away error, mN",
        ">creep, µm/s",
        ">noise at rest, mN",
        ">energy given, µJ a cycle",
    ]);
    for (name, m) in &rows {
        table.row([
            (*name).clone(),
            m.renderer.id().to_owned(),
            if m.passivity { "on" } else { "off" }.to_owned(),
            number(1e3 * m.sliding_error, 3),
            number(1e3 * m.felt_error, 3),
            number(1e3 * m.break_away_error, 3),
            format!("{:.3}", 1e6 * m.creep),
            format!("{:.3}", 1e3 * m.noise),
            number(1e6 * m.energy, 3),
        ]);
    }
    print!("{}", table.render());
    println!(
        "  encoder of 2.57 µm, edge times, 0.1 µs of jitter, force 20 µs after the sample; a relaxed hand"
    );
    println!();
    print!("{}", felt_table(&felt));
    println!("  fitted to the force of a hand that leads the handle by 8 mm at 1.2 Hz and 1 mm at 4 Hz");
    println!();
    let mut table =
        Table::new(&["renderer", "passivity", ">accepted, stable", ">come to rest, %", ">give no energy, %"]);
    for (at, renderer) in RendererKind::ALL.iter().enumerate() {
        for (passivity, cells) in [("off", &without), ("on", &with)] {
            let t = grid::tally(cells, at);
            let percent = |n: usize| format!("{:.2}", 100.0 * n as f64 / t.accepted.max(1) as f64);
            table.row([
                renderer.id().to_owned(),
                passivity.to_owned(),
                t.accepted.to_string(),
                percent(t.rests),
                percent(t.passive),
            ]);
        }
    }
    print!("{}", table.render());
    println!(
        "  the first {points} couplings of --grid; energy to the hand in 0.8 s after the handle was left alone, above 1 µJ"
    );
    Ok(Outcome::Done)
}
