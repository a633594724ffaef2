//! The human hand on the handle: a force source, or an impedance around a moving target.

use friction::Scalar;

/// A hand on the handle, evaluated at every integration step.
pub trait Hand {
    /// Force on the handle in N at time `t` s, handle position `x` m and velocity `v` m/s.
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64;

    /// Mass that moves with the handle while the hand holds it, kg.
    fn mass(&self) -> f64 {
        0.0
    }
}

/// No hand: the handle is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoHand;

impl Hand for NoHand {
    fn force(&mut self, _t: f64, _x: f64, _v: f64) -> f64 {
        0.0
    }
}

impl<F: FnMut(f64, f64, f64) -> f64> Hand for F {
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64 {
        self(t, x, v)
    }
}

/// A scripted force source, independent of the motion of the handle.
#[derive(Debug, Clone, PartialEq)]
pub enum HandForce {
    /// A push of `force` N from `from` s to `until` s.
    PushRelease {
        /// N.
        force: f64,
        /// s.
        from: f64,
        /// s.
        until: f64,
    },
    /// A ramp of `rate` N/s that begins at `from` s and ends at a magnitude of `limit` N.
    Ramp {
        /// N/s.
        rate: f64,
        /// s.
        from: f64,
        /// N.
        limit: f64,
    },
    /// `offset` + `amplitude`·sin(2π·`frequency`·t).
    Sine {
        /// N.
        amplitude: f64,
        /// Hz.
        frequency: f64,
        /// N.
        offset: f64,
    },
    /// Steps (time s, force N) in order of time. Each force holds until the next step; 0 N before the first.
    Steps(Vec<(f64, f64)>),
}

impl Hand for HandForce {
    fn force(&mut self, t: f64, _x: f64, _v: f64) -> f64 {
        match self {
            Self::PushRelease { force, from, until } => {
                if t >= *from && t < *until {
                    *force
                } else {
                    0.0
                }
            }
            Self::Ramp { rate, from, limit } => {
                let limit = Scalar::abs(*limit);
                Scalar::clamp(*rate * Scalar::max(t - *from, 0.0), -limit, limit)
            }
            Self::Sine { amplitude, frequency, offset } => {
                *offset + *amplitude * Scalar::sin(core::f64::consts::TAU * *frequency * t)
            }
            Self::Steps(steps) => {
                let next = steps.partition_point(|(at, _)| *at <= t);
                next.checked_sub(1).and_then(|k| steps.get(k)).map_or(0.0, |(_, force)| *force)
            }
        }
    }
}

/// Target position of an impedance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Constant `position`, m.
    Hold {
        /// m.
        position: f64,
    },
    /// Constant velocity from `start`.
    Ramp {
        /// m.
        start: f64,
        /// m/s.
        velocity: f64,
    },
    /// `centre` + `amplitude`·sin(2π·`frequency`·t).
    Sine {
        /// m.
        centre: f64,
        /// m.
        amplitude: f64,
        /// Hz.
        frequency: f64,
    },
    /// A reach along the minimum-jerk path from `from` m to `to` m, from `at` s for `duration` s.
    Reach {
        /// m.
        from: f64,
        /// m.
        to: f64,
        /// s.
        at: f64,
        /// s.
        duration: f64,
    },
    /// A pointed target: a critically damped second-order lag towards `to` m, so that neither position nor velocity jumps
    /// when `to` does.
    Pursuit {
        /// m.
        from: f64,
        /// m/s.
        velocity: f64,
        /// m.
        to: f64,
        /// s.
        at: f64,
        /// Natural frequency of the lag, rad/s.
        rate: f64,
    },
}

impl Target {
    /// Position, m, and velocity, m/s, at `t` s.
    #[must_use]
    pub fn at(&self, t: f64) -> (f64, f64) {
        match *self {
            Self::Hold { position } => (position, 0.0),
            Self::Ramp { start, velocity } => (start + velocity * t, velocity),
            Self::Sine { centre, amplitude, frequency } => {
                let omega = core::f64::consts::TAU * frequency;
                let (sin, cos) = turn(frequency * t);
                (centre + amplitude * sin, amplitude * omega * cos)
            }
            Self::Reach { from, to, at, duration } => {
                if t <= at || duration <= 0.0 {
                    return (if t <= at { from } else { to }, 0.0);
                }
                let s = Scalar::min((t - at) / duration, 1.0);
                let path = s * s * s * (10.0 + s * (6.0 * s - 15.0));
                let slope = 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration;
                (from + (to - from) * path, (to - from) * slope)
            }
            Self::Pursuit { from, velocity, to, at, rate } => {
                let s = Scalar::max(t - at, 0.0);
                let (away, decay) = (from - to, Scalar::exp(-rate * s));
                let slope = velocity + rate * away;
                (to + (away + slope * s) * decay, (velocity - rate * slope * s) * decay)
            }
        }
    }
}

/// Sine and cosine of 2π·`turns`. Whole quarters are removed before the multiplication by 2π. That is exact, and spares `libm`
/// the reduction of its argument, which took a third of the time of a rig with a hand.
fn turn(turns: f64) -> (f64, f64) {
    let quarters = libm::rint(turns * 4.0);
    let (sin, cos) = libm::sincos((turns - quarters * 0.25) * core::f64::consts::TAU);
    // `as` saturates: beyond 2⁶³ quarters a float has no angle
    match quarters as i64 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// A hand with mass, stiffness and damping around a moving target: F = k(x_t − x) + b(ẋ_t − ẋ) − m·ẍ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandImpedance {
    /// Mass of the hand that moves with the handle, kg.
    pub mass: f64,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
    /// Target position.
    pub target: Target,
}

impl HandImpedance {
    /// A relaxed hand in a precision grip: 0.1 kg, 400 N/m, 6 N·s/m.
    #[must_use]
    pub fn relaxed(target: Target) -> Self {
        Self { mass: 0.1, stiffness: 400.0, damping: 6.0, target }
    }
}

impl Hand for HandImpedance {
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64 {
        let (position, velocity) = self.target.at(t);
        self.stiffness * (position - x) + self.damping * (velocity - v)
    }

    fn mass(&self) -> f64 {
        self.mass
    }
}

#[cfg(test)]
mod tests {
    use super::{Target, turn};

    #[test]
    fn a_moved_pointer_causes_no_jump() {
        let first = Target::Pursuit { from: 0.0, velocity: 0.0, to: 0.01, at: 1.0, rate: 100.0 };
        assert_eq!(first.at(1.0), (0.0, 0.0));
        assert!((first.at(1.2).0 - 0.01).abs() < 1e-9);
        // the target moves while the hand still moves
        let (from, velocity) = first.at(1.013);
        let next = Target::Pursuit { from, velocity, to: -0.004, at: 1.013, rate: 100.0 };
        assert_eq!(next.at(1.013), (from, velocity));
        let mut worst = 0.0_f64;
        for k in 1..200 {
            let (t, h) = (1.013 + 1e-3 * f64::from(k), 1e-6);
            let slope = (next.at(t + h).0 - next.at(t - h).0) / (2.0 * h);
            worst = worst.max((slope - next.at(t).1).abs());
        }
        println!("velocity against the slope of position: {worst:.1e} m/s");
        assert!(worst < 1e-7 && (next.at(1.3).0 + 0.004).abs() < 1e-9);
    }

    #[test]
    fn a_turn_matches_sine_and_cosine() {
        let mut worst = 0.0_f64;
        for k in -40_000..40_000 {
            let turns = f64::from(k) * 1.7e-4;
            let (sin, cos) = turn(turns);
            let angle = core::f64::consts::TAU * turns;
            worst = worst.max((sin - angle.sin()).abs()).max((cos - angle.cos()).abs());
        }
        println!("turn: differs from sin and cos by {worst:.1e} over ±6.8 turns");
        assert!(worst < 1e-14);
        for quarters in -9..9_i32 {
            let (sin, cos) = turn(f64::from(quarters) * 0.25);
            let exact = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
            assert_eq!((sin, cos), exact[quarters.rem_euclid(4) as usize]);
        }
    }
}
