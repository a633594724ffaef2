//! The identification experiment of [thesis, ch. 3.5], simulated.

use crate::materials::Material;
use crate::noise::Noise;
use crate::{NoHand, Rig, RigConfig};
use friction::{FrictionLaw, Invalid};

/// Columns of equal length, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// s.
    pub time: Vec<f64>,
    /// m.
    pub position: Vec<f64>,
    /// m/s.
    pub velocity: Vec<f64>,
    /// m/s².
    pub acceleration: Vec<f64>,
    /// Force between device and block, N.
    pub force: Vec<f64>,
}

impl Series {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
}

/// Standard deviations of independent Gaussian measurement errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasurementNoise {
    /// m.
    pub position: f64,
    /// m/s.
    pub velocity: f64,
    /// m/s².
    pub acceleration: f64,
    /// N.
    pub force: f64,
}

impl MeasurementNoise {
    /// [thesis, table 3-2].
    pub const THESIS: Self =
        Self { position: 5.76e-5, velocity: 3.18e-3, acceleration: 0.2379, force: 0.062 };
}

/// Excitation of the block: a sine under PD control, with a second-order low-pass on the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excitation {
    /// m.
    pub amplitude: f64,
    /// Hz.
    pub frequency: f64,
    /// Warm-up before the recording, s.
    pub warm_up: f64,
    /// Length of the recording, s.
    pub seconds: f64,
    /// Proportional gain, N/m.
    pub stiffness: f64,
    /// Derivative gain, N·s/m.
    pub damping: f64,
    /// Cut-off of the low-pass on the command, Hz.
    pub cutoff: f64,
}

impl Excitation {
    /// 2 Hz, 10 mm, 10 s of warm-up, 2 s recorded, command filtered at 100 Hz [thesis, ch. 3.5]. The PD gains, which are
    /// not printed, give a smooth sine on every material.
    pub const THESIS: Self = Self {
        amplitude: 0.01,
        frequency: 2.0,
        warm_up: 10.0,
        seconds: 2.0,
        stiffness: 5000.0,
        damping: 100.0,
        cutoff: 100.0,
    };
}

/// One experiment, simulated once: the noise-free truth, from which recordings are drawn.
///
/// ```
/// use plant::{ThesisExperiment, materials};
/// let experiment = ThesisExperiment::on(&materials::BRASS)?;
/// let (first, second) = (experiment.recording(1), experiment.recording(2));
/// assert_eq!(first.len(), 2000);
/// assert_ne!(first.force, second.force);
/// # Ok::<(), friction::Invalid>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ThesisExperiment {
    /// The true state, without noise.
    pub truth: Series,
    /// Friction of the block, N, positive against positive motion: `force` − mass·`acceleration`.
    pub friction: Vec<f64>,
}

impl ThesisExperiment {
    /// The experiment with the mass and law of a column of [thesis, table 3-3].
    ///
    /// # Errors
    /// A parameter of the material that is out of range.
    pub fn on(material: &Material) -> Result<Self, Invalid> {
        Self::with(material.mass, material.law, &Excitation::THESIS)
    }

    /// The experiment with any block mass, kg, law and excitation, on the rig of [thesis, table 3-1].
    ///
    /// # Errors
    /// A parameter that is out of range.
    pub fn with<L: FrictionLaw<f64>>(mass: f64, law: L, excitation: &Excitation) -> Result<Self, Invalid> {
        let config = RigConfig { block_mass: mass, ..RigConfig::noiseless() };
        friction::in_range("amplitude", excitation.amplitude, 0.0, 1.0)?;
        friction::in_range("frequency", excitation.frequency, 0.0, 200.0)?;
        friction::in_range("warm_up", excitation.warm_up, 0.0, 3600.0)?;
        friction::in_range("seconds", excitation.seconds, 0.0, 3600.0)?;
        friction::in_range("cutoff", excitation.cutoff, 1.0, 0.49 / config.period())?;
        let mut rig = Rig::new(config, law, 0)?;
        let mut filter = LowPass::new(excitation.cutoff, config.period());
        let omega = core::f64::consts::TAU * excitation.frequency;
        let skip = (excitation.warm_up / config.period()).round() as usize;
        let keep = (excitation.seconds / config.period()).round() as usize;
        let mut result = Self { truth: Series::default(), friction: Vec::with_capacity(keep) };
        for k in 0..skip + keep {
            let now = rig.truth();
            let reference = excitation.amplitude * libm::sin(omega * now.time);
            let speed = excitation.amplitude * omega * libm::cos(omega * now.time);
            let drive = excitation.stiffness * (reference - now.position)
                + excitation.damping * (speed - now.velocity);
            rig.tick(filter.step(drive), &mut NoHand);
            if k >= skip {
                let t = rig.truth();
                result.truth.time.push((k - skip) as f64 * config.period());
                result.truth.position.push(t.block_position);
                result.truth.velocity.push(t.block_velocity);
                result.truth.acceleration.push(t.acceleration);
                result.truth.force.push(t.force_at_load_cell);
                result.friction.push(t.friction);
            }
        }
        Ok(result)
    }

    /// A recording with the measurement errors of [thesis, table 3-2], drawn from `seed`. Takes about 0.1 ms for 2 s.
    #[must_use]
    pub fn recording(&self, seed: u64) -> Series {
        self.recording_with(&MeasurementNoise::THESIS, seed)
    }

    /// A recording with other measurement errors. Each column has its own stream.
    #[must_use]
    pub fn recording_with(&self, noise: &MeasurementNoise, seed: u64) -> Series {
        let noisy = |column: &[f64], stream: u64, std: f64| {
            let mut noise = Noise::new(seed, stream);
            column.iter().map(|value| value + noise.draw(std)).collect()
        };
        Series {
            time: self.truth.time.clone(),
            position: noisy(&self.truth.position, 11, noise.position),
            velocity: noisy(&self.truth.velocity, 12, noise.velocity),
            acceleration: noisy(&self.truth.acceleration, 13, noise.acceleration),
            force: noisy(&self.truth.force, 14, noise.force),
        }
    }
}

/// One recording of the experiment of [thesis, ch. 3.5] on `material`. For many seeds, simulate once with
/// [`ThesisExperiment::on`] and draw from that.
///
/// # Errors
/// A parameter of the material that is out of range.
pub fn thesis_recording(material: &Material, seed: u64) -> Result<Series, Invalid> {
    Ok(ThesisExperiment::on(material)?.recording(seed))
}

/// Second-order Butterworth low-pass by the bilinear transform, direct form I.
struct LowPass {
    gain: f64,
    a1: f64,
    a2: f64,
    input: [f64; 2],
    output: [f64; 2],
}

impl LowPass {
    fn new(cutoff: f64, period: f64) -> Self {
        let k = libm::tan(core::f64::consts::PI * cutoff * period);
        let norm = 1.0 + core::f64::consts::SQRT_2 * k + k * k;
        Self {
            gain: k * k / norm,
            a1: 2.0 * (k * k - 1.0) / norm,
            a2: (1.0 - core::f64::consts::SQRT_2 * k + k * k) / norm,
            input: [0.0; 2],
            output: [0.0; 2],
        }
    }

    fn step(&mut self, input: f64) -> f64 {
        let output = self.gain * (input + 2.0 * self.input[0] + self.input[1])
            - self.a1 * self.output[0]
            - self.a2 * self.output[1];
        self.input = [input, self.input[0]];
        self.output = [output, self.output[0]];
        output
    }
}
