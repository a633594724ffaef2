//! The tables of a proof, for people and for machines.

use crate::score::{Outcome, wilson};
use report::Table;
use report::number::number;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Hits and trials, with Wilson's 95 % interval [wilson-1927].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Rate {
    /// Hits.
    pub hits: usize,
    /// Trials.
    pub of: usize,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Rate {
    fn new(hits: usize, of: usize) -> Self {
        let (low, high) = wilson(hits, of);
        Self { hits, of, low, high }
    }

    fn over<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>, hit: impl Fn(&Outcome) -> bool) -> Self {
        let (mut hits, mut of) = (0, 0);
        for o in outcomes {
            of += 1;
            hits += usize::from(hit(o));
        }
        Self::new(hits, of)
    }

    fn said(&self) -> String {
        if self.of == 0 {
            return "not asked".into();
        }
        let percent = |x: f64| format!("{:.0}", 100.0 * x);
        format!(
            "{} % ({} of {}; 95 %: {}–{})",
            percent(self.hits as f64 / self.of as f64),
            self.hits,
            self.of,
            percent(self.low),
            percent(self.high)
        )
    }
}

/// Everything a proof shows.
#[derive(Debug, Clone, Serialize)]
pub struct Proof {
    /// Version of the layout.
    pub(crate) schema: &'static str,
    /// Hidden alone, at the noise or above: first.
    pub(crate) single_first: Rate,
    /// The same, or said to be indistinguishable from what is first, or said to be what the recording is blind to.
    pub(crate) single_told: Rate,
    /// Hidden alone, below the noise: first.
    pub(crate) below_noise_first: Rate,
    /// Pairs at the noise or above: both named.
    pub(crate) pair_both: Rate,
    /// Something named where nothing is hidden.
    pub(crate) null_false_alarms: Rate,
    /// Physics named in a recording that only has a fault.
    pub(crate) decoy_false_alarms: Rate,
    /// Something named beside a single effect that is there.
    pub(crate) extra_named: Rate,
    /// Effects no motion shows: said to be so, and not named as something else.
    pub(crate) never_told: Rate,
    /// The first located coordinates are among those over which the effect shows.
    pub(crate) located: Rate,
    /// Of the recordings in which something was located, those in which it was hidden there; hidden alone at the noise or above, or
    /// not at all. What is missing to one is the false discovery rate.
    pub(crate) location_precision: Rate,
    /// Of what is hidden alone at the noise or above and shows over a coordinate, what was located there.
    pub(crate) location_recall: Rate,
    /// Harmonic mean of the two.
    pub(crate) location_f1: Option<f64>,
    /// 95 % intervals of an effect's parameters that hold the truth.
    pub(crate) parameter_coverage: Rate,
    /// The same for the baseline's.
    pub(crate) baseline_coverage: Rate,
    /// 95 % intervals of the gain that hold it.
    pub(crate) gain_coverage: Rate,
    /// Median over cases of the mean relative parameter error.
    pub(crate) parameter_error_median: Option<f64>,
    /// Median explained share on noise-free truth of a new motion, single effects at the noise or above.
    pub(crate) explained_median: Option<f64>,
    /// The same of the case where it is least, and that case.
    pub(crate) explained_worst: Option<(f64, usize)>,
    /// By effect and strength.
    pub(crate) effects: Vec<Row>,
    /// Hidden against named first, counts; hidden alone, at the noise or above.
    pub(crate) confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Every case.
    pub(crate) cases: Vec<Outcome>,
}

/// One effect at one strength.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    /// Kind of case.
    pub kind: String,
    /// What was hidden.
    pub hidden: String,
    /// Times the noise.
    pub strength: f64,
    /// First; for pairs, both named; for nulls and decoys, nothing named that is not there.
    pub right: Rate,
    /// First or said to be indistinguishable from what is.
    pub told: Rate,
    /// Median parameter error.
    pub parameter_error: Option<f64>,
    /// Median explained share.
    pub explained: Option<f64>,
    /// The most frequent wrong answer.
    pub mistaken_for: String,
}

fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

fn right(o: &Outcome) -> bool {
    match o.kind.as_str() {
        "pair" => o.all,
        "single" => o.first,
        "never" => never_told(o),
        _ => !o.false_alarm,
    }
}

fn never_told(o: &Outcome) -> bool {
    o.first || !o.false_alarm && o.blind
}

impl Proof {
    /// Sums up the outcomes.
    pub(crate) fn new(cases: Vec<Outcome>) -> Self {
        let of = |kind: &'static str| cases.iter().filter(move |o| o.kind == kind);
        let loud = || of("single").filter(|o| o.strength >= 1.0);
        let sum = |pick: fn(&Outcome) -> (usize, usize)| {
            let (of, hits) = cases.iter().map(pick).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            Rate::new(hits, of)
        };
        let known = |pick: fn(&Outcome) -> Option<bool>| {
            let known: Vec<bool> = cases.iter().filter_map(pick).collect();
            Rate::new(known.iter().filter(|k| **k).count(), known.len())
        };
        let mut groups: BTreeMap<(String, String, u64), Vec<&Outcome>> = BTreeMap::new();
        for o in &cases {
            groups.entry((o.kind.clone(), o.hidden.clone(), o.strength.to_bits())).or_default().push(o);
        }
        let effects = groups
            .into_iter()
            .map(|((kind, hidden, strength), group)| Row {
                right: Rate::over(group.iter().copied(), right),
                told: Rate::over(group.iter().copied(), |o| o.told),
                parameter_error: median(group.iter().filter_map(|o| o.parameter_error)),
                explained: median(group.iter().filter_map(|o| o.explained)),
                mistaken_for: mistaken(&group),
                strength: f64::from_bits(strength),
                kind,
                hidden,
            })
            .collect();
        let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for o in loud() {
            *confusion.entry(o.hidden.clone()).or_default().entry(answer(o)).or_default() += 1;
        }
        let placed = loud().filter(|o| o.has_a_place);
        let empty = cases.iter().filter(|o| matches!(o.kind.as_str(), "null" | "decoy"));
        let location_recall = Rate::over(placed.clone(), |o| o.placed == Some(true));
        let location_precision =
            Rate::over(placed.chain(empty).filter(|o| o.placed.is_some()), |o| o.placed == Some(true));
        let (found, missed) = (location_precision, location_recall);
        let of_both = found.of + missed.of;
        Self {
            schema: "tribos.proof/1",
            location_precision,
            location_recall,
            location_f1: (of_both > 0).then(|| (found.hits + missed.hits) as f64 / of_both as f64),
            single_first: Rate::over(loud(), |o| o.first),
            single_told: Rate::over(loud(), |o| o.told),
            below_noise_first: Rate::over(of("single").filter(|o| o.strength < 1.0), |o| o.first),
            pair_both: Rate::over(of("pair"), |o| o.all),
            null_false_alarms: Rate::over(of("null"), |o| o.false_alarm),
            decoy_false_alarms: Rate::over(of("decoy"), |o| o.false_alarm),
            extra_named: Rate::over(loud(), |o| o.first && o.false_alarm),
            never_told: Rate::over(of("never"), never_told),
            located: known(|o| o.located),
            parameter_coverage: sum(|o| o.parameters),
            baseline_coverage: sum(|o| o.baseline),
            gain_coverage: known(|o| o.gain_covered),
            parameter_error_median: median(loud().filter_map(|o| o.parameter_error)),
            explained_median: median(loud().filter_map(|o| o.explained)),
            explained_worst: loud()
                .filter_map(|o| Some((o.explained?, o.case)))
                .min_by(|a, b| a.0.total_cmp(&b.0)),
            effects,
            confusion,
            cases,
        }
    }

    /// The tables as people read them.
    #[must_use]
    pub fn describe(&self) -> String {
        let mut out = String::new();
        let share = |x: Option<f64>| x.map_or_else(|| "–".into(), |x| format!("{:.0} %", 100.0 * x));
        let mut strengths: Vec<f64> =
            self.effects.iter().filter(|r| r.kind == "single").map(|r| r.strength).collect();
        strengths.sort_by(f64::total_cmp);
        strengths.dedup();
        let mut heads: Vec<String> = vec!["hidden alone: named first".into()];
        heads.extend(strengths.iter().map(|s| format!(">× {s}")));
        heads.extend([">told".into(), ">parameters".into(), ">explained".into(), "mistaken for".into()]);
        let mut table = Table::new(&heads.iter().map(String::as_str).collect::<Vec<_>>());
        let mut names: Vec<&str> =
            self.effects.iter().filter(|r| r.kind == "single").map(|r| r.hidden.as_str()).collect();
        names.dedup();
        for name in names {
            let rows: Vec<&Row> =
                self.effects.iter().filter(|r| r.kind == "single" && r.hidden == name).collect();
            let mut cells = vec![name.to_string()];
            cells.extend(strengths.iter().map(|s| {
                rows.iter()
                    .find(|r| r.strength == *s)
                    .map_or_else(|| "–".into(), |r| format!("{}/{}", r.right.hits, r.right.of))
            }));
            let loud: Vec<&&Row> = rows.iter().filter(|r| r.strength >= 1.0).collect();
            let told: (usize, usize) = loud.iter().fold((0, 0), |a, r| (a.0 + r.told.hits, a.1 + r.told.of));
            let mut mistaken: Vec<&str> =
                loud.iter().map(|r| r.mistaken_for.as_str()).filter(|m| !m.is_empty()).collect();
            mistaken.sort_unstable();
            mistaken.dedup();
            cells.extend([
                format!("{}/{}", told.0, told.1),
                share(median(loud.iter().filter_map(|r| r.parameter_error))),
                share(median(loud.iter().filter_map(|r| r.explained))),
                mistaken.join(", "),
            ]);
            table.row(cells);
        }
        if !table.is_empty() {
            out += &table.render();
        }
        let mut others = Table::new(&["beside these", "what", ">×", ">right", "mistaken for"]);
        for r in self.effects.iter().filter(|r| r.kind != "single") {
            others.row([
                r.kind.clone(),
                r.hidden.clone(),
                if r.strength > 0.0 { number(r.strength, 2) } else { String::new() },
                format!("{}/{}", r.right.hits, r.right.of),
                r.mistaken_for.clone(),
            ]);
        }
        if !others.is_empty() {
            out.push('\n');
            out += &others.render();
        }
        let error = share(self.parameter_error_median);
        let explained = self.explained_median.map_or_else(|| "–".into(), |x| format!("{x:.3}"));
        let worst = |(share, case)| format!("{share:.3} (case {case})");
        let worst = self.explained_worst.map_or_else(|| "–".into(), worst);
        let Rate { hits, of, .. } = self.location_precision;
        let false_share = share((of > 0).then(|| 1.0 - hits as f64 / of as f64));
        let location =
            self.location_f1.map_or_else(|| "not asked".into(), |f1| format!("{false_share}, {f1:.3}"));
        let lines = [
            ("named first, 1 × the noise and above", self.single_first.said()),
            ("  or said to be its equal, or invisible here", self.single_told.said()),
            ("named first, below the noise", self.below_noise_first.said()),
            ("pairs, both named", self.pair_both.said()),
            ("false alarms where nothing is hidden", self.null_false_alarms.said()),
            ("false alarms on recording faults", self.decoy_false_alarms.said()),
            ("something named beside the effect that is there", self.extra_named.said()),
            ("what no motion shows, said so", self.never_told.said()),
            ("located where it shows", self.located.said()),
            ("located: of what was told, right (precision)", self.location_precision.said()),
            ("located: of what is hidden, told (recall)", self.location_recall.said()),
            ("located: false discovery rate, F1", location),
            ("95 % intervals of effect parameters hold the truth", self.parameter_coverage.said()),
            ("95 % intervals of baseline parameters", self.baseline_coverage.said()),
            ("95 % intervals of the held-out gain", self.gain_coverage.said()),
            ("median parameter error", error),
            ("median explained share, noise-free, new motion", explained),
            ("the worst of these", worst),
        ];
        out.push('\n');
        for (what, said) in lines {
            let _ = writeln!(out, "  {what:<52} {said}");
        }
        out
    }

    /// One line a case.
    pub(crate) fn cases_csv(&self) -> String {
        let mut out = String::from(
            "case,kind,hidden,strength,verdict,named,indistinguishable_from,first,told,all,false_alarm,located,parameter_error,explained_share\n",
        );
        let option = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.6}"));
        for o in &self.cases {
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                o.case,
                o.kind,
                o.hidden,
                o.strength,
                o.verdict,
                o.named.join("+"),
                o.equal.join("+"),
                o.first,
                o.told,
                o.all,
                o.false_alarm,
                o.located.map_or_else(String::new, |l| l.to_string()),
                option(o.parameter_error),
                option(o.explained)
            );
        }
        out
    }

    /// Hidden down, named first across.
    pub(crate) fn confusion_csv(&self) -> String {
        let mut columns: Vec<&String> = self.confusion.values().flat_map(BTreeMap::keys).collect();
        columns.sort();
        columns.dedup();
        let mut out = String::from("hidden");
        for c in &columns {
            let _ = write!(out, ",{c}");
        }
        out.push('\n');
        for (hidden, row) in &self.confusion {
            out += hidden;
            for c in &columns {
                let _ = write!(out, ",{}", row.get(*c).copied().unwrap_or(0));
            }
            out.push('\n');
        }
        out
    }
}

fn answer(o: &Outcome) -> String {
    o.named.first().cloned().unwrap_or_else(|| "nothing".into())
}

/// The most frequent wrong answer of a group.
fn mistaken(group: &[&Outcome]) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for o in group.iter().filter(|o| !right(o)) {
        let said = if o.kind == "single" { answer(o) } else { o.named.join("+") };
        let said = if said.is_empty() { "nothing".into() } else { said };
        *counts.entry(said).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, n)| *n).map_or_else(String::new, |(said, n)| format!("{said} ({n})"))
}
