//! A hum: a force that repeats in *time*, whatever the body does (a fan, a pump, the mains, a ripple of the supply).
//!
//! It is looked for before anything is named. A law of the motion cannot make it, but a model with enough of them, and the
//! channels of the force, can imitate a part: a force that predicts itself looks like one that comes late.
//!
//! Its frequency is a line in the spectrum of what the baseline leaves. The phase is that of a clock nobody recorded, so it
//! belongs to the recording and not to the machine: the hum is taken out of the force and reported, and no model file has it.

use crate::findings::locate::{row_motion, row_times};
use crate::findings::words::short;
use crate::free_form::candidate::Library;
use crate::library::design_matrix::DesignMatrix;
use crate::regression::linear::{FOLDS, Fit, fit};
use crate::regression::sign_flips::gain_interval;
use crate::result::{FreeCurve, FreeFormFinding, LooksLike, Missing, Quantity};
use crate::search::extra_columns::ExtraColumn;
use friction::effects::{Describe, Unnamed};
use friction::{Coordinate, Dimension, Factor, Geometry};
use realfft::RealFftPlanner;
use signals::{Basis, dot};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

/// Periods that a recording must hold: slower than this it is not told from a drift or a warming.
const FEWEST_PERIODS: f64 = 10.0;
/// Ratio of the frequencies between which one line is looked for.
const BAND: f64 = 1.25;
/// Ratio of frequencies around a line in which nothing else may be as high.
const AROUND: f64 = 1.5;
/// Power of a line over that of the highest line near it, and over the median near it. Physics of the motion that is left out
/// makes many lines near each other.
const OVER_HIGHEST: f64 = 9.0;
const OVER_MEDIAN: f64 = 40.0;
/// Largest share of its gain that a curve over the motion may explain that explains more than the hum itself: then it
/// repeats because the motion does.
const BY_MOTION: f64 = 0.4;
/// Largest share of the motion that may be at its frequency: a hum shakes the body far less.
const DRIVEN: f64 = 0.1;
/// Turns over the recording by which a wavelength is looked for around that of the mean speed, and steps of one.
const TURNS: i32 = 3;
const STEPS_A_TURN: i32 = 8;
/// Most hums, and most harmonics of one.
const MOST: usize = 3;
const HARMONICS: usize = 5;
/// Amplitude over its standard deviation from which on a harmonic is one.
const MIN_T_STATISTIC: f64 = 6.0;
/// Smallest gain, as a share of the squared error: less imitates nothing.
const MATERIAL: f64 = 0.02;
/// Values of the curve that is reported.
const VALUES: usize = 24;

/// A force that repeats in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Hum {
    /// Hz, with its standard deviation.
    pub frequency: (f64, f64),
    /// Multiples of the frequency.
    harmonics: Vec<u32>,
    /// For each recording and harmonic: cosine and sine of the time since the start, N or N·m.
    waves: BTreeMap<usize, Vec<[f64; 2]>>,
    /// Standard deviations of the first recording's.
    std: Vec<[f64; 2]>,
    /// Mean square error on blocks held out, without it and with it.
    pub squared: (f64, f64),
    gain: [f64; 2],
}

/// The rows of a design with their times, for spectra of a residual.
struct Rest<'a> {
    design: &'a DesignMatrix,
    times: Vec<f64>,
    /// Recording of each row.
    owner: Vec<usize>,
    recordings: Vec<usize>,
    /// Length of the longest recording, s, and time between rows, s.
    seconds: f64,
    step: f64,
}

impl<'a> Rest<'a> {
    fn new(design: &'a DesignMatrix) -> Option<Self> {
        let owner: Vec<usize> =
            design.tracks.iter().flat_map(|t| std::iter::repeat_n(t.raw.recording, t.row_count())).collect();
        let mut recordings = owner.clone();
        recordings.dedup();
        let times = row_times(design);
        let step = design.tracks.iter().map(|t| t.stride as f64 * t.raw.dt).fold(f64::INFINITY, f64::min);
        let span = |r: &usize| {
            let own: Vec<f64> = owner.iter().zip(&times).filter(|(o, _)| *o == r).map(|(_, t)| *t).collect();
            own.last().zip(own.first()).map_or(0.0, |(last, first)| last - first)
        };
        let seconds = recordings.iter().map(span).fold(0.0, f64::max);
        (step > 0.0 && seconds > step).then_some(Self { design, times, owner, recordings, seconds, step })
    }

    /// Rows of a recording.
    fn rows(&self, recording: usize) -> Range<usize> {
        let before = self.owner.iter().take_while(|o| **o != recording).count();
        before..before + self.owner.iter().filter(|o| **o == recording).count()
    }

    /// Power at the multiples of a frequency step, summed over the recordings, and that step, Hz.
    fn spectrum(&self, residual: &[f64]) -> (Vec<f64>, f64) {
        let length = (2.0 * self.seconds / self.step + 2.0).ceil() as usize;
        let length = length.next_power_of_two();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
        let mut power = vec![0.0; length / 2 + 1];
        for recording in &self.recordings {
            let mut series = transform.make_input_vec();
            let mut start = None;
            for r in self.rows(*recording) {
                let from = *start.get_or_insert(self.times[r]);
                let at = ((self.times[r] - from) / self.step).round() as usize;
                if let Some(slot) = series.get_mut(at) {
                    *slot += residual[r];
                }
            }
            let mut out = transform.make_output_vec();
            // both lengths are the transform's own
            if transform.process(&mut series, &mut out).is_ok() {
                for (p, x) in power.iter_mut().zip(out) {
                    *p += x.norm_sqr();
                }
            }
        }
        (power, 1.0 / (length as f64 * self.step))
    }

    /// Power of the residual at one frequency.
    fn power(&self, residual: &[f64], frequency: f64) -> f64 {
        let of = |recording: &usize| {
            let (c, s) = self.rows(*recording).fold((0.0, 0.0), |(c, s), r| {
                let (sine, cosine) = (TAU * frequency * self.times[r]).sin_cos();
                (c + residual[r] * cosine, s + residual[r] * sine)
            });
            c * c + s * s
        };
        self.recordings.iter().map(of).sum()
    }

    /// The frequency within `reach` of `from` at which the residual has most power.
    fn refined(&self, residual: &[f64], from: f64, reach: f64) -> f64 {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut low, mut high) = (from - reach, from + reach);
        while high - low > 1e-4 * reach {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if self.power(residual, a) > self.power(residual, b) {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }

    /// Rows of cosine and sine of one frequency, for each recording.
    fn columns(&self, frequency: f64) -> Vec<Vec<f64>> {
        let of = |recording: usize, wave: fn(f64) -> f64| {
            self.design.rows(|t| {
                let own = t.raw.recording == recording;
                let at = |i: usize| if own { wave(TAU * frequency * t.time(i)) } else { 0.0 };
                t.pass(&(0..t.len()).map(at).collect::<Vec<_>>())
            })
        };
        self.recordings.iter().flat_map(|r| [of(*r, f64::cos), of(*r, f64::sin)]).collect()
    }
}

/// The hum that stands out most in what the baseline leaves, at frequencies below `cutoff`.
fn strongest(design: &DesignMatrix, extra: &[ExtraColumn], cutoff: f64, seed: u64) -> Option<Hum> {
    let rest = Rest::new(design)?;
    let before = fit(&design.baseline, &design.y, &design.blocks, FOLDS)?;
    let (power, step) = rest.spectrum(&before.residual);
    let index = |frequency: f64| ((frequency / step).round() as usize).min(power.len() - 1);
    let first = FEWEST_PERIODS / rest.seconds;
    let last = cutoff.min(0.45 / rest.step);
    let bands = ((last / first).ln() / BAND.ln()).ceil().max(0.0) as i32;
    let mut lines: Vec<(f64, f64)> = (0..bands)
        .filter_map(|b| {
            let low = first * BAND.powi(b);
            let within = index(low)..=index((low * BAND).min(last));
            let top = within.max_by(|i, j| power[*i].total_cmp(&power[*j]))?;
            let frequency = top as f64 * step;
            let mut around = power[index(frequency / AROUND)..=index(frequency * AROUND)].to_vec();
            around.sort_by(f64::total_cmp);
            let median = around[around.len() / 2];
            (power[top] > OVER_MEDIAN * median).then_some((power[top] / median.max(1e-300), frequency))
        })
        .collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let library = Library::new(design);
    lines.into_iter().find_map(|(_, near)| {
        let frequency = rest.refined(&before.residual, near, 0.6 / rest.seconds);
        hum(&rest, &library, extra, &before, frequency, cutoff, seed)
    })
}

/// The hum of this frequency, if it is one.
fn hum(
    rest: &Rest,
    library: &Library,
    extra: &[ExtraColumn],
    before: &Fit,
    frequency: f64,
    cutoff: f64,
    seed: u64,
) -> Option<Hum> {
    let design = rest.design;
    let with = |columns: &[Vec<f64>]| {
        let all: Vec<&[f64]> = design.baseline.iter().chain(columns).map(Vec::as_slice).collect();
        fit(&all, &design.y, &design.blocks, FOLDS)
    };
    let mut columns = rest.columns(frequency);
    let mut harmonics = vec![1_u32];
    let mut after = with(&columns)?;
    if !stands_out(rest, before, &after, frequency)
        || moved(rest, library, extra, &columns)
        || along_the_way(rest, before, frequency)
    {
        return None;
    }
    for harmonic in 2..=HARMONICS as u32 {
        if f64::from(harmonic) * frequency >= cutoff {
            break;
        }
        let more: Vec<Vec<f64>> =
            columns.iter().cloned().chain(rest.columns(f64::from(harmonic) * frequency)).collect();
        let fitted = with(&more)?;
        let own = design.baseline.len() + columns.len()..fitted.coefficients.len();
        let t = own.map(|k| (fitted.coefficients[k] / fitted.std_errors()[k]).abs()).fold(0.0, f64::max);
        if t > MIN_T_STATISTIC && fitted.heldout_sum() < after.heldout_sum() {
            harmonics.push(harmonic);
            (columns, after) = (more, fitted);
        }
    }
    let weight = design.block_weight();
    let gain = gain_interval(&before.heldout, &after.heldout, &weight, &design.blocks.recordings, 1000, seed);
    let (without, with) = (before.heldout_sum(), after.heldout_sum());
    if gain[0] <= 0.0 || with > (1.0 - MATERIAL) * without {
        return None;
    }
    let rows: f64 = weight.iter().sum();
    let pair = |values: &[f64], recording: usize, harmonic: usize| {
        let at = design.baseline.len() + 2 * (harmonic * rest.recordings.len() + recording);
        [values[at], values[at + 1]]
    };
    let of = |values: &[f64], recording: usize| -> Vec<[f64; 2]> {
        (0..harmonics.len()).map(|h| pair(values, recording, h)).collect()
    };
    let waves: BTreeMap<usize, Vec<[f64; 2]>> =
        rest.recordings.iter().enumerate().map(|(k, r)| (*r, of(&after.coefficients, k))).collect();
    // a frequency is as sure as its phase is over the recording: of a line in noise, sqrt(6)/(pi T) of the relative error
    let [c, s] = of(&after.coefficients, 0)[0];
    let [dc, ds] = of(after.std_errors(), 0)[0];
    let relative = dc.max(ds) / c.hypot(s);
    let std_frequency = 3f64.sqrt() / (std::f64::consts::PI * rest.seconds) * relative;
    Some(Hum {
        frequency: (frequency, std_frequency),
        std: of(after.std_errors(), 0),
        harmonics,
        waves,
        squared: (without / rows, with / rows),
        gain,
    })
}

/// Whether no other line near it is nearly as high. They are compared once it is taken out, with its own side lines.
fn stands_out(rest: &Rest, before: &Fit, after: &Fit, frequency: f64) -> bool {
    let (with, step) = rest.spectrum(&before.residual);
    let (without, _) = rest.spectrum(&after.residual);
    let at = |f: f64| ((f / step).round() as usize).min(with.len() - 1);
    let line =
        with[at(frequency - 0.5 * step)..=at(frequency + 0.5 * step)].iter().copied().fold(0.0, f64::max);
    let highest =
        without[at(frequency / AROUND)..=at(frequency * AROUND)].iter().copied().fold(0.0, f64::max);
    line > OVER_HIGHEST * highest
}

/// Whether a curve over the motion, or over a further column of the recording, explains what the hum does. It is fitted to
/// each recording alone: recordings of one motion differ in phase, too.
fn moved(rest: &Rest, library: &Library, extra: &[ExtraColumn], columns: &[Vec<f64>]) -> bool {
    let design = rest.design;
    let ranges: Vec<Range<usize>> = rest.recordings.iter().map(|r| rest.rows(*r)).collect();
    // how much a form lowers the squared error, and how much the hum lowers it after that
    let taken = |form: &[Vec<f64>]| -> (f64, f64) {
        let of = |rows: &Range<usize>| {
            let known: Vec<&[f64]> = design.baseline.iter().map(|c| &c[rows.clone()]).collect();
            let mut basis = Basis::of(&known);
            let mut left = |more: &[Vec<f64>]| {
                more.iter().for_each(|c| {
                    basis.push(&c[rows.clone()]);
                });
                let rest = basis.project_out(&design.y[rows.clone()]);
                dot(&rest, &rest)
            };
            let [plain, formed, both] = [left(&[]), left(form), left(columns)];
            (plain - formed, formed - both)
        };
        ranges.iter().map(of).fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1))
    };
    let alone = taken(&[]).1;
    let least = (1.0 - BY_MOTION) * alone;
    // a hum shakes the body, so a curve over its speed holds a part of it, but no more than the hum does
    let explains = |form: &[Vec<f64>]| {
        let (gain, beside) = taken(form);
        beside < least && gain > alone
    };
    driven(rest, &ranges, columns)
        || library.of_motion().any(|candidate| {
            let (first, second) = candidate.ladder(false).first[0].knots;
            library.get(design, candidate, first, second).is_some_and(|(_, all)| explains(&all))
        })
        || extra.iter().any(|column| column.curves(design).iter().any(|curve| taken(curve).1 < least))
}

/// Whether a wave over the position of a body that only advances holds at least as much as the hum does: at one speed the
/// teeth of a motor pass as regularly as time, and the little by which the speed wanders tells them apart.
fn along_the_way(rest: &Rest, before: &Fit, frequency: f64) -> bool {
    if !rest.design.is_one_way() {
        return false;
    }
    let (x, _) = row_motion(rest.design);
    let used = |r: &usize| x[*r].is_finite() && rest.times[*r].is_finite();
    let over = |phase: &dyn Fn(usize) -> f64| -> f64 {
        let of = |recording: &usize| {
            let (c, s) = rest.rows(*recording).filter(used).fold((0.0, 0.0), |(c, s), r| {
                let (sine, cosine) = (TAU * phase(r)).sin_cos();
                (c + before.residual[r] * cosine, s + before.residual[r] * sine)
            });
            c * c + s * s
        };
        rest.recordings.iter().map(of).sum()
    };
    let travel = |recording: &usize| {
        let mut rows = rest.rows(*recording).filter(used);
        let first = rows.next();
        first.zip(rows.next_back()).map(|(a, b)| (x[b] - x[a], rest.times[b] - rest.times[a]))
    };
    let longest = rest.recordings.iter().filter_map(travel).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((way, seconds)) = longest.filter(|(way, _)| *way != 0.0) else { return false };
    let turns = frequency * seconds;
    let by_time = over(&|r| frequency * rest.times[r]);
    (-TURNS * STEPS_A_TURN..=TURNS * STEPS_A_TURN).any(|k| {
        let per_length = (turns + f64::from(k) / f64::from(STEPS_A_TURN)) / way;
        over(&|r| per_length * x[r]) >= by_time
    })
}

/// Whether the body is moved at the frequency of the hum: then it is what the motion makes.
fn driven(rest: &Rest, ranges: &[Range<usize>], columns: &[Vec<f64>]) -> bool {
    let design = rest.design;
    let one = design.rows(|t| t.pass(&vec![1.0; t.len()]));
    let motion =
        [design.rows(|t| t.pass(&t.x)), design.rows(|t| t.pass(&t.v)), design.rows(|t| t.pass(&t.sign))];
    let share = |series: &[f64], rows: &Range<usize>| {
        let mut basis = Basis::of(&[&one[rows.clone()]]);
        let before = basis.project_out(&series[rows.clone()]);
        columns.iter().for_each(|c| {
            basis.push(&c[rows.clone()]);
        });
        let after = basis.project_out(&before);
        1.0 - dot(&after, &after) / dot(&before, &before).max(1e-300)
    };
    ranges.iter().any(|rows| motion.iter().any(|series| share(series, rows) > DRIVEN))
}

/// Takes hums out of what `fresh` makes a design matrix of, the strongest first.
pub fn find(
    mut fresh: impl FnMut(&[Hum]) -> Option<DesignMatrix>,
    extra: &[ExtraColumn],
    cutoff: f64,
    seed: u64,
) -> Vec<Hum> {
    let mut out: Vec<Hum> = Vec::new();
    while out.len() < MOST
        && let Some(hum) = fresh(&out).and_then(|design| strongest(&design, extra, cutoff, seed))
    {
        out.push(hum);
    }
    out
}

impl Hum {
    /// Its force at a time of a recording, N or N·m.
    pub fn force(&self, recording: usize, time: f64) -> f64 {
        self.waves.get(&recording).map_or(0.0, |waves| self.wave(waves, time))
    }

    fn wave(&self, waves: &[[f64; 2]], time: f64) -> f64 {
        let of = |(harmonic, [c, s]): (&u32, &[f64; 2])| {
            let (sine, cosine) = (TAU * f64::from(*harmonic) * self.frequency.0 * time).sin_cos();
            c * cosine + s * sine
        };
        self.harmonics.iter().zip(waves).map(of).sum()
    }

    /// What is said of it.
    pub fn missing(&self, geometry: Geometry) -> Missing {
        let unit = Dimension::FORCE.unit(geometry).to_string();
        let (frequency, std) = self.frequency;
        let first = self.waves.values().next().map_or(&[][..], Vec::as_slice);
        let amplitude = first.first().map_or(0.0, |[c, s]| c.hypot(*s));
        let spread = self.std.iter().flatten().map(|s| s * s).sum::<f64>().sqrt();
        let knots: Vec<f64> = (0..VALUES).map(|k| k as f64 / (VALUES - 1) as f64 / frequency).collect();
        let quantity = |value, std, unit: &str| Quantity { value, std, unit: unit.into() };
        let parameters = BTreeMap::from([
            ("frequency".to_string(), quantity(frequency, std, "Hz")),
            (
                "gain".to_string(),
                quantity(amplitude, self.std.first().map_or(0.0, |s| s[0].max(s[1])), &unit),
            ),
        ]);
        let rms = |squared: f64| squared.sqrt();
        Missing {
            effect: Unnamed::ABOUT.id.into(),
            says: format!(
                "a force that repeats in time at {} Hz, whatever the body does, with an amplitude of {} {unit}",
                short(frequency),
                short(amplitude)
            ),
            equation: "f(time), the same after every period".into(),
            parameters: BTreeMap::new(),
            rms_heldout_before: rms(self.squared.0),
            rms_heldout_after: rms(self.squared.1),
            gain_ci95: self.gain,
            p: 1e-3,
            indistinguishable_from: Vec::new(),
            experiment: "hold the body still and record the force: what repeats then is no friction; then switch off what \
                         turns or is fed by the mains, one after the other"
                .into(),
            free_form: Some(FreeFormFinding {
                coordinates: vec![Coordinate::Time.id().into()],
                units: vec!["s".into()],
                curve: FreeCurve {
                    times: Factor::One.id().into(),
                    memory_s: None,
                    period_s: Some(1.0 / frequency),
                    values: knots.iter().map(|t| self.wave(first, *t)).collect(),
                    band: vec![1.96 * spread; VALUES],
                    knots,
                    knots_across: Vec::new(),
                    unit,
                },
                looks_like: Some(LooksLike {
                    formula: "sin(2*pi*frequency*time + phase)".into(),
                    parameters,
                    runner_up: None,
                    made_by: "something that turns at a constant speed or is fed by the mains: a fan, a pump, a supply's \
                              ripple, a neighbouring machine"
                        .into(),
                }),
                kin: Vec::new(),
            }),
        }
    }
}
