//! Hypotheses about what a simulation in the plane leaves out, as columns of the regression.

use super::design::Design;
use crate::library::scales::Scales;
use crate::library::term::TermKind;
use friction::Motion;
use friction::effects::{About, Anisotropy, Describe, EffectKind, MAX_GAINS, MAX_MEMORY, MAX_SHAPE};
use friction::planar::{DahlState, InPlane, Vector, bent};
use identify::planar::Track;
use signals::{quantile, rms};

/// What a term is a hypothesis about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// The level depends on the direction.
    Anisotropy,
    /// An effect against the motion, or of bristles.
    Effect(EffectKind),
    /// An effect of one axis: x or y.
    Axis(EffectKind, usize),
}

impl Kind {
    /// Every effect that is something in the plane, but those excluded by id.
    pub fn all(exclude: &[String]) -> Vec<Self> {
        let of = |kind: &EffectKind| match InPlane::of(*kind) {
            Some(InPlane::AlongPath | InPlane::Bristles) => vec![Self::Effect(*kind)],
            Some(InPlane::AlongAxes) => vec![Self::Axis(*kind, 0), Self::Axis(*kind, 1)],
            None => Vec::new(),
        };
        let effects = EffectKind::ALL.iter().flat_map(of);
        let all = std::iter::once(Self::Anisotropy).chain(effects);
        all.filter(|k| !exclude.iter().any(|id| id == k.about().id)).collect()
    }

    pub fn about(self) -> &'static About {
        const ANISOTROPY: About = Anisotropy::ABOUT;
        match self {
            Self::Anisotropy => &ANISOTROPY,
            Self::Effect(kind) | Self::Axis(kind, _) => kind.about(),
        }
    }

    /// What its parameters are called beyond their name.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Axis(_, 0) => "_x",
            Self::Axis(..) => "_y",
            _ => "",
        }
    }

    /// Ways its gains may go together, simplest first. Along a path there is one direction.
    fn variants(self) -> &'static [&'static [&'static [usize]]] {
        match self {
            Self::Axis(kind, _) => kind.about().groups,
            _ => &[&[&[0]]],
        }
    }

    /// Shapes to try first.
    fn grid(self, scales: &PlanarScales) -> Vec<[f64; MAX_SHAPE]> {
        match self {
            Self::Anisotropy => vec![[0.0; MAX_SHAPE]],
            Self::Effect(kind) => scales.path.grid(TermKind::Force(kind)),
            Self::Axis(kind, axis) => scales.axes[axis].grid(TermKind::Force(kind)),
        }
    }

    /// Range worth trying of shape parameter `i`.
    pub fn range(self, scales: &PlanarScales, i: usize) -> Option<(f64, f64)> {
        let (kind, of) = match self {
            Self::Anisotropy => return None,
            Self::Effect(kind) => (kind, &scales.path),
            Self::Axis(kind, axis) => (kind, &scales.axes[axis]),
        };
        let (low, high, _) = of.range(kind.shape().get(i)?);
        Some((low, high))
    }

    /// Number of shape parameters that are searched.
    pub fn shapes(self) -> usize {
        if self == Self::Anisotropy { 0 } else { self.about().shape.len() }
    }
}

/// A hypothesis with its shape and the way its gains go together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Term {
    pub kind: Kind,
    pub shape: [f64; MAX_SHAPE],
    pub variant: usize,
}

impl Term {
    /// Gains that share one column each.
    pub fn free(&self) -> &'static [&'static [usize]] {
        if self.kind == Kind::Anisotropy {
            return &[&[0], &[1]];
        }
        self.kind.variants().get(self.variant).copied().unwrap_or_default()
    }

    /// Columns, one for each free gain.
    pub fn columns(&self, design: &Design) -> Vec<Vec<f64>> {
        if self.kind == Kind::Anisotropy {
            return design.anisotropy();
        }
        let units: Vec<Vec<[[f64; 2]; MAX_GAINS]>> =
            design.tracks.iter().map(|t| units(self.kind, &self.shape, t)).collect();
        let column = |members: &&[usize]| {
            let all: Vec<[Vec<f64>; 2]> = units
                .iter()
                .zip(&design.tracks)
                .map(|(unit, t)| {
                    let axis = |axis: usize| -> Vec<f64> {
                        unit.iter().map(|u| members.iter().map(|m| u[*m][axis]).sum()).collect()
                    };
                    match self.kind {
                        Kind::Axis(_, 0) => [t.rows(&axis(0)), vec![0.0; t.row_count()]],
                        Kind::Axis(..) => [vec![0.0; t.row_count()], t.rows(&axis(1))],
                        _ => [t.rows(&axis(0)), t.rows(&axis(1))],
                    }
                })
                .collect();
            design.rows.iter().map(|row| all[row.track][row.axis][row.r]).collect()
        };
        self.free().iter().map(column).collect()
    }
}

/// Force per unit of each gain at every sample, x and y.
fn units(kind: Kind, shape: &[f64; MAX_SHAPE], t: &Track) -> Vec<[[f64; 2]; MAX_GAINS]> {
    let mut memory = [0.0; MAX_MEMORY];
    let mut bristles = DahlState::default();
    let dt = t.raw[0].dt;
    let step = |axis: usize, i: usize| if i > 0 { t.x[axis][i] - t.x[axis][i - 1] } else { 0.0 };
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    let mut at = |i: usize| match kind {
        Kind::Anisotropy => [[0.0; 2]; MAX_GAINS],
        Kind::Axis(kind, axis) => {
            let motion = Motion {
                dt,
                position: t.x[axis][i],
                displacement: step(axis, i),
                velocity: t.v[axis][i],
                ..Motion::default()
            };
            kind.unit(shape, &mut memory, &motion).map(|u| {
                let mut force = [0.0; 2];
                force[axis] = finite(u);
                force
            })
        }
        Kind::Effect(kind) => {
            let displacement = Vector { x: step(0, i), y: step(1, i) };
            let force = if InPlane::of(kind) == Some(InPlane::Bristles) {
                let motion = friction::planar::Motion {
                    dt,
                    displacement,
                    velocity: Vector { x: t.v[0][i], y: t.v[1][i] },
                    ..friction::planar::Motion::default()
                };
                bent(shape[0], &mut bristles, &motion)
            } else {
                let motion = Motion {
                    dt,
                    displacement: displacement.norm(),
                    velocity: t.speed[i].max(1e-12),
                    ..Motion::default()
                };
                let along = finite(kind.unit(shape, &mut memory, &motion)[0]);
                Vector { x: along * t.direction[0][i], y: along * t.direction[1][i] }
            };
            let mut out = [[0.0; 2]; MAX_GAINS];
            out[0] = [finite(force.x), finite(force.y)];
            out
        }
    };
    (0..t.len()).map(&mut at).collect()
}

/// Scales of the path, and of each axis.
#[derive(Debug, Clone)]
pub(super) struct PlanarScales {
    pub path: Scales,
    pub axes: [Scales; 2],
}

impl PlanarScales {
    pub fn of(tracks: &[Track], cutoff: f64) -> Self {
        let largest = |of: &dyn Fn(&Track) -> f64| tracks.iter().map(of).fold(0.0, f64::max);
        let magnitude = |s: &[f64]| quantile(&s.iter().map(|x| x.abs()).collect::<Vec<_>>(), 0.99);
        let stroke = |axis: usize| {
            tracks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), t| {
                (low.min(quantile(&t.x[axis], 0.002)), high.max(quantile(&t.x[axis], 0.998)))
            })
        };
        let fine = largest(&|t| rms(&t.speed) / (4.0 * cutoff));
        let scales = |speed: f64, stroke: (f64, f64), force: f64| Scales {
            duration: largest(&|t| t.len() as f64 * t.raw[0].dt),
            speed,
            slow: largest(&|t| t.guard),
            stroke,
            fine,
            turning: fine,
            force,
            cutoff,
            dt: largest(&|t| t.raw[0].dt),
        };
        let axes = [0, 1].map(|axis| {
            scales(largest(&|t| magnitude(&t.v[axis])), stroke(axis), largest(&|t| magnitude(&t.f[axis])))
        });
        let longest = axes.iter().map(|a| a.stroke.1 - a.stroke.0).fold(0.0, f64::max);
        let path = scales(
            largest(&|t| magnitude(&t.speed)),
            (0.0, longest),
            axes.iter().map(|a| a.force).fold(0.0, f64::max),
        );
        Self { path, axes }
    }
}

/// Every hypothesis at every shape worth trying.
pub(super) fn catalogue(kinds: &[Kind], scales: &PlanarScales) -> Vec<Term> {
    let mut out = Vec::new();
    for kind in kinds {
        let still = matches!(kind, Kind::Axis(_, axis) if !(scales.axes[*axis].stroke.1 > scales.axes[*axis].stroke.0));
        if still {
            continue;
        }
        for shape in kind.grid(scales) {
            out.extend((0..kind.variants().len()).map(|variant| Term { kind: *kind, shape, variant }));
        }
    }
    out
}
