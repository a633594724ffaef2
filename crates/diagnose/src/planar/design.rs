//! The rows of recordings in the plane: x and y of one time stand in the same block, so that one regression, its held-out
//! blocks and its sign flips take both axes.

use crate::regression::linear::Blocks;
use identify::planar::{Ellipse, Track};
use signals::{Basis, PlanarPrepared, dot};

/// Fewest rows of an axis that can be split into blocks, fitted and held out.
pub(super) const FEWEST_ROWS: f64 = 60.0;

/// Fewest rows of a stretch.
const FEWEST_OF_STRETCH: usize = 24;

/// Stretches that are long enough, behind a filter at `cutoff` Hz, and the recording of each.
pub(super) fn tracks(prepared: &[PlanarPrepared], cutoff: f64) -> (Vec<Track>, Vec<usize>) {
    let of = |(index, p): (usize, &PlanarPrepared)| {
        p.stretches.iter().map(|s| (Track::new(s.clone(), cutoff), index)).collect::<Vec<_>>()
    };
    prepared.iter().enumerate().flat_map(of).filter(|(t, _)| t.row_count() >= FEWEST_OF_STRETCH).unzip()
}

/// A row: its stretch, its axis and its number in the stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub track: usize,
    pub axis: usize,
    pub r: usize,
}

/// Both axes as one regression.
#[derive(Debug, Clone)]
pub(super) struct Design {
    pub tracks: Vec<Track>,
    pub rows: Vec<Row>,
    /// Share of each row's samples that are used.
    pub share: Vec<f64>,
    pub blocks: Blocks,
    /// Filtered, masked force.
    pub force: Vec<f64>,
    /// The ellipse about which the level is linear; a disc where none was found.
    pub ellipse: Ellipse,
    /// Which of [`BASELINE`] the motion tells apart.
    pub present: Vec<usize>,
}

/// What the columns of the baseline are the coefficients of. The mass stands first: its errors are those of the regression.
pub(super) const BASELINE: [(&str, &str); 8] = [
    ("mass", "kg"),
    ("mass_difference", "kg"),
    ("level", "N"),
    ("viscous_xx", "N·s/m"),
    ("viscous_xy", "N·s/m"),
    ("viscous_yy", "N·s/m"),
    ("offset_x", "N"),
    ("offset_y", "N"),
];
/// The level among them.
const LEVEL: usize = 2;
/// Share of a column outside those before it below which the motion does not tell it from them.
const OUTSIDE: f64 = 1e-2;

impl Design {
    /// None where too few rows are left. `recording` says which recording each stretch is of.
    pub fn new(tracks: Vec<Track>, recording: &[usize]) -> Option<Self> {
        let total: usize = tracks.iter().map(Track::row_count).sum();
        let wanted = (total / 20).clamp(8, 48);
        let (mut rows, mut edges, mut starts, mut recordings) = (Vec::new(), vec![0], Vec::new(), Vec::new());
        for (track, t) in tracks.iter().enumerate() {
            let n = t.row_count();
            let count = ((n * wanted + total / 2) / total.max(1)).max(1);
            for b in 0..count {
                let part = b * n / count..(b + 1) * n / count;
                rows.extend(
                    [0, 1].into_iter().flat_map(|axis| part.clone().map(move |r| Row { track, axis, r })),
                );
                edges.push(rows.len());
                starts.push(b == 0);
                recordings.push(recording[track]);
            }
        }
        let mut design = Self {
            tracks,
            rows,
            share: Vec::new(),
            blocks: Blocks { edges, starts, recordings, ..Blocks::default() },
            force: Vec::new(),
            ellipse: Ellipse { level: 1.0, ..Ellipse::default() },
            present: (0..BASELINE.len()).collect(),
        };
        design.share = design.arranged(|t| {
            let share = t.share();
            [share.clone(), share]
        });
        if design.share.iter().filter(|s| **s > 0.5).count() < 2 * FEWEST_ROWS as usize {
            return None;
        }
        design.force = design.column(|t| t.f.clone());
        let noise = design.arranged(|t| {
            let share = t.share();
            t.acceleration_noise.map(|std| share.iter().map(|s| s * std * std).collect())
        });
        design.blocks.noise =
            (0..design.blocks.len()).map(|k| noise[design.blocks.rows(k)].iter().sum()).collect();
        let mut basis = Basis::default();
        let mut tells = |column: &Vec<f64>| {
            let rest = basis.project_out(column);
            let apart = dot(&rest, &rest) > OUTSIDE * OUTSIDE * dot(column, column);
            apart && basis.push(column)
        };
        let all = design.baseline();
        design.present = (0..all.len()).filter(|i| tells(&all[*i])).collect();
        design.present.contains(&LEVEL).then_some(design)
    }

    /// Place of the level among the columns of the baseline.
    pub fn level(&self) -> usize {
        self.present.iter().position(|p| *p == LEVEL).unwrap_or_default()
    }

    /// Rows of each stretch and axis in the order of the regression.
    pub fn arranged(&self, of: impl Fn(&Track) -> [Vec<f64>; 2]) -> Vec<f64> {
        let all: Vec<[Vec<f64>; 2]> = self.tracks.iter().map(of).collect();
        self.rows.iter().map(|row| all[row.track][row.axis][row.r]).collect()
    }

    /// A column of unfiltered series: what is set aside taken out, behind the filter.
    pub fn column(&self, of: impl Fn(&Track) -> [Vec<f64>; 2]) -> Vec<f64> {
        self.arranged(|t| {
            let [x, y] = of(t);
            [t.rows(&x), t.rows(&y)]
        })
    }

    /// Columns of the baseline, about the present ellipse.
    pub fn baseline(&self) -> Vec<Vec<f64>> {
        let none = |t: &Track| vec![0.0; t.len()];
        let ones = |t: &Track| vec![1.0; t.len()];
        let against = |series: &[f64]| series.iter().map(|x| -x).collect::<Vec<_>>();
        let of = |column: &usize| match column {
            0 => self.column(|t| t.a.clone()),
            1 => self.column(|t| [t.a[0].clone(), against(&t.a[1])]),
            2 => self.bent(1),
            3 => self.column(|t| [t.v[0].clone(), none(t)]),
            4 => self.column(|t| [t.v[1].clone(), t.v[0].clone()]),
            5 => self.column(|t| [none(t), t.v[1].clone()]),
            6 => self.column(|t| [ones(t), none(t)]),
            _ => self.column(|t| [none(t), ones(t)]),
        };
        self.present.iter().map(of).collect()
    }

    /// Column of the level about the present ellipse.
    pub fn level_column(&self) -> Vec<f64> {
        self.bent(1)
    }

    /// Derivative of the friction by `level` (1), `c` (2) and `s` (3) of the ellipse.
    fn bent(&self, part: usize) -> Vec<f64> {
        self.column(|t| {
            let at = |i: usize| self.ellipse.force(t.v[0][i], t.v[1][i])[part];
            let forces: Vec<[f64; 2]> = (0..t.len()).map(at).collect();
            [0, 1].map(|axis| forces.iter().map(|f| f[axis]).collect())
        })
    }

    /// Columns of the anisotropy about the present ellipse.
    pub fn anisotropy(&self) -> Vec<Vec<f64>> {
        vec![self.bent(2), self.bent(3)]
    }

    /// The force, moved so that c and s themselves are the coefficients of [`Design::anisotropy`].
    pub fn target(&self, anisotropy: &[Vec<f64>]) -> Vec<f64> {
        let mut out = self.force.clone();
        for (column, value) in anisotropy.iter().zip([self.ellipse.c, self.ellipse.s]) {
            for (y, x) in out.iter_mut().zip(column) {
                *y += value * x;
            }
        }
        out
    }

    /// Effective number of rows in each block.
    pub fn block_weight(&self) -> Vec<f64> {
        (0..self.blocks.len()).map(|k| self.blocks.rows(k).map(|r| self.share[r]).sum()).collect()
    }

    /// Mean of a series over the used samples of each row.
    pub fn means(&self, of: impl Fn(&Track) -> [Vec<f64>; 2]) -> Vec<f64> {
        self.arranged(|t| {
            let [x, y] = of(t);
            [t.row_means(&x), t.row_means(&y)]
        })
    }
}
