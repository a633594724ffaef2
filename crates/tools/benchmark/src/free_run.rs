//! Free run: a plant driven by the recorded force alone.
//!
//! Fourth-order Runge-Kutta between reversals. Where the velocity changes its sign within a step, the step is cut at
//! that moment: the body stands, and friction decides whether it is held or in which direction it goes on. The integrator
//! therefore adds no limit cycle and no creep, and the error stays a smooth function of the parameters.

use crate::drive::Drive;
use crate::plant::Plant;
use friction::Scalar;

/// Position, m, and velocity, m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S> {
    /// m.
    pub position: S,
    /// m/s.
    pub velocity: S,
}

/// Reversals within one step; a body that trembles more is held to its end.
const MOST_REVERSALS: usize = 6;

/// Position at `samples` samples from sample `first` of the drive, m, beginning in `start`.
///
/// A run that leaves ±`bound` m stands still there, so that a fit can turn back from it.
pub fn free_run<S: Scalar>(
    plant: &Plant<S>,
    drive: &Drive,
    first: usize,
    samples: usize,
    start: State<S>,
    bound: f64,
) -> Vec<S> {
    let steps = drive.steps();
    let share = 1.0 / steps as f64;
    let dt = S::lit(drive.dt() * share);
    let dry = plant.has_dry_friction();
    let mut state = start;
    let mut out = Vec::with_capacity(samples);
    for sample in first..first + samples {
        out.push(state.position);
        for step in 0..steps {
            let recorded = drive.over(sample, step as f64 * share, share, plant.delay);
            let force = recorded.map(|f| plant.acting(f));
            state = if dry {
                through_rest(plant, state, force, dt)
            } else {
                sliding(plant, state, force, dt, None)
            };
        }
        let inside = state.velocity.is_finite() && state.position.re().abs() <= bound;
        if !inside {
            state = State { position: S::lit(bound), velocity: S::zero() };
        }
    }
    out
}

/// A step that may come to rest and leave it again.
fn through_rest<S: Scalar>(plant: &Plant<S>, mut state: State<S>, force: [S; 3], dt: S) -> State<S> {
    let zero = S::zero();
    let mut left = dt;
    for _ in 0..MOST_REVERSALS {
        let way = if state.velocity == zero {
            plant.breaks_away(state.position, force[1])
        } else {
            state.velocity.sgn()
        };
        if way == zero {
            return state;
        }
        let end = sliding(plant, state, force, left, Some(way));
        if !(end.velocity * way < zero) {
            return end;
        }
        let share = state.velocity / (state.velocity - end.velocity);
        let stop = sliding(plant, state, force, left * share, Some(way));
        state = State { position: stop.position, velocity: zero };
        left *= S::one() - share;
    }
    state
}

/// One step of Runge and Kutta. With a direction, friction keeps it although the velocity of a stage may not.
fn sliding<S: Scalar>(plant: &Plant<S>, state: State<S>, force: [S; 3], dt: S, way: Option<S>) -> State<S> {
    let creep = S::lit(1e-12);
    let rate = |x: S, v: S, f: S| {
        let felt = match way {
            Some(way) if !(v * way > creep) => way * creep,
            _ => v,
        };
        (v, (f - plant.resistance(x, felt)) / plant.mass)
    };
    let half = dt * S::lit(0.5);
    let State { position: x, velocity: v } = state;
    let (x1, v1) = rate(x, v, force[0]);
    let (x2, v2) = rate(x + half * x1, v + half * v1, force[1]);
    let (x3, v3) = rate(x + half * x2, v + half * v2, force[1]);
    let (x4, v4) = rate(x + dt * x3, v + dt * v3, force[2]);
    let (two, sixth) = (S::lit(2.0), dt / S::lit(6.0));
    State {
        position: x + sixth * (x1 + two * (x2 + x3) + x4),
        velocity: v + sixth * (v1 + two * (v2 + v3) + v4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Between;
    use crate::place::{Place, Way};

    #[test]
    fn sliding_body_stops_where_friction_says_and_stays() {
        let plant = Plant::new(&[Place::Mass, Place::Level(Way::Both)], &[2.0, 3.0]);
        let drive = Drive::new(&[0.0; 300], 1e-3, Between::Held);
        let start = State { position: 0.01, velocity: 0.25 };
        let run = free_run(&plant, &drive, 0, 300, start, 1.0);
        // v² m / 2F
        assert!((run[299] - 0.01 - 0.0625 * 2.0 / 6.0).abs() < 1e-9, "{}", run[299]);
        assert_eq!(run[200], run[299]);
    }

    #[test]
    fn reversal_is_cut_at_its_moment() {
        // forward under −10 N and 3 N of friction, then back with 7 N: both in closed form
        let plant = Plant::new(&[Place::Mass, Place::Level(Way::Both)], &[2.0, 3.0]);
        let drive = Drive::new(&[-10.0; 200], 1e-3, Between::Held);
        let run = free_run(&plant, &drive, 0, 200, State { position: 0.0, velocity: 0.2503 }, 1.0);
        let stop = 0.2503 / 6.5;
        let back = 0.199 - stop;
        let exact = 0.5 * 0.2503 * stop - 0.5 * 3.5 * back * back;
        assert!((run[199] - exact).abs() < 1e-12, "{} {exact}", run[199]);
    }

    #[test]
    fn runaway_ends_at_the_bound() {
        let plant = Plant::new(&[Place::Mass, Place::Viscous(Way::Both)], &[1e-6, -1.0]);
        let drive = Drive::new(&[1.0; 50], 1e-3, Between::Held);
        let run = free_run(&plant, &drive, 0, 50, State { position: 0.0, velocity: 0.0 }, 5.0);
        assert!(run.iter().all(|x| x.abs() <= 5.0));
    }
}
