//! Checks a set of parameters by the device's own validation before anything is sent.

use friction::Surface;
use friction::effects::{Effect, EffectName};
use haptics::number::Text;
use haptics::settings::{PARAMETERS, Parameter};
use haptics::{Accepted, Device, Refused, Settings, bounds};
use serde::Serialize;

/// Names and values as they are typed.
pub type Changes = [(String, String)];

/// A parameter with what would be accepted for it, everything else unchanged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// As typed.
    pub name: String,
    /// SI; empty for a choice.
    pub unit: String,
    /// One line.
    pub what: &'static str,
    /// Value as the device shows it.
    pub value: String,
    /// Least value, where there is one.
    pub low: Option<f64>,
    /// Largest value.
    pub high: Option<f64>,
    /// Words accepted, for a choice.
    pub choices: Vec<&'static str>,
    /// Whether law and renderer use it.
    pub used: bool,
}

/// One bound of chapter 4 and where the settings stand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bound {
    /// What it bounds.
    pub name: &'static str,
    /// Where the settings are.
    pub value: f64,
    /// Where they may go.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Below the limit is good; otherwise above it.
    pub below: bool,
    /// In words, with the equation.
    pub says: String,
}

/// What validation says of a set of parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// `stable`, `unfaithful` (taken with a warning) or `refused`.
    pub level: &'static str,
    /// In words.
    pub says: String,
    /// The parameter it is about.
    pub about: String,
    /// The bounds behind it.
    pub bounds: Vec<Bound>,
    /// Every parameter with its limits.
    pub parameters: Vec<Shown>,
}

fn number(x: f32) -> f64 {
    // the shortest decimal that is this `f32`: 0.1, not 0.10000000149
    Text(x).to_string().parse().unwrap_or(f64::from(x))
}

fn range(accepted: Accepted) -> (Option<f64>, Option<f64>) {
    match accepted {
        Accepted::AtMost(high) => (None, Some(number(high))),
        Accepted::AtLeast(low) => (Some(number(low)), None),
        Accepted::Between(low, high) => (Some(number(low)), Some(number(high))),
    }
}

/// What validation would accept for one parameter: it is asked with values that no device takes.
fn limits(settings: &Settings, device: &Device, name: &str) -> (Option<f64>, Option<f64>) {
    let (effect, parameter) = match name.split_once('.') {
        Some((effect, parameter)) => (EffectName::parse(effect), parameter),
        None => (None, name),
    };
    let mut found = (None, None);
    for absurd in ["-1e30", "1e30"] {
        let mut tried = *settings;
        if tried.set(name, absurd).is_err() {
            continue;
        }
        if let Err(refused) = tried.validate(device)
            && refused.parameter == parameter
            && refused.effect == effect
        {
            let (low, high) = range(refused.accepted);
            found = (found.0.or(low), found.1.or(high));
        }
    }
    let tight = |limit: f64| tighten(settings, device, name, limit);
    (found.0.map(tight), found.1.map(tight))
}

/// A limit of one parameter alone may be beyond what another one allows: dynamic friction ends at the static. Between a
/// value that is taken and such a limit validation turns somewhere.
fn tighten(settings: &Settings, device: &Device, name: &str, limit: f64) -> f64 {
    let takes = |x: f64| {
        let mut tried = *settings;
        tried.set(name, &format!("{x}")).is_ok() && tried.validate(device).is_ok()
    };
    let Some(haptics::Value::Number(now)) = settings.get(name) else { return limit };
    let (mut good, mut bad) = (number(now), limit);
    if takes(limit) || !takes(good) {
        return limit;
    }
    for _ in 0..30 {
        let middle = 0.5 * (good + bad);
        if takes(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    // four digits can be typed
    let typed = format!("{good:.3e}").parse().unwrap_or(good);
    if takes(typed) { typed } else { good }
}

/// Whether law and renderer use this parameter; those of effects, the block and its coupling always.
fn used(settings: &Settings, name: &str) -> bool {
    let law = settings.law;
    let of_laws = name == "adhesion" || Surface::<f64>::NAMES.contains(&name);
    // Karnopp's levels have no dead band under this renderer
    let unused = name == "dv" && law.holds() && settings.renderer == haptics::RendererKind::StoppingForce;
    !unused && (!of_laws || law.takes(name))
}

fn shown(settings: &Settings, device: &Device, name: String, p: &Parameter) -> Shown {
    let choices: Vec<&'static str> = match p.name {
        "law" => haptics::LawKind::ALL.iter().map(|law| law.id()).collect(),
        "renderer" => haptics::RendererKind::ON_BOARD.iter().map(|renderer| renderer.id()).collect(),
        "adhesion" => friction::Adhesion::ALL.map(|(id, _)| id).to_vec(),
        "passivity" => vec!["off", "on"],
        _ => Vec::new(),
    };
    let (low, high) = if choices.is_empty() { limits(settings, device, &name) } else { (None, None) };
    let value = settings.get(&name).map(|value| value.to_string()).unwrap_or_default();
    let unit = p.unit(device.geometry).map_or_else(String::new, |unit| unit.to_string());
    let used = used(settings, &name);
    Shown { name, unit, what: p.what, value, low, high, choices, used }
}

/// Every parameter of these settings with its limits.
#[must_use]
pub fn parameters(settings: &Settings, device: &Device) -> Vec<Shown> {
    let mut all: Vec<Shown> =
        PARAMETERS.iter().map(|p| shown(settings, device, p.name.to_owned(), p)).collect();
    for (effect, Effect { kind, .. }) in EffectName::of(settings.effects.iter().flatten()) {
        for p in kind.gains().iter().chain(kind.shape()) {
            let known = Parameter { name: p.name, dimension: Some(p.dimension), what: kind.id() };
            all.push(shown(settings, device, format!("{effect}.{}", p.name), &known));
        }
    }
    all
}

fn bounds_of(settings: &Settings, device: &Device) -> Vec<Bound> {
    let friction = settings.f_dynamic_p.max(settings.f_dynamic_n);
    let (k, b) = (settings.k_vc, settings.b_vc);
    let stiffest = bounds::stiffness_max_delayed(device.mass, device.damping, device.period, b, device.delay);
    let mut all = vec![Bound {
        name: "k_vc",
        value: number(k),
        limit: f64::from(stiffest).round(),
        unit: "N/m",
        below: true,
        says: "the stuck handle does not oscillate (eq. 4.18, with B)".into(),
    }];
    let cycle = match settings.renderer {
        _ if settings.law != haptics::LawKind::Karnopp => None,
        haptics::RendererKind::VirtualCoupling => Some((
            bounds::limit_cycle_velocity(friction, settings.mass, k, b, device.period),
            "the block stops instead of chattering (eq. 4.35)",
        )),
        haptics::RendererKind::Impedance => Some((
            friction / bounds::friction_max(device.mass, device.damping, device.period, 1.0),
            "the handle stops instead of chattering (eq. 4.21)",
        )),
        // the others have no dead band dv
        _ => None,
    };
    if let Some((cycle, says)) = cycle {
        all.push(Bound {
            name: "dv",
            value: 1e3 * number(settings.dv),
            limit: 1e3 * f64::from(cycle),
            unit: "mm/s",
            below: false,
            says: says.into(),
        });
    }
    let loaded = f64::from(settings.f_static_p.max(settings.f_static_n).max(friction));
    all.push(Bound {
        name: "force",
        value: loaded,
        limit: number(device.force_max),
        unit: "N",
        below: true,
        says: "the actuator holds it".into(),
    });
    all
}

/// What the device would say to these settings.
#[must_use]
pub fn judge(settings: &Settings, device: &Device) -> Verdict {
    let (level, about, says) = match settings.validate(device) {
        Ok(None) => ("stable", String::new(), "stable and faithful on this device".to_owned()),
        Ok(Some(warning)) => ("unfaithful", warning.parameter.to_owned(), warning.to_string()),
        Err(refused) => ("refused", parameter_of(&refused), refused.to_string()),
    };
    Verdict {
        level,
        says,
        about,
        bounds: bounds_of(settings, device),
        parameters: parameters(settings, device),
    }
}

fn parameter_of(refused: &Refused) -> String {
    match refused.effect {
        Some(effect) => format!("{effect}.{}", refused.parameter),
        None => refused.parameter.to_owned(),
    }
}

/// The settings with these changes; they are only understood, not yet judged.
///
/// # Errors
/// A name or value that cannot be understood, with what would be accepted.
pub fn changed(settings: &Settings, changes: &Changes) -> Result<Settings, String> {
    let mut new = *settings;
    for (name, value) in changes {
        word(name)?;
        word(value)?;
        new.set(name, value).map_err(|e| e.to_string())?;
    }
    Ok(new)
}

/// Text that can be a word of a command: what has blanks or line ends in it would be another command.
pub(crate) fn word(text: &str) -> Result<&str, String> {
    let fits = |b: u8| b.is_ascii_graphic();
    if !text.is_empty() && text.len() <= 48 && text.bytes().all(fits) {
        Ok(text)
    } else {
        let start: String = text.chars().take(48).filter(|c| !c.is_control()).collect();
        Err(format!("`{start}`: accepted is one word of 1 to 48 printable ASCII characters"))
    }
}

/// An order of these changes in which the device takes every single one: a heavier block before its stiffer coupling.
///
/// # Errors
/// What the device would refuse, with what it would accept; or that no order of single steps leads there.
pub fn steps<'a>(
    settings: &Settings,
    device: &Device,
    changes: &'a Changes,
) -> Result<Vec<&'a (String, String)>, String> {
    let target = changed(settings, changes)?;
    target.validate(device).map_err(|refused| refused.to_string())?;
    let (mut now, mut left, mut order) = (*settings, changes.iter().collect::<Vec<_>>(), Vec::new());
    while !left.is_empty() {
        let before = left.len();
        let mut refusal = String::new();
        left.retain(|change| {
            let mut next = now;
            match next
                .set(&change.0, &change.1)
                .map_err(|e| e.to_string())
                .and_then(|()| next.validate(device).map(|_| ()).map_err(|refused| refused.to_string()))
            {
                Ok(()) => {
                    now = next;
                    order.push(*change);
                    false
                }
                Err(why) => {
                    refusal = why;
                    true
                }
            }
        });
        if left.len() == before {
            return Err(format!("as a whole it would be taken, but no order of single steps: {refusal}"));
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(name: &str, value: &str) -> (String, String) {
        (name.to_owned(), value.to_owned())
    }

    #[test]
    fn limits_are_where_validation_turns() {
        let (settings, device) = (Settings::rubber(), Device::default());
        let mut checked = 0;
        for p in parameters(&settings, &device) {
            for (limit, outward) in [(p.low, -1.0), (p.high, 1.0)] {
                let Some(limit) = limit else { continue };
                let at = |x: f64| {
                    let mut tried = settings;
                    tried.set(&p.name, &format!("{x}")).is_ok() && tried.validate(&device).is_ok()
                };
                let beyond = limit + outward * (limit.abs() * 1e-3 + 1e-9);
                println!("{:20} {limit} {}: taken {}, beyond {}", p.name, p.unit, at(limit), at(beyond));
                assert!(at(limit) && !at(beyond), "{} {limit}", p.name);
                checked += 1;
            }
        }
        assert!(checked >= 20, "{checked} limits");
    }

    #[test]
    fn a_heavier_block_goes_before_its_stiffer_coupling() {
        let (mut settings, device) = (Settings::viscous(), Device::default());
        settings.mass = 0.03;
        settings.k_vc = 8000.0;
        assert!(settings.validate(&device).is_ok());
        let changes = [change("k_vc", "30000"), change("mass", "0.5")];
        let order = steps(&settings, &device, &changes).expect("an order");
        println!("{order:?}");
        assert_eq!(order[0].0, "mass");
        assert!(steps(&settings, &device, &changes[..1]).is_err());
    }

    #[test]
    fn refusals_name_the_accepted_range() {
        let (settings, device) = (Settings::rubber(), Device::default());
        let said = steps(&settings, &device, &[change("k_vc", "1e6")]).expect_err("too stiff");
        println!("{said}");
        assert!(said.contains("k_vc = 1000000: accepted from 1 to"));
        for bad in [change("k_vc", "1 000"), change("k_vc\nstop", "1"), change("", ""), change("k_vc", "NaN")]
        {
            assert!(steps(&settings, &device, &[bad]).is_err());
        }
    }
}
