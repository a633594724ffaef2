//! A formula for a curve: a sparse search over what machines make, judged by the band of the curve.

use crate::free_form::change::Change;
use crate::free_form::term::FreeTerm;
use friction::{Coordinate, Factor};
use signals::{Basis, dot};

/// What a shape parameter of a form is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// A place on the coordinate.
    Place,
    /// A width, a length, a scale of it.
    Scale,
    /// An exponent.
    Power,
}

/// A form of the grammar.
struct Form {
    /// With `u` for the coordinate.
    formula: &'static str,
    shape: &'static [(&'static str, Shape)],
    of: fn(f64, [f64; 2]) -> f64,
    /// Coordinates on which it is tried.
    over: &'static [Coordinate],
    /// What in a machine usually makes it.
    made_by: &'static str,
}

use Coordinate::{
    Acceleration, DistanceSinceReversal, Moved, Position, Slid, Speed, Time, TimeSinceReversal, Velocity,
};
use Shape::{Place, Power, Scale};

const FORMS: &[Form] = &[
    Form {
        formula: "max(u - u_0, 0)",
        shape: &[("u_0", Place)],
        of: |u, [at, _]| (u - at).max(0.0),
        over: &[Position, Acceleration, Slid],
        made_by: "a spring, a cable chain or a bellows that is taken along from a certain place on",
    },
    Form {
        formula: "max(u_0 - u, 0)",
        shape: &[("u_0", Place)],
        of: |u, [at, _]| (at - u).max(0.0),
        over: &[Position, Acceleration],
        made_by: "a spring, a cable chain or a bellows that is taken along up to a certain place",
    },
    Form {
        formula: "exp(-((u - u_0)/w)^2)",
        shape: &[("u_0", Place), ("w", Scale)],
        of: |u, [at, w]| (-((u - at) / w).powi(2)).exp(),
        over: &[Position, Velocity, Speed, Acceleration],
        made_by: "one bad place: dried lubricant, dirt, a dent, a bent or tight piece of the guide",
    },
    Form {
        formula: "(u - u_0)/w*exp(-((u - u_0)/w)^2)",
        shape: &[("u_0", Place), ("w", Scale)],
        of: |u, [at, w]| (u - at) / w * (-((u - at) / w).powi(2)).exp(),
        over: &[Position],
        made_by: "a detent: a magnet, a ball in a groove, a catch",
    },
    Form {
        formula: "u^2",
        shape: &[],
        of: |u, _| u * u,
        over: &[Position, Acceleration],
        made_by: "a spring or a guide that is not symmetric",
    },
    Form {
        formula: "u^3",
        shape: &[],
        of: |u, _| u.powi(3),
        over: &[Position],
        made_by: "a spring that stiffens: a flexure, a bellows, a cable",
    },
    Form {
        formula: "u",
        shape: &[],
        of: |u, _| u,
        over: &[Position, Time, Slid],
        made_by: "a spring, a slope, a drift",
    },
    Form {
        formula: "u",
        shape: &[],
        of: |u, _| u,
        over: &[Moved],
        made_by: "something that gives way slowly: a belt, a rubber part, a cable or a hose (a Maxwell element)",
    },
    Form {
        formula: "u^2",
        shape: &[],
        of: |u, _| u * u,
        over: &[Velocity],
        made_by: "something that is thrown outward or blown: a linkage that turns, a fan",
    },
    Form {
        formula: "sin(2*pi*(u - u_0)/w)",
        shape: &[("u_0", Place), ("w", Scale)],
        of: |u, [at, w]| (std::f64::consts::TAU * (u - at) / w).sin(),
        over: &[Position, Time],
        made_by: "something that turns: a bent screw, poles of a motor, a fan, the mains",
    },
    Form {
        formula: "u/(1 + (u/u_0)^2)",
        shape: &[("u_0", Scale)],
        of: |u, [at, _]| u / (1.0 + (u / at).powi(2)),
        over: &[Velocity, Speed],
        made_by: "an eddy-current brake: a magnet over a conductor",
    },
    Form {
        formula: "u^p",
        shape: &[("p", Power)],
        of: |u, [p, _]| u.abs().powf(p).copysign(u),
        over: &[Velocity, Speed],
        made_by: "a lubricant that thins as it is sheared, or a fluid that is pushed aside",
    },
    Form {
        formula: "ln(1 + |u|/u_0)",
        shape: &[("u_0", Scale)],
        of: |u, [at, _]| (u.abs() / at).ln_1p(),
        over: &[Speed, TimeSinceReversal, DistanceSinceReversal],
        made_by: "contacts that creep: polymers, paper, rock",
    },
    Form {
        formula: "exp(-u/u_0)",
        shape: &[("u_0", Scale)],
        of: |u, [at, _]| (-u / at).exp(),
        over: &[Speed, Time, DistanceSinceReversal, TimeSinceReversal, Slid],
        made_by: "something that settles: grease that warms up, a film that is built up, a contact that is renewed",
    },
    Form {
        formula: "|u|",
        shape: &[],
        of: |u, _| u.abs(),
        over: &[Acceleration, Velocity],
        made_by: "friction of what the acceleration loads, or a direction of the drive with another gain",
    },
];

/// What in a machine usually changes at one moment.
const CHANGES: &str = "something that happened once: a part that came loose or was added, a wiper that let go, a supply or a \
                       gain that was switched";

/// Places tried for each shape parameter, and how often the best is looked at closer.
const TRIED: usize = 17;
const CLOSER: usize = 4;
/// Largest mean square of the distance to the curve, in standard deviations, of a formula that is within its band.
const WITHIN: f64 = 2.0;

/// A formula that a curve looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// In the coordinate's own name.
    pub formula: String,
    /// Its size, in the unit of the curve's values.
    pub gain: (f64, f64),
    /// Shape parameters: name, value, and whether it has the unit of the coordinate.
    pub shape: Vec<(String, f64, bool)>,
    /// The next best formula.
    pub runner_up: Option<String>,
    /// What in a machine usually makes such a curve.
    pub made_by: &'static str,
}

/// A form fitted to a curve.
struct Fitted<'a> {
    form: &'a Form,
    shape: [f64; 2],
    gain: (f64, f64),
    chi_square: f64,
}

/// The formula within the band of a curve, the simplest first; None for a map, or where there is none.
pub fn looks_like(term: &FreeTerm) -> Option<Formula> {
    let form = &term.form;
    if form.across.is_some() {
        return None;
    }
    if let Some(change) = Change::of(term) {
        return Some(Formula {
            formula: "step(time - t_0)".into(),
            gain: (change.size(), change.std),
            shape: vec![("t_0".into(), change.at, true)],
            runner_up: None,
            made_by: CHANGES,
        });
    }
    let (u, values) = (form.knots.places(), form.values());
    let size = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let weight: Vec<f64> = term.std.iter().map(|s| s.max(0.01 * size).recip()).collect();
    let weighted = |of: &dyn Fn(usize) -> f64| (0..u.len()).map(|k| weight[k] * of(k)).collect::<Vec<f64>>();
    // what the baseline takes of a curve is not known of it
    let mut absorbed = vec![weighted(&|_| 1.0)];
    match (form.over, form.times) {
        (Velocity, Factor::One) => {
            absorbed.extend([weighted(&|k| u[k].signum()), weighted(&|k| u[k]), weighted(&|k| u[k].abs())])
        }
        (Speed, _) | (Acceleration, Factor::One) => absorbed.push(weighted(&|k| u[k])),
        _ => {}
    }
    let basis = Basis::of(&absorbed);
    let y = basis.project_out(&weighted(&|k| values[k]));
    let whole = dot(&y, &y);
    let mut fitted: Vec<(usize, Fitted)> = FORMS
        .iter()
        .filter(|f| f.over.contains(&form.over))
        .filter_map(|f| {
            // between two knots there is nothing but the straight line
            let free = u.len().checked_sub(absorbed.len() + 1 + f.shape.len())?;
            let free = if u.len() == 2 { 1 } else { Some(free).filter(|n| *n > 0)? };
            let at = |shape: [f64; 2]| -> Option<Fitted> {
                let g = basis.project_out(&weighted(&|k| (f.of)(u[k], shape)));
                let power = dot(&g, &g);
                if !(power > 1e-12) || !power.is_finite() {
                    return None;
                }
                let gain = dot(&g, &y) / power;
                let chi_square = (whole - gain * gain * power).max(0.0) / free as f64;
                Some(Fitted { form: f, shape, gain: (gain, power.sqrt().recip()), chi_square })
            };
            Some((f.shape.len(), best(f, u, &at)?))
        })
        .collect();
    fitted.sort_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square));
    let within: Vec<&(usize, Fitted)> = fitted.iter().filter(|f| f.1.chi_square <= WITHIN).collect();
    let (_, first) = within.iter().min_by_key(|f| f.0)?;
    let name = form.over.id();
    let written = |f: &Form| f.formula.replace("u_0", "\u{1}").replace('u', name).replace('\u{1}', "u_0");
    let runner_up = fitted.iter().find(|f| !std::ptr::eq(f.1.form, first.form)).map(|f| written(f.1.form));
    let shape = first.form.shape.iter().zip(first.shape);
    Some(Formula {
        formula: written(first.form),
        gain: first.gain,
        shape: shape.map(|((n, kind), x)| ((*n).to_string(), x, *kind != Power)).collect(),
        runner_up,
        made_by: first.form.made_by,
    })
}

/// The best shape of a form: over a grid, then closer about the best.
fn best<'a>(form: &Form, u: &[f64], at: &dyn Fn([f64; 2]) -> Option<Fitted<'a>>) -> Option<Fitted<'a>> {
    let (low, high) = (u[0], u[u.len() - 1]);
    let span = high - low;
    let range = |i: usize| match form.shape.get(i).map(|s| s.1) {
        Some(Place) => (low, high),
        Some(Scale) => (0.04 * span, 3.0 * span),
        Some(Power) => (0.2, 4.0),
        None => (0.0, 0.0),
    };
    let mut ranges = [range(0), range(1)];
    let mut found: Option<Fitted> = None;
    for _ in 0..=CLOSER {
        let grid = |(low, high): (f64, f64)| {
            let count = if low < high { TRIED } else { 1 };
            (0..count).map(move |k| low + (high - low) * k as f64 / (TRIED - 1) as f64)
        };
        for a in grid(ranges[0]) {
            for b in grid(ranges[1]) {
                if let Some(f) = at([a, b])
                    && found.as_ref().is_none_or(|x| f.chi_square < x.chi_square)
                {
                    found = Some(f);
                }
            }
        }
        let centre = found.as_ref()?.shape;
        for (i, r) in ranges.iter_mut().enumerate() {
            let (low, high) = range(i);
            let half = 0.2 * (r.1 - r.0);
            *r = ((centre[i] - half).max(low), (centre[i] + half).min(high));
        }
    }
    found
}
