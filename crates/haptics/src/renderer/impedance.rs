//! Friction on the handle itself.
//!
//! Karnopp is table 4-1, with its misprint corrected: `friction`, `ff` and `ff_old` are *one* variable. The stuck
//! spring is kept as the force it had where it was entered and the travel since, so that a handle that does not move
//! keeps exactly its force: no chatter from rounding.
//!
//! Coulomb needs no dead band: the spring itself is clipped to the level and dragged along (the stopping force where
//! the applied force is only known through a spring; eq. 4.6, 4.7 of Hayward and Armstrong), so there is no velocity
//! in the decision and no zero-crossing limit cycle.
//!
//! Dahl and LuGre act on the measured motion as it is. They creep where Karnopp and Coulomb hold: both laws drift under
//! a load that vibrates, and an encoder toggling over one edge is such a vibration.

use super::{Handle, Rendered};
use crate::Config;
use crate::settings::MAX_EFFECTS;
use core::mem::{Discriminant, discriminant};
use friction::effects::{EffectKind, EffectState};
use friction::{FrictionLaw, Law, LawState, Motion};

/// Memory of the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impedance {
    grip: Grip,
    /// Force on the handle in the last step, N: the one variable of table 4-1.
    friction: f32,
    law: LawState<f32>,
    law_kind: Discriminant<Law<f32>>,
    effects: [EffectState<f32>; MAX_EFFECTS],
    kinds: [Option<EffectKind>; MAX_EFFECTS],
}

/// `state` of table 4-1.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Grip {
    /// STUCK: the spring had `preload` N on the handle when this began at `entered`.
    Stuck { entered: f32, preload: f32 },
    /// SLIDING.
    Sliding,
}

/// Levels and slopes in one direction.
struct Direction {
    fixed: f32,
    moving: f32,
    viscous: f32,
}

impl Impedance {
    /// Stuck where the handle is, without force.
    #[inline(always)] // as the virtual coupling's
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
            Law::Dahl(_) | Law::LuGre(_) => {
                let friction = config.law.step(&mut self.law, &motion);
                (-friction, handle.velocity.abs() < config.dv)
            }
        };
        self.friction = force;
        // friction effects change sign with the velocity, which a stuck handle does not have
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

    /// Table 4-1. Returns the force on the handle and whether it is stuck.
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
                // a negative force holds against positive motion: sign(x − x_stuck) of the table
                let positive = spring < 0.0;
                let d = direction(positive);
                if spring.abs() > d.fixed {
                    self.grip = Grip::Sliding;
                    (slide(positive, &d, v), false)
                } else {
                    // 4.5.1.2: damping of the stuck spring, worth having since the velocity is good at rest
                    (spring - config.damping * v, true)
                }
            }
            Grip::Sliding => {
                if v.abs() < config.dv {
                    // x_stuck = x + sign(ff_old)·F_static/K_p, that is: the spring begins at the static level
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
            // dragged along: where it was clipped, the spring moves only back from its level
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

    /// The dry part of the last sliding force: its level, in its direction.
    fn sliding_level(&self, direction: &dyn Fn(bool) -> Direction) -> f32 {
        let positive = self.friction < 0.0;
        let level = direction(positive).moving;
        if positive { -level } else { level }
    }
}

/// −sign·F_dynamic − B·v. A falling slope never turns friction into drive.
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
