//! Surfaces under the puck.

use friction::effects::{Effect, EffectKind, EffectState};
use friction::planar::{Coulomb, Grain, Law, Vector};
use haptics::Settings;

/// Detents: wells in rows and columns, without friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detent {
    /// Distance between wells, m.
    pub pitch: f64,
    /// Largest force of a well along each axis, N.
    pub force: f64,
}

/// A surface.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Name.
    pub name: &'static str,
    /// What it is, and where its numbers are from.
    pub says: &'static str,
    kind: Kind,
    /// Wells, if it has any.
    pub detent: Option<Detent>,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// The levels of a preset, the mean of its two directions.
    Preset(fn() -> Settings),
    /// Dynamic and static level along the grain, N; its direction, rad; friction across it over that along it.
    Wood(f64, f64, f64, f64),
    /// No friction.
    Smooth,
}

impl Surface {
    /// Every surface.
    pub const ALL: [Self; 5] = [
        Self {
            name: "brass",
            says: "Aluminium on brass, levels of Richard 2000, table 3-3",
            kind: Kind::Preset(Settings::brass),
            detent: None,
        },
        Self {
            name: "teflon",
            says: "Aluminium on Teflon, levels of Richard 2000, table 3-3",
            kind: Kind::Preset(Settings::teflon),
            detent: None,
        },
        Self {
            name: "rubber",
            says: "Aluminium on rubber, levels of Richard 2000, table 3-3",
            kind: Kind::Preset(Settings::rubber),
            detent: None,
        },
        Self {
            name: "wood",
            says: "Wood grain, twice the friction across it; an example, not measured",
            kind: Kind::Wood(1.2, 1.5, 0.35, 2.0),
            detent: None,
        },
        Self {
            name: "detents",
            says: "Wells 10 mm apart, no friction: only the damper of the coupling takes energy; an example, not measured",
            kind: Kind::Smooth,
            detent: Some(Detent { pitch: 0.01, force: 1.0 }),
        },
    ];

    /// The surface of this name.
    ///
    /// # Errors
    /// The names that would be accepted.
    pub fn named(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|surface| surface.name == name);
        found.ok_or_else(|| {
            format!("no surface of this name: {} are accepted", Self::ALL.map(|s| s.name).join(", "))
        })
    }

    /// Its friction.
    #[must_use]
    pub fn law(&self) -> Law<f64> {
        let mean = |p: f32, n: f32| 0.5 * (f64::from(p) + f64::from(n));
        Law::Coulomb(match self.kind {
            Kind::Preset(make) => {
                let s = make();
                Coulomb {
                    level: mean(s.f_dynamic_p, s.f_dynamic_n),
                    stiction: mean(s.f_static_p, s.f_static_n),
                    viscous: mean(s.damping_p, s.damping_n),
                    grain: Grain::default(),
                }
            }
            Kind::Wood(level, stiction, angle, across) => {
                Coulomb { level, stiction, viscous: 0.0, grain: Grain::at(angle, across) }
            }
            Kind::Smooth => Coulomb { level: 0.0, stiction: 0.0, viscous: 0.0, grain: Grain::default() },
        })
    }

    /// Force of its wells on the puck, N.
    #[must_use]
    pub fn field(&self, at: Vector<f64>) -> Vector<f64> {
        let Some(Detent { pitch, force }) = self.detent else { return Vector::default() };
        // the effect on a line, along each axis: such a sum is conservative
        let well = Effect { kind: EffectKind::Cogging, gains: [0.0, force, 0.0, 0.0], shape: [pitch, 0.0] };
        let along = |position: f64| {
            -well.step(&mut EffectState::default(), &friction::Motion { position, ..Default::default() })
        };
        Vector { x: along(at.x), y: along(at.y) }
    }

    /// Energy of the puck in a well or between them, J: the work from the bottom of the nearest well, along a straight line.
    pub(super) fn stored(&self, at: Vector<f64>) -> f64 {
        const STEPS: u32 = 400;
        let Some(Detent { pitch, .. }) = self.detent else { return 0.0 };
        let nearest = |x: f64| (x / pitch).round() * pitch;
        let bottom = Vector { x: nearest(at.x), y: nearest(at.y) };
        let way = (at - bottom) * (1.0 / f64::from(STEPS));
        (0..STEPS).map(|k| -self.field(bottom + way * (f64::from(k) + 0.5)).dot(way)).sum()
    }

    /// Direction of the grain, rad.
    pub(super) fn grain(&self) -> Option<f64> {
        if let Kind::Wood(_, _, angle, _) = self.kind { Some(angle) } else { None }
    }

    /// The pulls that just move a puck at rest, N, all round; empty without friction.
    pub(super) fn edge(&self) -> Vec<[f64; 2]> {
        let Law::Coulomb(law) = self.law() else { return Vec::new() };
        if law.stiction == 0.0 {
            return Vec::new();
        }
        let point = |k: u32| {
            let (y, x) = (std::f64::consts::TAU * f64::from(k) / 48.0).sin_cos();
            let f = law.grain.force(Vector { x, y } * law.stiction);
            [f.x, f.y]
        };
        (0..48).map(point).collect()
    }
}
