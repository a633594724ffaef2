//! Dahl's law fitted to a recording: residuals and exact derivatives by running the law itself on dual numbers.

use friction::{Dahl, DahlState, FrictionLaw, Motion, Scalar};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{Const, DMatrix, DVector, Dyn, Owned};
use num_dual::DualSVec64;

/// Three directions of derivative: those in which the law is not linear.
type Dual = DualSVec64<3>;

/// Positions in the parameter vector: mass, viscous as they are, the others as logarithms.
pub(crate) const MASS: usize = 0;
pub(crate) const VISCOUS: usize = 1;
pub(crate) const LIMIT_P: usize = 2;
pub(crate) const LIMIT_N: usize = 3;
pub(crate) const SIGMA: usize = 4;
pub(crate) const COUNT: usize = 5;

/// The motion of a recording, ready to be slid along. Equal lengths.
pub(crate) struct Trace<'a> {
    /// s.
    pub dt: f64,
    /// Distance slid in the step that ends at a sample, m.
    pub displacement: &'a [f64],
    /// m/s.
    pub velocity: &'a [f64],
    /// Mass column and viscous column, behind the filter of the force, rows that are fitted.
    pub linear: [Vec<f64>; 2],
    /// Force behind its filter, rows that are fitted, N.
    pub force: Vec<f64>,
    /// The filter of the force, and the choice of rows: from every sample to the rows that are fitted.
    pub rows: &'a dyn Fn(&[f64]) -> Vec<f64>,
    /// Error variances of the mass and viscous columns.
    pub errors: [f64; 2],
    /// Whether to end early; what a fit returns is then worth nothing.
    pub is_interrupted: &'a (dyn Fn() -> bool + 'a),
}

/// Bounds of ln σ and ln D: far outside anything physical, so that a bad start cannot overflow.
const LOG_LEVEL: f64 = 14.0;
const LOG_SIGMA: (f64, f64) = (0.0, 25.0);

/// Parameters as the minimiser moves them.
pub(crate) type Point = [f64; COUNT];

/// Clamps a point to where every number is finite.
fn bounded(p: &Point) -> Point {
    let mut q = *p;
    for k in [LIMIT_P, LIMIT_N] {
        q[k] = q[k].clamp(-20.0, LOG_LEVEL);
    }
    q[SIGMA] = q[SIGMA].clamp(LOG_SIGMA.0, LOG_SIGMA.1);
    q
}

impl Trace<'_> {
    /// Friction of the law at every sample, with its derivatives by ln D_p, ln D_n, ln σ.
    fn slide(&self, p: &Point) -> (Vec<f64>, [Vec<f64>; 3]) {
        let p = bounded(p);
        let log = |k: usize, i: usize| Dual::lit(p[k]).derivative(i).exp();
        let (limit_p, limit_n) = (log(LIMIT_P, 0), log(LIMIT_N, 1));
        let law = Dahl {
            limit_p,
            limit_n,
            sigma: log(SIGMA, 2),
            exponent: Dual::lit(1.0),
            viscous: Dual::lit(0.0),
        };
        let zero = Dual::lit(0.0);
        // A recording that begins in motion begins with the bristle bent.
        let z = match self.velocity.first() {
            Some(v) if *v > 0.0 => limit_p,
            Some(v) if *v < 0.0 => -limit_n,
            _ => zero,
        };
        let mut state = DahlState { z };
        let n = self.velocity.len();
        let mut value = Vec::with_capacity(n);
        let mut slopes = [Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n)];
        for (dx, v) in self.displacement.iter().zip(self.velocity) {
            let motion = Motion {
                dt: Dual::lit(self.dt),
                displacement: Dual::lit(*dx),
                velocity: Dual::lit(*v),
                ..Motion::default()
            };
            let force = law.step(&mut state, &motion);
            value.push(force.re);
            let by_parameter = force.eps.unwrap_generic(Const::<3>, Const::<1>);
            for (slope, derivative) in slopes.iter_mut().zip(&by_parameter) {
                slope.push(*derivative);
            }
        }
        (value, slopes)
    }

    /// Residual, model less measured, and its derivatives by the free parameters.
    pub fn linearise(&self, p: &Point, free: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
        let (value, slopes) = self.slide(p);
        let friction = (self.rows)(&value);
        let residual = DVector::from_iterator(
            self.force.len(),
            (0..self.force.len()).map(|i| {
                p[MASS] * self.linear[0][i] + p[VISCOUS] * self.linear[1][i] + friction[i] - self.force[i]
            }),
        );
        let mut jacobian = DMatrix::zeros(self.force.len(), free.len());
        for (j, k) in free.iter().enumerate() {
            let column = match *k {
                MASS => self.linear[0].clone(),
                VISCOUS => self.linear[1].clone(),
                other => (self.rows)(&slopes[other - LIMIT_P]),
            };
            for (i, x) in column.iter().enumerate() {
                jacobian[(i, j)] = *x;
            }
        }
        (residual, jacobian)
    }

    /// Σe² corrected for the errors in the mass and viscous columns: unbiased, as [thesis, eq. 3.9] is.
    pub fn cost(&self, p: &Point, residual: &DVector<f64>) -> f64 {
        let n = residual.len() as f64;
        residual.norm_squared()
            - n * (self.errors[0] * p[MASS] * p[MASS] + self.errors[1] * p[VISCOUS] * p[VISCOUS])
    }

    /// Levenberg-Marquardt from `start` over the parameters `free`.
    pub fn minimise(&self, start: &Point, free: &[usize], patience: usize) -> Fitted {
        if (self.is_interrupted)() {
            return Fitted { point: *start, cost: f64::INFINITY, converged: false, evaluations: 0 };
        }
        let problem = Free { trace: self, point: bounded(start), free, now: None };
        let (problem, report) = LevenbergMarquardt::new()
            .with_ftol(1e-10)
            .with_xtol(1e-8)
            .with_gtol(1e-10)
            .with_patience(patience)
            .minimize(problem.evaluated());
        // Beyond the bounds nothing changes, so a minimiser may end anywhere there.
        let point = bounded(&self.corrected(problem.point, free));
        let (residual, _) = self.linearise(&point, &[]);
        let converged = report.termination.was_successful()
            || matches!(report.termination, TerminationReason::NoImprovementPossible(_));
        let cost = self.cost(&point, &residual);
        Fitted {
            point,
            cost: if cost.is_finite() { cost } else { f64::INFINITY },
            converged,
            evaluations: report.number_of_evaluations,
        }
    }

    /// A few Gauss-Newton steps of Fuller's equations: least squares alone shrinks a mass whose column has errors.
    fn corrected(&self, mut p: Point, free: &[usize]) -> Point {
        if self.errors == [0.0, 0.0] {
            return p;
        }
        let n = self.force.len() as f64;
        for _ in 0..4 {
            if (self.is_interrupted)() {
                break;
            }
            let (residual, jacobian) = self.linearise(&p, free);
            let mut normal = jacobian.tr_mul(&jacobian);
            let mut gradient = -jacobian.tr_mul(&residual);
            for (j, k) in free.iter().enumerate() {
                if *k < LIMIT_P {
                    normal[(j, j)] -= n * self.errors[*k];
                    gradient[j] += n * self.errors[*k] * p[*k];
                }
                normal[(j, j)] *= 1.0 + 1e-9;
            }
            let Some(step) = normal.cholesky().map(|c| c.solve(&gradient)) else { break };
            // A direction that is flat has no step worth taking.
            for (j, k) in free.iter().enumerate() {
                let most = if *k < LIMIT_P { f64::INFINITY } else { 0.5 };
                p[*k] += step[j].clamp(-most, most);
            }
            p = bounded(&p);
            if !p.iter().all(|x| x.is_finite()) {
                break;
            }
        }
        p
    }
}

/// Where a minimisation ended.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fitted {
    pub point: Point,
    pub cost: f64,
    pub converged: bool,
    pub evaluations: usize,
}

struct Free<'a, 'b> {
    trace: &'a Trace<'b>,
    point: Point,
    free: &'a [usize],
    now: Option<(DVector<f64>, DMatrix<f64>)>,
}

impl Free<'_, '_> {
    fn evaluated(mut self) -> Self {
        self.now = Some(self.trace.linearise(&self.point, self.free));
        self
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Free<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        for (k, value) in self.free.iter().zip(x.iter()) {
            self.point[*k] = *value;
        }
        self.now = Some(self.trace.linearise(&self.point, self.free));
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|k| self.point[*k]))
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        // without residuals the minimiser ends
        if (self.trace.is_interrupted)() {
            return None;
        }
        self.now.as_ref().map(|(r, _)| r.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.now.as_ref().map(|(_, j)| j.clone())
    }
}
