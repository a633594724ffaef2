//! Tidy CSV: one row an observation, one column a variable, units in the header.

use super::{Analysis, POOLED};
use crate::{Record, Session, Threshold, Throughput, segments};
use std::fmt::Write;

/// A cell; quoted where it must be.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Columns of [`speed`].
const SPEED: &str =
    "movements,effective_width_mm,effective_distance_mm,effective_id_bits,movement_time_s,throughput_bits_s";

fn speed(t: &Throughput) -> String {
    format!(
        "{},{},{},{},{},{}",
        t.movements,
        t.effective_width_mm,
        t.effective_distance_mm,
        t.effective_bits,
        t.movement_s,
        t.bits_per_s
    )
}

/// File name and contents of every table.
#[must_use]
pub fn tables(sessions: &[Session], analysis: &Analysis) -> Vec<(&'static str, String)> {
    let simulated = analysis.simulated;
    let mut out = Vec::new();
    let scored = segments(sessions);
    if !scored.is_empty() {
        let mut t = String::from(
            "subject,simulated,trial,resistance,index,id_bits,distance_px,width_px,completion_s,errors,mean_error_mm\n",
        );
        let mut clicks = String::from("subject,simulated,trial,click,time_s,position_px,target_px,valid\n");
        for s in &scored {
            let (x, d) = (s.trial, &s.trial.difficulty);
            let _ = writeln!(
                t,
                "{},{simulated},{},{},{},{},{},{},{},{},{}",
                cell(s.subject),
                x.number,
                x.resistance.id(),
                d.index,
                x.id_bits,
                d.distance_px,
                d.width_px,
                x.completion_s,
                x.errors,
                x.mean_error_mm
            );
            for (k, c) in x.clicks.iter().enumerate() {
                let _ = writeln!(
                    clicks,
                    "{},{simulated},{},{},{},{},{},{}",
                    cell(s.subject),
                    x.number,
                    k + 1,
                    c.time_s,
                    c.position_px,
                    c.target_px,
                    c.valid
                );
            }
        }
        let mut d = String::from(
            "subject,simulated,resistance,index,time_difference_s,error_difference,error_magnitude_difference_mm\n",
        );
        for x in &analysis.differences {
            let (id, index) = (x.resistance.id(), x.index);
            let _ = writeln!(
                d,
                "{},{simulated},{id},{index},{},{},{}",
                cell(&x.subject),
                x.time_s,
                x.errors,
                x.error_mm
            );
        }
        let mut speeds = format!("subject,simulated,resistance,index,{SPEED}\n");
        for s in &analysis.throughput {
            let _ = writeln!(
                speeds,
                "{},{simulated},{},{},{}",
                cell(&s.subject),
                s.resistance.id(),
                s.index,
                speed(&s.throughput)
            );
        }
        out.extend([
            ("targeting.csv", t),
            ("clicks.csv", clicks),
            ("differences.csv", d),
            ("throughput.csv", speeds),
        ]);
    }
    let mut trials = String::from(
        "subject,simulated,trial,batch,level,f_static_n,f_dynamic_n,difference_n,different,answer,correct,seconds,visits_baseline,visits_a,visits_b\n",
    );
    let mut any = false;
    for session in sessions {
        for record in &session.records {
            let Record::ForcedChoice(x) = record else { continue };
            any = true;
            let _ = writeln!(
                trials,
                "{},{simulated},{},{},{},{},{},{},{:?},{:?},{},{},{},{},{}",
                cell(&session.header.subject.id),
                x.number,
                cell(&x.batch),
                x.level,
                x.comparison.f_static,
                x.comparison.f_dynamic,
                x.difference_n,
                x.different,
                x.answer,
                x.correct,
                x.seconds,
                x.visits[0],
                x.visits[1],
                x.visits[2]
            );
        }
    }
    if !analysis.rings.is_empty() {
        let mut speeds =
            format!("subject,simulated,trial,surface,diameter_mm,width_mm,id_bits,errors,{SPEED}\n");
        for r in &analysis.rings {
            let _ = writeln!(
                speeds,
                "{},{simulated},{},{},{},{},{},{},{}",
                cell(&r.subject),
                r.trial,
                cell(&r.case.surface),
                1e3 * r.case.diameter_m,
                1e3 * r.case.width_m,
                r.id_bits,
                r.errors,
                speed(&r.throughput)
            );
        }
        out.push(("plane.csv", speeds));
    }
    if any {
        // x, right, answers: what psignifit takes, after a filter by subject and batch
        let mut psignifit = String::from("subject,simulated,batch,difference_n,n_correct,n_total\n");
        let mut fits = String::from(
            "subject,simulated,batch,outcome,jnd_n,ci95_low_n,ci95_high_n,bound_n,slope,lapse,deviance\n",
        );
        for f in &analysis.psychometric {
            let (subject, batch) = (cell(&f.subject), cell(&f.batch));
            if f.subject != POOLED {
                for l in &f.fit.levels {
                    let _ = writeln!(
                        psignifit,
                        "{subject},{simulated},{batch},{},{},{}",
                        l.difference_n, l.correct, l.answers
                    );
                }
            }
            let outcome = match f.fit.threshold {
                Threshold::Estimated { jnd, ci95 } => format!("estimated,{jnd},{},{},", ci95.0, ci95.1),
                Threshold::AboveLevels { at_least, .. } => format!("above_levels,,,,{at_least}"),
                Threshold::BelowLevels { at_most, .. } => format!("below_levels,,,,{at_most}"),
                Threshold::TooFew => "too_few,,,,".into(),
            };
            let c = &f.fit.curve;
            let _ = writeln!(
                fits,
                "{subject},{simulated},{batch},{outcome},{},{},{}",
                c.slope, c.lapse, f.fit.deviance
            );
        }
        out.extend([("forced_choice.csv", trials), ("psignifit.csv", psignifit), ("fits.csv", fits)]);
    }
    out
}
