//! What an effect tells about itself: everything that anybody else asks of it.

use crate::{Dimension, Geometry, Unit};

/// Most gains an effect has.
pub const MAX_GAINS: usize = 4;
/// Most shape parameters an effect has.
pub const MAX_SHAPE: usize = 2;

/// How a fit looks for a parameter, and by which scale of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The force is proportional to it: solved for, not searched.
    Gain,
    /// A speed of the motion.
    Speed,
    /// A distance over which something repeats.
    Wavelength,
    /// A place on the stroke, in hundredths of it from the lower end.
    Place {
        /// First place tried.
        from: u8,
        /// Last place tried.
        to: u8,
    },
    /// A distance after a reversal.
    Distance,
    /// A delay or a time constant of a signal.
    Lag,
    /// A time at rest.
    Rest,
    /// A time of the order of the recording.
    Duration,
    /// A level of the force.
    Force,
    /// A frequency of the motion.
    Frequency,
    /// A number of times per distance.
    PerLength,
    /// None: tried over its own range.
    Range,
    /// The same in its logarithm: a share of the critical damping.
    Damping,
}

impl Scale {
    /// Dimension of a parameter with this scale; a number where the scale does not say.
    const fn dimension(self) -> Dimension {
        match self {
            Self::Gain | Self::Range | Self::Damping => Dimension::NUMBER,
            Self::Speed => Dimension::VELOCITY,
            Self::Wavelength | Self::Place { .. } | Self::Distance => Dimension::LENGTH,
            Self::Lag | Self::Rest | Self::Duration => Dimension::TIME,
            Self::Force => Dimension::FORCE,
            Self::Frequency => Dimension::FREQUENCY,
            Self::PerLength => Dimension::NUMBER.per(Dimension::LENGTH),
        }
    }
}

/// A parameter of an effect, of a law or of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name as a user types it and as it stands in files.
    pub name: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// How a fit looks for it.
    pub scale: Scale,
    /// Smallest physical value.
    pub min: f64,
    /// Largest accepted value.
    pub max: f64,
    /// What it is, for a person.
    pub what: &'static str,
}

impl Parameter {
    /// A parameter that the force is proportional to.
    #[must_use]
    pub const fn gain(
        name: &'static str,
        dimension: Dimension,
        (min, max): (f64, f64),
        what: &'static str,
    ) -> Self {
        Self { name, dimension, scale: Scale::Gain, min, max, what }
    }

    /// A parameter that the force is not proportional to; its dimension is that of the scale.
    #[must_use]
    pub const fn shape(name: &'static str, scale: Scale, (min, max): (f64, f64), what: &'static str) -> Self {
        Self { name, dimension: scale.dimension(), scale, min, max, what }
    }

    /// Its SI unit.
    #[must_use]
    pub const fn unit(&self, geometry: Geometry) -> Unit {
        self.dimension.unit(geometry)
    }
}

/// What a recording or a simulation knows at every sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// How long something lasts.
    Time,
    /// Where the body is; depends on the origin.
    Position,
    /// How far the body went; does not depend on the origin.
    Displacement,
    /// Velocity, or its direction.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// The force that acts on the body beside friction.
    Force,
    /// The force across the contact.
    Load,
}

/// Where an effect sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seat {
    /// Anywhere: nothing in a recording says where.
    Unknown,
    /// Between the sliding surfaces.
    Contact,
    /// Between the body and the frame.
    Body,
    /// In the motor, its amplifier or the transmission.
    Drive,
    /// In the channel that measures this. A simulation need not contain it.
    Channel(Quantity),
}

/// What an effect changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acts {
    /// Adds a force of its own.
    Force,
    /// Changes the recorded motion.
    OnMotion,
    /// Changes what is moved, behind a drive that gives or has play; follows the acceleration.
    Behind,
    /// Moves the whole force in time as it is: a linear phase.
    Delay,
    /// Moves the whole force in time through a low-pass: a phase that bends.
    Lag,
    /// Changes the size of the whole force.
    OnForce,
}

impl Acts {
    /// Moves the whole force in time: its gain is 1, and what is sought is a time.
    #[must_use]
    pub const fn in_time(self) -> bool {
        matches!(self, Self::Delay | Self::Lag)
    }

    /// Is made of the whole force: moves, bends or follows it.
    #[must_use]
    pub const fn on_whole_force(self) -> bool {
        matches!(self, Self::Delay | Self::Lag | Self::OnForce)
    }
}

/// Ways the gains of an effect may be free, simplest first. Each way is a list of columns of a regression, each column a
/// list of gains that share one value.
pub type GainGroups = &'static [&'static [&'static [usize]]];

/// One gain.
pub const ONE: GainGroups = &[&[&[0]]];
/// Two gains that belong together.
pub const BOTH: GainGroups = &[&[&[0], &[1]]];
/// A gain for each direction, first alike in both.
pub const BY_DIRECTION: GainGroups = &[&[&[0, 1]], &[&[0], &[1]]];
/// Two separate mechanisms, one or the other.
pub const EITHER: GainGroups = &[&[&[0]], &[&[1]]];
/// Two separate mechanisms, one or the other or both.
pub const EITHER_OR_BOTH: GainGroups = &[&[&[0]], &[&[1]], &[&[0], &[1]]];
/// The first gain, then both.
pub const FIRST_OR_BOTH: GainGroups = &[&[&[0]], &[&[0], &[1]]];

/// An effect as a difference between two channels, where such a difference shows it without any force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// The equation in these parameters.
    pub equation: &'static str,
    /// What the comparison estimates, in this order.
    pub parameters: &'static [Parameter],
    /// What confirms it.
    pub confirmed_by: &'static str,
}

/// What no motion of the body separates an effect from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twin {
    /// Parameters of the baseline and ids of effects that give the same force in every motion.
    pub of: &'static [&'static str],
    /// Why.
    pub because: &'static str,
}

/// Gains and shape of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// In the order of [`About::gains`]; 0 beyond.
    pub gains: [f64; MAX_GAINS],
    /// In the order of [`About::shape`]; 0 beyond.
    pub shape: [f64; MAX_SHAPE],
}

/// The description of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// Fixed id, as in files and reports.
    pub id: &'static str,
    /// One plain sentence for a person.
    pub says: &'static str,
    /// The equation as text, in the names of `gains` and `shape`.
    pub equation: &'static str,
    /// Where in a motion it shows.
    pub shows: &'static str,
    /// Effects that look like it, with the cosine between the two where it was computed.
    pub confused_with: &'static str,
    /// The measurement that separates them.
    pub told_apart_by: &'static str,
    /// Parameters the force is proportional to.
    pub gains: &'static [Parameter],
    /// Which of them may be free together.
    pub groups: GainGroups,
    /// Its gains are a size and an angle. They count as one number where the simplest explanation is looked for: the rest position
    /// of a spring, which is part of the offset, does not count either.
    pub at_an_angle: bool,
    /// Its force at one speed is a matter of reference, a constant that belongs to the friction level.
    pub has_reference: bool,
    /// Parameters the force is not proportional to.
    pub shape: &'static [Parameter],
    /// Index of the shape parameter that distinguishes several instances on one machine, such as ripples of different wavelengths;
    /// `None` if there is at most one.
    pub several_by: Option<usize>,
    /// What its force is made of.
    pub reads: &'static [Quantity],
    /// Always against the motion, and nothing at rest but where it adds to break-away: a part of the friction level. The
    /// others are springs, loads or have a memory that pushes back.
    pub opposes_motion: bool,
    /// Where it sits.
    pub seat: Seat,
    /// What it changes.
    pub acts: Acts,
    /// The geometry it needs, and what it is on the other one.
    pub only: Option<(Geometry, &'static str)>,
    /// The measurement that shows it where no motion does.
    pub bench_test: Option<&'static str>,
    /// A motion can show it or separate it from others.
    pub shown_by_motion: bool,
    /// Where a diagnosis looks for it.
    pub looked_for: LookedFor,
    /// What it cannot be separated from.
    pub twin: Option<Twin>,
    /// Id of the effect that a diagnosis names in its place.
    pub case_of: Option<&'static str>,
    /// How it shows between two channels.
    pub comparison: Option<Comparison>,
    /// A size that the force noise of one sample on the [thesis, table 3-2] rig hides, 0.062 N, and ten seconds of sliding
    /// to and fro by 10 mm do not; None where that motion does not show it.
    pub example: Option<Example>,
}

/// Where a diagnosis looks for an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LookedFor {
    /// In every motion.
    Everywhere,
    /// Where the body only advances: beside a reversal other friction at low speed looks like it.
    WhereItAdvances,
    /// Nowhere: whatever the sensors, a motion lets it stand in for most other effects.
    Nowhere,
}

impl About {
    /// What most effects have in common; a file of an effect states the rest.
    pub const EFFECT: Self = Self {
        id: "",
        says: "",
        equation: "",
        shows: "",
        confused_with: "",
        told_apart_by: "",
        gains: &[],
        groups: ONE,
        at_an_angle: false,
        has_reference: false,
        shape: &[],
        several_by: None,
        reads: &[],
        opposes_motion: false,
        seat: Seat::Contact,
        acts: Acts::Force,
        only: None,
        bench_test: None,
        shown_by_motion: true,
        looked_for: LookedFor::Everywhere,
        twin: None,
        case_of: None,
        comparison: None,
        example: None,
    };

    /// Which shape parameter is the period along the stroke; none where the effect has no phase there.
    #[must_use]
    pub fn wavelength(&self) -> Option<usize> {
        self.shape.iter().position(|p| p.scale == Scale::Wavelength)
    }

    /// Every parameter: gains, then shape.
    pub fn parameters(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.gains.iter().chain(self.shape)
    }

    /// Whether its force is made of this.
    #[must_use]
    pub fn reads(&self, quantity: Quantity) -> bool {
        self.reads.contains(&quantity)
    }

    /// A force that is the same in every motion.
    #[must_use]
    pub const fn is_constant(&self) -> bool {
        matches!(self.acts, Acts::Force) && self.reads.is_empty() && !self.gains.is_empty()
    }

    /// An error of an instrument, that a simulation of the machine need not contain.
    #[must_use]
    pub const fn is_instrument(&self) -> bool {
        matches!(self.seat, Seat::Channel(_))
    }
}

/// What describes itself.
pub trait Describe {
    /// The description.
    const ABOUT: About;
}
