//! The formats.

/// Format of a simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MJCF of MuJoCo: damping, friction loss, a linear spring; bristles and waves over the position by a `dcmotor` without
    /// input.
    Mujoco,
    /// URDF: damping, friction, limits of a slide.
    Urdf,
    /// Modelica: friction and break-away by a table over the speed, a spring, a constant force, forces by a table over the position.
    Modelica,
    /// JSON of BAM: friction that falls with the speed and grows with the torque, of an axis.
    Bam,
}

impl Format {
    /// Terms of a sum that it has: sgn v, v, x, 1, |F_applied|·sgn v.
    pub(crate) fn terms(self) -> [bool; 5] {
        match self {
            Self::Mujoco | Self::Modelica => [true, true, true, true, false],
            Self::Urdf => [true, true, false, false, false],
            Self::Bam => [true, true, false, false, true],
        }
    }

    /// Whether it has a constant force without a spring.
    pub(crate) fn has_constant(self) -> bool {
        self == Self::Modelica
    }

    /// Whether it has a break-away above the sliding friction.
    pub(crate) fn has_break_away(self) -> bool {
        self == Self::Modelica
    }

    /// Whether friction may bend bristles before it slides: LuGre's law with a Gaussian fall over the speed.
    pub(crate) fn has_bristles(self) -> bool {
        self == Self::Mujoco
    }
}
