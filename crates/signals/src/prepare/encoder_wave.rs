//! A wave on the encoder, told by a channel that does not go through it: an accelerometer, a tachometer.
//!
//! r = dⁿx/dtⁿ − column, n = 2 of an acceleration and 1 of a velocity, behind one filter. Physics moves both alike and is not
//! in r; a wave on the position is, as a line over the position that grows with v² (with v). Every wavelength is scanned
//! beside what the channels may differ in otherwise (scale, zero, delay, drift, tilt), and the strongest line of all is
//! compared with what is left when the signs of whole blocks are flipped. What stands out has to be a wave: the same in
//! both directions, early and late, slow and fast, and not a line of the same height at every speed.

use super::channels::Channels;
use super::cutoff::differentiated;
use super::wave::Wave;
use crate::{Basis, LowPass, dot, four_point_difference, noise_std, quantile, quantum, random_signs};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Waves over the stroke between two lines that are scanned.
const SPACING: f64 = 0.3;
/// Most lines scanned.
const LINES: usize = 1000;
/// Longest wavelength, in strokes.
const LONGEST: f64 = 1.5;
/// Rows per period of the cut-off, and rows of a block.
const ROWS: f64 = 2.5;
const BLOCK: usize = 15;
/// Fewest rows, and most blocks.
const FEWEST: usize = 120;
const BLOCKS: usize = 120;
/// Random signs drawn, and how far beyond the largest line they leave a wave has to stand: the tail of a maximum of chance
/// falls by e⁻¹ for each unit of some ten.
const FLIPS: usize = 199;
const MIN_EXCESS: f64 = 1.5;
/// Squared height over noise below which no scan of flips is worth its time.
const PROMISING: f64 = 18.0;
/// Standard deviations of the amplitude.
const MIN_T_STATISTIC: f64 = 5.0;
/// Share of the amplitude by which two halves of a recording may differ, and the square in deviations where noise is more.
const MAX_RELATIVE_DIFFERENCE: f64 = 0.3;
const CHANCE: f64 = 12.0;
/// Steepest wave, 2π·amplitude/wavelength: at 1 the encoder would read backwards.
const STEEPEST: f64 = 0.7;
/// Rounds of the fit.
const ROUNDS: usize = 12;

/// What an independent channel says of the encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Comparison {
    /// The column has noise of its own beside the position's: it is not its derivative.
    pub independent: bool,
    /// The wave.
    pub wave: Option<Wave>,
}

/// The acceleration column of the stretches of one recording against its position (`order` 2), or the velocity column
/// (`order` 1). None where there is none, or the recording is too short for it.
pub(super) fn compare_channels(stretches: &[Channels], order: i32, seed: u64) -> Option<Comparison> {
    let ground = MotionModel::of(stretches, order)?;
    let mut left = ground.basis.project_out(&ground.difference);
    let wave = ground.search(&left, seed);
    if let Some((fit, _)) = &wave {
        left.clone_from(&fit.left);
    }
    let rows = left.len() as f64;
    let independent = dot(&left, &left) / rows > (0.5 * ground.noise.0).powi(2);
    Some(Comparison { independent, wave: wave.map(|w| w.1) })
}

fn column(c: &Channels, order: i32) -> Option<&Vec<f64>> {
    if order == 2 { c.acceleration.as_ref() } else { c.velocity.as_ref() }
}

/// One stretch, and which of its samples are rows.
struct Part<'a> {
    raw: &'a Channels,
    filter: LowPass,
    from: usize,
    step: usize,
    rows: usize,
}

impl Part<'_> {
    fn pick(&self, series: &[f64], out: &mut Vec<f64>) {
        out.extend((0..self.rows).map(|i| series[self.from + i * self.step]));
    }

    /// A column behind the filter and behind what central differences do to it besides: the mean from one neighbour to
    /// the other, by Simpson's rule.
    fn shown(&self, series: &[f64], order: i32) -> Vec<f64> {
        let mean = |s: Vec<f64>| -> Vec<f64> {
            let last = s.len() - 1;
            let of = |i: usize| (s[i.saturating_sub(1)] + 4.0 * s[i] + s[(i + 1).min(last)]) / 6.0;
            (0..=last).map(of).collect()
        };
        (0..order).fold(self.filter.apply(series), |s, _| mean(s))
    }
}

/// Position and column compared, row by row.
struct MotionModel<'a> {
    order: i32,
    parts: Vec<Part<'a>>,
    difference: Vec<f64>,
    /// What the channels may differ in without a wave.
    basis: Basis,
    x: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    middle: f64,
    span: f64,
    /// Speed that is rarely exceeded.
    fast: f64,
    finest: f64,
    blocks: usize,
    /// Of a row of the difference, by the position's noise and by the column's.
    noise: (f64, f64),
    /// The smallest amplitude worth looking at: half a count of the encoder.
    count: f64,
    /// Half a count of the column.
    column_count: f64,
}

/// A wave fitted at rows: cosine, sine about the middle of the stroke and 2π over the wavelength.
struct Fitted {
    cosine: f64,
    sine: f64,
    number: f64,
    cover: DMatrix<f64>,
    left: Vec<f64>,
}

impl<'a> MotionModel<'a> {
    fn of(stretches: &'a [Channels], order: i32) -> Option<Self> {
        let used: Vec<(&Channels, &Vec<f64>)> =
            stretches.iter().filter_map(|c| Some((c, column(c, order)?))).collect();
        let longest = used.iter().max_by_key(|(c, _)| c.position.len())?;
        let (of_position, of_column) = (noise_std(&longest.0.position), noise_std(longest.1));
        let dt = longest.0.dt;
        // where the noise of the one, which rises with frequency, meets that of the other
        let even = (of_column / of_position.max(1e-300)).powf(1.0 / f64::from(order)) / TAU;
        let cutoff = even.max(8.0 * longest.0.dominant_frequency()).min(0.1 / dt);
        let filter = LowPass::new(cutoff, dt);
        let step = (1.0 / (ROWS * cutoff * dt)).floor().max(1.0) as usize;
        let parts: Vec<Part> = used
            .iter()
            .map(|(raw, _)| {
                let n = raw.position.len();
                let from = filter.settle();
                Part { raw, filter, from, step, rows: n.saturating_sub(2 * from) / step }
            })
            .filter(|p| p.raw.position.len() > 4 * p.from)
            .collect();
        let total: usize = parts.iter().map(|p| p.rows).sum();
        if total < FEWEST {
            return None;
        }
        let mut series: [Vec<f64>; 5] = Default::default();
        let mut difference = Vec::with_capacity(total);
        for p in &parts {
            let x = p.filter.apply(&p.raw.position);
            let v = four_point_difference(&x, p.raw.dt);
            let a = four_point_difference(&v, p.raw.dt);
            let jerk = four_point_difference(&a, p.raw.dt);
            let shown = p.shown(column(p.raw, order)?, order);
            let own = if order == 2 { &a } else { &v };
            let time: Vec<f64> = (0..x.len()).map(|i| p.raw.start + i as f64 * p.raw.dt).collect();
            p.pick(&own.iter().zip(&shown).map(|(x, c)| x - c).collect::<Vec<_>>(), &mut difference);
            for (from, to) in [&x, &v, &a, &jerk, &time].into_iter().zip(&mut series) {
                p.pick(from, to);
            }
        }
        let [x, v, a, jerk, time] = series;
        let (low, high) = (quantile(&x, 0.002), quantile(&x, 0.998));
        let fast = quantile(&v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.95);
        let one = vec![1.0; total];
        let mut basis = Basis::of(&[&one[..], &time[..], &x[..], &v[..], &a[..]]);
        if order == 2 {
            basis.push(&jerk);
        }
        let own = of_position * differentiated(order, cutoff, dt);
        Some(Self {
            order,
            blocks: (total / BLOCK).min(BLOCKS),
            difference,
            basis,
            middle: 0.5 * (low + high),
            span: high - low,
            fast,
            finest: (0.7 * fast / cutoff).max(20.0 * of_position),
            noise: (own, of_column * differentiated(0, cutoff, dt)),
            count: 0.5 * quantum(&longest.0.position),
            column_count: 0.5 * quantum(longest.1) / fast.powi(order).max(1e-300),
            x,
            v,
            a,
            parts,
        })
    }

    /// Rows of a block.
    fn block(&self, b: usize) -> std::ops::Range<usize> {
        let n = self.x.len();
        b * n / self.blocks..(b + 1) * n / self.blocks
    }

    /// What a cosine and a sine of 2π/`number` add to the difference, over the rows, up to a factor.
    fn line(&self, number: f64) -> Option<[Vec<f64>; 2]> {
        let (mut c, mut s) = (Vec::with_capacity(self.x.len()), Vec::with_capacity(self.x.len()));
        for ((x, v), a) in self.x.iter().zip(&self.v).zip(&self.a) {
            let (sine, cosine) = (number * (x - self.middle)).sin_cos();
            let (along, across) = if self.order == 2 { (v * v, a / number) } else { (0.0, *v) };
            c.push(along * cosine + across * sine);
            s.push(along * sine - across * cosine);
        }
        let unit = |column: &mut Vec<f64>, before: f64| {
            let power = dot(column, column);
            column.iter_mut().for_each(|x| *x /= power.sqrt());
            power > 1e-4 * before
        };
        let (of_c, of_s) = (dot(&c, &c), dot(&s, &s));
        let (mut c, mut s) = (self.basis.project_out(&c), self.basis.project_out(&s));
        let told = unit(&mut c, of_c);
        let along = dot(&c, &s);
        s.iter_mut().zip(&c).for_each(|(s, c)| *s -= along * c);
        (unit(&mut s, of_s) && told).then_some([c, s])
    }

    /// Scores of every line in every block.
    fn scores(&self, numbers: &[f64], rest: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let of = |number: &f64| -> Vec<[f64; 2]> {
            let Some(line) = self.line(*number) else { return Vec::new() };
            let part = |b: usize| {
                let rows = self.block(b);
                line.each_ref().map(|column| dot(&column[rows.clone()], &rest[rows.clone()]))
            };
            (0..self.blocks).map(part).collect()
        };
        numbers.par_iter().map(of).collect()
    }

    /// The wave in `rest`, the difference without what may be in it otherwise.
    fn search(&self, rest: &[f64], seed: u64) -> Option<(Fitted, Wave)> {
        if !(self.span > 0.0 && self.finest < LONGEST * self.span) {
            return None;
        }
        let first = 1.0 / (LONGEST * self.span);
        let spacing = SPACING / self.span;
        let count = (((1.0 / self.finest - first) / spacing) as usize + 1).min(LINES);
        let numbers: Vec<f64> = (0..count).map(|i| TAU * (first + spacing * i as f64)).collect();
        let straight = vec![1.0; self.blocks];
        let heights: Vec<f64> = self.scores(&numbers, rest).iter().map(|s| height(s, &straight)).collect();
        let (best, _) = heights.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        let rows = rest.len() as f64;
        let beside = (dot(rest, rest) - heights[best]).max(0.0) / rows;
        if !(heights[best] > PROMISING * beside) {
            return None;
        }
        let fit = self.fit(numbers[best])?;
        let left = dot(&fit.left, &fit.left);
        let explained = dot(rest, rest) - left;
        // what it leaves beyond the sensors' noise is something else, and has a wave in it as everything has
        let noise = rows * (self.noise.0.powi(2) + self.noise.1.powi(2));
        if explained < left - 1.5 * noise || !self.stands_out(&numbers, &heights, &fit, seed) {
            return None;
        }
        let wave = fit.wave(self.middle)?;
        let (amplitude, std) = wave.amplitude;
        let possible = amplitude > self.count
            && amplitude * fit.number.powi(self.order) > self.column_count
            && amplitude * fit.number < STEEPEST
            && amplitude < 0.25 * self.span;
        (possible && amplitude > MIN_T_STATISTIC * std && self.is_a_wave(&fit)).then_some((fit, wave))
    }

    /// Whether the highest line stands out of all lines of what is left with the signs of whole blocks flipped.
    fn stands_out(&self, numbers: &[f64], heights: &[f64], fit: &Fitted, seed: u64) -> bool {
        let noise = self.scores(numbers, &fit.left);
        let white = dot(&fit.left, &fit.left) / fit.left.len() as f64;
        // half by blocks and half by rows: a line that lives in two blocks would be divided by what it happened to be
        let scale: Vec<f64> = noise
            .iter()
            .map(|s| white + 0.5 * s.iter().map(|z| z[0] * z[0] + z[1] * z[1]).sum::<f64>())
            .collect();
        let of = |heights: &mut dyn Iterator<Item = f64>| {
            heights.zip(&scale).map(|(h, s)| h / s).filter(|t| t.is_finite()).fold(0.0, f64::max)
        };
        let observed = of(&mut heights.iter().copied());
        let drawn = random_signs(FLIPS, self.blocks, seed ^ 0xecc);
        let flipped = |signs: &Vec<f64>| of(&mut noise.iter().map(|s| height(s, signs)));
        let largest = drawn.par_iter().map(flipped).reduce(|| 0.0, f64::max);
        observed > MIN_EXCESS * largest
    }

    /// Columns of a cosine, a sine, and the derivative of the wave by its number, as the comparison shows them.
    fn columns(&self, fit: &Fitted) -> [Vec<f64>; 3] {
        let mut out: [Vec<f64>; 3] = Default::default();
        let wave = fit.wave(self.middle);
        for p in &self.parts {
            let waves: Vec<[f64; 3]> = p
                .raw
                .position
                .iter()
                .map(|read| {
                    let u = wave.map_or(*read, |w| w.place(*read)) - self.middle;
                    let (sine, cosine) = (fit.number * u).sin_cos();
                    [cosine, sine, u * (fit.sine * cosine - fit.cosine * sine)]
                })
                .collect();
            let filtered = p.filter.apply_lanes(&waves);
            for (lane, out) in out.iter_mut().enumerate() {
                let series: Vec<f64> = filtered.iter().map(|w| w[lane]).collect();
                let derived = (0..self.order).fold(series, |s, _| four_point_difference(&s, p.raw.dt));
                p.pick(&derived, out);
            }
        }
        out
    }

    /// The wave around `number`, jointly with everything else the channels may differ in (Gauss-Newton).
    fn fit(&self, number: f64) -> Option<Fitted> {
        let start = number;
        let mut fit =
            Fitted { cosine: 0.0, sine: 0.0, number, cover: DMatrix::zeros(3, 3), left: Vec::new() };
        for round in 0..ROUNDS {
            let [c, s, k] = self.columns(&fit);
            // a wave of no height has no derivative by its number
            let columns: Vec<&[f64]> = if round == 0 { vec![&c, &s] } else { vec![&c, &s, &k] };
            let solved = self.solve(&columns)?;
            (fit.cosine, fit.sine) = (solved.c[0], solved.c[1]);
            (fit.cover, fit.left) = (solved.cover, solved.left);
            let Some(by) = solved.c.get(2) else { continue };
            let most = 0.3 / self.span;
            fit.number += by.clamp(-most, most);
            if by.abs() < 1e-6 * fit.number {
                break;
            }
        }
        let near = (fit.number - start).abs() * self.span < TAU && fit.number > 0.0;
        (near && fit.cover.nrows() == 3).then_some(fit)
    }

    /// Least squares of the difference beside what else may be in it, with the cover by blocks.
    fn solve(&self, columns: &[&[f64]]) -> Option<Solved> {
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| self.basis.project_out(c)).collect();
        let p = columns.len();
        let mut left = self.basis.project_out(&self.difference);
        let size: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt().max(1e-300)).collect();
        let gram = DMatrix::from_fn(p, p, |i, j| dot(&columns[i], &columns[j]) / (size[i] * size[j]));
        let moment = DVector::from_fn(p, |i, _| dot(&columns[i], &left) / size[i]);
        let inverse = gram.clone().cholesky()?.inverse();
        let c: Vec<f64> = (&inverse * moment).iter().zip(&size).map(|(c, s)| c / s).collect();
        for (column, c) in columns.iter().zip(&c) {
            left.iter_mut().zip(column).for_each(|(l, x)| *l -= c * x);
        }
        let white = dot(&left, &left) / left.len() as f64;
        let mut middle = gram * (0.5 * white);
        for b in 0..self.blocks {
            let rows = self.block(b);
            let score =
                DVector::from_fn(p, |i, _| dot(&columns[i][rows.clone()], &left[rows.clone()]) / size[i]);
            middle += 0.5 * &score * score.transpose();
        }
        let cover = &inverse * middle * &inverse;
        let cover = DMatrix::from_fn(p, p, |i, j| cover[(i, j)] / (size[i] * size[j]));
        c.iter().all(|c| c.is_finite()).then_some(Solved { c, cover, left })
    }

    /// Whether what was fitted is the same in every half of the recording, and no line of constant height.
    fn is_a_wave(&self, fit: &Fitted) -> bool {
        let [c, s, _] = self.columns(fit);
        let within = |column: &[f64], half: &dyn Fn(usize) -> bool| -> Vec<f64> {
            column.iter().enumerate().map(|(i, x)| if half(i) { *x } else { 0.0 }).collect()
        };
        let fast = |i: usize| self.v[i].abs() > 0.5 * self.fast;
        let middle = self.x.len() / 2;
        let halves: [&dyn Fn(usize) -> bool; 3] = [&|i| self.v[i] > 0.0, &|i| i < middle, &fast];
        let alike = halves.iter().all(|half| {
            let other = |i: usize| !half(i);
            let columns = [within(&c, half), within(&s, half), within(&c, &other), within(&s, &other)];
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            // where one half has nothing to say there is nothing to compare
            self.solve(&columns)
                .is_none_or(|f| f.agrees(fit, &[[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]]))
        });
        // an edge of the acceleration that the two channels show differently sits at a reversal, often at the same place
        let (c_fast, s_fast) = (within(&c, &fast), within(&s, &fast));
        let away_from_reversals = self.solve(&[&c_fast, &s_fast]).is_some_and(|f| {
            squared(&[f.c[0], f.c[1]], &f.cover) > MIN_T_STATISTIC * MIN_T_STATISTIC && f.is_near(fit)
        });
        let phase: Vec<f64> = self.x.iter().map(|x| fit.number * (x - self.middle)).collect();
        let line: [Vec<f64>; 2] =
            [phase.iter().map(|p| p.cos()).collect(), phase.iter().map(|p| p.sin()).collect()];
        let beside = self.solve(&[&c, &s, &line[0], &line[1]]);
        alike
            && away_from_reversals
            && beside.is_some_and(|f| {
                let cover = f.cover.view((0, 0), (2, 2)).into_owned();
                squared(&[f.c[0], f.c[1]], &cover) > MIN_T_STATISTIC * MIN_T_STATISTIC && f.is_near(fit)
            })
    }
}

/// Squared sum of the blocks' scores, each with its sign.
fn height(scores: &[[f64; 2]], signs: &[f64]) -> f64 {
    let [c, s] =
        scores.iter().zip(signs).fold([0.0; 2], |sum, (z, g)| [sum[0] + g * z[0], sum[1] + g * z[1]]);
    c * c + s * s
}

/// The square of a pair in standard deviations.
fn squared(pair: &[f64; 2], cover: &DMatrix<f64>) -> f64 {
    let pair = DVector::from_row_slice(pair);
    cover.clone().cholesky().map_or(0.0, |c| pair.dot(&c.solve(&pair)))
}

struct Solved {
    c: Vec<f64>,
    cover: DMatrix<f64>,
    left: Vec<f64>,
}

impl Solved {
    /// Whether the first two coefficients are those of the fit, within chance or a share of the wave.
    fn is_near(&self, fit: &Fitted) -> bool {
        let away = [self.c[0] - fit.cosine, self.c[1] - fit.sine];
        let cover = self.cover.view((0, 0), (2, 2)).into_owned();
        away[0].hypot(away[1]) < MAX_RELATIVE_DIFFERENCE * fit.cosine.hypot(fit.sine)
            || squared(&away, &cover) < CHANCE
    }

    /// Whether two combinations of the coefficients are zero, within chance or a share of the wave.
    fn agrees(&self, fit: &Fitted, rows: &[[f64; 4]; 2]) -> bool {
        let rows = DMatrix::from_fn(2, 4, |i, j| rows[i][j]);
        let away = &rows * DVector::from_row_slice(&self.c);
        let cover = &rows * &self.cover * rows.transpose();
        away.norm() < MAX_RELATIVE_DIFFERENCE * fit.cosine.hypot(fit.sine)
            || squared(&[away[0], away[1]], &cover) < CHANCE
    }
}

impl Fitted {
    /// As amplitude, phase at the origin and wavelength; `middle` is where cosine and sine begin. None without a height.
    fn wave(&self, middle: f64) -> Option<Wave> {
        let amplitude = self.cosine.hypot(self.sine);
        if !(amplitude > 0.0) {
            return None;
        }
        let std = |by: [f64; 3]| -> f64 {
            let by = DVector::from_fn(self.cover.nrows(), |i, _| by[i]);
            (&self.cover * &by).dot(&by).max(0.0).sqrt()
        };
        let (c, s) = (self.cosine / amplitude, self.sine / amplitude);
        let phase = (-s).atan2(c) - self.number * middle;
        let wavelength = TAU / self.number;
        Some(Wave {
            amplitude: (amplitude, std([c, s, 0.0])),
            phase: (
                (phase + std::f64::consts::PI).rem_euclid(TAU) - std::f64::consts::PI,
                std([s / amplitude, -c / amplitude, -middle]),
            ),
            wavelength: (wavelength, std([0.0, 0.0, wavelength / self.number])),
        })
    }
}
