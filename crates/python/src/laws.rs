//! Every law and every effect that is a force, along a series of motion. Names and texts are those of `friction`.

use crate::{arrays, errors};
use friction::effects::{Effect, EffectKind};
use friction::{FrictionLaw, Geometry, Invalid, LAWS, Motion};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// A motion, one value a sample.
pub(crate) struct Series {
    dt: f64,
    mass: f64,
    velocity: Vec<f64>,
    position: Vec<f64>,
    displacement: Vec<f64>,
    applied: Vec<f64>,
    normal: Option<Vec<f64>>,
}

impl Series {
    /// From arrays of one length: `velocity`, `position`, `displacement`, `applied`, perhaps `normal`; numbers `dt`, `mass`.
    ///
    /// # Errors
    /// What is missing or of another length.
    pub fn of(motion: &Bound<'_, PyDict>) -> PyResult<Self> {
        let item = |name: &str| {
            motion.get_item(name)?.ok_or_else(|| errors::option(name, "the motion does not have it"))
        };
        let velocity = arrays::values("velocity", &item("velocity")?)?;
        let column = |name: &str| {
            let values = arrays::values(name, &item(name)?)?;
            if values.len() == velocity.len() {
                return Ok(values);
            }
            let why = format!("{} samples, velocity has {}", values.len(), velocity.len());
            Err(errors::option(name, why))
        };
        let number = |name: &str| -> PyResult<f64> {
            let value: f64 = item(name)?.extract()?;
            if value.is_finite() && value >= 0.0 {
                return Ok(value);
            }
            Err(errors::option(name, format!("{value}: a finite number from 0 on is accepted")))
        };
        let normal = if motion.contains("normal")? { Some(column("normal")?) } else { None };
        Ok(Self {
            dt: number("dt")?,
            mass: number("mass")?,
            position: column("position")?,
            displacement: column("displacement")?,
            applied: column("applied")?,
            normal,
            velocity,
        })
    }

    fn motions(&self) -> impl Iterator<Item = Motion<f64>> {
        (0..self.velocity.len()).map(|i| Motion {
            dt: self.dt,
            position: self.position[i],
            displacement: self.displacement[i],
            velocity: self.velocity[i],
            applied: self.applied[i],
            mass: self.mass,
            normal: self.normal.as_ref().map(|n| n[i]),
        })
    }

    /// Force of a law that begins on a fresh contact.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn force<L: FrictionLaw<f64>>(&self, law: &L) -> Result<Vec<f64>, Invalid> {
        law.validate()?;
        let mut state = L::State::default();
        Ok(self.motions().map(|motion| law.step(&mut state, &motion)).collect())
    }
}

/// Id, documentation, and name and text of every parameter.
type About = (String, String, Vec<(String, String)>);

/// Every law.
#[pyfunction]
pub(crate) fn laws() -> Vec<About> {
    let one = |(id, about): &(&str, &friction::AboutLaw)| {
        let parameter = |p: &friction::LawParameter| (p.name.to_owned(), p.what.trim().to_owned());
        ((*id).to_owned(), about.text.to_owned(), about.parameters.iter().map(parameter).collect())
    };
    LAWS.iter().map(one).collect()
}

/// Every effect that is a force: id, sentence and equation, gains and shape.
#[pyfunction]
pub(crate) fn effects() -> Vec<(About, usize)> {
    let one = |kind: &EffectKind| {
        let about = kind.about();
        let parameter = |p: &friction::effects::Parameter| {
            let (slide, axis) = (p.unit(Geometry::Linear), p.unit(Geometry::Rotary));
            (p.name.to_owned(), format!("{}, {slide} ({axis}); {:e} to {:e}.", p.what, p.min, p.max))
        };
        let text = format!("{}\n\n    F = {}\n", about.says, about.equation);
        ((about.id.to_owned(), text, about.parameters().map(parameter).collect()), about.gains.len())
    };
    EffectKind::ALL.iter().map(one).collect()
}

/// Force of a law along a motion; its parameters are a JSON object.
#[pyfunction]
pub(crate) fn law_force<'py>(
    py: Python<'py>,
    law: &str,
    parameters: &str,
    motion: &Bound<'_, PyDict>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let series = Series::of(motion)?;
    macro_rules! run {
        ($($id:literal => $Law:ty,)*) => {
            match law {
                $($id => {
                    let law: $Law = serde_json::from_str(parameters)
                        .map_err(|e| errors::option(law, without_place(&e.to_string())))?;
                    py.detach(move || series.force(&law))
                })*
                _ => {
                    let ids: Vec<&str> = LAWS.iter().map(|(id, _)| *id).collect();
                    return Err(errors::option("law", format!("`{law}`: accepted are {}", ids.join(", "))));
                }
            }
        };
    }
    let force = friction::with_every_law!(run);
    Ok(arrays::array(py, force.map_err(|refused| errors::option(law, refused))?))
}

/// A message without its line and column: the text is our own.
fn without_place(text: &str) -> &str {
    text.split_once(" at line ").map_or(text, |(why, _)| why)
}

/// Force of an effect along a motion.
#[pyfunction]
pub(crate) fn effect_force<'py>(
    py: Python<'py>,
    effect: &str,
    parameters: BTreeMap<String, f64>,
    motion: &Bound<'_, PyDict>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let series = Series::of(motion)?;
    let Some(kind) = EffectKind::from_id(effect) else {
        let ids: Vec<&str> = EffectKind::ALL.iter().map(|k| k.id()).collect();
        return Err(errors::option("effect", format!("`{effect}`: accepted are {}", ids.join(", "))));
    };
    let mut made = Effect::silent(kind);
    for (name, value) in parameters {
        let Some(place) = made.get_mut(&name) else {
            let names: Vec<&str> = kind.about().parameters().map(|p| p.name).collect();
            let why = format!("no parameter `{name}`: accepted are {}", names.join(", "));
            return Err(errors::option(effect, why));
        };
        *place = value;
    }
    made.validate().map_err(|refused| errors::option(effect, refused))?;
    let force = py.detach(move || {
        let mut state = friction::effects::EffectState::default();
        series.motions().map(|motion| made.step(&mut state, &motion)).collect()
    });
    Ok(arrays::array(py, force))
}
