//! Parameters of a body and its friction, by the names they have in files.

use crate::Dimension;
use crate::effects::Parameter;

/// Largest force, damping and stiffness of a file.
const LARGEST: f64 = 1e12;

const fn signed(name: &'static str, dimension: Dimension, what: &'static str) -> Parameter {
    Parameter::gain(name, dimension, (-LARGEST, LARGEST), what)
}

const fn positive(name: &'static str, dimension: Dimension, what: &'static str) -> Parameter {
    Parameter::gain(name, dimension, (0.0, LARGEST), what)
}

/// Moving mass, or inertia.
pub const MASS: Parameter = positive("mass", Dimension::MASS, "moving mass");
/// Sliding friction in positive motion.
pub const COULOMB_P: Parameter =
    positive("coulomb_p", Dimension::FORCE, "sliding friction in positive motion");
/// Sliding friction in negative motion.
pub const COULOMB_N: Parameter =
    positive("coulomb_n", Dimension::FORCE, "sliding friction in negative motion");
/// Viscous friction in positive motion.
pub const VISCOUS_P: Parameter =
    signed("viscous_p", Dimension::DAMPING, "viscous friction in positive motion");
/// Viscous friction in negative motion.
pub const VISCOUS_N: Parameter =
    signed("viscous_n", Dimension::DAMPING, "viscous friction in negative motion");
/// Speed taken for rest.
pub const DELTA_V: Parameter = positive("delta_v", Dimension::VELOCITY, "speed taken for rest");
/// Constant that the force channel adds.
pub const OFFSET: Parameter = signed("offset", Dimension::FORCE, "constant that the force channel adds");
/// Time by which the force channel is behind the position.
pub const DELAY: Parameter =
    signed("delay", Dimension::TIME, "time by which the force channel is behind the position");
/// Where position is zero.
pub const ORIGIN: Parameter = signed("origin", Dimension::LENGTH, "where position is zero");
/// Sliding friction of one recording beyond that of another.
pub const FRICTION: Parameter =
    signed("friction", Dimension::FORCE, "sliding friction beyond that of another recording");

/// Every parameter of a body, of a law in an identification, of a preset and of a recording's nuisances. What an effect has
/// is in [`effects`](crate::effects).
pub const ALL: &[Parameter] = &[
    MASS,
    COULOMB_P,
    COULOMB_N,
    positive("coulomb", Dimension::FORCE, "sliding friction in both directions"),
    VISCOUS_P,
    VISCOUS_N,
    signed("viscous", Dimension::DAMPING, "viscous friction in both directions"),
    positive("static_p", Dimension::FORCE, "static friction against positive motion"),
    positive("static_n", Dimension::FORCE, "static friction against negative motion"),
    DELTA_V,
    positive("limit_p", Dimension::FORCE, "limit of Dahl's friction in positive motion"),
    positive("limit_n", Dimension::FORCE, "limit of Dahl's friction in negative motion"),
    positive("sigma", Dimension::STIFFNESS, "stiffness of a bristle"),
    positive("sigma_1", Dimension::DAMPING, "damping of a bristle"),
    positive("exponent", Dimension::NUMBER, "shape of Dahl's law"),
    positive("stribeck_velocity", Dimension::VELOCITY, "speed over which static friction falls to dynamic"),
    positive("elastic", Dimension::NUMBER, "elastic range as a share of the dynamic friction"),
    positive("attraction", Dimension::FORCE_RATE, "rate at which a slipping element follows its level"),
    positive("memory", Dimension::TIME, "time constant of the frictional memory"),
    positive("dwell", Dimension::TIME, "time at rest after which static friction has risen by half"),
    positive("steepness", Dimension::NUMBER, "steepness of a continuous curve at rest"),
    OFFSET,
    DELAY,
    ORIGIN,
    FRICTION,
    positive("f_static", Dimension::FORCE, "static friction"),
    positive("f_static_p", Dimension::FORCE, "static friction against positive motion"),
    positive("f_static_n", Dimension::FORCE, "static friction against negative motion"),
    positive("f_dynamic", Dimension::FORCE, "dynamic friction"),
    positive("f_dynamic_p", Dimension::FORCE, "dynamic friction against positive motion"),
    positive("f_dynamic_n", Dimension::FORCE, "dynamic friction against negative motion"),
    signed("damping", Dimension::DAMPING, "viscous damping"),
    signed("damping_p", Dimension::DAMPING, "viscous damping against positive motion"),
    signed("damping_n", Dimension::DAMPING, "viscous damping against negative motion"),
    positive("dv", Dimension::VELOCITY, "speed taken for zero"),
    positive("k_vc", Dimension::STIFFNESS, "stiffness of the virtual coupling"),
    positive("b_vc", Dimension::DAMPING, "damping of the virtual coupling"),
    signed("delay_s", Dimension::TIME, "time by which the force channel is behind the position"),
    positive("cutoff_hz", Dimension::FREQUENCY, "cut-off of the filter of a prediction"),
];

/// The parameter of this name.
///
/// ```
/// use friction::{Geometry, parameters};
///
/// let sigma = parameters::find("sigma").expect("a bristle's");
/// assert_eq!(sigma.unit(Geometry::Rotary).to_string(), "N·m/rad");
/// ```
#[must_use]
pub fn find(name: &str) -> Option<&'static Parameter> {
    ALL.iter().find(|parameter| parameter.name == name)
}
