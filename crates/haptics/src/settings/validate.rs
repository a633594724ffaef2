//! Validation with physics: an unsafe value is refused with the number that would be accepted, an unfaithful one is accepted
//! with a warning.

use super::{EFFECTS_CYCLES, LawKind, PASSIVITY_CYCLES, RendererKind, Settings, effect_cycles, law_cycles};
use crate::{Accepted, Device, Reason, Refused, Warning, bounds, number};
use friction::effects::{Effect, EffectKind, EffectName, EffectState, Scale};
use friction::{Dimension, Law, Motion};

/// Largest mass of a virtual block, kg. This and the next are those of the default device.
const HEAVIEST: f32 = 100.0;
/// Smallest mass of a virtual block, kg.
const LIGHTEST: f32 = 1e-3;
/// Margin of mass and coupling to the onset of oscillation: more than single precision loses on the way to the bound.
const HEAVIER: f32 = 1.001;
/// Smallest `dv` and Stribeck velocity, m/s.
const SLOWEST: f32 = 1e-6;
/// Usable share of a bound on damping. A period of delay halves the stable damping of the sampled device.
const DAMPING_SHARE: f32 = 0.5;

/// Speed of a hand that feels a pattern, m/s, on the default device.
const HAND_SPEED: f32 = 0.1;
/// Periods in which it crosses a wave at least.
const SAMPLES: f32 = 8.0;
/// Places of a wave at which its slope is taken.
const PLACES: u32 = 64;

/// Tolerance that keeps a bound at a round number in spite of rounding.
const ROUNDING: f32 = 1e-6;

/// `x` rounded towards zero to four digits: easy to type, and within the bound.
fn at_most(x: f32) -> f32 {
    if x > 0.0 && x.is_finite() { number::four_digits(x * (1.0 + ROUNDING), false) } else { 0.0 }
}

/// `x` rounded away from zero to four digits.
fn at_least(x: f32) -> f32 {
    if x > 0.0 && x.is_finite() { number::four_digits(x * (1.0 - ROUNDING), true) } else { 0.0 }
}

fn refuse<T>(parameter: &'static str, value: f32, accepted: Accepted, why: Reason) -> Result<T, Refused> {
    Err(Refused { effect: None, parameter, value, accepted, why })
}

/// Refuses unless `low ≤ value ≤ high`. NaN is refused.
fn within(parameter: &'static str, value: f32, low: f32, high: f32, why: Reason) -> Result<(), Refused> {
    if value >= low && value <= high {
        Ok(())
    } else {
        refuse(parameter, value, Accepted::Between(low, high), why)
    }
}

/// Wavelength, m, and steepest slope, N/m, of an effect that repeats over a distance.
fn pattern(effect: &Effect<f32>) -> Option<(f32, f32)> {
    let at = effect.kind.shape().iter().position(|p| p.scale == Scale::Wavelength)?;
    let wavelength = *effect.shape.get(at)?;
    let force = |place: u32| {
        let position = wavelength * (place as f32 / PLACES as f32);
        // moving: friction has a pattern only there
        let motion = Motion { position, velocity: HAND_SPEED, ..Motion::default() };
        effect.step(&mut EffectState::default(), &motion)
    };
    let steepest = (0..PLACES).fold(0.0_f32, |most, place| most.max((force(place + 1) - force(place)).abs()));
    Some((wavelength, steepest * PLACES as f32 / wavelength))
}

impl Settings {
    /// Checks every parameter against the device, alone and in combination.
    ///
    /// # Errors
    /// [`Refused`] for an unsafe value: NaN, a force above the limit of the actuator, friction that would add energy, a
    /// coupling outside its stability bounds.
    pub fn validate(&self, device: &Device) -> Result<Option<Warning>, Refused> {
        device.compensation.validate(device)?;
        // the contact is stable on the damping that is left
        let device = &Device { damping: device.compensation.left_damping(device), ..*device };
        self.levels(device)?;
        within(
            "dv",
            self.dv,
            SLOWEST,
            device.overspeed,
            Reason::of(Dimension::VELOCITY, "treated as zero below it"),
        )?;
        self.coupling(device)?;
        // the mass first: an error for a typed mass must name the mass
        self.block(device)?;
        self.free_block(device, self.k_vc)?;
        self.bristles(device)?;
        self.damping(device)?;
        self.own()?;
        self.curve(device)?;
        self.check_effects(device)?;
        Ok(self.unfaithful(device))
    }

    fn levels(&self, device: &Device) -> Result<(), Refused> {
        let most = device.force_max;
        let why = Reason::of(Dimension::FORCE, "limit of the actuator");
        within("f_dynamic_p", self.f_dynamic_p, 0.0, most, why)?;
        within("f_dynamic_n", self.f_dynamic_n, 0.0, most, why)?;
        let static_why = Reason::of(Dimension::FORCE, "from dynamic friction to the limit of the actuator");
        // some laws do not use their static friction, but a switch of law must find a valid number
        let takes = self.law.takes("f_static_p");
        let low = |dynamic: f32| if takes { dynamic } else { 0.0 };
        within("f_static_p", self.f_static_p, low(self.f_dynamic_p), most, static_why)?;
        within("f_static_n", self.f_static_n, low(self.f_dynamic_n), most, static_why)
    }

    /// Largest stable stiffness at this damping, N/m: [thesis, eq. 4.18] with B and the delay.
    fn stiffness_cap(device: &Device, damping: f32) -> f32 {
        bounds::stiffness_max_delayed(device.mass, device.damping, device.period, damping, device.delay)
    }

    /// Largest viscous damping for any mass, N·s/m: the stable damping of the sampled device.
    fn damping_cap(device: &Device) -> f32 {
        let (mass, damping, period) = (device.mass, device.damping, device.period);
        DAMPING_SHARE * bounds::damping_max(mass, damping, period)
    }

    fn damping(&self, device: &Device) -> Result<(), Refused> {
        let cap = Self::damping_cap(device);
        let high = match self.renderer {
            RendererKind::Impedance => cap,
            _ => cap.min(self.room(device, self.bristle_stiffness())),
        };
        let why = Reason::of(
            Dimension::DAMPING,
            "below, it would add energy at the largest speed; above, one period overshoots",
        );
        for (name, value, dynamic) in
            [("damping_p", self.damping_p, self.f_dynamic_p), ("damping_n", self.damping_n, self.f_dynamic_n)]
        {
            // the level of any other law must not be lowered by a slope that the law does not bound
            let lowest = if self.law.holds() { -at_most(dynamic / device.overspeed) } else { 0.0 };
            within(name, value, lowest, at_most(high), why)?;
        }
        // where a law has one value for both directions
        let one = |alias, parameter, value: f32, other: f32, why| {
            if value == other || !self.law.takes(alias) {
                Ok(())
            } else {
                refuse(parameter, value, Accepted::Between(other, other), why)
            }
        };
        let force = |what| Reason::of(Dimension::FORCE, what);
        one(
            "f_static",
            "f_static_n",
            self.f_static_n,
            self.f_static_p,
            force("this law has one static friction; `set f_static` sets both"),
        )?;
        one(
            "f_dynamic",
            "f_dynamic_n",
            self.f_dynamic_n,
            self.f_dynamic_p,
            force("this law has one dynamic friction; `set f_dynamic` sets both"),
        )?;
        one(
            "damping",
            "damping_n",
            self.damping_n,
            self.damping_p,
            Reason::of(Dimension::DAMPING, "this law has one damping; `set damping` sets both"),
        )
    }

    /// Checks what only some laws take, for each law: a switch of law must find valid numbers.
    fn own(&self) -> Result<(), Refused> {
        within("elastic", self.elastic, 0.0, 0.99, Reason::plain("a share of the dynamic friction"))?;
        within("attraction", self.attraction, 0.0, 1e9, Reason::of(Dimension::FORCE_RATE, ""))?;
        within("memory", self.memory, 0.0, 1e3, Reason::of(Dimension::TIME, ""))?;
        within("dwell", self.dwell, 1e-6, 1e6, Reason::of(Dimension::TIME, ""))?;
        within(
            "steepness",
            self.steepness,
            1.001,
            1e6,
            Reason::plain("the rise at rest is steeper than the fall"),
        )
    }

    /// Damping of a law that is one curve of speed, by its steepest slope, which is that at rest, N·s/m.
    fn slope_at_rest(&self) -> f32 {
        match self.friction_law() {
            Law::Classic(law) => law.stiction / law.knee,
            Law::MajdSimaan(law) => law.slope_at_rest(),
            _ => 0.0,
        }
    }

    /// Checks the steepness of a curve of speed: at rest it is a damper.
    fn curve(&self, device: &Device) -> Result<(), Refused> {
        let slope = self.slope_at_rest();
        let most = match self.renderer {
            RendererKind::Impedance => Self::damping_cap(device),
            _ => Self::damping_cap(device).min(self.room(device, 0.0)),
        };
        // a block without room is refused by its mass
        if slope <= most || slope == 0.0 {
            return Ok(());
        }
        let (parameter, value, viscous) = match self.law {
            LawKind::Classic => ("dv", self.dv, 0.0),
            _ => ("stribeck_velocity", self.stribeck_velocity, self.damping_p),
        };
        let why = Reason::of(Dimension::VELOCITY, "below, the curve is steeper at rest than a period allows");
        // the slope beyond the viscous one falls with the speed; a margin for what rounding and the stiction take
        let slowest = at_least(value * (slope - viscous) / (most - viscous) * HEAVIER);
        refuse(parameter, value, Accepted::AtLeast(slowest), why)
    }

    /// Checks the handle held by spring and damper: [thesis, eq. 4.18] extended by B.
    fn coupling(&self, device: &Device) -> Result<(), Refused> {
        let most = at_most(Self::damping_cap(device));
        within(
            "b_vc",
            self.b_vc,
            0.0,
            most,
            Reason::of(Dimension::DAMPING, "above, the handle oscillates with a period of delay"),
        )?;
        let most = at_most(Self::stiffness_cap(device, self.b_vc));
        if self.k_vc > most && (device.inertia(LIGHTEST)..=device.inertia(HEAVIEST)).contains(&self.mass) {
            // the number in the message must be accepted
            self.free_block(device, most)?;
        }
        within(
            "k_vc",
            self.k_vc,
            device.stiffness(1.0),
            most,
            Reason::of(Dimension::STIFFNESS, "above, the stuck handle oscillates (eq. 4.18)"),
        )
    }

    /// Stiffness of the bristles, N/m. 0 for a law without bristles.
    fn bristle_stiffness(&self) -> f32 {
        if self.law.takes("sigma") { self.sigma } else { 0.0 }
    }

    /// Damping of the bristles, N·s/m. 0 for a law without bristles.
    fn bristle_damping(&self) -> f32 {
        if self.law.takes("sigma_1") { self.sigma_1 } else { 0.0 }
    }

    /// Whether the coupling acts on the block in the middle of the period. Bristles are stepped as under the virtual coupling.
    fn midpoint(&self) -> bool {
        self.renderer == RendererKind::StoppingForce && self.law.holds()
    }

    /// Effective mass in [thesis, eq. 4.35] per mass of the block. A free handle yields, which increases the effect of the
    /// coupling's damping: KT² + 2BT (1 + M/m) < 4M. Does not apply to a coupling in the middle of the period.
    fn share_of_mass(&self, device: &Device) -> f32 {
        if self.midpoint() {
            return 1.0;
        }
        1.0 - self.b_vc / bounds::damping_max(device.mass, device.damping, device.period)
    }

    /// Largest stable damping of the block with its coupling and bristles, N·s/m: KT² + 2BT < 4M, the singularity of
    /// [thesis, eq. 4.35], with a margin of a thousandth.
    fn room(&self, device: &Device, bristles: f32) -> f32 {
        let mass = self.mass / HEAVIER * self.share_of_mass(device);
        bounds::damping_singular(mass, self.k_vc + bristles, device.period)
            - self.b_vc
            - self.bristle_damping()
    }

    fn bristles(&self, device: &Device) -> Result<(), Refused> {
        within(
            "stribeck_velocity",
            self.stribeck_velocity,
            SLOWEST,
            device.overspeed,
            Reason::of(Dimension::VELOCITY, ""),
        )?;
        let period = device.period;
        // laws without bristles do not use these, but a switch of law must find valid numbers
        let (mut sigma_most, mut sigma_1_most) = (1e9, 1e6);
        if self.law.takes("sigma") {
            let inner = self.bristle_damping();
            sigma_1_most = at_most(Self::damping_cap(device));
            sigma_most = match self.renderer {
                RendererKind::Impedance => at_most(Self::stiffness_cap(device, inner)),
                _ => {
                    // the rest after the viscous damping, N/m
                    let viscous = self.viscous_within(device);
                    at_most((self.room(device, 0.0) - viscous) * 2.0 / period)
                }
            };
        }
        let why = Reason::of(Dimension::DAMPING, "above, the contact oscillates");
        within("sigma_1", self.sigma_1, 0.0, sigma_1_most, why)?;
        let why = Reason::of(
            Dimension::STIFFNESS,
            "above, the contact oscillates on its bristles (eq. 4.18, 4.35)",
        );
        within("sigma", self.sigma, device.stiffness(1.0), sigma_most, why)
    }

    /// Larger viscous damping if it is in range. Otherwise 0: it is refused by its own check.
    fn viscous_within(&self, device: &Device) -> f32 {
        let cap = Self::damping_cap(device);
        let share = |x: f32| if x <= cap { x.max(0.0) } else { 0.0 };
        share(self.damping_p).max(share(self.damping_n))
    }

    /// Whether the coupling does not move the block: neither it nor bristles do.
    #[cfg(feature = "admittance")]
    fn ignores_the_coupling(&self) -> bool {
        self.renderer == RendererKind::Admittance && self.law.holds()
    }

    /// Whether the coupling does not move the block.
    #[cfg(not(feature = "admittance"))]
    fn ignores_the_coupling(&self) -> bool {
        false
    }

    /// Checks the mass and, with the virtual coupling, the block between handle and surface: KT² + 2BT < 4M, the singularity of
    /// [thesis, eq. 4.35]. Bristles that are unstable with a block of 1 kg are refused by their own check.
    fn block(&self, device: &Device) -> Result<(), Refused> {
        let why = Reason::of(Dimension::MASS, "a lighter block oscillates on its coupling (eq. 4.35)");
        let (mut lightest, heaviest) = (device.inertia(LIGHTEST), device.inertia(HEAVIEST));
        if self.renderer.has_block() && !self.ignores_the_coupling() {
            let period = device.period;
            let mut damping = self.b_vc + self.viscous_within(device);
            let (inner, sigma) = (self.bristle_damping(), self.bristle_stiffness());
            if inner <= Self::damping_cap(device) {
                damping += inner;
            }
            let mut stiffness = self.k_vc;
            if sigma <= bounds::stiffness_singular(1.0, damping, period) - stiffness {
                stiffness += sigma;
            }
            let needed = (stiffness * period * period + 2.0 * damping * period) / 4.0 * HEAVIER;
            lightest = lightest.max(at_least(needed / self.share_of_mass(device)));
        }
        within("mass", self.mass, lightest, heaviest, why)
    }

    /// Checks a free handle and block on a coupling of at most `k_vc`, N/m, with the complete sampled loop.
    fn free_block(&self, device: &Device, k_vc: f32) -> Result<(), Refused> {
        match self.renderer {
            RendererKind::Impedance => return Ok(()),
            // the coupling does not drive its block
            #[cfg(feature = "admittance")]
            RendererKind::Admittance => return self.follows_load_cell(device, k_vc),
            _ => {}
        }
        let pair = bounds::FreeBlock {
            device_mass: device.mass,
            device_damping: device.damping,
            period: device.period,
            delay: device.delay,
            mass: self.mass,
            midpoint: self.midpoint(),
        };
        let asked = k_vc * HEAVIER;
        if pair.is_stable(asked, self.b_vc) {
            return Ok(());
        }
        let most = at_most(pair.stiffness_max(self.b_vc, asked) / HEAVIER);
        let why =
            Reason::of(Dimension::STIFFNESS, "above, handle and sliding block swing against each other");
        within("k_vc", self.k_vc, device.stiffness(1.0), most, why)
    }

    /// Checks the loop of load cell, block and handle, in hands from released to firm.
    #[cfg(feature = "admittance")]
    fn follows_load_cell(&self, device: &Device, k_vc: f32) -> Result<(), Refused> {
        let heaviest = device.inertia(HEAVIEST);
        let stable = |mass: f32| bounds::admittance_is_stable(device, k_vc, self.b_vc, mass);
        if !(self.mass > 0.0 && self.mass <= heaviest) || stable(self.mass) {
            return Ok(());
        }
        let (mut low, mut high) = (self.mass, heaviest);
        while high > low * 1.001 {
            let middle = libm::sqrtf(low * high);
            if stable(middle) { high = middle } else { low = middle }
        }
        let why = Reason::of(Dimension::MASS, "a lighter block swings against a hand on the load cell");
        within("mass", self.mass, at_least(high), heaviest, why)
    }

    fn check_effects(&self, device: &Device) -> Result<(), Refused> {
        let mut slopes = 0.0;
        for (name, effect) in EffectName::of(self.effects.iter().flatten()) {
            let named = |refused: Refused| Refused { effect: Some(name), ..refused };
            effect.validate().map_err(|invalid| Refused {
                effect: Some(name),
                parameter: invalid.parameter,
                value: invalid.value as f32,
                accepted: Accepted::Between(invalid.min as f32, invalid.max as f32),
                why: Reason::plain("outside its range"),
            })?;
            self.check_stiffness(effect.kind, &effect.gains, device).map_err(named)?;
            slopes += self.check_slope(effect, slopes, device).map_err(named)?;
        }
        let observer = if self.passivity { PASSIVITY_CYCLES } else { 0 };
        let having = if self.effects.iter().any(Option::is_some) { EFFECTS_CYCLES } else { 0 };
        let cycles = observer
            + having
            + law_cycles(self.law)
            + device.compensation.cycles()
            + self.effects.iter().flatten().map(|effect| effect_cycles(effect.kind)).sum::<u32>();
        if cycles > device.effect_cycles {
            return Err(Refused {
                effect: None,
                parameter: "cycles of law and effects",
                value: cycles as f32,
                accepted: Accepted::AtMost(device.effect_cycles as f32),
                why: Reason::plain("the force of a longer step comes out late; switch an effect `off`"),
            });
        }
        Ok(())
    }

    /// Stiffness that grows with deflection, with its square, and damping that grows with speed.
    const CURVE: Dimension = Dimension::STIFFNESS.per(Dimension::LENGTH);
    const CUBIC: Dimension = Self::CURVE.per(Dimension::LENGTH);
    const DRAG: Dimension = Dimension::DAMPING.per(Dimension::VELOCITY);

    /// Largest stiffness and damping that effects may add to the contact, N/m and N·s/m.
    fn room_for_effects(&self, device: &Device) -> (f32, f32) {
        let period = device.period;
        match self.renderer {
            RendererKind::Impedance => {
                let (mass, damping) = (device.mass, device.damping);
                let most = DAMPING_SHARE * bounds::damping_max(mass, damping, period);
                (Self::stiffness_cap(device, self.b_vc) - self.k_vc, most)
            }
            _ => {
                let mass = self.mass * self.share_of_mass(device);
                let left = bounds::stiffness_singular(mass, self.b_vc, period) - self.k_vc;
                (left, bounds::damping_singular(mass, self.k_vc, period) - self.b_vc)
            }
        }
    }

    /// Checks the slope of a pattern over the position on top of the `others` before it, N/m: together they are a stiffness of the
    /// contact. Returns the slope.
    fn check_slope(&self, effect: &Effect<f32>, others: f32, device: &Device) -> Result<f32, Refused> {
        let Some((wavelength, slope)) = pattern(effect) else { return Ok(0.0) };
        // at least 1 N/m: the others may have used all of it
        let stiffest = (self.room_for_effects(device).0 - others).max(1.0);
        if slope <= stiffest {
            return Ok(slope);
        }
        let accepted = Accepted::AtLeast(at_least(wavelength * slope / stiffest));
        let why = Reason::of(
            Dimension::LENGTH,
            "below, the patterns are stiffer than device and block are stable with",
        );
        refuse("wavelength", wavelength, accepted, why)
    }

    /// Checks the gains of effects: as a force, spring or damper none may exceed the stability bounds of the contact.
    fn check_stiffness(
        &self,
        kind: EffectKind,
        gains: &[f32; friction::effects::MAX_GAINS],
        device: &Device,
    ) -> Result<(), Refused> {
        let (stiffest, most_damping) = self.room_for_effects(device);
        let reach = device.stroke / 2.0;
        for (gain, parameter) in gains.iter().zip(kind.gains()) {
            // largest stiffness or damping of the gain
            let most = match parameter.dimension {
                Dimension::FORCE => device.force_max,
                Dimension::STIFFNESS => at_most(stiffest),
                Self::CURVE => at_most(stiffest / (2.0 * reach)),
                Self::CUBIC => at_most(stiffest / (3.0 * reach * reach)),
                Dimension::DAMPING => at_most(most_damping),
                Self::DRAG => at_most(most_damping / (2.0 * device.overspeed)),
                _ => continue,
            };
            if !(gain.abs() <= most) {
                let accepted = Accepted::Between(if parameter.min < 0.0 { -most } else { 0.0 }, most);
                return refuse(
                    parameter.name,
                    *gain,
                    accepted,
                    Reason::plain("outside the stability bounds of device and block"),
                );
            }
        }
        Ok(())
    }

    /// Warns of what is safe and not what was asked for.
    fn unfaithful(&self, device: &Device) -> Option<Warning> {
        self.chatters(device).or_else(|| self.effects.iter().flatten().find_map(|e| self.coarse(e, device)))
    }

    /// Warns of a pattern that is steeper than the coupling, or that a hand crosses in too few periods.
    fn coarse(&self, effect: &Effect<f32>, device: &Device) -> Option<Warning> {
        let (wavelength, slope) = pattern(effect)?;
        let warn = |shortest: f32, why| {
            let faithful = Accepted::AtLeast(at_least(shortest));
            (wavelength < shortest).then_some(Warning {
                parameter: "wavelength",
                value: wavelength,
                faithful,
                why,
            })
        };
        let steep = wavelength * slope / self.k_vc;
        let sampled = SAMPLES * device.speed(HAND_SPEED) * device.period;
        warn(
            sampled,
            Reason::of(
                Dimension::LENGTH,
                "below, a hand at a tenth of the overspeed crosses a wave in fewer than 8 periods",
            ),
        )
        .or_else(|| {
            let why = Reason::of(
                Dimension::LENGTH,
                "below, the pattern is steeper than the coupling, and the handle jumps over it",
            );
            if self.renderer.has_block() { warn(steep, why) } else { None }
        })
    }

    /// Warns of a Δv below the zero-crossing limit cycle: the block chatters instead of stopping [thesis, eq. 4.21 and 4.35].
    fn chatters(&self, device: &Device) -> Option<Warning> {
        if self.law != LawKind::Karnopp {
            return None;
        }
        let friction = self.f_dynamic_p.max(self.f_dynamic_n);
        let period = device.period;
        let (needed, why) = match self.renderer {
            RendererKind::VirtualCoupling => {
                let (mass, k, b) = (self.mass, self.k_vc, self.b_vc);
                let why = Reason::of(
                    Dimension::VELOCITY,
                    "below its limit-cycle velocity the block chatters (eq. 4.35)",
                );
                (bounds::limit_cycle_velocity(friction, mass, k, b, period), why)
            }
            RendererKind::Impedance => {
                let most = bounds::friction_max(device.mass, device.damping, period, 1.0);
                (
                    friction / most,
                    Reason::of(Dimension::VELOCITY, "below, the handle chatters about rest (eq. 4.21)"),
                )
            }
            // have no dead band
            _ => return None,
        };
        (self.dv < needed).then(|| Warning {
            parameter: "dv",
            value: self.dv,
            faithful: Accepted::AtLeast(at_least(needed)),
            why,
        })
    }
}
