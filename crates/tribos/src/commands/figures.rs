//! `tribos figures`: the figures of the thesis, computed anew.

use crate::failure::{Failure, Outcome, Result};
use crate::figures::{FIGURES, Figure, svg};
use crate::files;
use crate::progress::Progress;
use crate::table::Table;
use std::fmt::Write;
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
        files::write(&args.out.join(name(&figure)), svg(&figure)?.as_bytes())?;
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

fn name(figure: &Figure) -> String {
    format!("figure_{}.svg", figure.id)
}

/// All of them with their captions and numbers.
fn page(figures: &[Figure]) -> String {
    let mut out = String::from(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">
<title>Figures of the thesis, computed anew</title>
<style>body{font:16px/1.5 system-ui,sans-serif;max-width:84rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
img{max-width:100%;height:auto}table{border-collapse:collapse;font-size:.9rem}td,th{padding:.15rem .8rem .15rem 0;text-align:left}
figure{margin:0 0 3rem}figcaption{margin:.3rem 0 .6rem}</style>
<h1>Figures of the thesis, computed anew</h1>
<p>Chapter 3: simulated recordings with the parameters of table 3-3 and the errors of table 3-2. Chapter 4: the device's own renderer around the device of section 4.4.</p>\n",
    );
    for f in figures {
        let _ = writeln!(
            out,
            "<figure id=\"{0}\"><img src=\"{1}\" alt=\"Figure {0}\"><figcaption><b>Figure {0}.</b> {2}</figcaption>",
            f.id,
            name(f),
            f.caption.replace('<', "&lt;").replace('>', "&gt;")
        );
        if !f.numbers.is_empty() {
            out.push_str("<table><tr><th></th><th>thesis</th><th>here</th></tr>");
            for n in &f.numbers {
                let _ = write!(out, "<tr><td>{}</td><td>{}</td><td>{}</td></tr>", n.what, n.thesis, n.ours);
            }
            out.push_str("</table>");
        }
        out.push_str("</figure>\n");
    }
    out
}
