//! Force that repeats over position, in one recording: detents, a ratchet, bumps, grain.
//!
//! While the body slides in direction d (+ or −), its force is
//!
//! > F = m·a + k·x + q·x² + P_d(v) + Σ_h A(d,h)·cos(2πh·x/λ) + B(d,h)·sin(2πh·x/λ),   h = 1 … 3
//!
//! P_d is a parabola in speed: friction. The sums are the *texture*, with the *period* λ. Columns and force pass the same
//! filter, so the filter takes nothing off an amplitude. The amplitude of a direction is that of a sine with the same power,
//! A_d² = Σ_h A(d,h)² + B(d,h)².
//!
//! **The period.** One harmonic at a time explains a power S(f) of the force at spatial frequency f; f runs from two
//! periods in the stroke up to what the filter passes at the median speed. A line is a local maximum of S that is
//! [`NARROW`] times the median of S within an octave on both sides, computed after the line is removed: a friction law that is
//! not a parabola leaves a slope in S, not a line. Gauss-Newton steps then fit λ with all harmonics.
//!
//! **Beyond noise.** The fit is repeated without each tenth of the recording. A texture shows if the n = 10 pseudo-values
//! c_k of its strongest line agree: R = |Σ c_k|²/(n·Σ|c_k|²). Noise exceeds R with probability (1 − R)^(n − 1); at
//! [`COHERENT`] that is 10⁻⁶, which a thousand frequencies leave at 10⁻³. Its amplitude must also be
//! just noticeable: the misfit of the parabola is smaller than that.

use crate::Jnd;
use crate::interval::BLOCKS;
use identify::Signals;
use nalgebra::{Complex, DMatrix, DVector};
use signals::{Basis, dot, quantile, subtract_scaled};
use std::f64::consts::TAU;

/// Harmonics of a texture.
pub(crate) const HARMONICS: usize = 3;
/// Least periods in the stroke.
const FEWEST_PERIODS: f64 = 2.0;
/// Frequencies that are tried per period in the stroke.
const OVERSAMPLING: f64 = 5.0;
/// Power of a line over the median within an octave on both sides.
const NARROW: f64 = 8.0;
/// Least agreement of the parts of a recording.
const COHERENT: f64 = 0.785;
/// Most frequencies that are tried.
const MOST_FREQUENCIES: usize = 3000;
/// Lines that are looked at, strongest first.
const CANDIDATES: usize = 5;
/// Least power of a subharmonic over that of the strongest line, to be the fundamental: a third of its amplitude. A body
/// that skips every other valley has a weaker one.
const SUBHARMONIC: f64 = 0.1;
/// Least amplitude, JND.
const NOTICED: f64 = 1.0;
/// Time that is excluded after a reversal, s: a coupling rings.
const RINGING: f64 = 0.05;
/// Rows to which excluded samples contribute more than this through the filter are excluded too.
const LEAK: f64 = 0.02;
/// Rows below which nothing is fitted.
const FEWEST_ROWS: usize = 400;
/// Gauss-Newton steps of the period.
const STEPS: usize = 6;
/// Power of residuals, as a share of the force's, below which a column adds nothing of its own.
const NOTHING: f64 = 1e-10;

/// Harmonics of both directions, N, with the period they were fitted at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lines {
    /// Forward and reverse; A + iB.
    pub lines: [[Complex<f64>; HARMONICS]; 2],
    /// m.
    pub period: f64,
}

impl Lines {
    pub(crate) fn power(&self, direction: usize) -> f64 {
        self.lines[direction].iter().map(Complex::norm_sqr).sum()
    }

    /// Harmonic with the largest power in both directions.
    pub(crate) fn strongest(&self) -> usize {
        let of = |h: usize| self.lines[0][h].norm_sqr() + self.lines[1][h].norm_sqr();
        (0..HARMONICS).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap_or(0)
    }
}

/// A texture, and what it is without each part of the recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Texture {
    pub whole: Lines,
    pub left_out: Vec<Lines>,
    /// Amplitude by direction, N, less what noise adds.
    pub amplitude: [f64; 2],
    /// What noise adds to the square of it, N².
    pub noise: [f64; 2],
    /// Mean friction by direction, N.
    pub level: [f64; 2],
}

/// Rows of a recording in which texture is looked for.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    signals: Signals,
    /// 1 forward, −1 in reverse, 0 where the body does not slide: of each sample.
    ways: Vec<f64>,
    /// m, from which phases count.
    centre: f64,
    /// Distance between the ends of sliding, m.
    stroke: f64,
    /// Highest spatial frequency, 1/m.
    highest: f64,
    /// Rows that are used.
    used: Vec<usize>,
    force: Vec<f64>,
    position: Vec<f64>,
    /// 1 forward, −1 in reverse, by row.
    way: Vec<f64>,
    block: Vec<usize>,
    base: Vec<Vec<f64>>,
}

impl Rows {
    /// None if too little slides, or over no distance.
    pub(crate) fn new(signals: Signals, band: f64) -> Option<Self> {
        let ways = ways(&signals.velocity, band, signals.dt);
        let idle = idle(&signals.velocity, band, signals.dt);
        let columns = [&ways, &idle, &signals.force, &signals.acceleration, &signals.velocity];
        let [way, idle, force, acceleration, velocity] = columns.map(|c| signals.condition(c));
        let position = signals.condition(&signals.position);
        let used: Vec<usize> =
            (0..force.len()).filter(|&i| idle[i].abs() <= LEAK && way[i].abs() > 0.5).collect();
        if used.len() < FEWEST_ROWS {
            return None;
        }
        let pick = |column: &[f64]| used.iter().map(|&i| column[i]).collect::<Vec<f64>>();
        let [force_used, acceleration, velocity, place] =
            [&force, &acceleration, &velocity, &position].map(|c| pick(c));
        let way: Vec<f64> = pick(&way).iter().map(|w| w.signum()).collect();
        let (low, high) = (quantile(&place, 0.01), quantile(&place, 0.99));
        let centre = 0.5 * (low + high);
        let stroke = high - low;
        let speeds: Vec<f64> = velocity.iter().map(|v| v.abs()).collect();
        let passed = signals.preparation().cutoff_hz.unwrap_or(0.25 / signals.dt);
        let (fast, top) = (quantile(&speeds, 0.5), quantile(&speeds, 0.98));
        let highest = passed / fast;
        if !(stroke > 0.0 && highest.is_finite() && highest * stroke > FEWEST_PERIODS) {
            return None;
        }
        let at: Vec<f64> = place.iter().map(|x| (x - centre) / stroke).collect();
        let mut base = vec![acceleration, at.clone(), at.iter().map(|x| x * x).collect()];
        for sign in [1.0, -1.0] {
            for power in 0..3 {
                let of = |(v, w): (&f64, &f64)| if *w == sign { (v / top).powi(power) } else { 0.0 };
                base.push(velocity.iter().zip(&way).map(of).collect());
            }
        }
        let count = force.len().max(1);
        let block = used.iter().map(|i| i * BLOCKS / count).collect();
        let position = place;
        Some(Self {
            signals,
            ways,
            centre,
            stroke,
            highest,
            used,
            force: force_used,
            position,
            way,
            block,
            base,
        })
    }

    /// The texture with the period that shows, if one does.
    pub(crate) fn texture(&self) -> Option<Texture> {
        let fundamental = self.fundamental()?;
        let texture = self.texture_at(1.0 / fundamental, true)?;
        let noticed = (0..2).any(|d| {
            let jnd = Jnd::force(texture.level[d] + texture.amplitude[d]);
            texture.amplitude[d] > NOTICED * jnd
        });
        (noticed && coherence(&texture) > COHERENT).then_some(texture)
    }

    /// What repeats over the period of another recording, m; None if these rows do not tell it.
    pub(crate) fn texture_beside(&self, period: f64) -> Option<Texture> {
        let told = period * self.highest >= 1.0 && self.stroke >= FEWEST_PERIODS * period;
        if told { self.texture_at(period, false) } else { None }
    }

    /// What repeats over `period`, m; with `free`, the period is refined.
    pub(crate) fn texture_at(&self, period: f64, free: bool) -> Option<Texture> {
        let mut period = period;
        if free {
            let start = period;
            for _ in 0..STEPS {
                let columns = self.harmonics(period);
                let lines = Fit::new(self, &columns, None)?.lines(period)?;
                let slope = self.slope(&lines);
                let step = Fit::new(self, &columns, Some(&slope))?.step?;
                let longest = 0.2 * period * period / self.stroke;
                period += step.clamp(-longest, longest);
            }
            // left its line
            if !((1.0 / period - 1.0 / start).abs() * self.stroke < 1.0) {
                return None;
            }
        }
        let columns = self.harmonics(period);
        let first = Fit::new(self, &columns, None)?.lines(period)?;
        let slope = free.then(|| self.slope(&first));
        let fit = Fit::new(self, &columns, slope.as_deref())?;
        let whole = fit.lines(period)?;
        let left_out = (0..BLOCKS).map(|k| fit.without(k, period)).collect::<Option<Vec<_>>>()?;
        let noise = [0, 1].map(|d| variance(&left_out, d));
        let amplitude = [0, 1].map(|d| (whole.power(d) - noise[d]).max(0.0).sqrt());
        let mut level = [0.0; 2];
        for (d, sign) in [1.0, -1.0].into_iter().enumerate() {
            let of = |(f, w): (&f64, &f64)| (*w == sign).then_some(f * sign);
            let forces: Vec<f64> = self.force.iter().zip(&self.way).filter_map(of).collect();
            level[d] = (forces.iter().sum::<f64>() / forces.len().max(1) as f64).abs();
        }
        Some(Texture { whole, left_out, amplitude, noise, level })
    }

    /// Columns of all harmonics in both directions, cosine and sine, behind the filter.
    fn harmonics(&self, period: f64) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        for sign in [1.0, -1.0] {
            for h in 1..=HARMONICS {
                // what the filter does not pass cannot be told
                if h > 1 && h as f64 / period > self.highest {
                    continue;
                }
                let turn = TAU * h as f64 / period;
                for wave in [f64::cos, f64::sin] {
                    columns.push(self.filtered(|x, way| if way == sign { wave(turn * x) } else { 0.0 }));
                }
            }
        }
        columns
    }

    /// Force of a texture at each row of the signals, N; 0 where the body does not slide.
    pub(crate) fn force_of(&self, texture: &Texture) -> Vec<f64> {
        let Lines { lines, period } = &texture.whole;
        let of = |(x, way): (&f64, &f64)| {
            if *way == 0.0 {
                return 0.0;
            }
            let by = |(h, c): (usize, &Complex<f64>)| {
                let (sine, cosine) = (TAU * (h + 1) as f64 / period * (x - self.centre)).sin_cos();
                c.re * cosine + c.im * sine
            };
            lines[usize::from(*way < 0.0)].iter().enumerate().map(by).sum()
        };
        let raw: Vec<f64> = self.signals.position.iter().zip(&self.ways).map(of).collect();
        self.signals.condition(&raw)
    }

    /// Derivative of the texture by its period.
    fn slope(&self, lines: &Lines) -> Vec<f64> {
        let period = lines.period;
        self.filtered(|x, way| {
            if way == 0.0 {
                return 0.0;
            }
            let of = &lines.lines[usize::from(way < 0.0)];
            let by = |(h, c): (usize, &Complex<f64>)| {
                let turn = TAU * (h + 1) as f64 / period;
                let (sine, cosine) = (turn * x).sin_cos();
                turn * x / period * (c.re * sine - c.im * cosine)
            };
            of.iter().enumerate().map(by).sum()
        })
    }

    fn filtered(&self, of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let samples = self.signals.position.iter().zip(&self.ways);
        let raw: Vec<f64> = samples.map(|(x, way)| of(x - self.centre, *way)).collect();
        let rows = self.signals.condition(&raw);
        self.used.iter().map(|&i| rows[i]).collect()
    }

    /// Spatial frequency that everything else is a harmonic of, 1/m.
    fn fundamental(&self) -> Option<f64> {
        let mut scan = Scan::new(self);
        scan.scan(self.highest);
        let line = scan.lines().into_iter().next()?;
        let mut beside = scan.without(line);
        beside.scan(line);
        let lowest = FEWEST_PERIODS / self.stroke;
        let strongest = scan.power(line);
        for part in [3.0, 2.0] {
            let f = line / part;
            if f < lowest {
                continue;
            }
            let power = beside.power(f);
            let around = beside.around(f);
            if power > SUBHARMONIC * strongest && power > NARROW * around {
                return Some(f);
            }
        }
        Some(line)
    }
}

/// 1 where a sample does not slide, as [`ways`] has it.
pub(crate) fn idle(velocity: &[f64], band: f64, dt: f64) -> Vec<f64> {
    ways(velocity, band, dt).iter().map(|w| 1.0 - w.abs()).collect()
}

/// Direction of each sample: 0 slower than `band`, and for [`RINGING`] after a reversal.
fn ways(velocity: &[f64], band: f64, dt: f64) -> Vec<f64> {
    let ringing = (RINGING / dt).ceil() as usize;
    let (mut way, mut since) = (0.0, 0);
    let of = |v: &f64| {
        since += 1;
        if v.abs() > band && v.signum() != way {
            (way, since) = (v.signum(), 0);
        }
        if v.abs() > band && since >= ringing { way } else { 0.0 }
    };
    velocity.iter().map(of).collect()
}

/// Rows without what the baseline explains, thinned.
struct Scan<'a> {
    rows: &'a Rows,
    kept: Vec<usize>,
    force: Vec<f64>,
    basis: Basis,
    /// Frequencies, 1/m, with the power that a line there explains.
    powers: Vec<(f64, f64)>,
}

impl<'a> Scan<'a> {
    fn new(rows: &'a Rows) -> Self {
        let passed = rows.signals.preparation().cutoff_hz.unwrap_or(f64::INFINITY);
        let step = ((0.2 / (passed * rows.signals.dt)) as usize).max(1);
        let kept: Vec<usize> = (0..rows.used.len()).step_by(step).collect();
        let pick = |column: &Vec<f64>| kept.iter().map(|&i| column[i]).collect::<Vec<f64>>();
        let force = pick(&rows.force);
        let mut scan = Self { rows, force, basis: Basis::default(), kept: kept.clone(), powers: Vec::new() };
        for column in &rows.base {
            scan.take_off(&pick(column));
        }
        scan
    }

    /// Adds a column to the basis and takes its share off the force.
    fn take_off(&mut self, column: &[f64]) {
        if self.basis.push(column)
            && let Some(unit) = self.basis.columns().last()
        {
            let share = dot(&self.force, unit);
            subtract_scaled(&mut self.force, share, unit);
        }
    }

    fn columns(&self, frequency: f64) -> [Vec<f64>; 4] {
        let turn = TAU * frequency;
        let mut out = [const { Vec::new() }; 4];
        for &i in &self.kept {
            let (sine, cosine) = (turn * (self.rows.position[i] - self.rows.centre)).sin_cos();
            let forward = self.rows.way[i] > 0.0;
            out[0].push(if forward { cosine } else { 0.0 });
            out[1].push(if forward { sine } else { 0.0 });
            out[2].push(if forward { 0.0 } else { cosine });
            out[3].push(if forward { 0.0 } else { sine });
        }
        out
    }

    /// Power of the force that a line at `frequency` explains, N² times rows.
    fn power(&self, frequency: f64) -> f64 {
        let mut line = Basis::default();
        for column in self.columns(frequency) {
            let own = line.project_out(&self.basis.project_out(&column));
            if dot(&own, &own) > 1e-6 * self.kept.len() as f64 {
                line.push(&own);
            }
        }
        line.captured(&self.force)
    }

    /// Median power that is left within an octave on both sides of a line, once the line is taken off.
    fn around(&self, frequency: f64) -> f64 {
        let beside = self.without(frequency);
        let far = |f: &f64| {
            *f >= 0.5 * frequency && *f <= 2.0 * frequency && (f - frequency).abs() * self.rows.stroke >= 1.0
        };
        let powers: Vec<f64> =
            self.powers.iter().map(|(f, _)| *f).filter(far).map(|f| beside.power(f)).collect();
        if powers.is_empty() { f64::INFINITY } else { quantile(&powers, 0.5) }
    }

    /// Fills the powers up to `highest` 1/m.
    fn scan(&mut self, highest: f64) {
        let step = 1.0 / (OVERSAMPLING * self.rows.stroke);
        let first = (FEWEST_PERIODS * OVERSAMPLING) as usize;
        let last = ((highest / step) as usize).min(MOST_FREQUENCIES);
        self.powers = (first..=last).map(|k| k as f64 * step).map(|f| (f, self.power(f))).collect();
    }

    /// Frequencies of lines, strongest first.
    fn lines(&self) -> Vec<f64> {
        let all = self.rows.force.iter().map(|f| f * f).sum::<f64>() / self.rows.force.len() as f64;
        let least = NOTHING * all * self.kept.len() as f64;
        let mut peaks: Vec<(f64, f64)> = self
            .powers
            .windows(3)
            .filter(|w| w[1].1 > least && w[1].1 >= w[0].1 && w[1].1 >= w[2].1)
            .map(|w| w[1])
            .collect();
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        peaks.truncate(CANDIDATES);
        peaks.into_iter().filter(|(f, power)| *power > NARROW * self.around(*f)).map(|(f, _)| f).collect()
    }

    /// The same without a line and its overtones.
    fn without(&self, frequency: f64) -> Self {
        let mut scan = Self {
            rows: self.rows,
            kept: self.kept.clone(),
            force: self.force.clone(),
            basis: self.basis.clone(),
            powers: Vec::new(),
        };
        // the line lies between two frequencies of the grid
        for shift in [0.0, -0.25, 0.25] {
            for column in self.columns(frequency + shift / (OVERSAMPLING * self.rows.stroke)) {
                scan.take_off(&column);
            }
        }
        scan
    }
}

/// Normal equations of a fit, by part of the recording.
struct Fit {
    parts: Vec<(DMatrix<f64>, DVector<f64>)>,
    /// Columns before the harmonics.
    first: usize,
    /// Harmonics of a direction.
    harmonics: usize,
    has_slope: bool,
    /// Of the period, m.
    step: Option<f64>,
}

impl Fit {
    fn new(rows: &Rows, columns: &[Vec<f64>], slope: Option<&[f64]>) -> Option<Self> {
        let mut all: Vec<&[f64]> = rows.base.iter().chain(columns).map(Vec::as_slice).collect();
        all.extend(slope);
        let n = all.len();
        let mut parts = vec![(DMatrix::zeros(n, n), DVector::zeros(n)); BLOCKS];
        for (k, part) in parts.iter_mut().enumerate() {
            let of: Vec<usize> = (0..rows.block.len()).filter(|&i| rows.block[i] == k).collect();
            let matrix = DMatrix::from_fn(of.len(), n, |i, j| all[j][of[i]]);
            let force = DVector::from_iterator(of.len(), of.iter().map(|&i| rows.force[i]));
            *part = (matrix.tr_mul(&matrix), matrix.tr_mul(&force));
        }
        let first = rows.base.len();
        let mut fit =
            Self { parts, first, harmonics: columns.len() / 4, has_slope: slope.is_some(), step: None };
        let solved = fit.solve(None)?;
        fit.step = slope.is_some().then(|| solved[n - 1]);
        Some(fit)
    }

    fn solve(&self, without: Option<usize>) -> Option<DVector<f64>> {
        let n = self.parts[0].1.len();
        let kept = self.parts.iter().enumerate().filter(|(k, _)| Some(*k) != without);
        let (squares, products) =
            kept.fold((DMatrix::zeros(n, n), DVector::zeros(n)), |(a, b), (_, (x, y))| (a + x, b + y));
        let scale = squares.diagonal().map(|d: f64| d.sqrt().recip());
        if scale.iter().any(|s| !s.is_finite()) {
            return None;
        }
        let scaled = squares.map_with_location(|i, j, x| x * scale[i] * scale[j]);
        Some(scaled.cholesky()?.solve(&products.component_mul(&scale)).component_mul(&scale))
            .filter(|x| x.iter().all(|x| x.is_finite()))
    }

    fn of(&self, solved: &DVector<f64>, period: f64) -> Lines {
        let mut lines = [[Complex::new(0.0, 0.0); HARMONICS]; 2];
        for (d, direction) in lines.iter_mut().enumerate() {
            for (h, line) in direction.iter_mut().enumerate().take(self.harmonics) {
                let at = self.first + 2 * (d * self.harmonics + h);
                *line = Complex::new(solved[at], solved[at + 1]);
            }
        }
        let step = if self.has_slope { solved[solved.len() - 1] } else { 0.0 };
        Lines { lines, period: period + step }
    }

    fn lines(&self, period: f64) -> Option<Lines> {
        let lines = self.of(&self.solve(None)?, period);
        Some(Lines { period, ..lines })
    }

    fn without(&self, part: usize, period: f64) -> Option<Lines> {
        Some(self.of(&self.solve(Some(part))?, period))
    }
}

/// Agreement of the parts about the strongest line: 1 if all are the same, about 1/n of noise.
fn coherence(texture: &Texture) -> f64 {
    let h = texture.whole.strongest();
    let n = texture.left_out.len() as f64;
    let (mut together, mut apart) = (0.0, 0.0);
    for d in 0..2 {
        let whole = texture.whole.lines[d][h];
        let pseudo = texture.left_out.iter().map(|l| whole * n - l.lines[d][h] * (n - 1.0));
        let (sum, squares) =
            pseudo.fold((Complex::new(0.0, 0.0), 0.0), |(sum, squares), c| (sum + c, squares + c.norm_sqr()));
        together += sum.norm_sqr();
        apart += n * squares;
    }
    if apart > 0.0 { together / apart } else { 0.0 }
}

/// What noise adds to the square of the amplitude, N²: the jackknife's.
fn variance(left_out: &[Lines], direction: usize) -> f64 {
    let n = left_out.len() as f64;
    (0..HARMONICS)
        .map(|h| {
            let mean = left_out.iter().map(|l| l.lines[direction][h]).sum::<Complex<f64>>() / n;
            left_out.iter().map(|l| (l.lines[direction][h] - mean).norm_sqr()).sum::<f64>() * (n - 1.0) / n
        })
        .sum()
}
