//! Stopping-force renderer: friction on the virtual block and its coupling, solved together within a period.
//!
//! Block, coupling and friction over one period T, with the sampled handle x, v and the new velocity w⁺ of the block:
//!
//! ```text
//! M (w⁺ − w)/T = F_c − F,      F_c = K (x − p̄) + B (v − w̄)
//! p⁺ = p + T w̄,                w̄ = (w + w⁺)/2,   p̄ = (p + p⁺)/2
//! F ∈ level·Sgn(w⁺) + b w⁺     Sgn(0) = [−static_n, static_p]
//! ```
//!
//! With c = KT/4 + B/2 this becomes D w⁺ + F = S, where D = M/T + c and S = (M/T − c) w + K (x − p) + B v. F grows with w⁺,
//! so there is exactly one solution, in closed form: beyond the holding level the block slides with w⁺ = (S ∓ level)/(D + b);
//! otherwise it rests, w⁺ = 0 and F = S. The holding level is static for a block at rest or about to reverse, dynamic for
//! one that slides on.
//!
//! * A block at rest stays at rest: p is constant, there is no creep, and the hand feels exactly K (x − p) + B v.
//! * At rest the hand does not feel the counts of the encoder (dither.rs).
//! * There is no dead band and no zero-crossing limit cycle. To throw a block from +a to −a every period, S would have to
//!   exceed both levels with (M/T − c) a of either sign added, which requires M/T < c. That is KT² + 2BT > 4M, where the
//!   coupling itself is unstable (the singularity of [thesis, eq. 4.35]). Δv is not used.
//! * The coupling is integrated at its midpoint: to second order the step neither adds nor removes energy. The swing of the
//!   block during a slip, and the frequency of stick-slip, match the continuous model to (ωT)²/12. Backward Euler,
//!   D = M/T + KT + B, would damp the swing by ωT/2 and needs eight sub-steps for the same accuracy (tests/stick_slip.rs
//!   measures both).
//! * The same F_c acts on block and handle. In the period of a stop the block moves only until it stops, so friction
//!   dissipates F·w̄ ≥ 0 in every period except one in which the block reverses.
//!
//! Other laws and effects: Karnopp and Coulomb are both levels and slopes here and render the same. Any other law has no
//! set-valued part and is stepped as under the virtual coupling. Effects that oppose motion
//! ([`opposes_motion`]) are added to the levels, so that they also stop the block and never push it. All others act as
//! external forces.
//!
//! [`opposes_motion`]: friction::effects::EffectKind::opposes_motion

use super::block::{Block, limited};
use super::levels::Levels;
use super::{Handle, Rendered};
use crate::Config;
use friction::Motion;

impl Block {
    /// One period of the equations above.
    pub(super) fn step_stopping_force(
        &mut self,
        config: &Config,
        handle: &Handle,
        mut levels: Levels,
    ) -> Rendered {
        let (w, period, limit) = (self.velocity, config.device.period, config.device.force_max);
        let x = self.dither.settle(handle, config.device.metre_per_count, config.count_per_metre);
        let brake = self.dither.brake(handle, config.edge_damping);
        let pull = config.stiffness * (x - self.position) + config.damping * handle.velocity;
        let half = config.coupling_share;
        let coupling_now = pull - 2.0 * half * w;
        let motion = Motion {
            dt: period,
            position: self.position,
            displacement: self.displacement,
            velocity: w,
            applied: limited(coupling_now, limit),
            mass: config.mass,
            normal: None,
        };
        let (mut outside, mut opposing) = (0.0, 0.0);
        if config.has_effects {
            for (effect, state) in config.effects.iter().zip(&mut self.effects) {
                if let Some(effect) = effect {
                    let force = effect.step(state, &motion);
                    if effect.kind.opposes_motion() {
                        opposing += force;
                    } else {
                        outside += force;
                    }
                }
            }
        }
        if opposing != 0.0 {
            levels.add(opposing, if w == 0.0 { coupling_now - outside } else { w });
        }
        // inertia·w⁺ + F = drive, with the coupling or with its force at the limit
        let solve = |drive: f32, inertia: f32| levels.solve(drive - outside, inertia, w);
        let mass = config.mass_per_period;
        let mut end = solve((mass - half) * w + pull, mass + half);
        let mut coupling = pull - half * (w + end.velocity);
        let possible = limited(coupling, limit);
        if coupling != possible {
            // the block gets no more force than the actuator can give
            coupling = possible;
            end = solve(mass * w + possible, mass);
        }
        self.displacement = period * end.mean;
        let before = self.position;
        self.position += self.displacement;
        // decaying, and too slow to change the position: at rest, or it would slide forever
        let faded = self.position == before && end.velocity.abs() <= w.abs();
        self.velocity = if faded { 0.0 } else { end.velocity };
        Rendered {
            force: -coupling - brake,
            block_position: self.position,
            block_velocity: self.velocity,
            friction: end.friction + outside,
            stuck: self.velocity == 0.0,
        }
    }
}
