//! A block on a surface, the example laws, and the paths they are tested on.
#![allow(dead_code)] // each test file uses its own part

use friction::{Coulomb, Dahl, FrictionLaw, Karnopp, Law, LuGre, Motion, Scalar, Surface};

/// Aluminium on rubber, [thesis, table 3-3] run 1.
pub fn rubber() -> Karnopp<f64> {
    Karnopp { c_p: 3.4901, c_n: 2.5611, b_p: 8.7338, b_n: 7.9521, d_p: 3.8513, d_n: 2.9099, delta_v: 0.02 }
}

/// The same contact as a stopping force.
pub fn coulomb() -> Coulomb<f64> {
    let k = rubber();
    Coulomb {
        level_p: k.c_p,
        level_n: k.c_n,
        static_p: k.d_p,
        static_n: k.d_n,
        viscous_p: k.b_p,
        viscous_n: k.b_n,
    }
}

/// Aluminium on rubber, [thesis, table 3-4].
pub fn dahl() -> Dahl<f64> {
    Dahl { limit_p: 3.3122, limit_n: 2.4238, sigma: 50_000.0, exponent: 1.0, viscous: 9.9812 }
}

/// A passive LuGre contact of the same size.
pub fn lugre() -> LuGre<f64> {
    LuGre {
        sigma_0: 50_000.0,
        sigma_1: 60.0,
        sigma_2: 9.0,
        coulomb: 3.0,
        stiction: 3.4,
        stribeck_velocity: 0.01,
    }
}

/// A contact that every law can describe.
pub fn surface() -> Surface<f64> {
    Surface {
        static_p: 3.4,
        static_n: 3.4,
        dynamic_p: 3.0,
        dynamic_n: 3.0,
        damping_p: 9.0,
        damping_n: 9.0,
        dv: 0.005,
        sigma: 50_000.0,
        sigma_1: 60.0,
        memory: 2e-3,
        dwell: 0.5,
        ..Surface::default()
    }
}

/// Each law with the load it must hold in positive and negative direction.
pub fn laws() -> [(Law<f64>, f64, f64); 4] {
    [
        (Law::Karnopp(rubber()), rubber().d_p, rubber().d_n),
        (Law::Coulomb(coulomb()), coulomb().static_p, coulomb().static_n),
        (Law::Dahl(dahl()), dahl().limit_p, dahl().limit_n),
        (Law::LuGre(lugre()), lugre().stiction, lugre().stiction),
    ]
}

/// The laws with the same parameters in both directions.
pub fn symmetric_laws() -> [Law<f64>; 4] {
    [
        Law::Karnopp(Karnopp { c_n: 3.4901, b_n: 8.7338, d_n: 3.8513, ..rubber() }),
        Law::Coulomb(Coulomb { level_n: 3.4901, viscous_n: 8.7338, static_n: 3.8513, ..coulomb() }),
        Law::Dahl(Dahl { limit_n: 3.3122, ..dahl() }),
        Law::LuGre(lugre()),
    ]
}

/// Mass of the block [thesis, ch. 3.6], kg.
pub const MASS: f64 = 0.419;

/// A free block, stepped by semi-implicit Euler.
#[derive(Debug, Clone, Copy)]
pub struct Block<L: FrictionLaw<S>, S: Scalar> {
    pub law: L,
    pub state: L::State,
    pub mass: S,
    pub dt: S,
    pub x: S,
    pub v: S,
    pub friction: S,
    displacement: S,
}

impl<S: Scalar, L: FrictionLaw<S>> Block<L, S> {
    pub fn new(law: L, mass: S, dt: S) -> Self {
        let zero = S::zero();
        Self {
            law,
            state: L::State::default(),
            mass,
            dt,
            x: zero,
            v: zero,
            friction: zero,
            displacement: zero,
        }
    }

    pub fn push(&mut self, applied: S) {
        let motion = Motion {
            dt: self.dt,
            position: self.x,
            displacement: self.displacement,
            velocity: self.v,
            applied,
            mass: self.mass,
            normal: None,
        };
        self.friction = self.law.step(&mut self.state, &motion);
        self.v += (applied - self.friction) * self.dt / self.mass;
        self.displacement = self.v * self.dt;
        self.x += self.displacement;
    }
}

/// Friction along a prescribed path; the velocity is that of the step, nothing is applied, no mass.
pub fn along<S: Scalar, L: FrictionLaw<S>>(law: &L, state: &mut L::State, path: &[S], dt: S) -> Vec<S> {
    path.windows(2)
        .map(|pair| {
            let displacement = pair[1] - pair[0];
            let motion = Motion {
                dt,
                position: pair[1],
                displacement,
                velocity: displacement / dt,
                ..Motion::default()
            };
            law.step(state, &motion)
        })
        .collect()
}

/// Up from 0 to `stroke` and back, `steps` each way.
pub fn triangle(stroke: f64, steps: usize) -> Vec<f64> {
    let up = (0..=steps).map(|k| stroke * k as f64 / steps as f64);
    let down = (0..steps).rev().map(|k| stroke * k as f64 / steps as f64);
    up.chain(down).collect()
}

/// Whether two numbers agree within `tolerance`, absolute and relative.
pub fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs()))
}
