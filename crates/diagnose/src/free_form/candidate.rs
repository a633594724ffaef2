//! What a free form may depend on, and where its knots stand.

use crate::library::design_matrix::DesignMatrix;
use friction::{Coordinate, Factor, FreeForm, FreeFormState, Knots, MAX_KNOTS, MAX_VALUES};
use signals::quantile;
use std::sync::{Arc, Mutex};

/// Coordinates, factor and memory of a free form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    pub over: Coordinate,
    pub across: Option<Coordinate>,
    pub times: Factor,
    /// Time constant of what was slid or moved, s.
    pub memory: f64,
    /// The moment of a change, s since the start; everything else is smooth.
    pub change: Option<f64>,
}

/// How fine a free form is.
#[derive(Debug, Clone, Copy)]
pub struct Fineness {
    /// Knots on its first axis and, of a map, on the other.
    pub knots: (usize, usize),
    /// Numbers of free directions of its values that are tried: the smoothness of a spline. A knot that few blocks tell of, such as
    /// the highest speed or a stretch of time, is hardly determined where they are held out, unless the curve is smooth.
    pub freedom: &'static [usize],
}

/// Time constants of what was slid or moved, as shares of the length of the longest recording.
const MEMORIES: [f64; 4] = [0.003, 0.01, 0.03, 0.1];

/// What a form is tried with at first, and what the best are tried with besides.
#[derive(Debug)]
pub struct Ladder {
    pub first: &'static [Fineness],
    pub besides: &'static [Fineness],
}

const SMOOTH: Fineness = Fineness { knots: (16, 0), freedom: &[6, 12] };
const SMOOTHER: Fineness = Fineness { knots: (22, 0), freedom: &[3, 4, 5, 7, 10, 14, 18, 22] };
const CURVE: Ladder = Ladder { first: &[SMOOTH], besides: &[SMOOTHER] };
/// A detent, a bent tooth or a ripple that grows along the stroke is much shorter than the stroke.
const STROKE: Ladder = Ladder {
    first: &[SMOOTH, Fineness { knots: (48, 0), freedom: &[20, 36] }],
    besides: &[SMOOTHER, Fineness { knots: (64, 0), freedom: &[18, 28, 40, 55] }],
};
/// What a brake or a bent guide does to a viscous coefficient is shorter than the stroke, but no ripple.
const GUIDE: Ladder =
    Ladder { first: &[SMOOTH], besides: &[SMOOTHER, Fineness { knots: (48, 0), freedom: &[12, 18, 28] }] };
const TIME: Ladder = Ladder {
    first: &[Fineness { knots: (20, 0), freedom: &[6, 13] }],
    besides: &[Fineness { knots: (32, 0), freedom: &[3, 4, 6, 9, 13, 18, 28] }],
};
/// What relaxes is a spring, and hardly bent: a curve of many bends over a memory stands for anything in a motion that repeats.
const RELAXES: Ladder = Ladder {
    first: &[Fineness { knots: (2, 0), freedom: &[2] }, Fineness { knots: (4, 0), freedom: &[4] }],
    besides: &[],
};
const CUT: Ladder = Ladder {
    first: &[Fineness { knots: (14, 0), freedom: &[7, 14] }],
    besides: &[
        Fineness { knots: (5, 0), freedom: &[5] },
        Fineness { knots: (8, 0), freedom: &[8] },
        Fineness { knots: (22, 0), freedom: &[4, 6, 9, 13, 22] },
    ],
};
const MAP: Ladder = Ladder {
    first: &[Fineness { knots: (6, 6), freedom: &[8, 16] }],
    besides: &[Fineness { knots: (10, 10), freedom: &[6, 9, 13, 18, 25, 35, 50] }],
};
const CHANGE: Ladder = Ladder { first: &[Fineness { knots: (2, 0), freedom: &[2] }], besides: &[] };

/// Most samples that decide where knots stand.
const SAMPLES: usize = 20_000;

/// Whether a curve over this is cut after its smoothest directions. Others are smoothing splines; but what a penalty takes off
/// a curve over the velocity the viscous coefficient gives back, and neither is right beyond the speeds that were there. What
/// relaxes has few directions, all free.
pub fn is_cut(over: Coordinate) -> bool {
    use Coordinate::{Acceleration, Moved, Speed, Velocity};
    matches!(over, Velocity | Speed | Acceleration | Moved)
}

/// Every candidate on a motion of `seconds`.
fn all(seconds: f64) -> Vec<Candidate> {
    use Coordinate::{
        Acceleration, DistanceSinceReversal, Moved, Position, Slid, Speed, Time, TimeSinceReversal, Velocity,
    };
    use Factor::{Direction, One, Velocity as Viscous};
    let curve = Candidate::curve;
    let map = |over, across| Candidate { across: Some(across), ..curve(over, One) };
    let mut out = vec![
        curve(Position, One),
        curve(Position, Direction),
        curve(Position, Viscous),
        curve(Velocity, One),
        curve(Speed, Direction),
        curve(Acceleration, One),
        curve(Acceleration, Direction),
        curve(Time, One),
        curve(Time, Direction),
        curve(Time, Viscous),
        curve(DistanceSinceReversal, Direction),
        curve(TimeSinceReversal, Direction),
        map(Position, Velocity),
        map(Position, Acceleration),
        map(Position, Time),
        map(Time, Velocity),
    ];
    for share in MEMORIES {
        for (over, times) in [(Slid, Direction), (Slid, Viscous), (Moved, One)] {
            out.push(Candidate { memory: share * seconds, ..curve(over, times) });
        }
    }
    out
}

/// A free form with its columns.
type Columns = Option<(FreeForm<f64>, Arc<Vec<Vec<f64>>>)>;

/// A candidate with its numbers of knots.
type Key = (Candidate, usize, usize);

/// The candidates on a design matrix. Columns are kept, because most are asked for several times.
pub struct Library {
    pub candidates: Vec<Candidate>,
    /// Candidates over an acceleration that is derived from the position.
    derived: Vec<Candidate>,
    kept: Mutex<Vec<(Key, Columns)>>,
}

/// Most rows of which columns are kept.
const KEPT: usize = 20_000;

impl Library {
    /// The candidates on a design matrix, without those of [`Self::widen`].
    pub fn new(design: &DesignMatrix) -> Self {
        let seconds = design.tracks.iter().map(|t| t.len() as f64 * t.raw.dt).fold(0.0, f64::max);
        // derived from the position alone, its noise is that of the mass's column: noise would depend on it
        let measured = design.tracks.iter().all(|t| t.raw.velocity.is_some() || t.raw.acceleration.is_some());
        let (candidates, derived) =
            all(seconds).into_iter().partition(|c| measured || !c.reads(Coordinate::Acceleration));
        Self { candidates, derived, kept: Mutex::default() }
    }

    /// Adds the candidates over a derived acceleration, for an error that neither names nor the others explain; whether
    /// there are any.
    pub fn widen(&mut self) -> bool {
        let any = !self.derived.is_empty();
        self.candidates.append(&mut self.derived);
        any
    }

    /// Candidates that depend on the motion alone.
    pub fn of_motion(&self) -> impl Iterator<Item = Candidate> {
        self.candidates.iter().copied().filter(|c| !c.reads(Coordinate::Time))
    }

    /// The form of a candidate with this many knots, and its columns.
    pub fn get(&self, design: &DesignMatrix, candidate: Candidate, first: usize, second: usize) -> Columns {
        let key = (candidate, first, second);
        let known = |kept: &Vec<(Key, Columns)>| kept.iter().find(|(k, _)| *k == key).map(|(_, c)| c.clone());
        if let Some(columns) = self.kept.lock().ok().and_then(|kept| known(&kept)) {
            return columns;
        }
        let form = candidate.form(design, first, second);
        let columns = form.map(|form| (form, Arc::new(design.free_columns(&form))));
        if design.share.len() <= KEPT
            && let Ok(mut kept) = self.kept.lock()
        {
            kept.push((key, columns.clone()));
        }
        columns
    }
}

impl Candidate {
    /// A curve over one coordinate.
    fn curve(over: Coordinate, times: Factor) -> Self {
        Self { over, across: None, times, memory: 1.0, change: None }
    }

    /// What is multiplied by `times` is another from the moment `at` on, s since the start.
    pub fn change(at: f64, times: Factor) -> Self {
        Self { change: Some(at), ..Self::curve(Coordinate::Time, times) }
    }

    /// Whether it depends on a coordinate.
    pub fn reads(&self, coordinate: Coordinate) -> bool {
        self.over == coordinate || self.across == Some(coordinate)
    }

    /// How fine it is; `much` is left.
    pub fn ladder(&self, much: bool) -> &'static Ladder {
        match (self.change, self.across, self.over) {
            (Some(_), ..) => &CHANGE,
            (None, Some(_), _) => &MAP,
            (None, None, Coordinate::Time) => &TIME,
            (None, None, Coordinate::Moved) => &RELAXES,
            (None, None, over) if is_cut(over) => &CUT,
            (None, None, Coordinate::Position) if much && self.times == Factor::Velocity => &GUIDE,
            (None, None, Coordinate::Position) if much => &STROKE,
            (None, None, _) => &CURVE,
        }
    }

    /// The form with knots where the motion is: `first` on its first axis, `second` on the other. None where a coordinate
    /// does not change.
    pub fn form(&self, design: &DesignMatrix, first: usize, second: usize) -> Option<FreeForm<f64>> {
        if let Some(at) = self.change {
            return FreeForm::curve(self.over, self.times, at_a_moment(design, at)?, &[0.0; 2]).ok();
        }
        let placeholder = Knots::new(&[0.0, 1.0]).ok()?;
        let mut probe = FreeForm::curve(self.over, self.times, placeholder, &[0.0; 2]).ok()?;
        probe.memory = self.memory.max(1e-6);
        if let Some(across) = self.across {
            probe = probe.map(across, placeholder, &[0.0; 4]).ok()?;
        }
        let values = design.walk(FreeFormState::default, |state, motion| probe.coordinates(state, motion));
        let every = (values.iter().map(Vec::len).sum::<usize>() / SAMPLES).max(1);
        let masks = design.tracks.iter().flat_map(|t| &t.mask);
        let used: Vec<(f64, Option<f64>)> = values
            .iter()
            .flatten()
            .zip(masks)
            .step_by(every)
            .filter(|(_, mask)| **mask > 0.5)
            .map(|(v, _)| *v)
            .collect();
        let u: Vec<f64> = used.iter().map(|v| v.0).collect();
        let knots = knots(self.over, &u, first)?;
        let zero = [0.0; MAX_VALUES];
        let mut form = FreeForm::curve(self.over, self.times, knots, &zero[..knots.places().len()]).ok()?;
        form.memory = probe.memory;
        let Some(across) = self.across else { return Some(form) };
        let w: Vec<f64> = used.iter().filter_map(|v| v.1).collect();
        let other = self::knots(across, &w, second)?;
        form.map(across, other, zero.get(..knots.places().len() * other.places().len())?).ok()
    }
}

/// Knots over the range of the values: the mean of even spacing and of quantiles. Distances and times since an event are
/// spaced in their logarithm.
fn knots(of: Coordinate, values: &[f64], count: usize) -> Option<Knots<f64>> {
    let logarithmic =
        matches!(of, Coordinate::DistanceSinceReversal | Coordinate::TimeSinceReversal | Coordinate::Slid);
    let used: Vec<f64> =
        values.iter().copied().filter(|x| x.abs() < 1e20 && (!logarithmic || *x > 0.0)).collect();
    if used.len() < 4 * count {
        return None;
    }
    let scale = |x: f64| if logarithmic { x.ln() } else { x };
    let back = |x: f64| if logarithmic { x.exp() } else { x };
    let ends = if logarithmic { 0.02 } else { 0.002 };
    let (low, high) = (scale(quantile(&used, ends)), scale(quantile(&used, 1.0 - ends)));
    let span = high - low;
    if !(span > 1e-9 * low.abs().max(high.abs())) || !span.is_finite() {
        return None;
    }
    let count = count.min(MAX_KNOTS);
    let mut places: Vec<f64> = (0..count)
        .map(|k| {
            let share = k as f64 / (count - 1) as f64;
            let by_number = scale(quantile(&used, share)).clamp(low, high);
            back(0.5 * (low + span * share + by_number))
        })
        .collect();
    places.dedup_by(|a, b| scale(*a) - scale(*b) <= 1e-3 * span);
    Knots::new(&places).ok()
}

/// Knots of a change `at` a moment, s since the start.
fn at_a_moment(design: &DesignMatrix, at: f64) -> Option<Knots<f64>> {
    let rows = design.tracks.iter().map(|t| t.stride as f64 * t.raw.dt).fold(0.0, f64::max);
    Knots::new(&[at - 0.5 * rows, at + 0.5 * rows]).ok()
}
