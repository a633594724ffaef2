//! A hypothesis about what was left out: an effect of the catalogue with a shape, as columns of the regression.

use friction::effects::{
    About, Acts, EffectKind, GainGroups, MAX_GAINS, MAX_SHAPE, Parameter, Quantity, SeriesKind,
};

/// What a term is a hypothesis about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TermKind {
    /// A force, renderable on the device unchanged.
    Force(EffectKind),
    /// A sensor, an estimator or the drive.
    Series(SeriesKind),
}

impl TermKind {
    /// Every effect that can be told from others by a force.
    pub fn all() -> Vec<Self> {
        let forces = EffectKind::ALL.iter().copied().map(Self::Force);
        forces.chain(SeriesKind::ALL.iter().copied().map(Self::Series)).collect()
    }

    /// Its description.
    pub fn about(&self) -> &'static About {
        match self {
            Self::Force(kind) => kind.about(),
            Self::Series(kind) => kind.about(),
        }
    }

    /// Catalogue id.
    pub fn id(&self) -> &'static str {
        self.about().id
    }

    /// Gains, in the order of the columns.
    pub fn gains(&self) -> &'static [Parameter] {
        self.about().gains
    }

    /// Shape parameters.
    pub fn shape(&self) -> &'static [Parameter] {
        self.about().shape
    }

    /// Whether it acts there.
    pub fn acts(&self, there: Acts) -> bool {
        self.about().acts == there
    }

    /// Whether it repeats along the stroke: its phase holds as long as the zero of the position does.
    pub fn is_periodic(&self) -> bool {
        self.about().wavelength().is_some()
    }

    /// Whether it moves the whole force in time.
    pub fn moves_in_time(&self) -> bool {
        self.about().acts.in_time()
    }

    /// Whether its columns are made of the force that acts: what moves, bends or follows the whole of it.
    pub fn needs_force(&self) -> bool {
        self.about().acts.on_whole_force()
    }

    /// Whether another force that acts changes a column of it.
    pub fn reads_force(&self) -> bool {
        self.about().reads(Quantity::Force)
    }

    /// Ways the gains may go together, simplest first; each is a list of gains that share one column.
    pub fn variants(&self) -> GainGroups {
        self.about().groups
    }
}

/// An effect with its shape, and which of its gains are free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// The effect.
    pub kind: TermKind,
    /// Non-linear parameters.
    pub shape: [f64; MAX_SHAPE],
    /// Index into [`TermKind::variants`].
    pub variant: usize,
}

impl Term {
    /// Gains that share one column each.
    pub fn free_gains(&self) -> &'static [&'static [usize]] {
        self.kind.variants().get(self.variant).copied().unwrap_or_default()
    }

    /// The full set of gains from one coefficient per column.
    pub fn spread(&self, coefficients: &[f64]) -> [f64; MAX_GAINS] {
        let mut gains = [0.0; MAX_GAINS];
        for (members, c) in self.free_gains().iter().zip(coefficients) {
            for &m in *members {
                gains[m] = *c;
            }
        }
        gains
    }
}
