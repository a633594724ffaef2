//! How far apart two explanations are on what was recorded and on what could be, by normal equations: the recorded part
//! is summed once, however many moves are considered.

use nalgebra::{DMatrix, DVector};
use signals::dot;

/// One explanation as the truth on one design matrix.
#[derive(Debug, Clone)]
pub(crate) struct Contrast {
    /// What it says beyond the other, as both are fitted.
    pub target: Vec<f64>,
    /// The effect's own force.
    pub own: Vec<f64>,
    /// Columns both have.
    pub shared: Vec<Vec<f64>>,
    /// Columns only the other has.
    pub answer: Vec<Vec<f64>>,
    /// Factor that an effect of nominal size was given.
    pub scale: Option<f64>,
}

/// Sums of squares and products of a contrast.
#[derive(Debug, Clone)]
struct Sums {
    gram: DMatrix<f64>,
    target: DVector<f64>,
    own: DVector<f64>,
    target_power: f64,
    own_power: f64,
    shared: usize,
}

impl Sums {
    fn of(contrast: &Contrast) -> Self {
        let columns: Vec<&[f64]> =
            contrast.shared.iter().chain(&contrast.answer).map(Vec::as_slice).collect();
        let p = columns.len();
        let mut gram = DMatrix::zeros(p, p);
        for i in 0..p {
            for j in 0..=i {
                gram[(i, j)] = dot(columns[i], columns[j]);
                gram[(j, i)] = gram[(i, j)];
            }
        }
        let against = |y: &[f64]| DVector::from_iterator(p, columns.iter().map(|c| dot(c, y)));
        Self {
            gram,
            target: against(&contrast.target),
            own: against(&contrast.own),
            target_power: dot(&contrast.target, &contrast.target),
            own_power: dot(&contrast.own, &contrast.own),
            shared: contrast.shared.len(),
        }
    }

    /// This information plus `times` that of another design matrix.
    fn plus(&self, other: &Self, times: f64) -> Self {
        Self {
            gram: &self.gram + &other.gram * times,
            target: &self.target + &other.target * times,
            own: &self.own + &other.own * times,
            target_power: self.target_power + other.target_power * times,
            own_power: self.own_power + other.own_power * times,
            shared: self.shared,
        }
    }

    /// Squared distance from the explanation to the nearest the other can say.
    fn left(&self) -> f64 {
        left(&self.gram, &self.target, self.target_power)
    }

    /// Cosine between the effect's force and what the other has for it, what both share projected out; with nothing else
    /// to answer, between the force and what is shared.
    fn cosine(&self) -> f64 {
        let all = left(&self.gram, &self.own, self.own_power);
        let n = self.shared;
        let before = if n < self.gram.nrows() {
            left(
                &self.gram.view((0, 0), (n, n)).into_owned(),
                &self.own.rows(0, n).into_owned(),
                self.own_power,
            )
        } else {
            self.own_power
        };
        if before > 1e-9 * self.own_power { (1.0 - all / before).clamp(0.0, 1.0).sqrt() } else { 1.0 }
    }
}

/// What is left of a vector of squared length `power` outside the span of columns, given by their products. Scaled to
/// unit diagonal; columns that depend on others share what they explain.
pub(crate) fn left(gram: &DMatrix<f64>, moment: &DVector<f64>, power: f64) -> f64 {
    let p = gram.nrows();
    let scale: Vec<f64> =
        (0..p).map(|i| if gram[(i, i)] > 0.0 { gram[(i, i)].sqrt().recip() } else { 0.0 }).collect();
    let unit =
        DMatrix::from_fn(p, p, |i, j| if i == j { 1.0 + 1e-10 } else { gram[(i, j)] * scale[i] * scale[j] });
    let moment = DVector::from_fn(p, |i, _| moment[i] * scale[i]);
    match unit.cholesky() {
        Some(c) => (power - moment.dot(&c.solve(&moment))).max(0.0),
        // cannot be told: nothing is promised
        None => 0.0,
    }
}

/// What was recorded so far says about a question.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    forth: Sums,
    back: Option<Sums>,
    /// Factor that an effect of nominal size was given, where the recordings excite it.
    pub scale: Option<f64>,
}

/// How far apart the explanations are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judged {
    /// In noise floors, on what was recorded.
    pub now: f64,
    /// In noise floors, with the move.
    pub after: f64,
    /// On what was recorded.
    pub cosine_now: f64,
    /// With the move.
    pub cosine: f64,
}

impl Evidence {
    pub fn new(forth: Contrast, back: Option<Contrast>) -> Self {
        Self { forth: Sums::of(&forth), back: back.as_ref().map(Sums::of), scale: forth.scale }
    }

    /// The same with one more design matrix, that comes `times` over; None where numbers are not finite.
    pub fn with(&self, forth: &Contrast, back: Option<&Contrast>, times: f64, floor: f64) -> Option<Judged> {
        let forth = Sums::of(forth);
        let back = back.map(Sums::of);
        let both = |now: f64, other: Option<f64>| other.map_or(now, |o| now.min(o));
        let now = both(self.forth.left(), self.back.as_ref().map(Sums::left));
        let joint = self.back.as_ref().zip(back.as_ref()).map(|(a, b)| a.plus(b, times).left());
        let together = self.forth.plus(&forth, times);
        let after = both(together.left(), joint);
        let judged = Judged {
            now: now.sqrt() / floor,
            after: after.sqrt() / floor,
            cosine_now: self.forth.cosine(),
            cosine: together.cosine(),
        };
        (judged.now.is_finite() && judged.after.is_finite()).then_some(judged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, w: f64, phase: f64) -> Vec<f64> {
        (0..n).map(|i| (w * i as f64 + phase).sin()).collect()
    }

    #[test]
    fn a_second_frequency_tells_mass_from_spring() {
        // acceleration −ω²x and position x on one sine are one column; on two they are not
        let contrast = |w: f64| {
            let x = wave(4000, w, 0.0);
            let a: Vec<f64> = x.iter().map(|x| -w * w * x).collect();
            Contrast { target: x.clone(), own: x, shared: vec![a], answer: Vec::new(), scale: None }
        };
        let evidence = Evidence::new(contrast(0.02), None);
        let same = evidence.with(&contrast(0.02), None, 1.0, 0.1).unwrap();
        let other = evidence.with(&contrast(0.05), None, 1.0, 0.1).unwrap();
        println!("the same sine again {:.3}, another {:.1} noise floors", same.after, other.after);
        assert!(same.now < 0.1 && same.after < 0.1 && (same.cosine_now - 1.0).abs() < 1e-9);
        // nearest mass m: Σ (x₁ + m ω₁² x₁)² + …; with equal powers P: P·(ω₂² − ω₁²)²/(ω₁⁴ + ω₂⁴)
        let (a, b) = (0.02_f64.powi(2), 0.05_f64.powi(2));
        let expected = (2000.0 * (b - a).powi(2) / (a * a + b * b)).sqrt() / 0.1;
        assert!((other.after / expected - 1.0).abs() < 0.01, "{} against {expected}", other.after);
    }
}
