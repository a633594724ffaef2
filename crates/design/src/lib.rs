//! What [thesis, ch. 4] allows: bounds, the closed loop's spectral radius, and the preset next to one that is not allowed.

#![forbid(unsafe_code)]

mod closed;
mod felt;
pub mod grid;
mod grid_map;
mod map;
mod nearest;
mod renderable;
pub mod renderers;
pub mod texture;

pub use closed::Error;
pub use felt::{felt_over_position, felt_over_speed};
pub use grid_map::grid_map;
pub use map::map;
pub use nearest::{Change, nearest};
pub use renderable::{LeftOut, Renderable, renderable};

use haptics::bounds::{self, ClosedLoop, Grasp};
use serde_json::{Map, Value, json};

/// What the user gave; lengths in SI.
#[derive(Debug, Clone, Copy, Default)]
pub struct Given {
    /// Control period T, s.
    pub period: f64,
    /// Virtual mass M, kg.
    pub mass: Option<f64>,
    /// Dynamic friction F, N.
    pub friction: Option<f64>,
    /// Coupling stiffness K, N/m.
    pub stiffness: Option<f64>,
    /// Coupling damping B, N·s/m.
    pub damping: Option<f64>,
    /// Mass of the handle m, kg.
    pub device_mass: Option<f64>,
    /// Damping of the handle b, N·s/m.
    pub device_damping: Option<f64>,
    /// From sample to force, s.
    pub delay: f64,
    /// Dead band DV, m/s.
    pub dv: Option<f64>,
    /// Travel of one count, m.
    pub encoder: Option<f64>,
    /// Dominant frequency of the applied force, Hz.
    pub frequency: Option<f64>,
    /// The hand on the handle.
    pub grasp: Grasp,
}

/// One number with where it comes from.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Key in the JSON.
    pub key: &'static str,
    /// What it is, for people.
    pub what: &'static str,
    /// In `unit`.
    pub value: f64,
    /// SI.
    pub unit: &'static str,
    /// Source: an equation or a paper.
    pub source: &'static str,
}

/// What follows from what was given.
#[derive(Debug, Clone, Default)]
pub struct Design {
    /// Numbers, in the order they are shown.
    pub figures: Vec<Figure>,
    /// Nothing grows; absent where nothing that could grow was given.
    pub stable: Option<bool>,
    /// Passive with any hand while the block is stuck [colgate-1997].
    pub passive: Option<bool>,
    /// Sentences about what is not as it should be.
    pub violations: Vec<String>,
}

/// A motion that neither grows nor dies out has a radius of 1, to rounding.
const STEADY: f64 = 1.0 + 1e-9;

impl Given {
    /// The loop, where handle and coupling were given.
    #[must_use]
    pub fn closed_loop(&self) -> Option<ClosedLoop> {
        Some(ClosedLoop {
            device_mass: self.device_mass?,
            device_damping: self.device_damping?,
            period: self.period,
            delay: self.delay,
            grasp: self.grasp,
            stiffness: self.stiffness?,
            damping: self.damping?,
        })
    }

    /// Everything that follows.
    #[must_use]
    pub fn design(&self) -> Design {
        let mut d = Design::default();
        self.device(&mut d);
        self.block(&mut d);
        self.whole(&mut d);
        self.dead_band(&mut d);
        d
    }

    /// Bounds of the handle alone (4.5).
    fn device(&self, d: &mut Design) {
        let t = self.period;
        if let (Some(m), Some(b)) = (self.device_mass, self.device_damping) {
            d.say("kp_max", "largest K_p of a stuck handle", bounds::kp_max(m, b, t), "N/m", "eq. 4.18");
            let coupling = self.damping.unwrap_or(0.0);
            let most = bounds::stiffness_max_delayed(m, b, t, coupling, self.delay);
            let what = "largest K beside this B, with the delay";
            d.say("stiffness_max", what, most, "N/m", "eq. 4.18 with B and delay");
            d.say("damping_max", "largest B with no K", bounds::damping_max(m, b, t), "N·s/m", "eq. 4.21");
            if let Some(dv) = self.dv {
                let most = bounds::friction_max(m, b, t, dv);
                d.say("friction_max", "largest F_d for this DV", most, "N", "eq. 4.21");
                if let Some(f) = self.friction.filter(|f| self.mass.is_none() && *f > most) {
                    d.violations.push(format!(
                        "friction {f} N is above {most:.4} N: the bare handle chatters about rest (eq. 4.21)"
                    ));
                }
            }
            if let (Some(k), Some(coupling)) = (self.stiffness, self.damping) {
                let margin = bounds::passivity_margin(b, k, coupling, t);
                d.say("passivity_margin", "b − (KT/2 + B)", margin, "N·s/m", "Colgate and Schenkel 1997");
                d.passive = Some(margin >= 0.0);
            }
        }
        if let (Some(m), Some(f)) = (self.device_mass, self.frequency) {
            let least = bounds::kp_min(m, f);
            d.say("kp_min", "smallest K_p that follows the force", least, "N/m", "4.5.1.3, 20 times as high");
            if let Some(k) = self.stiffness.filter(|k| *k < least) {
                d.violations.push(format!(
                    "stiffness {k} N/m is below {least:.4} N/m: friction lags behind the hand"
                ));
            }
        }
    }

    /// Bounds of the block on its coupling, handle held still (4.6).
    fn block(&self, d: &mut Design) {
        let t = self.period;
        if let (Some(m), Some(k)) = (self.mass, self.stiffness) {
            let most = bounds::damping_singular(m, k, t);
            d.say("damping_singular", "B at which the limit cycle is singular", most, "N·s/m", "eq. 4.35");
        }
        if let (Some(m), Some(b)) = (self.mass, self.damping) {
            let most = bounds::stiffness_singular(m, b, t);
            d.say("stiffness_singular", "K at which the limit cycle is singular", most, "N/m", "eq. 4.35");
        }
        if let (Some(m), Some(k), Some(b)) = (self.mass, self.stiffness, self.damping) {
            d.stable = Some(4.0 * m - k * t * t - 2.0 * b * t > 0.0);
            if let Some(f) = self.friction {
                let v = bounds::limit_cycle_velocity(f, m, k, b, t);
                let p = bounds::limit_cycle_position(f, m, k, b, t);
                d.say("limit_cycle_velocity", "velocity of the limit cycle", v, "m/s", "eq. 4.35");
                d.say("limit_cycle_position", "its position", p, "m", "eq. 4.36, corrected");
                d.say("dv_min", "smallest DV without it", v, "m/s", "4.6.2");
            }
            if d.stable == Some(false) {
                let singular = bounds::damping_singular(m, k, t);
                d.violations.push(if singular > 0.0 {
                    format!("K T² + 2 B T ≥ 4 M: the block oscillates; damping below {singular:.4} N·s/m is stable")
                } else {
                    let mass = (k * t * t + 2.0 * b * t) / 4.0;
                    format!("K T² + 2 B T ≥ 4 M: the block oscillates; a mass above {mass:.4} kg is stable")
                });
            }
        }
    }

    /// The loop as it is: handle, hand, delay, block.
    fn whole(&self, d: &mut Design) {
        let Some(closed) = self.closed_loop() else { return };
        let stuck = closed.radius_stuck();
        d.say("radius_stuck", "spectral radius, block stuck", stuck, "-", "eq. 4.16, with B, delay, hand");
        let mut stable = d.stable.unwrap_or(true) && stuck <= STEADY;
        if stuck > STEADY {
            d.violations.push("the stuck handle oscillates: spectral radius above 1".to_owned());
        }
        if let Some(mass) = self.mass {
            let sliding = closed.radius_sliding(mass);
            d.say(
                "radius_sliding",
                "spectral radius, block free",
                sliding,
                "-",
                "eq. 4.22-4.24 with the handle",
            );
            stable &= sliding <= STEADY;
            if sliding > STEADY {
                d.violations.push("handle and free block oscillate: spectral radius above 1".to_owned());
            }
        }
        d.stable = Some(stable);
    }

    fn dead_band(&self, d: &mut Design) {
        if let Some(count) = self.encoder {
            let resolution = count / self.period;
            d.say("velocity_resolution", "one count in one period", resolution, "m/s", "eq. 2.10");
        }
        let (Some(dv), Some(needed)) = (self.dv, d.get("dv_min")) else { return };
        if dv < needed {
            d.violations.push(format!(
                "dv {dv} m/s is below the limit cycle's {needed:.4e} m/s: the block chatters about rest (eq. 4.35)"
            ));
        }
    }
}

impl Design {
    fn say(
        &mut self,
        key: &'static str,
        what: &'static str,
        value: f64,
        unit: &'static str,
        source: &'static str,
    ) {
        self.figures.push(Figure { key, what, value, unit, source });
    }

    /// The figure of this key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<f64> {
        self.figures.iter().find(|f| f.key == key).map(|f| f.value)
    }

    /// As JSON, SI; what is infinite is null.
    #[must_use]
    pub fn json(&self) -> Map<String, Value> {
        let mut out = Map::new();
        out.insert("schema".into(), json!("tribos.design/1"));
        for f in &self.figures {
            out.insert(f.key.into(), json!(f.value));
        }
        for (key, verdict) in [("stable", self.stable), ("passive", self.passive)] {
            if let Some(verdict) = verdict {
                out.insert(key.into(), json!(verdict));
            }
        }
        out.insert("violations".into(), json!(self.violations));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_thesis() {
        let block = Given {
            period: 1e-3,
            mass: Some(0.5),
            friction: Some(4.0),
            stiffness: Some(1e4),
            damping: Some(10.0),
            ..Given::default()
        };
        let d = block.design();
        assert!((d.get("limit_cycle_velocity").expect("given") - 4.06e-3).abs() < 5e-6);
        assert!((d.get("limit_cycle_position").expect("given") - 2.03e-6).abs() < 5e-9);
        assert!((d.get("damping_singular").expect("given") - 995.0).abs() < 1e-9);
        assert_eq!(d.stable, Some(true));
        assert_eq!(Given { damping: Some(996.0), ..block }.design().stable, Some(false));
        let handle = Given {
            period: 1e-3,
            device_mass: Some(1.0),
            device_damping: Some(10.0),
            dv: Some(0.02),
            ..Given::default()
        };
        let d = handle.design();
        assert!((d.get("kp_max").expect("given") - 20_033.4).abs() < 0.05);
        assert!((d.get("friction_max").expect("given") - 40.0).abs() < 0.05);
        assert_eq!(d.stable, None, "nothing that could oscillate was given");
    }

    #[test]
    fn table_5_3_is_told_that_its_dv_is_too_small() {
        let d = Given {
            period: 1e-3,
            mass: Some(0.5),
            friction: Some(2.0),
            stiffness: Some(25_000.0),
            damping: Some(10.0),
            dv: Some(1e-3),
            ..Given::default()
        }
        .design();
        assert!((d.get("dv_min").expect("given") - 2.05e-3).abs() < 5e-6);
        assert_eq!(d.violations.len(), 1, "{:?}", d.violations);
    }
}
