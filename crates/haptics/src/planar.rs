//! The virtual coupling in the plane: a virtual block of mass M slides on a surface, tied to the handle by a spring K and a damper B.
//!
//! The recursion is that of the virtual coupling on a line [thesis, eq. 4.22 to 4.24], with vectors. Friction is a law of
//! [`friction::planar`]; an external force that depends on position, such as detents, may be added. Spring and damper are the same in every
//! direction, so the loop of handle and block falls into two equal loops, one an axis, and the bounds of [`crate::bounds`]
//! hold for each. What couples the axes is friction, which only dissipates.
//!
//! ```
//! use friction::planar::{Coulomb, Grain, Law, Vector};
//! use haptics::planar::{Block, Coupling};
//! let coupling = Coupling { period: 1e-3, mass: 0.2, stiffness: 2000.0, damping: 20.0, force_max: 10.0 };
//! coupling.validate().unwrap();
//! let law = Law::Coulomb(Coulomb { level: 1.0, stiction: 1.5, viscous: 0.0, grain: Grain::default() });
//! let (mut block, still) = (Block::at(Vector::default()), Vector::default());
//! // pulled by 1.4 N: held, and exactly at rest
//! let handle = Vector { x: 0.7e-3, y: 0.0 };
//! let felt = coupling.step(&mut block, &law, handle, still, |_| still);
//! assert!((felt.force.x + 1.4_f64).abs() < 1e-12 && felt.stuck && block.velocity == still);
//! ```

use friction::planar::{FrictionLaw, Law, LawState, Motion, Vector};
use friction::{Invalid, Scalar};

/// Relative rounding error of the forces that stop a block.
const ROUNDING: f64 = 1e-5;

/// Block and coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling<S> {
    /// Period of the loop T, s.
    pub period: S,
    /// Mass of the block M, kg.
    pub mass: S,
    /// Stiffness K, N/m.
    pub stiffness: S,
    /// Damping B, N·s/m.
    pub damping: S,
    /// Largest force of the coupling, N.
    pub force_max: S,
}

/// State of the block and of its contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block<S> {
    /// m.
    pub position: Vector<S>,
    /// m/s.
    pub velocity: Vector<S>,
    displacement: Vector<S>,
    law: LawState<S>,
}

/// Result of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendered<S> {
    /// Force on the handle, N.
    pub force: Vector<S>,
    /// Friction on the block, N, against its motion.
    pub friction: Vector<S>,
    /// Displacement of the block in this step, m.
    pub displacement: Vector<S>,
    /// Whether the block is brought to rest, or rests.
    pub stuck: bool,
}

impl<S: Scalar> Block<S> {
    /// A block at rest.
    pub fn at(position: Vector<S>) -> Self {
        let still = Vector::default();
        Self { position, velocity: still, displacement: still, law: LawState::default() }
    }
}

impl<S: Scalar> Coupling<S> {
    /// One period: `handle` is at a position, m, with a velocity, m/s; `field` is the force of the surface on the block
    /// besides friction, N, at a position.
    pub fn step(
        &self,
        block: &mut Block<S>,
        law: &Law<S>,
        handle: Vector<S>,
        velocity: Vector<S>,
        field: impl FnOnce(Vector<S>) -> Vector<S>,
    ) -> Rendered<S> {
        let stretched =
            (handle - block.position) * self.stiffness + (velocity - block.velocity) * self.damping;
        let coupling = stretched.within(self.force_max);
        let applied = coupling + field(block.position);
        let motion = Motion {
            dt: self.period,
            position: block.position,
            displacement: block.displacement,
            velocity: block.velocity,
            applied,
            mass: self.mass,
            normal: None,
        };
        let friction = law.step(&mut block.law, &motion);
        let momentum = block.velocity * (self.mass / self.period);
        let rounding = S::lit(ROUNDING) * (applied.norm() + momentum.norm());
        let stuck = (applied + momentum - friction).norm() <= rounding;
        block.velocity = if stuck {
            Vector::default()
        } else {
            block.velocity + (applied - friction) * (self.period / self.mass)
        };
        block.displacement = block.velocity * self.period;
        block.position = block.position + block.displacement;
        Rendered { force: -coupling, friction, displacement: block.displacement, stuck }
    }

    /// Checks that the block is stable at a handle that is held, in each axis: KT² + 2BT < 4M, the singularity of
    /// [thesis, eq. 4.35].
    ///
    /// # Errors
    /// The parameter, and what would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        let above_zero = |name, value: S| friction::in_range(name, value, 1e-9, 1e9);
        above_zero("period", self.period)?;
        above_zero("mass", self.mass)?;
        above_zero("force_max", self.force_max)?;
        friction::in_range("damping", self.damping, 0.0, 1e9)?;
        let most = crate::bounds::stiffness_singular(self.mass, self.damping, self.period);
        friction::in_range("stiffness", self.stiffness, 0.0, most.re())
    }
}
