//! What a simulation leaves out of a recording, in ten lines:
//! `cargo run --release -p diagnose --example find -- rec.csv`

use diagnose::{Options, diagnose};
use signals::{ReadOptions, Recording};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a recording: time_s,position_m,force_n")?;
    let recording = Recording::read(path, &ReadOptions::default())?;
    let found = diagnose(&[recording], &[], &Options::default(), &|_, _| ())?;
    println!("{}", found.summary);
    for m in &found.missing {
        println!("{}: {:.3} -> {:.3} N held out", m.effect, m.rms_heldout_before, m.rms_heldout_after);
    }
    std::fs::write("found.json", serde_json::to_string_pretty(&found)?)?;
    Ok(())
}
