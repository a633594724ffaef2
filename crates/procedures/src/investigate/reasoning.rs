//! What is believed, what changed and why the next move, in sentences.

use diagnose::{Diagnosis, ENOUGH, Experiment, NextExperiment, Verdict, WORTHWHILE};
use report::number::{number, with_std};
use std::collections::BTreeMap;

/// Effects named, each with what explains the recordings as well.
pub(super) fn named(found: &Diagnosis) -> BTreeMap<String, Vec<String>> {
    found.missing.iter().map(|m| (m.effect.clone(), m.indistinguishable_from.clone())).collect()
}

/// What is believed, one line each: what was named with its numbers, or that nothing was.
#[must_use]
pub fn beliefs(found: &Diagnosis) -> Vec<String> {
    let unit = &found.noise_floor.unit;
    match found.verdict {
        Verdict::NotTestable => vec![found.summary.clone()],
        Verdict::NoMismatch => vec![format!(
            "nothing is seen to be missing; most effects above {} {unit} would have been",
            number(found.detectable, 2)
        )],
        Verdict::Mismatch => found
            .missing
            .iter()
            .map(|m| {
                let numbers: Vec<String> = m
                    .parameters
                    .iter()
                    .map(|(name, q)| {
                        let (value, std) = with_std(q.value, q.std);
                        format!("{name} {value} ± {std} {}", q.unit)
                    })
                    .collect();
                let or = if m.indistinguishable_from.is_empty() {
                    String::new()
                } else {
                    format!(" or {}", m.indistinguishable_from.join(" or "))
                };
                format!(
                    "{}{or}: {}; error {} → {} {unit}",
                    m.effect,
                    numbers.join(", "),
                    number(m.rms_heldout_before, 3),
                    number(m.rms_heldout_after, 3)
                )
            })
            .collect(),
    }
}

/// The lines of a round after its recording.
pub(super) fn told(found: &Diagnosis, changed: &[String]) -> Vec<String> {
    let mut out: Vec<String> = beliefs(found).iter().map(|b| format!("  believed: {b}")).collect();
    out.extend(found.recording_faults.iter().map(|f| format!("  fault of the recording: {}", f.why)));
    out.extend(changed.iter().map(|c| format!("  changed: {c}")));
    for b in &found.blind_to {
        out.push(format!("  blind to {}: {}", b.effect, b.because));
    }
    out
}

/// Whether a move is made for this answer: it is worth it, and better than what is known.
pub(super) fn is_a_reason(a: &Experiment) -> bool {
    a.discrimination >= WORTHWHILE && a.discrimination >= 1.2 * a.discrimination_now
}

/// Why this move.
pub(super) fn reasons(next: &NextExperiment) -> Vec<String> {
    let mut answers: Vec<_> = next.answers.iter().filter(|a| is_a_reason(a)).collect();
    answers.sort_by(|a, b| {
        b.rival.is_some().cmp(&a.rival.is_some()).then(b.discrimination.total_cmp(&a.discrimination))
    });
    let mut out = vec![format!("  next: {}", next.command)];
    for a in answers {
        let what = match &a.rival {
            Some(rival) => format!("tells {} from {rival}", a.effect),
            None => format!("shows {}", a.effect),
        };
        let enough = if a.discrimination >= ENOUGH { "" } else { ", hardly" };
        out.push(format!(
            "    {what}{enough}: {} noise floors apart instead of {}, cosine {} → {}",
            number(a.discrimination, 2),
            number(a.discrimination_now, 2),
            number(a.cosine_now, 4),
            number(a.cosine, 4)
        ));
    }
    out
}

/// What another recording changed.
pub(super) fn changes(before: &Diagnosis, now: &Diagnosis) -> Vec<String> {
    let (old, new) = (named(before), named(now));
    let mut out = Vec::new();
    let was_blind = |effect: &str| before.blind_to.iter().any(|b| b.effect == effect);
    for (effect, rivals) in &new {
        match old.get(effect) {
            None => {
                let was = old
                    .iter()
                    .find(|(_, rivals)| rivals.contains(effect))
                    .map(|(other, _)| format!("was a rival of {other}"))
                    .unwrap_or_else(|| {
                        if was_blind(effect) { "could not be seen before".into() } else { "is new".into() }
                    });
                out.push(format!("{effect} is named: it {was}"));
            }
            Some(had) => {
                for rival in had.iter().filter(|r| !rivals.contains(r)) {
                    out.push(format!("{effect} is told from {rival}"));
                }
                for rival in rivals.iter().filter(|r| !had.contains(r)) {
                    out.push(format!("{rival} explains the recordings as well as {effect}"));
                }
            }
        }
    }
    for effect in old.keys().filter(|e| !new.contains_key(*e)) {
        let still = new.values().any(|rivals| rivals.contains(effect));
        let how = if still { "is a rival now" } else { "is no longer needed" };
        out.push(format!("{effect} {how}"));
    }
    let unit = &now.noise_floor.unit;
    for r in now.rejected.iter().filter(|r| was_blind(&r.effect)) {
        out.push(format!("{} is ruled out above {} {unit}", r.effect, number(r.upper_bound, 2)));
    }
    out
}
