//! Feed-forward of what was found of a device itself, and what a hand feels of it before and after.
//!
//! ```text
//! learn      the free handle swings and sweeps slowly; the command moves it, so the command is the force (own_friction)
//! FeedForward::of   a model as the settings of `compensate`, with what of it cannot be fed forward
//! predict    what it would leave of the force of a recording
//! measure    a hand moves the handle before and after; the handle rests: a limit cycle would show
//! ```

use crate::error::{Error, Result};
use crate::own_friction::{OwnFriction, Period};
use crate::watch::{Watch, record};
use crate::{library, recordings::model_name};
use client::{Event, Move, Plan, Session};
use friction::effects::{EffectName, EffectState, Scale};
use friction::{Dimension, Law, Motion, Surface};
use haptics::{Compensation, Device, Wave, compensation::MAX_FED};
use identify::{Model, Preprocess, prepare};
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
/// A found damping is told to be cut from this multiple of the device's on.
const TOLD: f64 = 1.02;
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

/// Four digits, rounded towards zero: never more than what was found.
fn rounded(x: f64) -> f32 {
    let one = 10_f64.powf(3.0 - x.abs().log10().floor());
    if one.is_finite() { ((x * one).trunc() / one) as f32 } else { x as f32 }
}

/// Sliding levels and the smaller damping of a law.
fn levels(law: &Law<f64>) -> [f64; 3] {
    let surface = Surface::of(law);
    [surface.dynamic_p, surface.dynamic_n, surface.damping_p.min(surface.damping_n)]
}

impl FeedForward {
    /// The `share` of a model, on `device`.
    ///
    /// # Errors
    /// What the device would refuse, with the number that would be accepted; a model of the other geometry.
    pub fn of(model: &Model, share: f64, device: &Device) -> Result<Self> {
        if model.geometry != device.geometry {
            let why = format!(
                "{}: a {:?} model, and the device is {:?}",
                model.name, model.geometry, device.geometry
            );
            return Err(Error::input(why.to_lowercase()));
        }
        let refused = |refused: haptics::Refused| Error::input(refused.on(device.geometry).to_string());
        let [friction_p, friction_n, damping] = levels(&model.law);
        let mut left_out = Vec::new();
        let damping_unit = Dimension::DAMPING.unit(device.geometry);
        let most = f64::from(device.damping);
        if damping > TOLD * most {
            left_out.push(format!(
                "damping above {most:.4} {damping_unit}: `damping` of the device, which its stability bounds are made with"
            ));
        }
        let mut settings = Compensation {
            share: share as f32,
            friction_p: rounded(friction_p),
            friction_n: rounded(friction_n),
            damping: rounded(damping.clamp(0.0, most)),
            ..Compensation::off(device)
        };
        settings.validate(device).map_err(refused)?;
        for (id, effect) in EffectName::of(model.effects.iter()) {
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
                gains: effect.gains.map(rounded),
                shape: effect.shape.map(|x| x as f32),
            };
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
        // off first: what another one had is not kept
        let mut line = String::from("compensate");
        for p in Compensation::PARAMETERS {
            line += &format!(" {} {}", p.name, c.get(p.name).unwrap_or(0.0));
        }
        let mut lines = vec!["compensate off".to_owned(), line];
        for effect in c.effects.iter().flatten() {
            let gains = effect.kind.gains().iter().zip(effect.gains);
            let words = gains.chain(effect.kind.shape().iter().zip(effect.shape));
            let words: Vec<String> =
                words.map(|(p, x)| format!("{}.{} {x}", effect.kind.id(), p.name)).collect();
            lines.push(format!("compensate {}", words.join(" ")));
        }
        lines
    }

    /// Wavelength of the first effect that has one.
    fn period(&self) -> Period {
        let wave = |effect: &friction::effects::Effect<f32>| {
            let (_, length) =
                effect.kind.shape().iter().zip(effect.shape).find(|(p, _)| p.scale == Scale::Wavelength)?;
            Some(f64::from(length))
        };
        self.settings.effects.iter().flatten().find_map(wave).map_or(Period::None, Period::Known)
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
pub fn predict(
    model: &Model,
    feed: &FeedForward,
    recording: &Recording,
    absolute: bool,
) -> Result<Predicted> {
    let has_phase =
        feed.settings.effects.iter().flatten().any(|effect| effect.kind.about().wavelength().is_some());
    if has_phase && !absolute && model.name != model_name(std::slice::from_ref(recording)) {
        return Err(Error::input(format!(
            "{}: a phase along the stroke holds only while the zero of the position does",
            recording.name
        ))
        .with_help("`--absolute` says that it does: the device was homed both times"));
    }
    let signals = prepare(recording, &Preprocess::Tribos { cutoff_hz: model.cutoff_hz })?;
    let explained = model.predict_signals(&signals);
    // a slow sweep runs at the speed that says the direction
    let slow = 0.5 * f64::from(feed.settings.speed);
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

/// Learns the device of a session from its free handle, hands off, feed-forward off: a swing and one slow sweep, with the
/// command as the force.
///
/// # Errors
/// The device refuses or stops on a fault, a file cannot be written, or nothing can be identified.
pub fn learn(session: &mut Session, device: &Device, out: &Path, watch: &dyn Watch) -> Result<Model> {
    session.command("compensate off")?;
    let mut recordings = Vec::new();
    for (name, motion) in [("swing", SWINGS), ("sweep", SWEEPS)] {
        let motion = Move { amplitude: f64::from(device.length(motion.amplitude as f32)), ..motion };
        let plan = Plan { motion: Some(motion), seconds: motion.seconds.unwrap_or(20.0), notes: Vec::new() };
        let recording = recorded(session, &plan, &out.join(format!("{name}.csv")), watch)?;
        // the ramp-out of a move keeps the device busy
        for _ in 0..250 {
            session.poll()?;
        }
        recordings.push(driven_by_command(recording)?);
    }
    Ok(OwnFriction::of(&recordings, Period::Searched, device)?.model(device.geometry))
}

/// A recording, written to the file and read back.
fn recorded(session: &mut Session, plan: &Plan, file: &Path, watch: &dyn Watch) -> Result<Recording> {
    if record(session, plan, file, watch)?.interrupted {
        return Err(Error::Cancelled);
    }
    Ok(Recording::read(file, &ReadOptions::default())?)
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
    /// Damping.
    pub damping: f64,
    /// Mass beyond the load cell left out.
    pub mass: f64,
    /// Amplitude of the cogging.
    pub cogging: f64,
    /// Push on the handle about rest, beyond its inertia; one sample in twenty carries more.
    pub break_away: f64,
}

impl Felt {
    /// The mean friction of both directions, which no zero of the load cell changes.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.friction[0] + self.friction[1])
    }

    /// From a recording whose load cell shows the reaction to the push of the hand.
    fn of(mut recording: Recording, wave: Period, device: &Device) -> Result<Self> {
        recording.force.iter_mut().for_each(|force| *force = -*force);
        let recordings = [recording];
        let found = OwnFriction::of(&recordings, wave, device)?;
        let own = |name: &str| found.value(name);
        let break_away = push_at_rest(&recordings[0], own("mass").0, device)?;
        Ok(Self {
            friction: ["friction_p", "friction_n"].map(|name| own(name).0),
            friction_std: ["friction_p", "friction_n"].map(|name| own(name).1),
            damping: own("damping").0,
            mass: own("mass").0,
            cogging: found.amplitude(),
            break_away,
        })
    }
}

/// Push of the hand that a handle about rest carries, without that for its mass: the 95th of a hundred, N.
fn push_at_rest(recording: &Recording, mass: f64, device: &Device) -> Result<f64> {
    let signals = prepare(recording, &Preprocess::default())?;
    let slow = f64::from(device.rest_speed) / 5.0;
    let mut pushes: Vec<f64> = (0..signals.len())
        .filter(|i| signals.velocity[*i].abs() < slow)
        .map(|i| (signals.force_full()[i] - mass * signals.acceleration[i]).abs())
        .filter(|push| push.is_finite())
        .collect();
    pushes.sort_by(f64::total_cmp);
    Ok(pushes.get(pushes.len() * 95 / 100).copied().unwrap_or(f64::NAN))
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
/// The feed-forward stays on, and the preset as it was; a handle that does not rest switches it off.
///
/// # Errors
/// The device refuses or stops on a fault, a file cannot be written, or a recording cannot be identified.
pub fn measure(
    session: &mut Session,
    feed: &FeedForward,
    out: &Path,
    seconds: f64,
    watch: &dyn Watch,
    by_hand: &mut dyn FnMut(&mut Session, Hand) -> std::result::Result<(), client::Error>,
) -> Result<Measured> {
    let status = session.command("status")?;
    let measured = measure_with(session, feed, out, seconds, watch, by_hand);
    if !measured.as_ref().is_ok_and(|measured| measured.rests) {
        // whatever went wrong; the first failure is reported
        let _ = session.off();
        let _ = session.command("compensate off");
    }
    let preset = status.split(", ").find_map(|part| part.strip_prefix("preset "));
    if let Some(name) = preset.filter(|name| !name.contains(' ')) {
        let _ = session.command(&format!("preset use {name}"));
    }
    measured
}

fn measure_with(
    session: &mut Session,
    feed: &FeedForward,
    out: &Path,
    seconds: f64,
    watch: &dyn Watch,
    by_hand: &mut dyn FnMut(&mut Session, Hand) -> std::result::Result<(), client::Error>,
) -> Result<Measured> {
    session.command("compensate off")?;
    // rendered is nothing: what is felt is the device
    let bare = library::read(Path::new("baseline"))?;
    let settled = session.set_all(&bare.preset_lines())?;
    if let Some(first) = settled.refused.first() {
        return Err(Error::Identified(first.clone()));
    }
    let device = device_of(session)?;
    by_hand(session, Hand::Moves)?;
    let rendered = |session: &mut Session, name: &str, seconds: f64, told: &str| {
        session.command("render on")?;
        let plan = Plan { motion: None, seconds, notes: vec![("compensation".into(), told.to_owned())] };
        recorded(session, &plan, &out.join(name), watch)
    };
    let felt = |session: &mut Session, name: &str, told: &str| -> Result<Felt> {
        Felt::of(rendered(session, name, seconds, told)?, feed.period(), &device)
    };
    let before = felt(session, "before.csv", "off")?;
    for command in feed.commands() {
        session.command(&command)?;
    }
    let words = feed.settings.on(feed.geometry).to_string();
    let after = felt(session, "after.csv", &words)?;
    by_hand(session, Hand::Off)?;
    let rest = rendered(session, "rest.csv", REST_S, &words)?;
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
    Ok(Measured { before, after, rest_counts, rests: rest_counts <= TOGGLE })
}

/// What a person, or the simulated hand, does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hand {
    /// Moves the handle to and fro.
    Moves,
    /// Lets go of it.
    Off,
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

    /// A virtual device with this cogging, N and m.
    fn learned(seed: u64, cogging: &str) -> (tempfile::TempDir, Session, Device, Model) {
        let dir = tempfile::tempdir().expect("a folder");
        let mut session = session(seed);
        session.command(&format!("sim cogging {cogging}")).expect("a rig");
        let device = device_of(&mut session).expect("a header");
        let model =
            learn(&mut session, &device, dir.path(), &crate::Unwatched).unwrap_or_else(|e| panic!("{e}"));
        (dir, session, device, model)
    }

    fn hand(session: &mut Session, hand: Hand) -> std::result::Result<(), client::Error> {
        session.command(if hand == Hand::Off { "sim hand off" } else { "sim hand sine 0.008 0.5" })?;
        Ok(())
    }

    #[test]
    fn a_device_learns_its_friction_and_cogging() {
        for (seed, cogging, amplitude, wavelength) in
            [(1, "0.2 0.004", 0.2, 0.004), (2, "0.08 0.0063", 0.08, 0.0063), (3, "0.3 0.0017", 0.3, 0.0017)]
        {
            let (_dir, _, _, model) = learned(seed, cogging);
            let [p, n, damping] = levels(&model.law);
            let [effect] = model.effects[..] else { panic!("{cogging}: {:?}", model.effects) };
            let (found, length) = (effect.gains[0].hypot(effect.gains[1]), effect.shape[0]);
            println!(
                "{cogging}: {p:.4} N, {n:.4} N, {damping:.3} N·s/m; {} {found:.4} N every {length:.6} m",
                effect.kind.id()
            );
            assert!((p - 1.04).abs() < 0.01 && (n - 0.69).abs() < 0.01 && (damping - 6.92).abs() < 0.2);
            assert!(
                (found - amplitude).abs() < 0.01 && (length / wavelength - 1.0).abs() < 2e-3,
                "{effect:?}"
            );
        }
        for seed in 4..8 {
            let (_dir, _, _, model) = learned(seed, "0 0.004");
            assert_eq!(model.effects, [], "no cogging is there");
        }
    }

    #[test]
    fn a_hand_feels_a_tenth_of_what_was_found() {
        for seed in 1..4 {
            let (dir, mut session, device, model) = learned(seed, "0.2 0.004");
            let feed = FeedForward::of(&model, 0.9, &device).unwrap_or_else(|e| panic!("{e}"));
            let m = measure(&mut session, &feed, dir.path(), 12.0, &crate::Unwatched, &mut hand)
                .unwrap_or_else(|e| panic!("{e}"));
            println!("{:?}\n{:?}, {} counts", m.before, m.after, m.rest_counts);
            for (k, level) in [1.04, 0.69].into_iter().enumerate() {
                assert!((m.before.friction[k] - level).abs() < 0.03);
                assert!(m.after.friction[k] > 0.05 * level && m.after.friction[k] < 0.15 * level);
            }
            assert!(
                m.after.cogging < 0.15 * m.before.cogging && m.after.break_away < 0.25 * m.before.break_away
            );
            assert!(m.rests && m.rest_counts < 1.0);
            // it stays on, and the preset is what it was
            let status = session.command("status").expect("an answer");
            assert!(status.contains("preset brass, ") && status.contains("compensates 90 %"), "{status}");
        }
    }

    /// A model that tells half too much friction.
    #[test]
    fn a_handle_that_runs_by_itself_is_switched_off() {
        let dir = tempfile::tempdir().expect("a folder");
        let mut session = session(1);
        let device = device_of(&mut session).expect("a header");
        let law = friction::Coulomb {
            level_p: 1.56,
            level_n: 1.04,
            static_p: 1.56,
            static_n: 1.04,
            viscous_p: 6.9,
            viscous_n: 6.9,
        };
        let model = Model { mass: 0.692, law: Law::Coulomb(law), ..Model::default() };
        let feed = FeedForward::of(&model, 0.9, &device).unwrap_or_else(|e| panic!("{e}"));
        let mut let_go_in_motion = |session: &mut Session, hand: Hand| {
            session.command("sim hand sine 0.008 0.5")?;
            if hand == Hand::Off {
                session.command("render on")?;
                (0..40).try_for_each(|_| session.poll().map(|_| ()))?;
                session.command("sim hand off")?;
            }
            Ok(())
        };
        match measure(&mut session, &feed, dir.path(), 6.0, &crate::Unwatched, &mut let_go_in_motion) {
            Ok(m) => {
                println!("{} counts", m.rest_counts);
                assert!(!m.rests && m.rest_counts > 100.0);
            }
            // it ran into its stop
            Err(fault) => println!("{fault}"),
        }
        let told = session.exchange("compensate").expect("an answer");
        assert_eq!(told, ["ok compensate off"]);
    }

    #[test]
    fn what_cannot_be_fed_forward_is_told() {
        use friction::effects::{Effect, EffectKind};
        let effect = |kind, gains, shape| Effect { kind, gains, shape };
        let model = Model {
            effects: vec![
                effect(EffectKind::Stribeck, [0.3, 0.3, 0.0, 0.0], [0.01, 0.0]),
                effect(EffectKind::Spring, [90_000.0, 0.0, 0.0, 0.0], [0.0, 0.0]),
                effect(EffectKind::Cogging, [0.1, 0.0, 0.0, 0.0], [0.004, 0.0]),
            ],
            ..Model::default()
        };
        let device = Device::default();
        let feed = FeedForward::of(&model, 0.9, &device).unwrap_or_else(|e| panic!("{e}"));
        println!("{:#?}", feed.left_out);
        assert!(
            feed.left_out[0].starts_with("stribeck: ")
                && feed.left_out[1].starts_with("spring: share = 0.9: accepted up to")
        );
        assert_eq!(feed.settings.effects.iter().flatten().count(), 1);
        let error = FeedForward::of(&model, 0.95, &device).expect_err("above");
        assert!(error.to_string().starts_with("share = 0.95: accepted from 0 to 0.9; "), "{error}");
        let rotary = Device { geometry: Geometry::Rotary, ..device };
        assert!(FeedForward::of(&model, 0.9, &rotary).is_err());
    }
}
