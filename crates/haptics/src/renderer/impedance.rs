//! Impedance renderer: friction on the handle itself.
//!
//! Karnopp follows [thesis, table 4-1] with its misprint corrected: `friction`, `ff` and `ff_old` are *one* variable. The
//! stuck spring is stored as its force at entry plus the travel since, so that a resting handle keeps exactly its force,
//! without chatter from rounding.
//!
//! Coulomb needs no dead band. The spring itself is clipped to the level and dragged along: the stopping force for an applied
//! force that is known only through a spring [thesis, eq. 4.6 and 4.7]. The decision does not use the velocity, so there is
//! no zero-crossing limit cycle.
//!
//! Any other law acts on the measured motion. Dahl and LuGre creep where Karnopp and Coulomb hold: both laws drift under a
//! vibrating load, and an encoder that toggles across an edge is such a load.

use super::{Handle, Rendered};
use crate::Config;
use crate::settings::MAX_EFFECTS;
use core::mem::{Discriminant, discriminant};
use friction::effects::{EffectKind, EffectState};
use friction::{FrictionLaw, Law, LawState, Motion};

/// State of the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impedance {
    grip: Grip,
    /// Force on the handle in the previous step, N: the one variable of [thesis, table 4-1].
    friction: f32,
    pub(super) law: LawState<f32>,
    law_kind: Discriminant<Law<f32>>,
    effects: [EffectState<f32>; MAX_EFFECTS],
    kinds: [Option<EffectKind>; MAX_EFFECTS],
}

/// `state` of [thesis, table 4-1].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Grip {
    /// STUCK: the spring pushed with `preload`, N, when the handle stuck at `entered`, m.
    Stuck { entered: f32, preload: f32 },
    /// SLIDING.
    Sliding,
}

/// A law that acts on the measured motion. A function of its own: where the compiler knows which laws it cannot be, it writes traps
/// for them.
#[inline(never)]
fn moved(law: &Law<f32>, state: &mut LawState<f32>, motion: &Motion<f32>) -> f32 {
    law.step(state, motion)
}

/// Levels and slopes in one direction.
struct Direction {
    fixed: f32,
    moving: f32,
    viscous: f32,
}

impl Impedance {
    /// A contact stuck at the handle, without force.
    #[inline(always)] // like that of the virtual coupling
    pub(crate) fn new(config: &Config, handle: &Handle) -> Self {
        Self {
            grip: Grip::Stuck { entered: handle.position, preload: 0.0 },
            friction: 0.0,
            law: LawState::default(),
            law_kind: discriminant(&config.law),
            effects: [EffectState::default(); MAX_EFFECTS],
            kinds: config.kinds,
        }
    }

    /// Force of the spring of a stuck or dragged contact, N. 0 for a law that does not hold.
    pub(super) fn spring(&self, config: &Config, handle: &Handle) -> f32 {
        match (self.grip, config.law) {
            (Grip::Stuck { entered, preload }, Law::Karnopp(_) | Law::Coulomb(_)) => {
                preload - config.stiffness * (handle.position - entered)
            }
            // dragged along at its level
            (Grip::Sliding, Law::Coulomb(_)) => self.friction,
            _ => 0.0,
        }
    }

    pub(crate) fn fits(&self, config: &Config) -> bool {
        self.law_kind == discriminant(&config.law) && self.kinds == config.kinds
    }

    pub(crate) fn step(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let motion = Motion {
            dt: config.device.period,
            position: handle.position,
            displacement: handle.displacement,
            velocity: handle.velocity,
            applied: -self.friction,
            mass: 0.0,
            normal: None,
        };
        let (force, stuck) = match config.law {
            Law::Karnopp(law) => {
                let direction = |positive: bool| {
                    if positive {
                        Direction { fixed: law.d_p, moving: law.c_p, viscous: law.b_p }
                    } else {
                        Direction { fixed: law.d_n, moving: law.c_n, viscous: law.b_n }
                    }
                };
                self.table_4_1(config, handle, &direction)
            }
            Law::Coulomb(law) => {
                let direction = |positive: bool| {
                    if positive {
                        Direction { fixed: law.static_p, moving: law.level_p, viscous: law.viscous_p }
                    } else {
                        Direction { fixed: law.static_n, moving: law.level_n, viscous: law.viscous_n }
                    }
                };
                self.clipped_spring(config, handle, &direction)
            }
            _ => {
                let friction = moved(&config.law, &mut self.law, &motion);
                (-friction, handle.velocity.abs() < config.dv)
            }
        };
        self.friction = force;
        // friction effects change sign with the velocity, which is zero for a stuck handle
        let felt = if stuck { Motion { velocity: 0.0, displacement: 0.0, ..motion } } else { motion };
        let mut extra = 0.0;
        for (effect, state) in config.effects.iter().zip(&mut self.effects) {
            if let Some(effect) = effect {
                extra += effect.step(state, &felt);
            }
        }
        let block_position = match self.grip {
            Grip::Stuck { entered, .. } => entered,
            Grip::Sliding => handle.position,
        };
        Rendered {
            force: force - extra,
            block_position,
            block_velocity: if stuck { 0.0 } else { handle.velocity },
            friction: extra - force,
            stuck,
        }
    }

    /// [thesis, table 4-1]. Returns the force on the handle and whether it is stuck.
    fn table_4_1(
        &mut self,
        config: &Config,
        handle: &Handle,
        direction: &dyn Fn(bool) -> Direction,
    ) -> (f32, bool) {
        let (x, v) = (handle.position, handle.velocity);
        match self.grip {
            Grip::Stuck { entered, preload } => {
                let spring = preload - config.stiffness * (x - entered);
                // a negative force opposes positive motion: sign(x − x_stuck) of the table
                let positive = spring < 0.0;
                let d = direction(positive);
                if spring.abs() > d.fixed {
                    self.grip = Grip::Sliding;
                    (slide(positive, &d, v), false)
                } else {
                    // damping of the stuck spring [thesis, ch. 4.5.1.2]; the velocity estimate is good at rest
                    (spring - config.damping * v, true)
                }
            }
            Grip::Sliding => {
                if v.abs() < config.dv {
                    // x_stuck = x + sign(ff_old)·F_static/K_p: the spring begins at the static level
                    let old = self.friction;
                    let level = direction(old < 0.0).fixed;
                    let preload = if old > 0.0 {
                        level
                    } else if old < 0.0 {
                        -level
                    } else {
                        0.0
                    };
                    self.grip = Grip::Stuck { entered: x, preload };
                    (preload, true)
                } else {
                    (slide(v > 0.0, &direction(v > 0.0), v), false)
                }
            }
        }
    }

    /// The spring clipped to the level and dragged along.
    fn clipped_spring(
        &mut self,
        config: &Config,
        handle: &Handle,
        direction: &dyn Fn(bool) -> Direction,
    ) -> (f32, bool) {
        let (x, v) = (handle.position, handle.velocity);
        let (spring, was_stuck) = match self.grip {
            Grip::Stuck { entered, preload } => (preload - config.stiffness * (x - entered), true),
            // dragged along: a clipped spring only moves back from its level
            Grip::Sliding => (self.sliding_level(direction) - config.stiffness * handle.displacement, false),
        };
        let positive = spring < 0.0;
        let d = direction(positive);
        let level = if was_stuck { d.fixed } else { d.moving };
        if spring.abs() > level || (!was_stuck && spring.abs() >= level) {
            self.grip = Grip::Sliding;
            (slide(positive, &d, v), false)
        } else {
            if !was_stuck {
                self.grip = Grip::Stuck { entered: x, preload: spring };
            }
            (spring - config.damping * v, true)
        }
    }

    /// Dry part of the last sliding force: its level with its direction.
    fn sliding_level(&self, direction: &dyn Fn(bool) -> Direction) -> f32 {
        let positive = self.friction < 0.0;
        let level = direction(positive).moving;
        if positive { -level } else { level }
    }
}

/// Sliding force −sign·F_dynamic − B·v. A falling slope never makes friction drive.
fn slide(positive: bool, d: &Direction, v: f32) -> f32 {
    let viscous = d.viscous * v;
    if positive {
        let force = d.moving + viscous;
        -(if force > 0.0 { force } else { 0.0 })
    } else {
        let force = d.moving - viscous;
        if force > 0.0 { force } else { 0.0 }
    }
}
