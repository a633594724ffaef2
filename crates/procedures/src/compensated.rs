//! Feed-forward of what was found of a device itself, and what a hand feels of it before and after.
//!
//! ```text
//! learn      the free handle swings and sweeps slowly; the command moves it, so the command is the force: friction, cogging
//! FeedForward::of   a model as the settings of `compensate`, with what of it cannot be fed forward
//! predict    what it would leave of the force of a recording
//! measure    a hand moves the handle before and after; the handle rests: a limit cycle would show
//! ```

use crate::error::{Error, Result};
use crate::watch::{Watch, record};
use crate::{library, recordings::model_name};
use client::{Event, Move, Plan, Session};
use diagnose::{Options, diagnose};
use friction::effects::{EffectState, MAX_GAINS, MAX_SHAPE};
use friction::{Dimension, Law, Motion};
use haptics::{Compensation, Device, Wave, settings::MAX_FED};
use identify::{KarnoppOptions, Model, Preprocess, identify_karnopp, prepare};
use serde::Serialize;
use signals::{Geometry, ReadOptions, Recording};
use std::path::Path;
use std::time::{Duration, Instant};

/// How the device swings its own handle: mass, damping and both levels of friction.
const SWINGS: Move = Move { wave: Wave::Multisine, amplitude: 0.01, frequency: 0.8, seconds: Some(15.0) };
/// How it sweeps along the stroke, slowly: cogging shows at every place.
const SWEEPS: Move = Move { wave: Wave::Triangle, amplitude: 0.012, frequency: 0.08, seconds: Some(25.0) };
/// Length of a recording of the resting handle, s.
const REST_S: f64 = 3.0;
/// Travel of a handle at rest that is no limit cycle, counts: an edge that toggles.
const TOGGLE: f64 = 2.0;
/// Longest wait for the header of a stream.
const PATIENCE: Duration = Duration::from_secs(5);

/// What of a model is fed forward on a device.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedForward {
    /// The settings.
    pub settings: Compensation,
    /// Slide or axis.
    pub geometry: Geometry,
    /// What of the model is not fed forward, and why.
    pub left_out: Vec<String>,
    /// Damping that is left, and what the sampled effects need of it, N·s/m.
    pub damping: [f64; 2],
    /// Smallest friction, as a share of what was found, with which the device stays passive.
    pub passive_from: f64,
    /// The same with two standard errors of what was found; none where the model has no errors.
    pub certain_from: Option<f64>,
}

/// Sliding levels and the smaller damping of a law.
fn levels(law: &Law<f64>) -> [f64; 3] {
    match law {
        Law::Karnopp(k) => [k.c_p, k.c_n, k.b_p.min(k.b_n)],
        Law::Coulomb(c) => [c.level_p, c.level_n, c.viscous_p.min(c.viscous_n)],
        Law::Dahl(d) => [d.limit_p, d.limit_n, d.viscous],
        Law::LuGre(l) => [l.coulomb, l.coulomb, l.sigma_2],
    }
}

impl FeedForward {
    /// The `share` of a model, on `device`.
    ///
    /// # Errors
    /// What the device would refuse, with the number that would be accepted; a model of the other geometry.
    pub fn of(model: &Model, share: f64, device: &Device) -> Result<Self> {
        if model.geometry != device.geometry {
            let why = format!("{}: a {:?} model, and the device is {:?}", model.name, model.geometry, device.geometry);
            return Err(Error::input(why.to_lowercase()));
        }
        let refused = |refused: haptics::Refused| Error::option("compensate", refused.on(device.geometry).to_string());
        let [friction_p, friction_n, damping] = levels(&model.law);
        let mut left_out = Vec::new();
        let damping_unit = Dimension::DAMPING.unit(device.geometry);
        let most = f64::from(device.damping);
        if damping > most {
            left_out.push(format!(
                "damping above {most:.4} {damping_unit}: `damping` of the device, which its stability bounds are made with"
            ));
        }
        let mut settings = Compensation {
            share: share as f32,
            friction_p: friction_p as f32,
            friction_n: friction_n as f32,
            damping: damping.clamp(0.0, most) as f32,
            ..Compensation::off(device)
        };
        settings.validate(device).map_err(refused)?;
        for effect in &model.effects {
            let id = effect.kind.id();
            if !effect.kind.is_of_position() {
                left_out.push(format!("{id}: no force of the position alone"));
                continue;
            }
            let Some(place) = settings.effects.iter().position(Option::is_none) else {
                left_out.push(format!("{id}: {MAX_FED} effects are fed forward at most"));
                continue;
            };
            let narrow = friction::effects::Effect {
                kind: effect.kind,
                gains: effect.gains.map(|x| x as f32),
                shape: effect.shape.map(|x| x as f32),
            };
            const { assert!(MAX_GAINS > 0 && MAX_SHAPE > 0) };
            let mut with = settings;
            with.effects[place] = Some(narrow);
            match with.validate(device) {
                Ok(()) => settings = with,
                Err(why) => left_out.push(format!("{id}: {}", why.on(device.geometry))),
            }
        }
        if !model.curves.is_empty() {
            left_out.push("curves without a name: the device has none".to_owned());
        }
        let (left, needed) = settings.sampled_damping(device);
        // the relative error of the worse direction
        let error = [("f_dynamic_p", friction_p), ("f_dynamic_n", friction_n)]
            .iter()
            .filter_map(|(name, level)| Some(2.0 * model.std.get(*name)? / level))
            .filter(|error| error.is_finite())
            .reduce(f64::max);
        Ok(Self {
            settings,
            geometry: device.geometry,
            left_out,
            damping: [f64::from(left), f64::from(needed)],
            passive_from: share,
            certain_from: error.map(|error| share * (1.0 + error)),
        })
    }

    /// The commands that set it on a device.
    #[must_use]
    pub fn commands(&self) -> Vec<String> {
        let c = &self.settings;
        let mut line = String::from("compensate");
        for p in Compensation::PARAMETERS {
            line += &format!(" {} {}", p.name, c.get(p.name).unwrap_or(0.0));
        }
        let mut lines = vec![line];
        for effect in c.effects.iter().flatten() {
            let gains = effect.kind.gains().iter().zip(effect.gains);
            let words = gains.chain(effect.kind.shape().iter().zip(effect.shape));
            let words: Vec<String> = words.map(|(p, x)| format!("{}.{} {x}", effect.kind.id(), p.name)).collect();
            lines.push(format!("compensate {}", words.join(" ")));
        }
        lines
    }

    /// The force that would be fed forward in a motion, N; the direction by velocity alone.
    fn force(&self, position: f64, velocity: f64, applied: f64) -> f64 {
        let c = &self.settings;
        let wide = |x: f32| f64::from(x);
        let direction = (velocity / wide(c.speed)).clamp(-1.0, 1.0);
        let level = wide(if direction > 0.0 { c.friction_p } else { c.friction_n });
        let motion = Motion { position: position as f32, applied: applied as f32, ..Motion::default() };
        let effects: f32 =
            c.effects.iter().flatten().map(|effect| effect.step(&mut EffectState::default(), &motion)).sum();
        wide(c.share) * (level * direction + wide(c.damping) * velocity + wide(effects))
    }
}

/// What a feed-forward would leave of a recording. Forces without that of the mass, where the body slides; N or N·m, rms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Predicted {
    /// Friction, damping and effects as recorded.
    pub before: f64,
    /// The same with the feed-forward.
    pub after: f64,
    /// What the model itself does not explain of them.
    pub unexplained: f64,
    /// Number of samples.
    pub samples: usize,
}

/// Predicts what a feed-forward leaves of the force of a recording. Nothing moves.
///
/// # Errors
/// A recording that cannot be prepared; one that was made of another model and whose zero is not known, for effects with a
/// phase along the stroke, unless its position is `absolute`.
pub fn predict(model: &Model, feed: &FeedForward, recording: &Recording, absolute: bool) -> Result<Predicted> {
    let has_phase = feed.settings.effects.iter().flatten().any(|effect| effect.kind.about().wavelength().is_some());
    if has_phase && !absolute && model.name != model_name(std::slice::from_ref(recording)) {
        return Err(Error::input(format!(
            "{}: a phase along the stroke holds only while the zero of the position does",
            recording.name
        ))
        .with_help("`--absolute` says that it does: the device was homed both times"));
    }
    let signals = prepare(recording, &Preprocess::Tribos { cutoff_hz: model.cutoff_hz })?;
    let explained = model.predict_signals(&signals);
    let slow = f64::from(feed.settings.speed);
    let (mut before, mut after, mut unexplained, mut samples) = (0.0, 0.0, 0.0, 0_usize);
    let offset = model.nuisances.offset;
    for (i, explained) in explained.iter().enumerate() {
        let (x, v, a, force) =
            (signals.position[i], signals.velocity[i], signals.acceleration[i], signals.force[i]);
        if !(v.abs() > slow && (force + a + explained).is_finite()) {
            continue;
        }
        let own = force - offset - model.mass * a;
        let left = own - feed.force(x, v, force);
        before += own * own;
        after += left * left;
        unexplained += (force - explained) * (force - explained);
        samples += 1;
    }
    if samples == 0 {
        return Err(Error::input(format!("{}: nothing moves faster than {slow} m/s", recording.name)));
    }
    let rms = |sum: f64| (sum / samples as f64).sqrt();
    Ok(Predicted { before: rms(before), after: rms(after), unexplained: rms(unexplained), samples })
}

/// The device of a session, as its stream tells.
///
/// # Errors
/// The line failed, or no header came.
pub fn device_of(session: &mut Session) -> Result<Device> {
    session.command("stream on 10")?;
    let began = Instant::now();
    let found = loop {
        let header = session.poll()?.into_iter().find_map(|event| match event {
            Event::Header(header) => Some(header.device()),
            _ => None,
        });
        if header.is_some() || began.elapsed() > PATIENCE {
            break header;
        }
    };
    session.command("stream off")?;
    found.ok_or_else(|| Error::input(format!("{}: no header in its stream", session.name())))
}

/// Learns the device of a session from its free handle, hands off, feed-forward off: a swing and one slow sweep, diagnosed
/// with the command as the force.
///
/// # Errors
/// The device refuses or stops on a fault, a file cannot be written, or nothing can be identified.
pub fn learn(session: &mut Session, device: &Device, out: &Path, watch: &dyn Watch) -> Result<Model> {
    session.command("compensate off")?;
    let mut recordings = Vec::new();
    for (name, motion) in [("swing", SWINGS), ("sweep", SWEEPS)] {
        let motion = Move { amplitude: f64::from(device.length(motion.amplitude as f32)), ..motion };
        let path = out.join(format!("{name}.csv"));
        let plan = Plan { motion: Some(motion), seconds: motion.seconds.unwrap_or(20.0), notes: Vec::new() };
        if record(session, &plan, &path, watch)?.interrupted {
            return Err(Error::Cancelled);
        }
        // the ramp-out of a move keeps the device busy
        for _ in 0..250 {
            session.poll()?;
        }
        recordings.push(driven_by_command(Recording::read(&path, &ReadOptions::default())?)?);
    }
    let bar = watch.begin("diagnosing");
    let found = diagnose(&recordings, &[], &Options::default(), &|share, what| bar.set(share, what))?;
    let model = found.model.ok_or_else(|| Error::input(format!("nothing was identified: {}", found.summary)))?;
    Ok(Model { name: "device".into(), ..model })
}

/// The recording of a free handle: what moves it is the command.
fn driven_by_command(mut recording: Recording) -> Result<Recording> {
    let Some(command) = recording.command.take() else {
        return Err(Error::input(format!("{}: no column of the command", recording.name)));
    };
    recording.force = command;
    Ok(recording)
}

/// What a hand that moves the handle feels of the device. N, N·s/m, kg, or those of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Felt {
    /// Sliding friction in positive and in negative direction.
    pub friction: [f64; 2],
    /// Their standard errors.
    pub friction_std: [f64; 2],
    /// Damping, mean of both directions.
    pub damping: f64,
    /// Mass beyond the load cell left out.
    pub mass: f64,
}

impl Felt {
    /// The mean friction of both directions, which no zero of the load cell changes.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.friction[0] + self.friction[1])
    }

    /// From a recording whose force is what the hand feels: the load cell shows the reaction to its push.
    fn of(recording: &Recording) -> Result<Self> {
        let mut pushed = recording.clone();
        pushed.force.iter_mut().for_each(|force| *force = -*force);
        let found = identify_karnopp(&prepare(&pushed, &Preprocess::default())?, &KarnoppOptions::default())?;
        let of = |name: &str| found.value(name).unwrap_or(f64::NAN);
        let std = |name: &str| found.parameters.get(name).map_or(f64::NAN, |p| p.std);
        Ok(Self {
            friction: ["coulomb_p", "coulomb_n"].map(of),
            friction_std: ["coulomb_p", "coulomb_n"].map(std),
            damping: 0.5 * (of("viscous_p") + of("viscous_n")),
            mass: of("mass"),
        })
    }
}

/// What a measurement on the device found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// Without the feed-forward.
    pub before: Felt,
    /// With it.
    pub after: Felt,
    /// Travel of the released handle with the feed-forward, counts, peak to peak.
    pub rest_counts: f64,
    /// Whether it rests.
    pub rests: bool,
}

/// Records a hand on the handle before and after, and the released handle. `by_hand` is told what is wanted of the hand.
/// The feed-forward stays on; a handle that does not rest switches it off.
///
/// # Errors
/// The device refuses or stops on a fault, a file cannot be written, or a recording cannot be identified.
pub fn measure(
    session: &mut Session,
    feed: &FeedForward,
    out: &Path,
    seconds: f64,
    watch: &dyn Watch,
    by_hand: &mut dyn FnMut(&mut Session, Hand) -> Result<()>,
) -> Result<Measured> {
    session.command("compensate off")?;
    // rendered is nothing: what is felt is the device
    let bare = library::read(Path::new("baseline"))?;
    let settled = session.set_all(&bare.preset_lines())?;
    if let Some(first) = settled.refused.first() {
        return Err(Error::Identified(first.clone()));
    }
    by_hand(session, Hand::Moves)?;
    let before = felt(session, &out.join("before.csv"), seconds, "off", watch)?;
    for command in feed.commands() {
        session.command(&command)?;
    }
    let words = feed.settings.on(feed.geometry).to_string();
    let after = felt(session, &out.join("after.csv"), seconds, &words, watch)?;
    by_hand(session, Hand::Off)?;
    session.command("render on")?;
    let rest = out.join("rest.csv");
    let plan = Plan { motion: None, seconds: REST_S, notes: vec![("compensation".into(), words)] };
    let recorded = record(session, &plan, &rest, watch)?;
    if recorded.interrupted {
        return Err(Error::Cancelled);
    }
    let rest = Recording::read(&rest, &ReadOptions::default())?;
    // the last two seconds: a released handle coasts
    let from = rest.time.partition_point(|t| *t < REST_S - 2.0);
    let (low, high) = rest.position[from..]
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    let count = rest
        .metadata
        .iter()
        .find(|(key, _)| key.ends_with("_per_count"))
        .and_then(|(_, value)| value.parse::<f64>().ok())
        .unwrap_or(1e-6);
    let rest_counts = (high - low) / count;
    let rests = rest_counts <= TOGGLE;
    if !rests {
        session.command("compensate off")?;
    }
    Ok(Measured { before, after, rest_counts, rests })
}

/// What a person, or the simulated hand, does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hand {
    /// Moves the handle to and fro.
    Moves,
    /// Lets go of it.
    Off,
}

/// Records a hand that moves the handle, and what it feels.
fn felt(session: &mut Session, path: &Path, seconds: f64, told: &str, watch: &dyn Watch) -> Result<Felt> {
    session.command("render on")?;
    let plan = Plan { motion: None, seconds, notes: vec![("compensation".into(), told.to_owned())] };
    let recorded = record(session, &plan, path, watch)?;
    if recorded.interrupted {
        return Err(Error::Cancelled);
    }
    Felt::of(&Recording::read(path, &ReadOptions::default())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use client::Virtual;

    fn session(seed: u64) -> Session {
        let mut session = Session::over("sim", Box::new(Virtual::new(seed).expect("a virtual device")));
        session.command("sim friction 1.04 0.69").expect("a rig");
        session.command("sim cogging 0.2 0.004").expect("a rig");
        session
    }

    #[test]
    fn try_learn() {
        let dir = tempfile::tempdir().expect("a folder");
        let mut s = session(1);
        let device = device_of(&mut s).expect("device");
        let t = Instant::now();
        let model = learn(&mut s, &device, dir.path(), &crate::Unwatched).unwrap_or_else(|e| panic!("{e}"));
        println!("{:?}\n{}", t.elapsed(), model.to_toml());
        let feed = FeedForward::of(&model, 0.9, &device).unwrap_or_else(|e| panic!("{e}"));
        println!("{feed:?} {:?}", feed.commands());
        let mut hand = |session: &mut Session, hand: Hand| {
            session.command(if hand == Hand::Off { "sim hand off" } else { "sim hand sine 0.008 0.5" })?;
            Ok(())
        };
        let m = measure(&mut s, &feed, dir.path(), 12.0, &crate::Unwatched, &mut hand).unwrap_or_else(|e| panic!("{e}"));
        println!("{m:#?}");
    }
}
