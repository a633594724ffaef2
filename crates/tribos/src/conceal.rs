//! Effects that can be concealed in the simulated rig, each with a size of its own.

use friction::effects::{Effect, EffectKind};

/// Parameters by name.
type Named = &'static [(&'static str, f64)];

/// Effects that can be concealed in the rig: each with a size that a single sample hides (table 3-2: 0.062 N of
/// noise) but ten seconds of motion do not.
pub(crate) fn concealed(kind: EffectKind, size: f64) -> Option<Effect<f64>> {
    use EffectKind as K;
    let (gains, shape): (Named, Named) = match kind {
        K::Stribeck => (&[("force_p", 0.5), ("force_n", 0.5)], &[("v_s", 0.02), ("delta", 1.0)]),
        K::SublinearViscous => (&[("force_p", 0.6), ("force_n", 0.6)], &[("v_0", 0.03), ("power", 1.0)]),
        K::QuadraticDrag => (&[("c_p", 30.0), ("c_n", 30.0)], &[]),
        K::Presliding => (&[("force_p", 0.5), ("force_n", 0.5)], &[("x_s", 4e-4)]),
        K::FrictionalLag => (&[("stribeck", 0.8)], &[("lag", 0.01), ("v_s", 0.05)]),
        K::FrictionDrift => (&[("force_p", 0.6), ("force_n", 0.6)], &[("settling_time", 6.0)]),
        K::PositionDependentFriction => (&[("slope_p", 35.0), ("slope_n", 35.0)], &[]),
        K::Spring => (&[("stiffness", 40.0)], &[]),
        K::NonlinearSpring => (&[("cubic", 6e5)], &[]),
        K::Cogging => (&[("cosine_1", 0.2), ("sine_1", 0.15)], &[("wavelength", 0.004)]),
        K::PeriodicFriction => (&[("cosine", 0.2), ("sine", 0.15)], &[("wavelength", 0.004)]),
        _ => return None,
    };
    let mut effect = Effect { kind, gains: [0.0; _], shape: [0.0; _] };
    for &(name, value) in gains {
        *effect.get_mut(name)? = size * value;
    }
    for &(name, value) in shape {
        *effect.get_mut(name)? = value;
    }
    Some(effect)
}

/// The effects [`concealed`] has a size for.
pub(crate) fn concealable() -> Vec<EffectKind> {
    EffectKind::ALL.iter().copied().filter(|&kind| concealed(kind, 1.0).is_some()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use friction::Motion;
    use friction::effects::EffectState;

    #[test]
    fn every_concealable_effect_is_valid_and_above_the_noise() {
        assert!(concealable().len() >= 8, "{:?}", concealable());
        for kind in concealable() {
            let effect = concealed(kind, 1.0).unwrap();
            effect.validate().unwrap_or_else(|e| panic!("{}: {e}", kind.id()));
            let mut state = EffectState::default();
            let mut strongest: f64 = 0.0;
            for k in 0..4000 {
                let (t, w) = (f64::from(k) * 1e-3, 4.0 * std::f64::consts::PI);
                let motion = Motion {
                    dt: 1e-3,
                    position: 0.01 * (w * t).sin(),
                    displacement: 0.01 * w * (w * t).cos() * 1e-3,
                    velocity: 0.01 * w * (w * t).cos(),
                    ..Motion::default()
                };
                strongest = strongest.max(effect.step(&mut state, &motion).abs());
            }
            println!("{}: up to {strongest:.3} N", kind.id());
            assert!(strongest > 0.062 && strongest < 2.0, "{}", kind.id());
        }
    }
}
