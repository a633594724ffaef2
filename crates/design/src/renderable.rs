//! What a device renders of a body that was identified or diagnosed: the law, moved to the bounds of the device, and the effects
//! that the device accepts with it.

use crate::nearest::{Change, nearest};
use haptics::settings::MAX_EFFECTS;
use haptics::{Device, Settings};
use serde::Serialize;

/// Something that was found and is not rendered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Parameter, effect or part of the model.
    pub name: String,
    /// Value, limit and reason.
    pub why: String,
}

/// What a device renders of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Renderable {
    /// Accepted by [`Settings::validate`].
    pub settings: Settings,
    /// Parameters of law and coupling that moved to a bound of the device.
    pub moved: Vec<Change>,
    /// What is not rendered.
    pub left_out: Vec<LeftOut>,
    /// Warning of the device, if it accepts the settings with one.
    pub warning: Option<String>,
}

/// The preset of `found` that the device accepts. Names and values of `found` are those of the console; what it does not name,
/// the coupling for instance, stays as in `active`. A parameter of the law moves to its bound. An effect is taken as it was
/// found or left out: a pattern with another wavelength would be another pattern.
///
/// ```
/// use haptics::{Device, Settings};
/// let found = [("f_static", "20"), ("f_dynamic", "3"), ("spring.stiffness", "1e9")];
/// let found = found.map(|(name, value)| (name.to_owned(), value.to_owned()));
/// let device = Device::default();
/// let body = design::renderable(&found, &Settings::brass(), &device)?;
/// assert_eq!(body.settings.f_static_p, device.force_max);
/// assert_eq!(body.left_out[0].name, "spring");
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// A parameter that no device knows, or no preset near the law is accepted.
pub fn renderable(
    found: &[(String, String)],
    active: &Settings,
    device: &Device,
) -> Result<Renderable, String> {
    let mut law = Settings { effects: [None; MAX_EFFECTS], ..*active };
    let mut left_out = Vec::new();
    for (name, value) in found.iter().filter(|(name, _)| !name.contains('.')) {
        // a motion that does not show the mass leaves it at zero
        if name == "mass" && value.parse::<f64>().is_ok_and(|mass| mass <= 0.0) {
            let why = format!(
                "{value} was found: the motion does not show it; the block keeps {} {}",
                active.mass,
                friction::Dimension::MASS.unit(device.geometry)
            );
            left_out.push(LeftOut { name: name.clone(), why });
            continue;
        }
        law.set(name, value).map_err(|e| e.to_string())?;
    }
    let (moved, mut settings) = nearest(&law, device).ok_or_else(|| match law.validate(device) {
        Err(refused) => format!("no law near it is accepted: {}", refused.on(device.geometry)),
        Ok(_) => "no law near it is accepted".to_owned(),
    })?;
    let mut effects: Vec<&str> =
        found.iter().filter_map(|(name, _)| name.split_once('.').map(|(effect, _)| effect)).collect();
    effects.dedup();
    for effect in effects {
        match with_effect(&settings, effect, found, device) {
            Ok(with) => settings = with,
            Err(why) => left_out.push(LeftOut { name: effect.to_owned(), why }),
        }
    }
    let warning = settings.validate(device).ok().flatten().map(|w| w.on(device.geometry).to_string());
    Ok(Renderable { settings, moved, left_out, warning })
}

/// The settings with one effect of `found`, if the device accepts them.
fn with_effect(
    settings: &Settings,
    effect: &str,
    found: &[(String, String)],
    device: &Device,
) -> Result<Settings, String> {
    let mut with = *settings;
    for (name, value) in found {
        if name.split_once('.').is_some_and(|(of, _)| of == effect) {
            with.set(name, value).map_err(|e| e.to_string())?;
        }
    }
    with.validate(device).map_err(|refused| refused.on(device.geometry).to_string())?;
    Ok(with)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(found: &[(&str, &str)]) -> Vec<(String, String)> {
        found.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
    }

    const RUBBER: [(&str, &str); 7] = [
        ("law", "karnopp"),
        ("mass", "0.387"),
        ("f_static_p", "3.48"),
        ("f_static_n", "2.56"),
        ("f_dynamic_p", "3.48"),
        ("f_dynamic_n", "2.56"),
        ("damping", "8.8"),
    ];

    #[test]
    fn a_mass_that_was_not_found_is_named_and_the_rest_is_rendered() {
        let device = Device::default();
        let mut found = lines(&RUBBER);
        found[1].1 = "0.0".into();
        let body = renderable(&found, &Settings::brass(), &device).expect("the rest");
        println!("{:?}", body.left_out);
        assert_eq!(body.settings.mass, Settings::brass().mass);
        assert_eq!((body.settings.f_dynamic_p, body.left_out[0].name.as_str()), (3.48, "mass"));
    }

    #[test]
    fn every_limit_of_the_device_is_named_with_its_value() {
        let device = Device::default();
        let mut found = lines(&RUBBER);
        found.extend(lines(&[
            ("dv", "0.0001"),
            ("stribeck.force_p", "0.7"),
            ("stribeck.v_s", "0.016"),
            // the weave of a linen, far too fine
            ("periodic_friction.sine", "1.5"),
            ("periodic_friction.wavelength", "2e-6"),
            ("spring.stiffness", "1e7"),
            ("nonsense.force", "1"),
        ]));
        found[2].1 = "12.5".into();
        let body = renderable(&found, &Settings::brass(), &device).expect("the rest");
        for change in &body.moved {
            println!("{} {} -> {}: {}", change.parameter, change.from, change.to, change.why);
        }
        for left in &body.left_out {
            println!("{}: {}", left.name, left.why);
        }
        let moved: Vec<(&str, f32)> = body.moved.iter().map(|c| (c.parameter.as_str(), c.to)).collect();
        assert!(moved.contains(&("f_static_p", device.force_max)), "{moved:?}");
        assert!(moved.iter().any(|(name, to)| *name == "dv" && *to > 1e-4), "{moved:?}");
        let left: Vec<&str> = body.left_out.iter().map(|left| left.name.as_str()).collect();
        assert_eq!(left, ["periodic_friction", "spring", "nonsense"]);
        assert!(body.left_out[..2].iter().all(|left| left.why.contains("accepted from")));
        assert!(body.settings.validate(&device).is_ok());
        assert_eq!(body.settings.effects.iter().flatten().count(), 1, "stribeck stays");
    }

    #[test]
    fn effects_beyond_the_time_of_a_step_are_left_out() {
        let device = Device { effect_cycles: 900, ..Device::default() };
        let mut found = lines(&RUBBER);
        found.extend(lines(&[
            ("stribeck.force_p", "0.7"),
            ("spring.stiffness", "10"),
            ("cogging.sine_1", "0.3"),
        ]));
        let body = renderable(&found, &Settings::brass(), &device).expect("the rest");
        println!("{:?}", body.left_out);
        assert_eq!(body.left_out.len(), 1);
        assert!(body.left_out[0].why.starts_with("cycles of law and effects = 1280: accepted up to 900"));
    }
}
