//! Every effect at every shape worth trying, and which of them a recording can show.

use crate::library::design_matrix::{DesignMatrix, gather, shapes_together};
use crate::library::kept::Column;
use crate::library::scales::Scales;
use crate::library::term::{Term, TermKind};
use crate::search::hypothesis::Atom;
use friction::effects::{Acts, MAX_SHAPE};
use rayon::prelude::*;
use signals::Basis;
use std::sync::Arc;

/// Share of an effect left outside the baseline (U) below which a recording is said to be blind to it.
pub const CONCEALED: f64 = 0.1;
/// The same for a gain of the whole force channel, below which it is not looked for: nearly all of it is friction and mass
/// of another size, and as it has no shape to choose it is found by the little that is not.
const CONCEALED_GAIN: f64 = 0.04;

/// The catalogue evaluated on a design matrix.
#[derive(Debug, Clone)]
pub struct Catalogue {
    /// Every effect at every shape of the grid.
    pub atoms: Vec<Atom>,
    /// Basis of the baseline.
    pub baseline: Basis,
}

impl Catalogue {
    /// Evaluates the catalogue over its grid; `noisy` is the same design matrix with one more draw of sensor noise.
    ///
    /// `lines` are wavelengths finer than the grid's that stand out of the residual.
    pub fn new(
        design: &DesignMatrix,
        noisy: &DesignMatrix,
        scales: &Scales,
        lines: &[f64],
        exclude: &[&str],
    ) -> Self {
        let baseline = Basis::of(&design.baseline);
        let mut groups = Vec::new();
        for kind in TermKind::all() {
            if !exclude.contains(&kind.id()) {
                let mut shapes = scales.grid(kind);
                if kind.is_periodic() {
                    shapes.extend(lines.iter().map(|line| [*line, 0.0]));
                }
                groups.extend(shapes.chunks(shapes_together(kind)).map(|shapes| (kind, shapes.to_vec())));
            }
        }
        let evaluate = |(kind, shapes): &(TermKind, Vec<[f64; MAX_SHAPE]>)| -> Vec<Atom> {
            let (clean, other) = (design.columns_at(*kind, shapes), noisy.columns_at(*kind, shapes));
            let held = |columns: Vec<Vec<f64>>| columns.into_iter().map(Arc::new).collect::<Vec<Column>>();
            let of_shape = |shape: &[f64; MAX_SHAPE], clean: Vec<Column>, other: Vec<Column>| {
                let variant = |(variant, groups): (usize, &&'static [&'static [usize]])| {
                    let term = Term { kind: *kind, shape: *shape, variant };
                    let noise = |c: &[f64]| design.noise_beside(c);
                    let mut atom = Atom::of(shared(&clean, groups), &baseline, noise, term);
                    atom.reliable = reliability(&shared(&other, groups), &baseline, &atom);
                    atom
                };
                kind.variants().iter().enumerate().map(variant).collect::<Vec<_>>()
            };
            let columns = clean.into_iter().zip(other);
            shapes.iter().zip(columns).flat_map(|(s, (c, o))| of_shape(s, held(c), held(o))).collect()
        };
        // In the order of the catalogue whatever the number of workers: everything random hangs on it.
        let atoms = groups.par_iter().flat_map_iter(evaluate).collect();
        Self { atoms, baseline }
    }

    /// Evaluates what the force that acts is part of once more, on stages of which only that force is another.
    pub fn renew(&mut self, design: &DesignMatrix, noisy: &DesignMatrix) {
        let baseline = &self.baseline;
        self.atoms.par_iter_mut().filter(|a| a.term.kind.reads_force()).for_each(|atom| {
            *atom = Atom::new(design, baseline, atom.term);
            let other: Vec<Column> = noisy.columns(&atom.term).into_iter().map(Arc::new).collect();
            atom.reliable = reliability(&other, baseline, atom);
        });
    }

    /// Takes an effect out.
    pub fn exclude(&mut self, kind: TermKind) {
        self.atoms.retain(|a| a.term.kind != kind);
    }

    /// Atoms that this recording can show: visible beside the baseline, and more signal than noise.
    pub fn testable(&self) -> Vec<&Atom> {
        self.atoms.iter().filter(|a| is_testable(a)).collect()
    }
}

/// Whether an atom may be found: it stands out of the baseline at all, and above its own noise.
pub fn is_testable(atom: &Atom) -> bool {
    let kind = atom.term.kind;
    let least = if kind.acts(Acts::OnForce) && kind.shape().is_empty() { CONCEALED_GAIN } else { CONCEALED };
    !atom.columns.is_empty() && atom.visible >= least && atom.reliable >= needed_reliability(atom.term.kind)
}

/// Whether the recording can be relied on to show it: what is not found is not there.
pub fn is_shown(atom: &Atom) -> bool {
    is_testable(atom) && atom.visible >= CONCEALED
}

pub(crate) fn needed_reliability(kind: TermKind) -> f64 {
    // The noise of these is the acceleration's own noise seen again: it correlates with the residual.
    if kind.acts(Acts::OnMotion) {
        0.99
    } else if kind.acts(Acts::Behind) {
        0.9
    } else {
        0.7
    }
}

/// Sums of the columns that share a gain; a column that has one of its own is shared itself.
fn shared(all: &[Column], groups: &[&[usize]]) -> Vec<Column> {
    let slices: Vec<&[f64]> = all.iter().map(|c| c.as_slice()).collect();
    let of = |group: &&[usize]| match *group {
        [own] => all.get(*own).cloned(),
        several => gather(&slices, &[several]).pop().map(Arc::new),
    };
    groups.iter().filter_map(of).collect()
}

fn reliability(other: &[Column], baseline: &Basis, atom: &Atom) -> f64 {
    let (mut signal, mut noise) = (0.0, 0.0);
    for (column, i) in atom.columns.iter().zip(&atom.active) {
        let Some(other) = other.get(*i) else { continue };
        let change: Vec<f64> = column.iter().zip(other.iter()).map(|(a, b)| a - b).collect();
        signal += baseline.left(column);
        noise += baseline.left(&change);
    }
    if signal > 0.0 { 1.0 - noise / signal } else { 0.0 }
}
