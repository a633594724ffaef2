//! One sliding body over one step: friction as a stopping force, with the zero crossing as an event.

use crate::Zoh;
use friction::{FrictionLaw, Motion};

/// Limit of any force, N: far above anything on a bench, far below overflow.
pub(crate) const FORCE_LIMIT: f64 = 1e6;
/// Largest residue of a stop from rounding, m/s. A body slower than this after a stop is at rest.
const REST: f64 = 1e-14;
/// Speed at which a law is evaluated to find its jump at rest, m/s.
const NUDGE: f64 = 1e-12;
/// Largest |v|·m/h, N, at which a step could cross zero; the state of the law is then kept to go back.
const CROSSING_FORCE: f64 = 200.0;

/// Friction on a body: the Coulomb friction of its guide, and a law if it slides on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Friction {
    /// Coulomb friction of the guide, N.
    pub guide: f64,
    /// Friction of the law, N.
    pub law: f64,
}

impl Friction {
    pub(crate) fn total(&self) -> f64 {
        self.guide + self.law
    }
}

/// Sources of friction on a body.
pub(crate) struct Surface<'a, L: FrictionLaw<f64>> {
    pub guide_p: f64,
    pub guide_n: f64,
    /// Normal load on the surface, N.
    pub normal: f64,
    /// The law with its state, if the body slides on a surface.
    pub law: Option<(&'a L, &'a mut L::State)>,
    /// Number of forces that were not finite.
    pub not_finite: &'a mut u64,
}

/// Replaces a non-finite force by 0 and counts it.
#[inline]
pub(crate) fn finite(force: f64, not_finite: &mut u64) -> f64 {
    if force.is_finite() {
        force.clamp(-FORCE_LIMIT, FORCE_LIMIT)
    } else {
        *not_finite += 1;
        0.0
    }
}

impl<L: FrictionLaw<f64>> Surface<'_, L> {
    /// Friction during a step of `dt` that starts with `velocity` under the non-frictional force `applied`,
    /// viscous damping of the guide included.
    /// `position` is that of the middle of the step, so that a spring in a law is conservative.
    ///
    /// By convention the guide takes its share of the stop first. For rigid bodies the sharing of a load between two
    /// stopping forces is undetermined.
    #[inline]
    pub(crate) fn friction(
        &mut self,
        dt: f64,
        position: f64,
        velocity: f64,
        displacement: f64,
        applied: f64,
        stopping_mass: f64,
    ) -> Friction {
        let guide = if self.guide_p > 0.0 || self.guide_n > 0.0 {
            (applied + stopping_mass * velocity / dt).clamp(-self.guide_n, self.guide_p)
        } else {
            0.0
        };
        let Some((law, state)) = &mut self.law else { return Friction { guide, law: 0.0 } };
        let mut motion = Motion {
            dt,
            position,
            displacement,
            velocity,
            applied: applied - guide,
            mass: stopping_mass,
            normal: Some(self.normal),
        };
        let force = finite(law.step(state, &motion), self.not_finite);
        let net = motion.applied - force;
        if velocity == 0.0 && net != 0.0 {
            let mut nudged = **state;
            // The law does not balance the load. A law with a jump at rest, such as sgn(v), may still hold: evaluate
            // it just beside rest, on the side the body would leave to (Filippov's convention).
            motion.velocity = NUDGE.copysign(net);
            motion.displacement = motion.velocity * dt;
            let beside = finite(law.step(&mut nudged, &motion), self.not_finite);
            if (motion.applied - beside) * net <= 0.0 {
                return Friction { guide, law: motion.applied };
            }
        }
        Friction { guide, law: force }
    }

    /// Moves a body by one step of `zoh` under the constant force `applied`. Calls `segment` for each part of the motion
    /// with one direction: (start s, length s, velocity at its start, displacement).
    ///
    /// A step in which the velocity would change sign is split. The body comes to rest there and leaves only if the load
    /// exceeds the holding friction: friction stops a body and never drives it.
    #[inline]
    pub(crate) fn slide(
        &mut self,
        body: &mut Body,
        zoh: &Zoh,
        applied: f64,
        mut segment: impl FnMut(f64, f64, f64, f64),
    ) -> f64 {
        let (x, v, h) = (body.position, body.velocity, zoh.step);
        let crossing_possible = v != 0.0 && (v * zoh.stopping_mass).abs() < CROSSING_FORCE * h;
        let saved = if crossing_possible { self.law.as_ref().map(|(_, state)| **state) } else { None };
        let load = applied - body.damping * v;
        let friction = self.friction(h, x + 0.5 * v * h, v, v * h, load, zoh.stopping_mass);
        let (displacement, mut end) = zoh.advance(v, applied - friction.total());
        if v != 0.0 && end.abs() < REST {
            end = 0.0;
        }
        if v * end >= 0.0 {
            body.position = x + displacement;
            body.velocity = end;
            segment(0.0, h, v, displacement);
            return friction.total() * displacement;
        }
        // the force is constant: the velocity crosses zero once
        let until = time_to_rest(body, v, applied - friction.total()).clamp(0.0, h);
        if let (Some((_, state)), Some(saved)) = (&mut self.law, saved) {
            **state = saved;
        }
        let first = Zoh::new(body.mass, body.damping, until);
        let friction =
            self.friction(until, x + 0.25 * v * until, v, 0.5 * v * until, load, first.stopping_mass);
        let (displacement, _) = first.advance(v, applied - friction.total());
        segment(0.0, until, v, displacement);
        let mut taken = friction.total() * displacement;
        body.position = x + displacement;
        body.velocity = 0.0;
        let rest = h - until;
        if rest > 1e-9 * h {
            let second = Zoh::new(body.mass, body.damping, rest);
            let friction = self.friction(rest, body.position, 0.0, 0.0, applied, second.stopping_mass);
            let (displacement, end) = second.advance(0.0, applied - friction.total());
            segment(until, rest, 0.0, displacement);
            taken += friction.total() * displacement;
            body.position += displacement;
            body.velocity = end;
        }
        taken
    }
}

/// Time at which m·v̇ + b·v = F reaches v = 0, s: (m/b)·ln(1 − b·v/F), with the limit −m·v/F.
fn time_to_rest(body: &Body, velocity: f64, force: f64) -> f64 {
    let undamped = -body.mass * velocity / force;
    let y = -body.damping * velocity / force;
    if y == 0.0 { undamped } else { undamped * libm::log1p(y) / y }
}

/// A mass on a viscous guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Body {
    pub mass: f64,
    pub damping: f64,
    pub position: f64,
    pub velocity: f64,
}
