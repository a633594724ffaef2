//! Single effects against their closed forms, their energy, and equations integrated in another way.

use friction::effects::{Effect, EffectKind, EffectState};
use friction::{Motion, Scalar};
use proptest::prelude::*;

fn effect(kind: EffectKind, gains: [f64; 4], shape: [f64; 2]) -> Effect<f64> {
    Effect { kind, gains, shape }
}

fn moved<S: Scalar>(displacement: S, dt: S) -> Motion<S> {
    Motion { dt, displacement, velocity: displacement / dt, ..Motion::default() }
}

const LEVEL: f64 = 3.0;
const GAP: f64 = 4e-3;
const GIVE: f64 = 1.5e-3;

fn play() -> Effect<f64> {
    effect(EffectKind::LostMotion, [LEVEL, LEVEL, 0.0, 0.0], [GAP, GIVE])
}

/// Coulomb friction and the play in series with it, along displacements.
fn behind_play(play: &Effect<f64>, level: [f64; 2], steps: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut state = EffectState::default();
    let mut law = |dx: f64| {
        let coulomb = if dx > 0.0 { level[0] } else { -level[1] };
        coulomb + play.step(&mut state, &moved(dx, 1e-3))
    };
    steps.map(&mut law).collect()
}

#[test]
fn lost_motion_is_a_trapezoid_after_a_reversal() {
    let h = 1e-5;
    let forward = (0..2000).map(|_| h);
    let back = (0..2000).map(|_| -h);
    let forces = behind_play(&play(), [LEVEL, LEVEL], forward.chain(back));
    assert!((forces[1999] - LEVEL).abs() < 1e-12, "the slider follows");
    for k in 0..2000 {
        let after = (k + 1) as f64 * h;
        let expected = LEVEL
            * if after < GIVE {
                1.0 - after / GIVE
            } else if after < GIVE + GAP {
                0.0
            } else {
                -((after - GIVE - GAP) / GIVE).min(1.0)
            };
        let force = forces[2000 + k];
        assert!((force - expected).abs() < 1e-9, "{after} m after the reversal: {force} N, {expected} N");
    }
}

#[test]
fn a_stroke_inside_the_gap_is_free() {
    let path = |k: i32| 0.45 * GAP * (f64::from(k) * 0.01).sin();
    let forces = behind_play(&play(), [LEVEL, LEVEL], (0..5000).map(|k| path(k + 1) - path(k)));
    let most = forces.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    assert!(most < 1e-12, "{most} N");
}

#[test]
fn nothing_holds_a_body_inside_the_gap() {
    let mut state = EffectState::default();
    for applied in [0.5, -0.5] {
        let rest: f64 = play().step(&mut state, &Motion { applied, ..Motion::default() });
        // what a law that holds has to balance is then more than its level
        assert!((rest + LEVEL * applied.signum()).abs() < 1e-12 && (applied - rest).abs() > LEVEL);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// With other levels for the two directions, on any path: what is given back was stored before.
    #[test]
    fn lost_motion_gives_back_no_more_than_it_stores(
        amplitudes in prop::array::uniform4(-8e-3..8e-3_f64),
        phases in prop::array::uniform4(0.0..6.0_f64),
        levels in prop::array::uniform2(0.1..5.0_f64),
    ) {
        let at = |k: usize| -> f64 {
            (0..4).map(|h| amplitudes[h] * ((h + 1) as f64 * 1e-3 * k as f64 + phases[h]).sin()).sum()
        };
        let play = effect(EffectKind::LostMotion, [levels[0], levels[1], 0.0, 0.0], [GAP, GIVE]);
        let steps: Vec<f64> = (0..20_000).map(|k| at(k + 1) - at(k)).collect();
        let forces = behind_play(&play, levels, steps.iter().copied());
        let (mut d, mut done, mut before) = (0.0_f64, 0.0, 0.0);
        for (dx, force) in steps.iter().zip(&forces) {
            d = (d + dx).clamp(-0.5 * GAP - GIVE, 0.5 * GAP + GIVE);
            done += 0.5 * (before + force) * dx;
            before = *force;
            let bent = (d.abs() - 0.5 * GAP).max(0.0);
            let stored = 0.5 * levels[usize::from(d < 0.0)] * bent * bent / GIVE;
            // the trapezoidal rule at the corners: half a step of 40 µm times the level, in each of a few crossings
            prop_assert!(done >= stored - 1e-3 * levels[0].max(levels[1]) * GAP, "{done} J, {stored} J");
        }
    }

    /// Power flows out of the body whichever way the force points, and equal shares are the simpler effect.
    #[test]
    fn losses_of_a_transmission_brake(
        v in -1.0..1.0_f64, applied in -20.0..20.0_f64, shares in prop::array::uniform2(0.0..1.0_f64),
    ) {
        let motion = Motion { velocity: v, applied, ..Motion::default() };
        let force = |kind, gains| -> f64 {
            effect(kind, gains, [0.0; 2]).step(&mut EffectState::default(), &motion)
        };
        let lost = force(EffectKind::DirectionalEfficiency, [shares[0], shares[1], 0.0, 0.0]);
        let share = if applied * v > 0.0 { shares[0] } else { shares[1] };
        prop_assert!(lost * v >= 0.0 && (lost.abs() - share * applied.abs()).abs() < 1e-12);
        let equal = force(EffectKind::DirectionalEfficiency, [shares[0], shares[0], 0.0, 0.0]);
        prop_assert_eq!(equal, force(EffectKind::LoadDependentFriction, [0.0, shares[0], 0.0, 0.0]));
    }
}

const REFERENCE: f64 = 1e-3;
const D: f64 = 2e-5;

fn contact(healing: f64) -> Effect<f64> {
    effect(EffectKind::RateAndState, [0.0, 0.0, 0.4, 0.7], [D, healing])
}

/// Force after a step from steady sliding at `from` to `to`, at `steps` samples over the distance `over`.
fn after_step(healing: f64, [from, to]: [f64; 2], over: f64, steps: usize) -> Vec<f64> {
    let (contact, mut state) = (contact(healing), EffectState::default());
    contact.step(&mut state, &moved(from * 1e-3, 1e-3));
    let dx = over / steps as f64;
    (0..steps).map(|_| contact.step(&mut state, &moved(dx, dx / to))).collect()
}

#[test]
fn a_velocity_step_follows_the_ageing_and_the_slip_law() {
    for [from, to] in [[1e-4, 1e-3], [1e-3, 1e-4], [2e-3, 3e-3]] {
        let over = 3.0 * D;
        for steps in [1, 7, 1000] {
            let decay = (-over / D).exp();
            let direct = 0.4 * f64::ln(to / REFERENCE);
            let theta = D / to + (D / from - D / to) * decay;
            let ageing = direct + 0.7 * f64::ln(REFERENCE * theta / D);
            let slip = direct + 0.7 * (f64::ln(to / from) * decay - f64::ln(to / REFERENCE));
            for (healing, expected) in [(1.0, ageing), (0.0, slip)] {
                let force = after_step(healing, [from, to], over, steps)[steps - 1];
                assert!((force - expected).abs() < 1e-9, "{healing} {from} {to} {steps}: {force} {expected}");
            }
        }
    }
}

#[test]
fn every_healing_follows_its_equation() {
    for healing in [-0.7, -1e-3, 1e-5, 0.3, 1.6] {
        let (from, to): (f64, f64) = (1e-4, 2e-3);
        // du/dx = −(1 − e^(−healing·u))/(healing·d_c) by the midpoint rule
        let slope = |u: f64| -(1.0 - (-healing * u).exp()) / (healing * D);
        let (n, over) = (200_000, 2.0 * D);
        let h = over / f64::from(n);
        let mut u = (to / from).ln();
        for _ in 0..n {
            u += h * slope(u + 0.5 * h * slope(u));
        }
        let rate = (to / REFERENCE).ln();
        let expected = 0.4 * rate + 0.7 * (u - rate);
        let force = after_step(healing, [from, to], over, 3)[2];
        println!("healing {healing}: {force:.8} N, integrated {expected:.8} N");
        assert!((force - expected).abs() < 1e-5);
    }
}

#[test]
fn only_the_ageing_law_heals_at_rest() {
    let healed = |healing: f64| {
        let (contact, mut state) = (contact(healing), EffectState::default());
        contact.step(&mut state, &moved(1e-6, 1e-3));
        for _ in 0..2000 {
            contact.step(&mut state, &Motion { dt: 1e-3, applied: 1.0, ..Motion::default() });
        }
        contact.step(&mut state, &moved(1e-12, 1e-9))
    };
    // θ = d_c/v + 2 s
    let expected = 0.7 * (REFERENCE * (D / 1e-3 + 2.0) / D).ln();
    assert!((healed(1.0) - expected).abs() < 2e-3, "{} {expected}", healed(1.0));
    assert!(healed(0.0).abs() < 2e-3, "{}", healed(0.0));
    // a step of the age at rest is far below one ulp of 1 in single precision
    let single =
        Effect { kind: EffectKind::RateAndState, gains: [0.0, 0.0, 0.0, 1.0], shape: [D as f32, 1.0] };
    let mut state = EffectState::default();
    single.step(&mut state, &moved(1e-6_f32, 1e-3));
    let rest = Motion { dt: 1e-3_f32, applied: 1.0, ..Motion::default() };
    let last = (0..2000).map(|_| single.step(&mut state, &rest)).last().expect("a force");
    assert!((last / (expected as f32 / 0.7) - 1.0).abs() < 1e-3, "{last}");
}

/// The first sample of a recording has a velocity, but nothing slid before it.
#[test]
fn a_contact_that_had_not_slid_yet_began_a_thousand_times_too_old() {
    let (contact, mut state) = (contact(1.0), EffectState::default());
    contact.step(&mut state, &Motion { dt: 0.1, velocity: 1e-6, ..Motion::default() });
    let force = contact.step(&mut state, &moved(1e-7, 0.1));
    assert!(
        (force - (0.4 - 0.7) * f64::ln(1e-6 / REFERENCE)).abs() < 1e-9,
        "steady at its first speed: {force}"
    );
}

/// Velocity steps in one direction, the contact integrated by small Euler steps, with noise of a fixed sequence: the gains,
/// the distance and the law come back by least squares over a grid.
#[test]
fn velocity_steps_in_one_direction_give_a_b_and_the_distance() {
    let (a, b, d_c, level) = (0.012, 0.017, 8e-6, 0.6);
    for slip in [false, true] {
        let (dt, fine) = (0.05, 4000);
        let (mut theta, mut seed) = (d_c / 1e-6, 7_u64);
        let mut rows = Vec::new();
        for k in 0..4000_usize {
            let v = [1e-6, 1e-5, 3e-6, 3e-5][(k / 250) % 4];
            for _ in 0..fine {
                let x = v * theta / d_c;
                theta += dt / f64::from(fine) * if slip { -x * x.ln() } else { 1.0 - x };
            }
            let noise: f64 = (0..12)
                .map(|_| {
                    seed =
                        seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (seed >> 40) as f64 / f64::from(1 << 24) - 0.5
                })
                .sum();
            let force = level + a * (v / REFERENCE).ln() + b * (REFERENCE * theta / d_c).ln() + 5e-4 * noise;
            rows.push((v, force));
        }
        let (mut best, mut found) = (f64::INFINITY, None);
        for healing in [0.0, 1.0] {
            for k in -10..=10 {
                let distance = d_c * 1.1_f64.powi(k);
                let mut memory = [0.0; 4];
                let columns: Vec<[f64; 3]> = rows
                    .iter()
                    .map(|(v, _)| {
                        let unit = EffectKind::RateAndState.unit(
                            &[distance, healing],
                            &mut memory,
                            &moved(v * dt, dt),
                        );
                        [1.0, unit[2], unit[3]]
                    })
                    .collect();
                let (gains, left) = least_squares(&columns, &rows);
                if left < best {
                    (best, found) = (left, Some((healing, distance, gains)));
                }
            }
        }
        let (healing, distance, [c, found_a, found_b]) = found.expect("a fit");
        println!(
            "slip {slip}: healing {healing}, d_c {distance:.2e}, a {found_a:.5}, b {found_b:.5}, level {c:.4}"
        );
        assert_eq!(healing, if slip { 0.0 } else { 1.0 });
        assert!((distance / d_c - 1.0).abs() < 0.11);
        assert!((found_a / a - 1.0).abs() < 0.05 && (found_b / b - 1.0).abs() < 0.05);
    }
}

/// Coefficients of three columns, and the squares that are left.
fn least_squares(columns: &[[f64; 3]], rows: &[(f64, f64)]) -> ([f64; 3], f64) {
    let mut m = [[0.0; 4]; 3];
    for (c, (_, y)) in columns.iter().zip(rows) {
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += c[i] * c[j];
            }
            m[i][3] += c[i] * y;
        }
    }
    for i in 0..3 {
        for j in (0..3).filter(|j| *j != i) {
            let (row, share) = (m[i], m[j][i] / m[i][i]);
            for (x, y) in m[j].iter_mut().zip(row) {
                *x -= share * y;
            }
        }
    }
    let x = [m[0][3] / m[0][0], m[1][3] / m[1][1], m[2][3] / m[2][2]];
    let left = columns.iter().zip(rows).map(|(c, (_, y))| {
        let e = y - (c[0] * x[0] + c[1] * x[1] + c[2] * x[2]);
        e * e
    });
    (x, left.sum())
}
