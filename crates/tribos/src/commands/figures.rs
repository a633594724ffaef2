//! `tribos figures`: the figures of [thesis, ch. 3 and 4], recomputed.

use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::progress::Progress;
use ::figures::{FIGURES, page};
use report::Table;
use std::path::PathBuf;

/// Options of `figures`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the figures and their page
    #[arg(long, value_name = "DIR", default_value = "figures")]
    out: PathBuf,
    /// Only these, e.g. 4-3,4-10
    #[arg(long, value_name = "ID,…", value_delimiter = ',')]
    only: Vec<String>,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let known = || FIGURES.iter().map(|(id, _)| *id).collect::<Vec<_>>().join(", ");
    if let Some(wrong) = args.only.iter().find(|id| !FIGURES.iter().any(|(known, _)| known == id)) {
        return Err(Failure::new(format!("--only {wrong}: no such figure; there are {}", known())));
    }
    std::fs::create_dir_all(&args.out).map_err(|e| {
        Failure::in_file(&args.out, format!("cannot be made a folder: {}", files::reason(&e)))
    })?;
    let chosen: Vec<_> =
        FIGURES.iter().filter(|(id, _)| args.only.is_empty() || args.only.iter().any(|o| o == id)).collect();
    let progress = Progress::new("figures");
    let mut figures = Vec::new();
    for (id, make) in &chosen {
        progress.set(figures.len() as f32 / chosen.len() as f32, &format!("figure {id}"));
        let figure = make()?;
        files::write(&args.out.join(figure.file()), figure.svg()?.as_bytes())?;
        figures.push(figure);
    }
    drop(progress);
    files::write(&args.out.join("index.html"), page(&figures).as_bytes())?;
    let mut table = Table::new(&["figure", "", ">thesis", ">here"]);
    for f in &figures {
        for n in &f.numbers {
            table.row([f.id, &n.what, &n.thesis, &n.ours]);
        }
    }
    print!("{}", table.render());
    println!("  {} figures: {}", figures.len(), args.out.join("index.html").display());
    Ok(Outcome::Done)
}
