//! The formats.

/// Format of a simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MJCF of MuJoCo: damping, friction loss, a linear spring.
    Mujoco,
    /// URDF: damping, friction, limits of a slide.
    Urdf,
}
