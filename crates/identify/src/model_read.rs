//! Reader of `model.toml`. Each error names a line and a column.

use crate::model::Model;
use crate::model_curves;
use crate::model_words::{Complaint, MODEL_SCHEMA, name_in_file, sensor_words};
use friction::effects::{EffectKind, EffectName, SeriesEffect, SeriesKind};
use friction::parameters::OFFSET;
use friction::{Adhesion, BOTH_DIRECTIONS, LawKind, Surface, directions};
use signals::Geometry;
use std::collections::BTreeMap;
use toml::de::{DeTable, DeValue};

/// Numbers of `[preset]` that are neither an effect's nor the law's.
const OF_BODY: [&str; 3] = ["mass", "k_vc", "b_vc"];
/// Numbers of a law without which it is a simpler one: static friction is dynamic friction, the others are zero.
const OPTIONAL: [&str; 10] = [
    "f_static",
    "f_static_p",
    "f_static_n",
    "damping",
    "damping_p",
    "damping_n",
    "dv",
    "sigma_1",
    "memory",
    "adhesion",
];

/// Names of the numbers of `[preset]` that are not an effect's. `exponent` stands in `[model]`.
fn of_preset() -> impl Iterator<Item = &'static str> {
    OF_BODY.into_iter().chain(Surface::<f64>::NAMES.iter().copied().filter(|name| *name != "exponent"))
}

/// A key with its value and where it stands.
struct Entry {
    key: String,
    value: Value,
    at: usize,
}

enum Value {
    Number(f64),
    Word(String),
}

struct Reader<'a> {
    text: &'a str,
    numbers: BTreeMap<&'static str, (f64, usize)>,
    law: Option<(LawKind, usize)>,
    exponent: f64,
    adhesion: Adhesion,
    model: Model,
    sensors: BTreeMap<String, (f64, usize)>,
    places: BTreeMap<String, usize>,
}

pub(crate) fn read(text: &str) -> Result<Model, Complaint> {
    let place = |at: usize| Some(line_column(text, at));
    let table = DeTable::parse(text).map_err(|e| Complaint {
        at: e.span().and_then(|s| place(s.start)),
        why: e.message().lines().collect::<Vec<_>>().join("; "),
    })?;
    let mut reader = Reader {
        text,
        numbers: BTreeMap::new(),
        law: None,
        exponent: 1.0,
        adhesion: Adhesion::default(),
        model: Model::default(),
        sensors: BTreeMap::new(),
        places: BTreeMap::new(),
    };
    let mut flat = Vec::new();
    let table = table.into_inner();
    let sectioned = ["preset", "model", "std", "curve"].iter().any(|s| table.contains_key(*s));
    for (key, value) in &table {
        let at = key.span().start;
        let (section, name) =
            if sectioned { (key.get_ref().as_ref(), "") } else { ("preset", key.get_ref().as_ref()) };
        if section == "curve" {
            reader.model.curves =
                model_curves::read(at, value.get_ref()).map_err(|(at, why)| reader.error(at, why))?;
            continue;
        }
        if !matches!(section, "preset" | "model" | "std") {
            return Err(reader.error(
                at,
                format!("section `{section}`: accepted are [preset], [model], [std], [[curve]]"),
            ));
        }
        reader.flatten(section, name, at, value.get_ref(), &mut flat)?;
    }
    for (section, entry) in flat {
        reader.places.insert(entry.key.clone(), entry.at);
        match section {
            "preset" => reader.preset(entry)?,
            "model" => reader.host(entry)?,
            _ => {
                let value = reader.number(&entry)?;
                if value < 0.0 {
                    return Err(reader.error(entry.at, format!("{} = {value}: accepted from 0", entry.key)));
                }
                reader.model.std.insert(entry.key, value);
            }
        }
    }
    reader.finish()
}

fn line_column(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at.min(text.len())).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

impl Reader<'_> {
    fn error(&self, at: usize, why: String) -> Complaint {
        Complaint { at: Some(line_column(self.text, at)), why }
    }

    /// Tables into dotted keys.
    fn flatten(
        &self,
        section: &str,
        key: &str,
        at: usize,
        value: &DeValue<'_>,
        out: &mut Vec<(&'static str, Entry)>,
    ) -> Result<(), Complaint> {
        let home = ["preset", "model"].into_iter().find(|s| *s == section).unwrap_or("std");
        let mut push = |value| out.push((home, Entry { key: key.to_string(), value, at }));
        match value {
            DeValue::Table(table) => {
                for (inner, value) in table {
                    let name = inner.get_ref();
                    let name = if key.is_empty() { name.to_string() } else { format!("{key}.{name}") };
                    self.flatten(section, &name, inner.span().start, value.get_ref(), out)?;
                }
            }
            DeValue::String(word) => push(Value::Word(word.to_string())),
            DeValue::Float(number) => {
                let x: f64 = number.as_str().parse().unwrap_or(f64::NAN);
                push(Value::Number(x));
            }
            DeValue::Integer(number) => {
                let x = i64::from_str_radix(number.as_str(), number.radix()).map_or(f64::NAN, |i| i as f64);
                push(Value::Number(x));
            }
            other => {
                let why = format!("{key}: accepted is a number or a word, found: {}", other.type_str());
                return Err(self.error(at, why));
            }
        }
        Ok(())
    }

    fn number(&self, entry: &Entry) -> Result<f64, Complaint> {
        match &entry.value {
            Value::Number(x) if x.is_finite() => Ok(*x),
            Value::Number(x) => {
                Err(self.error(entry.at, format!("{} = {x}: accepted is a finite number", entry.key)))
            }
            Value::Word(word) => {
                Err(self.error(entry.at, format!("{} = \"{word}\": accepted is a finite number", entry.key)))
            }
        }
    }

    fn word(&self, entry: &Entry, accepted: &[&str]) -> Result<String, Complaint> {
        let shown = match &entry.value {
            Value::Word(word) if accepted.is_empty() || accepted.contains(&word.as_str()) => {
                return Ok(word.clone());
            }
            Value::Word(word) => format!("\"{word}\""),
            Value::Number(x) => x.to_string(),
        };
        let accepted = if accepted.is_empty() { "a word in quotes".to_string() } else { accepted.join(", ") };
        Err(self.error(entry.at, format!("{} = {shown}: accepted: {accepted}", entry.key)))
    }

    fn preset(&mut self, entry: Entry) -> Result<(), Complaint> {
        let both = directions(&entry.key);
        let names: &[&'static str] = match entry.key.as_str() {
            "law" => {
                let ids: Vec<&str> = LawKind::ALL.iter().map(|law| law.id()).collect();
                let id = self.word(&entry, &ids)?;
                self.law = LawKind::from_id(&id).map(|law| (law, entry.at));
                return Ok(());
            }
            "adhesion" => {
                let id = self.word(&entry, &Adhesion::ALL.map(|(id, _)| id))?;
                self.adhesion = Adhesion::from_id(&id).unwrap_or_default();
                return Ok(());
            }
            "renderer" => {
                self.model.coupling.renderer =
                    Some(self.word(&entry, &["virtual_coupling", "stopping_force", "impedance"])?);
                return Ok(());
            }
            "passivity" => {
                self.model.coupling.passivity = Some(self.word(&entry, &["on", "off"])?);
                return Ok(());
            }
            _ if let Some(both) = &both => both,
            name => match of_preset().find(|known| *known == name) {
                Some(known) => &[known],
                None => return self.effect(&entry),
            },
        };
        let value = self.number(&entry)?;
        for name in names {
            self.numbers.insert(name, (value, entry.at));
        }
        Ok(())
    }

    fn effect(&mut self, entry: &Entry) -> Result<(), Complaint> {
        let Some((id, parameter)) = entry.key.split_once('.') else {
            let why = format!(
                "no parameter `{}`: accepted are law, renderer, adhesion, passivity, {}, {} and EFFECT.PARAMETER",
                entry.key,
                BOTH_DIRECTIONS.join(", "),
                of_preset().collect::<Vec<_>>().join(", ")
            );
            return Err(self.error(entry.at, why));
        };
        let Some(name) = EffectName::parse(id) else {
            let ids: Vec<&str> = EffectKind::ALL.iter().map(|k| k.id()).collect();
            return Err(self.error(entry.at, format!("no effect `{id}`: accepted are {}", ids.join(", "))));
        };
        let value = self.number(entry)?;
        let Some(effect) = self.model.effect_mut(name) else {
            let before = EffectName { index: name.index.saturating_sub(1), ..name };
            return Err(self.error(entry.at, format!("no {before}: {id} is accepted after it")));
        };
        let Some(place) = effect.get_mut(parameter) else {
            let names: Vec<&str> = name.kind.about().parameters().map(|p| p.name).collect();
            return Err(
                self.error(entry.at, format!("{id} has no `{parameter}`: accepted are {}", names.join(", ")))
            );
        };
        *place = value;
        Ok(())
    }

    fn host(&mut self, entry: Entry) -> Result<(), Complaint> {
        match entry.key.as_str() {
            "schema" => {
                self.word(&entry, &[MODEL_SCHEMA])?;
            }
            "name" => self.model.name = self.word(&entry, &[])?,
            "geometry" => {
                let rotary = self.word(&entry, &["linear", "rotary"])? == "rotary";
                self.model.geometry = if rotary { Geometry::Rotary } else { Geometry::Linear };
            }
            "exponent" => self.exponent = self.number(&entry)?,
            "delay_s" => self.model.nuisances.delay_s = self.number(&entry)?,
            "cutoff_hz" => self.model.cutoff_hz = Some(self.number(&entry)?),
            key if key == OFFSET.name => self.model.nuisances.offset = self.number(&entry)?,
            key => {
                let known = key.split_once('.').is_some_and(|(id, name)| {
                    SeriesKind::from_id(id)
                        .is_some_and(|kind| kind.about().parameters().any(|p| p.name == name))
                });
                if !known {
                    let why = format!(
                        "no parameter `{key}`: accepted are schema, name, geometry, exponent, offset, delay_s, cutoff_hz, {}",
                        sensor_words()
                    );
                    return Err(self.error(entry.at, why));
                }
                let value = self.number(&entry)?;
                self.sensors.insert(entry.key, (value, entry.at));
            }
        }
        Ok(())
    }

    fn required(&self, name: &'static str) -> Result<f64, Complaint> {
        self.numbers.get(name).map(|(x, _)| *x).ok_or_else(|| {
            let law = self.law.map_or("", |(law, _)| law.id());
            let why = format!("[preset] has no {name}; a model with law \"{law}\" needs it");
            Complaint { at: self.law.map(|(_, at)| line_column(self.text, at)), why }
        })
    }

    fn finish(mut self) -> Result<Model, Complaint> {
        let Some((law, law_at)) = self.law else {
            let why = format!("[preset] has no law; accepted: {}", LawKind::IDS);
            return Err(Complaint { at: None, why });
        };
        self.model.mass = self.required("mass")?;
        for name in law.parameters().iter().filter(|name| !OPTIONAL.contains(name)) {
            match directions(name) {
                Some(both) => both.into_iter().try_for_each(|name| self.required(name).map(drop))?,
                None => drop(self.required(name)?),
            }
        }
        let of = |name: &str| self.numbers.get(name).map(|(x, _)| *x);
        let mut surface =
            Surface { dv: 0.0, exponent: self.exponent, adhesion: self.adhesion, ..Surface::default() };
        for name in Surface::<f64>::NAMES {
            if let (Some(value), Some(place)) = (of(name), surface.get_mut(name)) {
                *place = value;
            }
        }
        surface.static_p = of("f_static_p").unwrap_or(surface.dynamic_p);
        surface.static_n = of("f_static_n").unwrap_or(surface.dynamic_n);
        self.model.law = surface.law(law);
        self.model.coupling.k_vc = self.numbers.get("k_vc").map(|(x, _)| *x);
        self.model.coupling.b_vc = self.numbers.get("b_vc").map(|(x, _)| *x);
        for kind in SeriesKind::ALL {
            let id = kind.about().id;
            let names: Vec<&str> = kind.about().parameters().map(|p| p.name).collect();
            let at = names.iter().find_map(|n| self.sensors.get(&format!("{id}.{n}"))).map(|(_, at)| *at);
            let Some(at) = at else { continue };
            let value = |name: &str| self.sensors.get(&format!("{id}.{name}")).map(|(x, _)| *x);
            match SeriesEffect::from_parameters(*kind, value) {
                Some(sensor) => self.model.nuisances.sensors.push(sensor),
                None => return Err(self.error(at, format!("{id} needs all of {}", names.join(", ")))),
            }
        }
        // an effect's parameter is named with its effect: another effect may have one of the same name
        let effects =
            EffectName::of(self.model.effects.iter()).map(|(name, e)| (name.to_string(), e.validate()));
        let sensors =
            self.model.nuisances.sensors.iter().map(|s| (s.kind.about().id.to_string(), s.validate()));
        for (id, result) in effects.chain(sensors) {
            if let Err(refused) = result {
                let key = format!("{id}.{}", refused.parameter);
                let at = self.places.get(&key).copied().unwrap_or(law_at);
                return Err(self.error(at, format!("{id}.{refused}")));
            }
        }
        self.model.validate().map_err(|refused| {
            let refused = name_in_file(&self.model.law, refused);
            let stands_for =
                |alias: &&&str| directions(alias).is_some_and(|both| both.contains(&refused.parameter));
            let place = |name: &str| self.places.get(name);
            let own = place(refused.parameter).or_else(|| place(BOTH_DIRECTIONS.iter().find(stands_for)?));
            self.error(*own.unwrap_or(&law_at), refused.to_string())
        })?;
        Ok(self.model)
    }
}
