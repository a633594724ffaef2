//! A rig in the plane: a body on two axes, driven along a path, on a surface with a law of [`friction::planar`].
//!
//! The drive is a spring and a damper between a reference and the body; the load cell of each axis shows the force it puts on the
//! body. The body moves by semi-implicit Euler in steps finer than the sampling. Each axis has an encoder of its own
//! resolution, and each load cell its own noise and zero.

use crate::noise::Noise;
use friction::planar::{FrictionLaw, Law, LawState, Motion, Vector};
use friction::{Invalid, in_range};

/// The rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarConfig {
    /// Moving mass of each axis, kg.
    pub mass: Vector<f64>,
    /// Sampling period, s.
    pub period: f64,
    /// Steps of the integration in a sampling period.
    pub substeps: usize,
    /// Stiffness of the drive, N/m.
    pub stiffness: f64,
    /// Damping of the drive, N·s/m.
    pub damping: f64,
    /// Resolution of the encoder of each axis, m.
    pub resolution: Vector<f64>,
    /// Standard deviation of one sample of a load cell, N.
    pub force_noise: f64,
    /// What each load cell shows without a load, N.
    pub force_zero: Vector<f64>,
}

impl Default for PlanarConfig {
    /// 0.4 kg and 0.5 kg, 1 kHz in 40 steps, encoders of 1 µm, load cells with 0.03 N of noise.
    fn default() -> Self {
        Self {
            mass: Vector { x: 0.4, y: 0.5 },
            period: 1e-3,
            substeps: 40,
            stiffness: 5000.0,
            damping: 100.0,
            resolution: Vector { x: 1e-6, y: 1e-6 },
            force_noise: 0.03,
            force_zero: Vector { x: 0.0, y: 0.0 },
        }
    }
}

impl PlanarConfig {
    /// Checks every number, and that the drive is stable in the steps of the integration.
    ///
    /// # Errors
    /// The first that is out of range, with the accepted range.
    pub fn validate(&self) -> Result<(), Invalid> {
        let (light, heavy) = (self.mass.x.min(self.mass.y), self.mass.x.max(self.mass.y));
        in_range("mass", light, 1e-3, 1e3)?;
        in_range("mass", heavy, 1e-3, 1e3)?;
        in_range("period", self.period, 1e-5, 0.1)?;
        in_range("substeps", self.substeps as f64, 1.0, 1e4)?;
        let dt = self.period / self.substeps as f64;
        in_range("damping", self.damping, 0.0, 0.5 * light / dt)?;
        in_range("stiffness", self.stiffness, 0.0, 0.5 * light / (dt * dt))?;
        in_range("resolution", self.resolution.x.min(self.resolution.y), 0.0, 1e-2)?;
        in_range("resolution", self.resolution.x.max(self.resolution.y), 0.0, 1e-2)?;
        in_range("force_noise", self.force_noise, 0.0, 1e3)
    }
}

/// Where the drive goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// Two sines for each axis, m and Hz; without a common period, the motion takes every direction at many speeds.
    Multisines {
        /// Largest excursion of an axis, m.
        amplitude: f64,
        /// Of the slowest sine, Hz.
        frequency: f64,
    },
    /// Circles whose radius breathes, so that the speed changes.
    Circles {
        /// Largest radius, m.
        radius: f64,
        /// Turns a second, Hz.
        frequency: f64,
    },
    /// To and fro on lines through the middle; each line is turned against the one before.
    Lines {
        /// Half the length, m.
        half: f64,
        /// To and fro, Hz.
        frequency: f64,
        /// Lines in half a turn.
        lines: u32,
    },
}

impl Path {
    /// Reference position, m, at a time, s.
    #[must_use]
    pub fn at(&self, time: f64) -> Vector<f64> {
        let sine = |hz: f64, phase: f64| libm::sin(core::f64::consts::TAU * hz * time + phase);
        match *self {
            Self::Multisines { amplitude, frequency: f } => Vector {
                x: amplitude * (0.65 * sine(f, 0.0) + 0.35 * sine(2.618 * f, 1.1)),
                y: amplitude * (0.65 * sine(1.272 * f, 0.7) + 0.35 * sine(3.147 * f, 0.2)),
            },
            Self::Circles { radius, frequency: f } => {
                let breath = radius * (0.65 + 0.35 * sine(0.137 * f, 0.0));
                let quarter = core::f64::consts::FRAC_PI_2;
                Vector { x: breath * sine(f, quarter), y: breath * sine(f, 0.0) }
            }
            Self::Lines { half, frequency: f, lines } => {
                let line = libm::floor(f * time / 2.0);
                let angle = core::f64::consts::PI * line / f64::from(lines.max(1));
                // at rest in the middle, where the line turns
                let along = half * libm::pow(sine(f, 0.0), 3.0);
                Vector { x: along * libm::cos(angle), y: along * libm::sin(angle) }
            }
        }
    }
}

/// What the sensors of a [`PlanarRig`] show.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanarSeries {
    /// s.
    pub time: Vec<f64>,
    /// Encoders, m.
    pub position: [Vec<f64>; 2],
    /// Load cells, N.
    pub force: [Vec<f64>; 2],
}

/// The simulated rig in the plane.
///
/// ```
/// use friction::planar::{Coulomb, Grain, Law};
/// use plant::{Path, PlanarConfig, PlanarRig};
/// let wood = Law::Coulomb(Coulomb { level: 1.0, stiction: 1.0, viscous: 0.0, grain: Grain::at(0.0, 2.0) });
/// let same = friction::planar::Vector { x: 0.4, y: 0.4 };
/// let mut rig = PlanarRig::new(PlanarConfig { mass: same, ..PlanarConfig::default() }, wood, 1)?;
/// let seen = rig.record(&Path::Circles { radius: 0.02, frequency: 1.0 }, 0.5, |_, _, _| Default::default());
/// assert_eq!(seen.time.len(), 500);
/// # Ok::<(), friction::Invalid>(())
/// ```
#[derive(Debug, Clone)]
pub struct PlanarRig {
    config: PlanarConfig,
    law: Law<f64>,
    state: LawState<f64>,
    position: Vector<f64>,
    velocity: Vector<f64>,
    displacement: Vector<f64>,
    time: f64,
    noise: [Noise; 2],
}

impl PlanarRig {
    /// A rig at rest at the origin, its noise drawn from `seed`.
    ///
    /// # Errors
    /// The first parameter of `config` or `law` that is out of range. Masses that differ need a law with bristles: the
    /// others stop a body that is equally heavy in every direction.
    pub fn new(config: PlanarConfig, law: Law<f64>, seed: u64) -> Result<Self, Invalid> {
        config.validate()?;
        law.validate()?;
        if matches!(law, Law::Coulomb(_) | Law::Karnopp(_)) {
            in_range("mass", config.mass.y, config.mass.x, config.mass.x)?;
        }
        let still = Vector::default();
        Ok(Self {
            config,
            law,
            state: LawState::default(),
            position: still,
            velocity: still,
            displacement: still,
            time: 0.0,
            noise: [Noise::new(seed, 1), Noise::new(seed, 2)],
        })
    }

    /// True position, m.
    #[must_use]
    pub fn position(&self) -> Vector<f64> {
        self.position
    }

    /// Advances by `dt`, s, and returns the force of the drive, N.
    fn advance(
        &mut self,
        reference: [Vector<f64>; 2],
        dt: f64,
        field: &impl Fn(f64, Vector<f64>, Vector<f64>) -> Vector<f64>,
    ) -> Vector<f64> {
        let c = &self.config;
        let wanted = (reference[1] - reference[0]) * (1.0 / dt);
        let drive = (reference[0] - self.position) * c.stiffness + (wanted - self.velocity) * c.damping;
        let applied = drive - field(self.time, self.position, self.velocity);
        let motion = Motion {
            dt,
            position: self.position,
            displacement: self.displacement,
            velocity: self.velocity,
            applied,
            mass: c.mass.x,
            normal: None,
        };
        let left = applied - self.law.step(&mut self.state, &motion);
        self.velocity = self.velocity + Vector { x: left.x * dt / c.mass.x, y: left.y * dt / c.mass.y };
        self.displacement = self.velocity * dt;
        self.position = self.position + self.displacement;
        self.time += dt;
        drive
    }

    /// Follows `path` for some seconds. `field` is a further force against the body, N, at a time, a position and a velocity.
    pub fn record(
        &mut self,
        path: &Path,
        seconds: f64,
        field: impl Fn(f64, Vector<f64>, Vector<f64>) -> Vector<f64>,
    ) -> PlanarSeries {
        let c = self.config;
        let dt = c.period / c.substeps as f64;
        let mut seen = PlanarSeries::default();
        for sample in 0..(seconds / c.period).round() as usize {
            // a load cell shows the mean over its period, an encoder the middle of it
            let mut force = Vector::default();
            let mut position = Vector::default();
            for step in 0..c.substeps {
                let reference = [path.at(self.time), path.at(self.time + dt)];
                let (before, drive) = (self.position, self.advance(reference, dt, &field));
                force = force + drive * (1.0 / c.substeps as f64);
                if step == c.substeps / 2 {
                    position = before;
                }
            }
            seen.time.push(sample as f64 * c.period);
            let axes = [
                (position.x, c.resolution.x, force.x + c.force_zero.x),
                (position.y, c.resolution.y, force.y + c.force_zero.y),
            ];
            for (axis, (x, quantum, f)) in axes.into_iter().enumerate() {
                let counts = if quantum > 0.0 { libm::floor(x / quantum + 0.5) * quantum } else { x };
                seen.position[axis].push(counts);
                seen.force[axis].push(f + self.noise[axis].draw(c.force_noise));
            }
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use friction::planar::{Coulomb, Grain, LuGre};

    const QUIET: PlanarConfig = PlanarConfig {
        mass: Vector { x: 0.4, y: 0.4 },
        period: 1e-3,
        substeps: 40,
        stiffness: 5000.0,
        damping: 100.0,
        resolution: Vector { x: 0.0, y: 0.0 },
        force_noise: 0.0,
        force_zero: Vector { x: 0.0, y: 0.0 },
    };

    fn coulomb(grain: Grain<f64>) -> Law<f64> {
        Law::Coulomb(Coulomb { level: 1.0, stiction: 1.0, viscous: 0.0, grain })
    }

    fn no_field(_: f64, _: Vector<f64>, _: Vector<f64>) -> Vector<f64> {
        Vector::default()
    }

    #[test]
    fn a_circle_at_constant_speed_needs_friction_and_centripetal_force() {
        let (radius, frequency) = (0.02, 1.0);
        let mut rig = PlanarRig::new(QUIET, coulomb(Grain::default()), 1).unwrap();
        let seen = rig.record(&Path::Circles { radius, frequency }, 1.9, no_field);
        // the radius is largest, and nearly constant, after a quarter of 1 s / 0.137
        let at = 1825;
        let (x, y) = (seen.position[0][at], seen.position[1][at]);
        let (fx, fy) = (seen.force[0][at], seen.force[1][at]);
        let r = libm::sqrt(x * x + y * y);
        let (along, inward) = ((fy * x - fx * y) / r, -(fx * x + fy * y) / r);
        println!("radius {r:.5} m, along {along:.4} N, inward {inward:.4} N");
        let omega = core::f64::consts::TAU * frequency;
        assert!((along - 1.0).abs() < 0.01, "{along}");
        assert!((inward - 0.4 * (omega * omega + 0.26) * r).abs() < 0.01, "{inward}");
    }

    #[test]
    fn the_drive_feels_twice_the_friction_across_the_grain() {
        let law = coulomb(Grain::at(0.3, 2.0));
        let along = |lines: u32, line: f64| {
            let mut rig = PlanarRig::new(QUIET, law, 1).unwrap();
            let path = Path::Lines { half: 0.02, frequency: 1.0, lines };
            // two periods a line
            let seen = rig.record(&path, 2.0 * (line + 1.0), no_field);
            // where sin³ is steepest: no acceleration, the drive balances friction
            let at = (2000.0 * line + 1000.0 * libm::asin(libm::sqrt(2.0 / 3.0)) / core::f64::consts::TAU)
                as usize;
            libm::sqrt(seen.force[0][at].powi(2) + seen.force[1][at].powi(2))
        };
        let found: Vec<f64> = (0..6).map(|line| along(6, f64::from(line))).collect();
        println!("{found:.3?} N");
        let most = found.iter().fold(0.0, |m: f64, f| m.max(*f));
        let least = found.iter().fold(9.0, |m: f64, f| m.min(*f));
        assert!((1.0..1.3).contains(&least) && (1.8..2.05).contains(&most), "{found:?}");
    }

    #[test]
    fn axes_of_different_mass_are_refused_where_the_law_stops_the_body() {
        let config = PlanarConfig::default();
        let refused = PlanarRig::new(config, coulomb(Grain::default()), 1).unwrap_err();
        assert_eq!(refused.to_string(), "mass = 0.5: accepted from 0.4 to 0.4");
        let contact = friction::LuGre {
            sigma_0: 1e5,
            sigma_1: 10.0,
            sigma_2: 0.0,
            coulomb: 1.0,
            stiction: 1.0,
            stribeck_velocity: 1e-3,
        };
        assert!(PlanarRig::new(config, Law::LuGre(LuGre { contact, grain: Grain::default() }), 1).is_ok());
    }

    #[test]
    fn the_same_seed_gives_the_same_recording() {
        let of = |seed| {
            let config = PlanarConfig { force_noise: 0.03, ..QUIET };
            let mut rig = PlanarRig::new(config, coulomb(Grain::default()), seed).unwrap();
            rig.record(&Path::Multisines { amplitude: 0.02, frequency: 0.7 }, 0.2, no_field)
        };
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
    }
}
