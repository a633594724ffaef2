//! A simulated hand in the targeting task, on the simulated device with the real renderer.
//!
//! ```text
//!  target ──> planned submovement ──> desired path ──> spring, damper, learnt friction and mass ──> muscle ──> handle
//!     ^        (minimum jerk,             x_d(t)        (impedance about x_d)       noise in proportion     │
//!     │         noisy end point)                                                    to the force            │
//!     └────────────── seen 100 ms late, with noise ───────── correct, or click ──────────────────────────────┘
//! ```
//!
//! The model contains neither Fitts's law [fitts-1954] nor any effect of friction on time or errors: friction acts only on
//! the handle. [`HandModel`] states every assumption; the parameters of a subject are drawn around it.

use crate::record::TargetingTrial;
use crate::stimulus::{Resistance, Stimulus};
use crate::targeting::{Event, Targeting};
use friction::{Coulomb, Law};
use haptics::{Control, Device, Inputs, Request, Settings};
use plant::{Hand, Rig, RigConfig, materials::RUBBER};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;

/// Time step of hand and control, s.
const DT: f64 = 1e-3;
/// Longest segment, s; a longer one is aborted.
const PATIENCE: f64 = 120.0;

/// Parameters of a simulated hand. The defaults are round numbers of the size reported for reaches of wrist and forearm. They
/// are not fitted to the results of [thesis, ch. 5.4]: stiffness, damping and the shortest submovement were changed once,
/// because the hand never finished a segment, and before any two resistances were compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandModel {
    /// Mass that moves with the handle, kg.
    pub mass: f64,
    /// Stiffness about the desired path, N/m.
    pub stiffness: f64,
    /// Damping about it, N·s/m.
    pub damping: f64,
    /// Time constant of the muscle, s.
    pub muscle_s: f64,
    /// Standard deviation of the force, as a share of the force (signal-dependent noise).
    pub force_noise: f64,
    /// Standard deviation of tremor, N.
    pub tremor: f64,
    /// Standard deviation of a submovement's planned end, as a share of its length.
    pub aim_noise: f64,
    /// Standard deviation of the seen position, pixels.
    pub sight_noise_px: f64,
    /// Delay from handle to sight, s.
    pub sight_delay_s: f64,
    /// Delay from motion of the handle to its perception, s.
    pub touch_delay_s: f64,
    /// Delay from the decision to the click, s.
    pub click_delay_s: f64,
    /// Duration of a submovement of 1 mm, s. Grows with the square root of the length.
    pub pace_s: f64,
    /// Shortest submovement, s.
    pub shortest_s: f64,
    /// Smallest distance from the rim for a click, pixels.
    pub caution_px: f64,
    /// Growth of a push that does not move the handle, N/s.
    pub push_rate: f64,
    /// Share of friction and mass learnt in practice.
    pub learnt: f64,
}

impl Default for HandModel {
    fn default() -> Self {
        Self {
            mass: 0.4,
            stiffness: 400.0,
            damping: 30.0,
            muscle_s: 0.03,
            force_noise: 0.08,
            tremor: 0.1,
            aim_noise: 0.06,
            sight_noise_px: 1.0,
            sight_delay_s: 0.10,
            touch_delay_s: 0.05,
            click_delay_s: 0.08,
            pace_s: 0.11,
            shortest_s: 0.2,
            caution_px: 1.0,
            push_rate: 20.0,
            learnt: 0.9,
        }
    }
}

impl HandModel {
    /// A subject: every parameter drawn from the seed within about a fifth of the default.
    #[must_use]
    pub fn drawn(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut vary = |value: f64| {
            let z: f64 = StandardNormal.sample(&mut rng);
            value * (0.2 * z.clamp(-2.5, 2.5)).exp()
        };
        let d = Self::default();
        Self {
            mass: vary(d.mass),
            stiffness: vary(d.stiffness),
            damping: vary(d.damping),
            muscle_s: d.muscle_s,
            force_noise: vary(d.force_noise),
            tremor: vary(d.tremor),
            aim_noise: vary(d.aim_noise),
            sight_noise_px: vary(d.sight_noise_px),
            sight_delay_s: vary(d.sight_delay_s),
            touch_delay_s: vary(d.touch_delay_s),
            click_delay_s: vary(d.click_delay_s),
            pace_s: vary(d.pace_s),
            shortest_s: vary(d.shortest_s),
            caution_px: vary(d.caution_px),
            push_rate: vary(d.push_rate),
            learnt: vary(d.learnt).min(1.0),
        }
    }

    /// Names and values of all parameters, for the session's file.
    #[must_use]
    pub fn parameters(&self) -> Vec<(String, f64)> {
        [
            ("hand.mass_kg", self.mass),
            ("hand.stiffness_n_m", self.stiffness),
            ("hand.damping_ns_m", self.damping),
            ("hand.muscle_s", self.muscle_s),
            ("hand.force_noise", self.force_noise),
            ("hand.tremor_n", self.tremor),
            ("hand.aim_noise", self.aim_noise),
            ("hand.sight_noise_px", self.sight_noise_px),
            ("hand.sight_delay_s", self.sight_delay_s),
            ("hand.touch_delay_s", self.touch_delay_s),
            ("hand.click_delay_s", self.click_delay_s),
            ("hand.pace_s", self.pace_s),
            ("hand.shortest_s", self.shortest_s),
            ("hand.caution_px", self.caution_px),
            ("hand.push_rate_n_s", self.push_rate),
            ("hand.learnt", self.learnt),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
    }
}

/// The device under one resistance: rig, sensors and control step.
struct Bench {
    rig: Rig<Law<f64>>,
    control: Control,
    force: f64,
    begun: bool,
    /// Static and dynamic friction, N, damping, N·s/m, and mass, kg, as perceived.
    felt: [f64; 4],
}

/// Apparatus of the targeting task: about 0.8 N and 1.4 kg [thesis, table 5-2].
const OWN_FRICTION: f64 = 0.8;
const OWN_MASS: f64 = 1.4;

impl Bench {
    fn new(resistance: Resistance, start: f64, seed: u64) -> Result<Self, String> {
        let zero = Coulomb {
            level_p: 0.0,
            level_n: 0.0,
            static_p: 0.0,
            static_n: 0.0,
            viscous_p: 0.0,
            viscous_n: 0.0,
        };
        let own = RigConfig {
            device_mass: OWN_MASS,
            device_friction_p: OWN_FRICTION,
            device_friction_n: OWN_FRICTION,
            start_position: start,
            ..RigConfig::free_handle()
        };
        let real = resistance == Resistance::Real;
        let (config, law) = if real {
            let block = Resistance::Simulated.rendered().map_or(0.5, |s| s.mass);
            (RigConfig { block_mass: block, handle_mass: 0.0, ..own }, Law::Karnopp(RUBBER.law))
        } else {
            (own, Law::Coulomb(zero))
        };
        let rig = Rig::new(config, law, seed).map_err(|e| e.to_string())?;
        let rendered = resistance.rendered();
        let settings = settings(rendered.as_ref())?;
        let device = Device::default();
        let control = Control::referenced(settings.build(&device).map_err(|e| e.to_string())?);
        let b = own.device_damping;
        let felt = match (rendered, real) {
            (Some(s), _) => {
                [s.f_static + OWN_FRICTION, s.f_dynamic + OWN_FRICTION, s.damping + b, s.mass + OWN_MASS]
            }
            (None, true) => [
                RUBBER.law.d_p + OWN_FRICTION,
                RUBBER.law.c_p + OWN_FRICTION,
                RUBBER.law.b_p + b,
                0.5 + OWN_MASS,
            ],
            (None, false) => [OWN_FRICTION, OWN_FRICTION, b, OWN_MASS],
        };
        Ok(Self { rig, control, force: 0.0, begun: rendered.is_none(), felt })
    }

    /// One control period with this hand on the handle.
    fn tick(&mut self, hand: &mut dyn Hand) -> (f64, f64) {
        let sensors = self.rig.tick(self.force, hand);
        let inputs = Inputs {
            sample_ticks: sensors.sample_ticks,
            count: sensors.count,
            edge_ticks: sensors.edge_ticks,
            load_code: sensors.load_code,
            accel_code: sensors.accel_code,
        };
        let request = (!self.begun).then_some(Request::Render(true));
        let out = self.control.step(request.as_ref(), &inputs);
        self.begun = true;
        if out.fault.is_some() {
            // clears the fault and continues, as a person would
            self.control.step(Some(&Request::ClearFault), &inputs);
            self.begun = false;
        }
        self.force = if out.amplifier { f64::from(out.force) } else { 0.0 };
        let truth = self.rig.truth();
        (truth.position, truth.velocity)
    }
}

fn settings(stimulus: Option<&Stimulus>) -> Result<Settings, String> {
    let mut settings = Settings::viscous();
    for (name, value) in stimulus.map(Stimulus::parameters).into_iter().flatten() {
        settings.set(name, &value.to_string()).map_err(|e| e.to_string())?;
    }
    Ok(settings)
}

/// Spring, damper and push on the handle.
struct Arm {
    model: HandModel,
    to: f64,
    speed: f64,
    push: f64,
}

impl Hand for Arm {
    fn force(&mut self, _t: f64, x: f64, v: f64) -> f64 {
        self.push + self.model.stiffness * (self.to - x) + self.model.damping * (self.speed - v)
    }

    fn mass(&self) -> f64 {
        self.model.mass
    }
}

/// A planned reach.
#[derive(Clone, Copy)]
struct Reach {
    from: f64,
    to: f64,
    begins: f64,
    lasts: f64,
}

impl Reach {
    /// Position, speed and acceleration of the minimum-jerk path.
    fn at(&self, t: f64) -> (f64, f64, f64) {
        let s = ((t - self.begins) / self.lasts).clamp(0.0, 1.0);
        let d = self.to - self.from;
        let x = self.from + d * s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let v = d * 30.0 * s * s * (1.0 - s) * (1.0 - s) / self.lasts;
        let a = d * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (self.lasts * self.lasts);
        (x, v, a)
    }
}

/// Performs the segment that `task` presents, and returns its trial.
///
/// # Errors
/// The session is complete, the rig or the renderer rejects the resistance, or the hand never reaches the target.
pub fn reach(task: &mut Targeting, model: &HandModel, seed: u64) -> Result<TargetingTrial, String> {
    let segment = task.next().ok_or("the session is complete")?;
    let scale = task.plan().metre_per_px;
    let start = -0.5 * segment.difficulty.distance_px * scale;
    let half = 0.5 * segment.difficulty.width_px * scale;
    let mut bench = Bench::new(segment.resistance, start, seed)?;
    let [f_static, f_dynamic, damping, mass] = bench.felt;
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    let mut arm = Arm { model: *model, to: start, speed: 0.0, push: 0.0 };
    let samples = |s: f64| (s / DT).round() as usize;
    let (sight, touch) = (samples(model.sight_delay_s), samples(model.touch_delay_s));
    let mut past: VecDeque<(f64, f64)> = VecDeque::from(vec![(start, 0.0); sight.max(touch) + 1]);
    let mut planned = Reach { from: start, to: start, begins: 0.0, lasts: DT };
    let mut clicks_at: Option<f64> = None;
    // next look: the last reach was seen to its end
    let mut looks_at = 0.0;
    // whether the last reach moved the handle; if not, a push follows
    let (mut moved, mut pushing) = (true, false);
    let (mut searching, mut muscle, mut shake, mut tremble) = (0.0, 0.0, 0.0, 0.0);
    let keep = (-DT / model.muscle_s).exp();
    let fresh = (1.0 - keep * keep).sqrt();
    task.start(0.0);
    let mut t = 0.0;
    while t < PATIENCE {
        let target = task.target_m().ok_or("no target")?;
        let seen = past[past.len() - 1 - sight.min(past.len() - 1)];
        let moving = past[past.len() - 1 - touch.min(past.len() - 1)].1.abs() > 3e-3;
        if let Some(at) = clicks_at
            && t >= at
        {
            clicks_at = None;
            let here = past.back().map_or(start, |p| p.0);
            match task.click(t, here) {
                Some(Event::Finished(trial)) => return Ok(trial),
                Some(Event::Valid) => (looks_at, moved) = (t, true),
                // seen as a miss after the delay of the eye
                _ => (looks_at, moved) = (t + model.sight_delay_s, true),
            }
            continue;
        }
        if clicks_at.is_none() && t >= looks_at {
            let see = seen.0 + model.sight_noise_px * scale * normal();
            let off = target - see;
            let dares = off.abs() <= (half - model.caution_px * scale).max(0.5 * half);
            // slow enough to stay in the target until the finger has moved
            let stays = seen.1.abs() * (model.sight_delay_s + model.click_delay_s) < half;
            if !dares && !moved && !pushing {
                // the reach moved nothing: push until the handle moves
                pushing = true;
            }
            if pushing && !dares {
                looks_at = t + DT;
            } else if dares && stays {
                clicks_at = Some(t + model.click_delay_s);
            } else if dares {
                looks_at = t + 0.02;
            } else {
                let end = planned.to + off + model.aim_noise * off * normal();
                // a hand does not compress a spring beyond its target
                let end = end.clamp(see + off - 0.012, see + off + 0.012);
                let lasts = (model.pace_s * (off.abs() * 1e3).sqrt()).max(model.shortest_s);
                planned = Reach { from: arm.to, to: end, begins: t, lasts };
                moved = false;
                looks_at = t + lasts + model.sight_delay_s;
            }
        }
        let (x, v, a) = planned.at(t);
        (arm.to, arm.speed) = (x, v);
        // learnt friction in the intended direction: the static level until motion is felt
        let level = if moving { f_dynamic } else { f_static };
        let learnt = model.learnt * (level * (v / 5e-3).tanh() + damping * v + mass * a);
        // a push without motion grows, and ends when motion is felt
        moved |= moving;
        if pushing && !moving {
            searching += model.push_rate * (target - seen.0).signum() * DT;
            searching = f64::clamp(searching, -f_static - 2.0, f_static + 2.0);
        } else {
            if pushing {
                pushing = false;
                looks_at = t + model.sight_delay_s;
            }
            searching *= 1.0 - DT / 0.04;
        }
        muscle = keep * muscle + (1.0 - keep) * (learnt + searching);
        shake = keep * shake + fresh * normal();
        tremble = keep * tremble + fresh * normal();
        let here = past.back().map_or((start, 0.0), |p| *p);
        let wanted = muscle + model.stiffness * (arm.to - here.0) + model.damping * (arm.speed - here.1);
        arm.push = muscle + model.force_noise * wanted.abs() * shake + model.tremor * tremble;
        past.push_back(bench.tick(&mut arm));
        past.pop_front();
        t += DT;
    }
    Err(format!("segment {} is not done after {PATIENCE} s", task.progress().0 + 1))
}
