//! The preset next to one that must not run, or will not feel as asked: each parameter at its bound, one after the
//! other, in the order in which the device would refuse them.

use haptics::{Accepted, Device, Reason, Settings};

/// A parameter that had to move.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its name.
    pub parameter: String,
    /// As it was.
    pub from: f32,
    /// As the device takes it.
    pub to: f32,
    /// Must not run as it was; otherwise it is only unfaithful.
    pub unsafe_before: bool,
    /// Why it had to move.
    pub why: Reason,
}

/// More than a preset has parameters: each is moved once or twice.
const MAX_STEPS: usize = 64;

fn into(value: f32, accepted: Accepted) -> f32 {
    match accepted {
        Accepted::AtMost(high) => high.min(value),
        Accepted::AtLeast(low) => {
            if value >= low {
                value
            } else {
                low
            }
        }
        Accepted::Between(low, high) => {
            if value >= low {
                value.min(high)
            } else {
                low
            }
        }
    }
}

/// What had to change, and the preset then; `None` where no sequence of such moves is accepted.
#[must_use]
pub fn nearest(settings: &Settings, device: &Device) -> Option<(Vec<Change>, Settings)> {
    let mut now = *settings;
    let mut changes: Vec<Change> = Vec::new();
    for _ in 0..MAX_STEPS {
        let (effect, parameter, value, accepted, why, unsafe_before) = match now.validate(device) {
            Ok(None) => return Some((changes, now)),
            Ok(Some(w)) => (None, w.parameter, w.value, w.faithful, w.why, false),
            Err(r) => (r.effect, r.parameter, r.value, r.accepted, r.why, true),
        };
        let to = into(value, accepted);
        let name = effect.map_or_else(|| parameter.to_owned(), |effect| format!("{effect}.{parameter}"));
        now.set(&name, &format!("{to}")).ok()?;
        match changes.iter_mut().find(|c| c.parameter == name) {
            Some(change) => (change.to, change.unsafe_before) = (to, change.unsafe_before || unsafe_before),
            None => changes.push(Change { parameter: name, from: value, to, unsafe_before, why }),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_5_3_needs_only_a_larger_dv() {
        let (changes, found) = nearest(&Settings::forced_choice(), &Device::default()).expect("there is one");
        println!("{changes:?}");
        assert_eq!(changes.len(), 1);
        assert_eq!((changes[0].parameter.as_str(), changes[0].unsafe_before), ("dv", false));
        assert!((f64::from(changes[0].to) - 2.046e-3).abs() < 2e-6, "eq. 4.35");
        assert_eq!(found.validate(&Device::default()), Ok(None));
    }

    #[test]
    fn whatever_is_wrong_a_preset_that_runs_is_found() {
        let wild = [
            Settings { k_vc: 1e7, b_vc: 1e4, mass: 1e-6, ..Settings::forced_choice() },
            Settings { f_static_p: 99.0, f_dynamic_p: 98.0, f_static_n: 0.1, ..Settings::forced_choice() },
            Settings { dv: f32::NAN, k_vc: f32::INFINITY, ..Settings::forced_choice() },
            Settings { law: haptics::LawKind::LuGre, sigma: 1e12, sigma_1: 1e9, ..Settings::forced_choice() },
        ];
        for preset in wild {
            let (changes, found) = nearest(&preset, &Device::default()).expect("there is one");
            println!("{:?}", changes.iter().map(|c| (&c.parameter, c.from, c.to)).collect::<Vec<_>>());
            assert!(changes.iter().any(|c| c.unsafe_before));
            assert_eq!(found.validate(&Device::default()), Ok(None));
        }
    }
}
