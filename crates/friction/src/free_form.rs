//! Physics without a name: a smooth curve or map over coordinates of the motion.

use crate::{Invalid, Motion, Scalar, in_range, mean_decay};

/// Largest number of knots on one axis.
pub const MAX_KNOTS: usize = 72;
/// Largest number of values of a curve or map.
pub const MAX_VALUES: usize = 100;

/// What a free form may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coordinate {
    /// Position, m or rad.
    #[default]
    Position,
    /// Velocity, m/s or rad/s.
    Velocity,
    /// Its magnitude.
    Speed,
    /// Change of velocity over a step, m/s² or rad/s².
    Acceleration,
    /// Time since the state began, s.
    Time,
    /// Distance slid since the direction last changed, m or rad; far where it has not changed yet.
    DistanceSinceReversal,
    /// Time since then, s.
    TimeSinceReversal,
    /// Distance slid in the last moments, m or rad: ∫ |v| dt that fades with the time constant [`FreeForm::memory`].
    Slid,
    /// Displacement in the last moments, m or rad: ∫ v dt that fades likewise. A spring over it is a Maxwell element.
    Moved,
}

impl Coordinate {
    /// Every coordinate.
    pub const ALL: [Self; 9] = [
        Self::Position,
        Self::Velocity,
        Self::Speed,
        Self::Acceleration,
        Self::Time,
        Self::DistanceSinceReversal,
        Self::TimeSinceReversal,
        Self::Slid,
        Self::Moved,
    ];

    /// Name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Time => "time",
            Self::DistanceSinceReversal => "distance_since_reversal",
            Self::TimeSinceReversal => "time_since_reversal",
            Self::Slid => "slid",
            Self::Moved => "moved",
        }
    }

    /// Whether it fades with the time constant of the form.
    #[must_use]
    pub const fn fades(self) -> bool {
        matches!(self, Self::Slid | Self::Moved)
    }

    /// The coordinate of this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.id() == id)
    }
}

/// What multiplies the curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Factor {
    /// Nothing: a force of its own.
    #[default]
    One,
    /// The direction of motion: the curve is a friction level.
    Direction,
    /// The velocity: the curve is a viscous coefficient, N·s/m or N·m·s/rad.
    Velocity,
}

impl Factor {
    /// Every factor.
    pub const ALL: [Self; 3] = [Self::One, Self::Direction, Self::Velocity];

    /// Name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::Direction => "direction",
            Self::Velocity => "velocity",
        }
    }

    /// The factor of this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.id() == id)
    }
}

/// Increasing places on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knots<S> {
    at: [S; MAX_KNOTS],
    count: usize,
}

impl<S: Scalar> Knots<S> {
    /// # Errors
    /// Fewer than two knots, more than [`MAX_KNOTS`], or knots that do not increase.
    pub fn new(places: &[S]) -> Result<Self, Invalid> {
        in_range("knots", places.len() as f64, 2.0, MAX_KNOTS as f64)?;
        let mut at = [S::zero(); MAX_KNOTS];
        at[..places.len()].copy_from_slice(places);
        for (i, x) in places.iter().enumerate() {
            let least = if i == 0 { -1e30 } else { places[i - 1].re() };
            in_range("knots", *x, least, 1e30)?;
            if i > 0 && *x <= places[i - 1] {
                return Err(Invalid { parameter: "knots", value: x.re(), min: least, max: 1e30 });
            }
        }
        Ok(Self { at, count: places.len() })
    }

    /// The places.
    #[must_use]
    pub fn places(&self) -> &[S] {
        &self.at[..self.count]
    }

    /// First of four neighbouring knots and the weights of their values at `u`: cubic between knots with the slope of the
    /// parabola through three of them, straight at the ends, constant beyond.
    fn weights(&self, u: S) -> (usize, [S; 4]) {
        let (zero, one) = (S::zero(), S::one());
        let k = self.places();
        let u = u.clamp(k[0], k[k.len() - 1]);
        let j = k.partition_point(|x| *x <= u).clamp(1, k.len() - 1) - 1;
        let h = k[j + 1] - k[j];
        let t = (u - k[j]) / h;
        // weights of the values at j − 1, j, j + 1, j + 2
        let mut w = [zero; 4];
        let two = one + one;
        let three = two + one;
        w[1] = one - t * t * (three - two * t);
        w[2] = t * t * (three - two * t);
        let mut slope = |at: usize, times: S| {
            // shares of the slopes before and behind the knot
            let (before, behind) =
                (at.checked_sub(1).map(|b| k[at] - k[b]), k.get(at + 1).map(|n| *n - k[at]));
            let (share_before, share_behind) = match (before, behind) {
                (Some(b), Some(n)) => (n / (b + n), b / (b + n)),
                (Some(_), None) => (one, zero),
                _ => (zero, one),
            };
            let own = at + 1 - j;
            if let Some(b) = before {
                w[own] += times * share_before / b;
                w[own - 1] -= times * share_before / b;
            }
            if let Some(n) = behind.filter(|_| share_behind > zero) {
                w[own + 1] += times * share_behind / n;
                w[own] -= times * share_behind / n;
            }
        };
        slope(j, h * t * (one - t) * (one - t));
        slope(j + 1, -h * t * t * (one - t));
        (j, w)
    }
}

/// A force over one coordinate or two, given by its values at knots.
///
/// F = f(u) or f(u, w), times the direction or the velocity if wanted. Between knots f is cubic and as smooth as its slope;
/// beyond the first and the last it keeps their values.
///
/// ```
/// use friction::{Coordinate, Factor, FreeForm, FreeFormState, Knots, Motion};
///
/// // a detent of 0.3 N about the middle
/// let knots = Knots::new(&[-0.02, -0.01, 0.0, 0.01, 0.02])?;
/// let detent = FreeForm::curve(Coordinate::Position, Factor::One, knots, &[0.0, -0.3, 0.0, 0.3, 0.0])?;
/// let mut state = FreeFormState::default();
/// let mut at = |position: f64| detent.step(&mut state, &Motion { dt: 1e-3, position, ..Motion::default() });
/// assert_eq!(at(0.01), 0.3);
/// assert_eq!(at(0.5), 0.0); // beyond its knots
/// # Ok::<(), friction::Invalid>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeForm<S> {
    /// First coordinate.
    pub over: Coordinate,
    /// Second coordinate of a map.
    pub across: Option<(Coordinate, Knots<S>)>,
    /// What multiplies it.
    pub times: Factor,
    /// Time constant of a coordinate that fades, s.
    pub memory: S,
    /// Knots of the first coordinate.
    pub knots: Knots<S>,
    values: [S; MAX_VALUES],
}

/// What a free form remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeFormState<S> {
    time: S,
    velocity: Option<S>,
    way: S,
    distance: S,
    since: S,
    slid: S,
    moved: S,
}

impl<S: Scalar> Default for FreeFormState<S> {
    fn default() -> Self {
        let (zero, far) = (S::zero(), S::lit(1e30));
        Self { time: zero, velocity: None, way: zero, distance: far, since: far, slid: zero, moved: zero }
    }
}

impl<S: Scalar> FreeForm<S> {
    /// A curve: one value at each knot.
    ///
    /// # Errors
    /// Another number of values than knots, or a value that is not finite.
    pub fn curve(over: Coordinate, times: Factor, knots: Knots<S>, values: &[S]) -> Result<Self, Invalid> {
        let (across, memory) = (None, S::one());
        Self { over, across, times, memory, knots, values: [S::zero(); MAX_VALUES] }.with_values(values)
    }

    /// The same with a second coordinate: for each knot of the first the values at all knots of the second.
    ///
    /// # Errors
    /// Another number of values than pairs of knots, more than [`MAX_VALUES`], or a value that is not finite.
    pub fn map(self, across: Coordinate, knots: Knots<S>, values: &[S]) -> Result<Self, Invalid> {
        Self { across: Some((across, knots)), ..self }.with_values(values)
    }

    /// The same with other values.
    ///
    /// # Errors
    /// Another number of values, or one that is not finite.
    pub fn with_values(mut self, values: &[S]) -> Result<Self, Invalid> {
        let count = self.count();
        in_range("values", values.len() as f64, count as f64, count.min(MAX_VALUES) as f64)?;
        self.values[..count].copy_from_slice(values);
        self.validate()?;
        Ok(self)
    }

    /// Whether it depends on the time since the start: one part of a recording says nothing about another.
    #[must_use]
    pub fn is_of_time(&self) -> bool {
        self.reads(Coordinate::Time)
    }

    /// Whether it depends on a coordinate.
    #[must_use]
    pub fn reads(&self, coordinate: Coordinate) -> bool {
        self.over == coordinate || self.across.is_some_and(|(c, _)| c == coordinate)
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> usize {
        self.knots.count * self.across.map_or(1, |(_, knots)| knots.count)
    }

    /// The values, the second coordinate running first.
    #[must_use]
    pub fn values(&self) -> &[S] {
        &self.values[..self.count()]
    }

    /// # Errors
    /// A value that is not finite, or a memory of no time.
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("memory_s", self.memory, 1e-6, 1e6)?;
        self.values().iter().try_for_each(|v| in_range("values", *v, -1e9, 1e9))
    }

    /// Advances the state by a step, and calls `each` with the index of every value that matters there and its weight.
    pub fn weights(&self, state: &mut FreeFormState<S>, motion: &Motion<S>, mut each: impl FnMut(usize, S)) {
        if !motion.is_finite() {
            return;
        }
        state.advance(self.memory, motion);
        let times = match self.times {
            Factor::One => S::one(),
            Factor::Direction => motion.velocity.sgn(),
            Factor::Velocity => motion.velocity,
        };
        let (first, weights) = self.knots.weights(state.at(self.over, motion));
        let second =
            self.across.as_ref().map(|(c, knots)| (knots.weights(state.at(*c, motion)), knots.count));
        for (i, w) in weights.into_iter().enumerate().filter(|(_, w)| *w != S::zero()) {
            let row = first + i - 1;
            match &second {
                None => each(row, times * w),
                Some(((start, across), count)) => {
                    for (j, a) in across.iter().enumerate().filter(|(_, a)| **a != S::zero()) {
                        each(row * count + start + j - 1, times * w * *a);
                    }
                }
            }
        }
    }

    /// Advances the state by a step and returns the coordinates there.
    pub fn coordinates(&self, state: &mut FreeFormState<S>, motion: &Motion<S>) -> (S, Option<S>) {
        state.advance(self.memory, motion);
        (state.at(self.over, motion), self.across.map(|(c, _)| state.at(c, motion)))
    }

    /// Advances the state by a step and returns the force, N or N·m, positive against positive motion.
    pub fn step(&self, state: &mut FreeFormState<S>, motion: &Motion<S>) -> S {
        let mut force = S::zero();
        self.weights(state, motion, |i, w| force += w * self.values[i]);
        force
    }
}

impl<S: Scalar> FreeFormState<S> {
    fn advance(&mut self, memory: S, motion: &Motion<S>) {
        let zero = S::zero();
        let (dt, slid) = (motion.dt.max(zero), motion.displacement.abs());
        let way = motion.velocity.sgn();
        if way != zero && way != self.way {
            if self.way != zero {
                (self.distance, self.since) = (zero, zero);
            }
            self.way = way;
        }
        let far = S::lit(1e30);
        self.time += dt;
        self.distance = (self.distance + slid).min(far);
        self.since = (self.since + dt).min(far);
        let q = dt / memory;
        let (stays, added) = ((-q).exp(), mean_decay(q));
        self.slid = (self.slid * stays + slid * added).min(far);
        self.moved = (self.moved * stays + motion.displacement * added).clamp(-far, far);
    }

    /// Value of a coordinate after [`Self::advance`].
    fn at(&mut self, coordinate: Coordinate, motion: &Motion<S>) -> S {
        match coordinate {
            Coordinate::Position => motion.position,
            Coordinate::Velocity => motion.velocity,
            Coordinate::Speed => motion.velocity.abs(),
            Coordinate::Acceleration => {
                let before = self.velocity.replace(motion.velocity).unwrap_or(motion.velocity);
                if motion.dt > S::zero() { (motion.velocity - before) / motion.dt } else { S::zero() }
            }
            Coordinate::Time => self.time,
            Coordinate::DistanceSinceReversal => self.distance,
            Coordinate::TimeSinceReversal => self.since,
            Coordinate::Slid => self.slid,
            Coordinate::Moved => self.moved,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn at(form: &FreeForm<f64>, motion: Motion<f64>) -> f64 {
        form.step(&mut FreeFormState::default(), &motion)
    }

    #[test]
    fn straight_lines_are_exact_on_uneven_knots() {
        let places = [-1.0, -0.4, -0.3, 0.2, 0.9, 1.0];
        let values: Vec<f64> = places.iter().map(|x| 2.0 - 3.0 * x).collect();
        let form = FreeForm::curve(Coordinate::Position, Factor::One, Knots::new(&places).unwrap(), &values)
            .unwrap();
        for i in -120..=120 {
            let position = f64::from(i) / 100.0;
            let want = 2.0 - 3.0 * position.clamp(-1.0, 1.0);
            let got = at(&form, Motion { position, ..Motion::default() });
            assert!((got - want).abs() < 1e-12, "{position}: {got} for {want}");
        }
    }

    #[test]
    fn a_sine_is_met_within_the_cube_of_the_step() {
        let places: Vec<f64> = (0..24).map(|i| f64::from(i) / 23.0).collect();
        let values: Vec<f64> = places.iter().map(|x| (6.0 * x).sin()).collect();
        let form = FreeForm::curve(Coordinate::Velocity, Factor::One, Knots::new(&places).unwrap(), &values)
            .unwrap();
        let worst = (60..940).map(|i| f64::from(i) / 1000.0).fold(0.0, |worst: f64, velocity| {
            worst.max((at(&form, Motion { velocity, ..Motion::default() }) - (6.0 * velocity).sin()).abs())
        });
        std::println!("{worst:.1e}");
        assert!(worst < 2e-3);
    }

    #[test]
    fn a_map_of_a_product_is_the_product() {
        let x = Knots::new(&[-1.0, 0.0, 1.0]).unwrap();
        let v = Knots::new(&[-2.0, -1.0, 1.0, 2.0]).unwrap();
        let mut values = Vec::new();
        for i in x.places() {
            values.extend(v.places().iter().map(|j| i * j));
        }
        let form = FreeForm::curve(Coordinate::Position, Factor::One, x, &[0.0; 3])
            .and_then(|f| f.map(Coordinate::Velocity, v, &values))
            .unwrap();
        let got = at(&form, Motion { position: 0.3, velocity: -1.7, ..Motion::default() });
        assert!((got + 0.51).abs() < 1e-12, "{got}");
    }

    #[test]
    fn what_was_slid_fades() {
        let knots = Knots::new(&[0.0, 1.0]).unwrap();
        let mut form = FreeForm::curve(Coordinate::Slid, Factor::Direction, knots, &[0.0, 1.0]).unwrap();
        form.memory = 0.5;
        let mut state = FreeFormState::default();
        let sliding = Motion { dt: 1e-3, velocity: 0.2, displacement: 2e-4, ..Motion::default() };
        let last = (0..5_000).map(|_| form.step(&mut state, &sliding)).last().unwrap();
        assert!((last - 0.2 * 0.5).abs() < 1e-4, "v·τ in the long run: {last}");
    }

    #[test]
    fn a_spring_over_what_was_moved_is_a_maxwell_element() {
        let knots = Knots::new(&[-0.1, 0.1]).unwrap();
        let mut form = FreeForm::curve(Coordinate::Moved, Factor::One, knots, &[-20.0, 20.0]).unwrap();
        form.memory = 0.3;
        let mut state = FreeFormState::default();
        let step = |state: &mut FreeFormState<f64>, displacement: f64| {
            form.step(
                state,
                &Motion { dt: 1e-3, velocity: 1e3 * displacement, displacement, ..Motion::default() },
            )
        };
        let bent = (0..100).map(|_| step(&mut state, -1e-5)).last().unwrap();
        let held = (0..300).map(|_| step(&mut state, 0.0)).last().unwrap();
        // k·v·τ·(1 − e^(−t/τ)) while it moves, then e^(−t/τ) of that
        let want = -200.0 * 0.01 * 0.3 * (1.0 - (-1.0_f64 / 3.0).exp());
        assert!((bent - want).abs() < 1e-6, "{bent} for {want}");
        assert!((held - bent * (-1.0_f64).exp()).abs() < 1e-6, "{held} of {bent}");
    }

    #[test]
    fn distance_begins_anew_at_a_reversal() {
        let knots = Knots::new(&[0.0, 0.01]).unwrap();
        let form = FreeForm::curve(Coordinate::DistanceSinceReversal, Factor::Direction, knots, &[0.0, 1.0])
            .unwrap();
        let mut state = FreeFormState::default();
        let mut go = |velocity: f64, displacement: f64| {
            form.step(&mut state, &Motion { dt: 1e-3, velocity, displacement, ..Motion::default() })
        };
        assert_eq!(go(1.0, 1e-3), 1.0, "before the first reversal it is far");
        assert!((go(-1.0, -1e-3) + 0.1).abs() < 1e-12);
        assert!((go(-1.0, -2e-3) + 0.3).abs() < 1e-12);
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(Knots::new(&[1.0]).is_err());
        assert!(Knots::new(&[1.0, 1.0]).is_err());
        assert!(Knots::new(&[0.0, f64::NAN]).is_err());
        let knots = Knots::new(&[0.0, 1.0]).unwrap();
        assert!(FreeForm::curve(Coordinate::Time, Factor::One, knots, &[1.0]).is_err());
        assert!(FreeForm::curve(Coordinate::Time, Factor::One, knots, &[1.0, f64::INFINITY]).is_err());
    }
}
