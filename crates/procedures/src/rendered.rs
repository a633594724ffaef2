//! A real block, the same rendered from its identification, and the same again with a tenth too much and too little.

use crate::error::{Error, Result};
use crate::library;
use crate::watch::{Watch, record};
use client::{Move, Plan, Session, Virtual};
use compare::{Comparison, MARGIN, Measured, compare};
use friction::Law;
use haptics::Wave;
use identify::{KarnoppOptions, Model, Preprocess, identify_karnopp, prepare};
use plant::materials::{BRASS, Material, RUBBER, TEFLON};
use report::overlay;
use signals::{ReadOptions, Recording, files};
use std::path::Path;
use tribos_firmware::board::simulated::Holder;

/// How the device drives the real block to identify it: five harmonics, so that velocity and acceleration come apart.
const IDENTIFIED: Move = Move { wave: Wave::Multisine, amplitude: 0.01, frequency: 0.8, seconds: Some(20.0) };
/// How it drives the block to be compared with, slowly, so that there is time to slide: not seen by the identification.
const DRIVEN: Move = Move { wave: Wave::Sine, amplitude: 0.012, frequency: 0.7, seconds: Some(20.0) };
/// How the hand moves the handle: m, Hz.
const BY_HAND: (f64, f64) = (0.012, 0.6);
/// Length of a recording by hand, s.
const HELD: f64 = 20.0;
/// What is rendered: times the friction that was identified.
const TIMES: [f64; 3] = [1.0, 1.1, 0.9];

/// One rendering against its real block.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// Brass, Teflon or rubber.
    pub material: &'static str,
    /// Times the friction that was identified.
    pub times: f64,
    /// What came out.
    pub comparison: Comparison,
}

/// All of them; recordings, models and overlays go to `out`.
///
/// # Errors
/// A file that cannot be written, or a device that refuses what was identified.
pub fn demo(out: &Path, seed: u64, watch: &dyn Watch) -> Result<Vec<Rendered>> {
    std::fs::create_dir_all(out)
        .map_err(|e| Error::Folder { path: out.to_owned(), reason: files::reason(&e) })?;
    let progress = watch.begin("rendering");
    let mut all = Vec::new();
    for (k, material) in [BRASS, TEFLON, RUBBER].iter().enumerate() {
        let name = ["brass", "teflon", "rubber"][k];
        progress.set(k as f32 / 3.0, name);
        let driven =
            slide(material, IDENTIFIED, &out.join(format!("{name}-identified.csv")), seed + k as u64, watch)?;
        let model = identified(&driven, name)?;
        let real =
            slide(material, DRIVEN, &out.join(format!("{name}-real.csv")), seed + 50 + k as u64, watch)?;
        files::write(&out.join(format!("{name}.toml")), model.to_toml().as_bytes())?;
        let bare = library::read(Path::new("baseline"))?;
        // another seed each time: no two recordings share their noise
        let bare = feel(&bare, &out.join(format!("{name}-bare.csv")), seed + 100 + k as u64, watch)?;
        let (real, bare) = (Measured::new(&real)?, Measured::new(&bare)?);
        for (j, times) in TIMES.into_iter().enumerate() {
            let what = format!("{name}-x{times}");
            let felt = feel(
                &scaled(&model, times),
                &out.join(format!("{what}.csv")),
                seed + 200 + (10 * k + j) as u64,
                watch,
            )?;
            let felt = Measured::new(&felt)?;
            let comparison = compare(&real, &felt, Some(&bare), MARGIN)?;
            files::write(&out.join(format!("{what}.svg")), overlay(&comparison, &real, &felt)?.as_bytes())?;
            all.push(Rendered { material: name, times, comparison });
        }
    }
    Ok(all)
}

/// A real block on the rig, driven by the device and recorded over its line.
fn slide(material: &Material, motion: Move, path: &Path, seed: u64, watch: &dyn Watch) -> Result<Recording> {
    let mut device = Virtual::new(seed)?;
    device.device().set_block(material.mass, material.law, &[]).map_err(|e| Error::Block(e.to_string()))?;
    let mut session = Session::over("sim", Box::new(device));
    let plan = Plan { motion: Some(motion), seconds: motion.seconds.unwrap_or(20.0), notes: Vec::new() };
    record(&mut session, &plan, path, watch)?;
    Ok(Recording::read(path, &ReadOptions::default())?)
}

fn identified(recording: &Recording, name: &str) -> Result<Model> {
    let signals = prepare(recording, &Preprocess::default())?;
    let found = identify_karnopp(&signals, &KarnoppOptions::default())?;
    Ok(Model { name: name.into(), ..Model::from(&found) })
}

/// The same block with its friction multiplied by `times`.
fn scaled(model: &Model, times: f64) -> Model {
    let mut model = model.clone();
    if let Law::Karnopp(law) = &mut model.law {
        for level in [&mut law.c_p, &mut law.c_n, &mut law.b_p, &mut law.b_n, &mut law.d_p, &mut law.d_n] {
            *level *= times;
        }
    }
    model
}

fn feel(model: &Model, path: &Path, seed: u64, watch: &dyn Watch) -> Result<Recording> {
    feel_with(BY_HAND, model, path, seed, watch)
}

/// A hand moves the handle to and fro, with an amplitude, m, and a frequency, Hz, while the device renders the model;
/// recorded over its line.
pub(crate) fn feel_with(
    hand: (f64, f64),
    model: &Model,
    path: &Path,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Recording> {
    let mut device = Virtual::new(seed)?;
    device.device().hold(Holder::to_and_fro(hand.0, hand.1));
    let mut session = Session::over("sim", Box::new(device));
    let settled = session.set_all(&model.preset_lines())?;
    if let Some(first) = settled.refused.first() {
        return Err(Error::Identified(first.clone()));
    }
    session.command("render on")?;
    let plan = Plan { motion: None, seconds: HELD, notes: vec![("rendered".into(), model.name.clone())] };
    record(&mut session, &plan, path, watch)?;
    Ok(Recording::read(path, &ReadOptions::default())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use compare::Verdict;

    #[test]
    fn a_break_away_that_the_filter_blurred_below_the_sliding_level_was_refused_by_the_device() {
        let dir = tempfile::tempdir().expect("a folder");
        // the excitation of [thesis, ch. 3.5.2]
        let motion = Move { wave: Wave::Sine, amplitude: 0.01, frequency: 2.0, seconds: Some(20.0) };
        let recording = slide(&BRASS, motion, &dir.path().join("sine.csv"), 11, &crate::Unwatched)
            .unwrap_or_else(|e| panic!("{e}"));
        let signals = prepare(&recording, &Preprocess::default()).expect("signals");
        let found = identify_karnopp(&signals, &KarnoppOptions::default()).expect("a fit");
        let of = |name: &str| found.value(name).unwrap_or(f64::NAN);
        println!("static {:.3} N, sliding {:.3} N", of("static_p"), of("coulomb_p"));
        // the break-away comes from unfiltered samples since, and is not below the sliding level
        assert!(of("static_p") >= of("coulomb_p"));
        let mut session = Session::open("sim", 1).expect("a virtual device");
        let settled = session.set_all(&Model::from(&found).preset_lines()).expect("a line");
        assert_eq!(settled.refused, Vec::<String>::new());
    }

    #[test]
    fn rendered_from_its_identification_a_block_feels_like_the_real_one_and_a_tenth_is_told() {
        let dir = tempfile::tempdir().expect("a folder");
        let all = demo(dir.path(), 11, &crate::Unwatched).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(all.len(), 9);
        for r in &all {
            let c = &r.comparison;
            println!(
                "{} × {}: {:.3} JND ({:.3} to {:.3}), {:.4} times the real ({:.4} to {:.4}), {:?}",
                r.material,
                r.times,
                c.distance.value,
                c.distance.ci95[0],
                c.distance.ci95[1],
                c.ratio.value,
                c.ratio.ci95[0],
                c.ratio.ci95[1],
                c.verdict
            );
            assert!(c.texture.is_none(), "{}: {:?}", r.material, c.texture);
            if r.times == 1.0 {
                assert!(c.distance.ci95[1] < 0.5, "{}: {:?}", r.material, c.distance);
                assert_eq!(c.verdict, Verdict::Same, "{}: {:?}", r.material, c.ratio);
            } else {
                assert_eq!(c.verdict, Verdict::Different, "{} × {}: {:?}", r.material, r.times, c.ratio);
                let [low, high] = c.ratio.ci95;
                assert!(low < r.times + 0.03 && high > r.times - 0.03, "{:?}", c.ratio);
            }
        }
    }
}
