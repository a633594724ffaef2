//! A hypothesis about what was left out: an effect of the catalogue with a shape, as columns of the regression.

use friction::effects::{
    About, Acts, EffectKind, GainGroups, MAX_GAINS, MAX_SHAPE, Parameter, Quantity, SeriesKind,
};

/// Least ratio of two wavelengths, and least difference of their waves on the stroke, for two separate lines. Closer together they
/// fit one line whose amplitude varies along the stroke.
const WAVES_APART: (f64, f64) = (1.4, 3.0);
/// Least ratio of any other shape. Closer together the second effect only corrects the law of the first.
const APART: f64 = 8.0;

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

    /// Waves on the stroke, of the line and of each harmonic; each has a cosine and a sine.
    fn waves(&self, stroke: f64) -> impl Iterator<Item = f64> + use<> {
        let first = self.kind.about().wavelength().map(|axis| stroke / self.shape[axis]);
        let harmonics = self.free_gains().len().div_ceil(2);
        first.into_iter().flat_map(move |first| (1..=harmonics).map(move |k| k as f64 * first))
    }

    /// Whether both describe the same effect on this stroke: the same kind and, where a machine may have several, nearly the same
    /// shape.
    pub fn is_one_with(&self, other: &Self, stroke: f64) -> bool {
        let within = |factor: f64, a: f64, b: f64| a.max(b) < factor * a.min(b);
        let (factor, waves) = WAVES_APART;
        let close = |a: f64, b: f64| within(factor, a, b) || (a - b).abs() < waves;
        self.kind == other.kind
            && match self.kind.about().several_by {
                None => true,
                Some(_) if self.kind.is_periodic() => {
                    self.waves(stroke).any(|a| other.waves(stroke).any(|b| close(a, b)))
                }
                Some(axis) => within(APART, self.shape[axis], other.shape[axis]),
            }
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
