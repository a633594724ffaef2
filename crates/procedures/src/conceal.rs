//! Effects that can be concealed in the simulated rig, each in the size of its example.

use friction::effects::{Effect, EffectKind};

/// An effect at a multiple of its example's size: too small to see in one sample, large enough for ten seconds of motion.
#[must_use]
pub fn concealed(kind: EffectKind, size: f64) -> Option<Effect<f64>> {
    let example = kind.about().example?;
    Some(Effect { kind, gains: example.gains.map(|gain| size * gain), shape: example.shape })
}

/// The effects that have an example.
#[must_use]
pub fn concealable() -> Vec<EffectKind> {
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
