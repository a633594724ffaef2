//! A rig of the size of the model, driven by the very control step of the device.

use crate::error::{Error, Result};
use crate::watch::Watch;
use client::{Calibration, Decoding, Move, Raw, Sample};
use friction::{FrictionLaw, Invalid, Law, Motion};
use haptics::{Channel, Control, Device, Request, Settings};
use identify::Model;
use plant::{Layered, NoHand, Rig, RigConfig, Sensor};
use signals::{Geometry, Recording};
use tribos_firmware::board::simulated::inputs;

/// What the block slides by: a law and the effects beside it.
pub type Slide = Layered<Law<f64>>;

/// What a model's block slides by.
///
/// # Errors
/// More effects or curves than a block can have.
pub fn slide_of(model: &Model) -> std::result::Result<Slide, Invalid> {
    let mut slide = Layered::with(model.law, &model.effects)?;
    model.curves.iter().try_for_each(|curve| slide.add_curve(*curve))?;
    Ok(slide)
}

/// The recording of a simulated rig that slides by a model. Its length is that of the motion, or `seconds`.
///
/// # Errors
/// Those of [`slide_of`] and [`simulate`].
pub fn recording(
    model: &Model,
    motion: &Move,
    seconds: f64,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Recording> {
    let slide = slide_of(model).map_err(|e| Error::input(format!("{}: {e}", model.name)))?;
    let seconds = motion.seconds.unwrap_or(seconds);
    let (points, calibration) = simulate(slide, model.mass, motion, seconds, seed, watch)?;
    let column = |f: fn(&Sample) -> f64| points.iter().map(f).collect::<Vec<f64>>();
    let start = points.first().map_or(0.0, |p| p.time);
    let offset = model.nuisances.offset;
    let mut recording = Recording {
        name: "simulated".into(),
        geometry: model.geometry,
        time: points.iter().map(|p| p.time - start).collect(),
        position: column(|p| p.position),
        force: points.iter().map(|p| p.force + offset).collect(),
        velocity: Some(column(|p| p.velocity)),
        acceleration: Some(column(|p| p.acceleration)),
        ..Recording::default()
    };
    if model.geometry == Geometry::Linear {
        recording.command = Some(column(|p| p.command));
        recording.reference = Some(column(|p| p.reference));
    }
    for (key, value) in [
        ("simulated_by", format!("tribos {}", env!("CARGO_PKG_VERSION"))),
        ("model", model.name.clone()),
        ("move", motion.to_string()),
        ("seed", seed.to_string()),
        ("newton_per_code", calibration.load_unit.to_string()),
    ] {
        recording.metadata.insert(key.into(), value);
    }
    Ok(recording)
}

/// Seconds before the recording begins: the ramp-in of the excitation and a period to settle.
const WARM_UP_S: f64 = 1.5;

/// Moves a simulated rig whose block slides by `slide` and has the mass `mass` kg.
///
/// Device, gains and sensors are those of [thesis, table 3-1 and 3-2], scaled where the model is too heavy for
/// them: PD gains with the moving mass, load cell range and noise with the expected force.
///
/// # Errors
/// A parameter of model or move that the simulation refuses, with what it would accept; [`Error::Cancelled`].
pub fn simulate(
    slide: Slide,
    mass: f64,
    motion: &Move,
    seconds: f64,
    seed: u64,
    watch: &dyn Watch,
) -> Result<(Vec<Sample>, Calibration)> {
    let refused = |e: &dyn std::fmt::Display| Error::Rig(e.to_string());
    let thesis = RigConfig::default();
    let total = thesis.device_mass + mass;
    let scale = total / (thesis.device_mass + thesis.block_mass);
    let turn = std::f64::consts::TAU * motion.frequency;
    let speed = f64::from(motion.wave.speed_factor()) * motion.amplitude * turn;
    let acceleration = f64::from(motion.wave.acceleration_factor()) * motion.amplitude * turn * turn;
    let friction = level(&slide, motion.amplitude, speed);
    // Twice what the move needs, so that a poor guess at the friction does not saturate the load cell.
    let expected = 2.0 * (mass * acceleration + friction);
    let range = (expected / 44.8).max(1.0);
    let mut rig = RigConfig {
        block_mass: mass,
        force_max: None,
        stroke: None,
        load: Sensor { noise: thesis.load.noise * range, ..thesis.load },
        ..thesis
    };
    rig.calibration.load.unit_per_code *= range;
    let device = Device {
        force_max: (4.0 * expected + 10.0 * total + 10.0) as f32,
        stroke: (4.0 * motion.amplitude + 0.01) as f32,
        overspeed: (8.0 * speed + 1.5) as f32,
        acceleration_max: 1e9,
        load: Channel {
            offset_code: rig.calibration.load.offset_code as f32,
            unit_per_code: rig.calibration.load.unit_per_code as f32,
        },
        tracking_stiffness: (2_500.0 * scale) as f32,
        tracking_damping: (50.0 * scale) as f32,
        ..Device::default()
    };
    let excitation = motion.excitation(0.0);
    excitation.validate(&device).map_err(|e| refused(&e))?;
    let config = Settings::viscous().build(&device).map_err(|e| refused(&e))?;
    let mut control = Control::referenced(config);
    let mut plant = Rig::new(rig, slide, seed).map_err(|e| refused(&e))?;
    let c = &rig.calibration;
    let calibration = Calibration {
        tick_hz: f64::from(c.tick_hz),
        metre_per_count: c.metre_per_count,
        origin_count: 0,
        load_offset: c.load.offset_code,
        load_unit: c.load.unit_per_code,
        accel_offset: c.accel.offset_code,
        accel_unit: c.accel.unit_per_code,
    };
    let mut decoding = Decoding::new(calibration);
    let periods = |s: f64| (s / rig.period()).round() as usize;
    let (skipped, kept) = (periods(WARM_UP_S), periods(seconds));
    let bar = watch.begin("simulating");
    let mut points = Vec::with_capacity(kept);
    let (mut force, mut began) = (0.0, None);
    for k in 0..skipped + kept {
        let sensors = plant.tick(f64::from(force), &mut NoHand);
        let request = (k == 0).then_some(Request::Excite(excitation));
        let out = control.step(request.as_ref(), &inputs(&sensors));
        if let Some(fault) = out.fault {
            let (seconds, fault) = (k as f64 * rig.period(), fault.explain().to_string());
            return Err(Error::Stopped { seconds, fault });
        }
        force = out.force;
        let sample = decoding.sample(&Raw {
            sample_ticks: sensors.sample_ticks,
            count: sensors.count,
            edge_ticks: sensors.edge_ticks,
            load_code: sensors.load_code,
            accel_code: sensors.accel_code,
            command: out.force,
            reference: out.reference,
            ..Raw::default()
        });
        // the estimator runs before the recording begins, and has its history then
        if let Some(sample) = sample.filter(|_| k >= skipped) {
            let from = *began.get_or_insert(sample.time);
            points.push(Sample { time: sample.time - from, ..sample });
        }
        if k % 1000 == 0 {
            bar.set(k as f32 / (skipped + kept) as f32, "");
            if watch.is_interrupted() {
                return Err(Error::Cancelled);
            }
        }
    }
    if plant.truth().not_finite > 0 {
        return Err(Error::NotFinite);
    }
    Ok((points, calibration))
}

/// Largest friction met on the way, N: the law asked at a few speeds and places.
fn level(slide: &Slide, amplitude: f64, speed: f64) -> f64 {
    let mut most: f64 = 0.0;
    for direction in [-1.0, 1.0] {
        let mut state = <Slide as FrictionLaw<f64>>::State::default();
        for k in 0..200 {
            let position = direction * amplitude * (f64::from(k) / 100.0 - 1.0);
            let velocity = direction * speed * f64::from(k % 20) / 19.0;
            let motion =
                Motion { dt: 1e-3, position, velocity, displacement: velocity * 1e-3, ..Motion::default() };
            let force = slide.step(&mut state, &motion).abs();
            if force.is_finite() {
                most = most.max(force);
            }
        }
    }
    most
}
