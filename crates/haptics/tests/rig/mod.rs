//! A device for tests: the exact solution of [thesis, eq. 4.15] over a period, with an ideal encoder.
#![allow(dead_code)] // each test uses a part

use haptics::{Control, Device, Inputs, Outputs, Request, Settings};

pub const HZ: f64 = 170e6;
pub const COUNT: f64 = 2.57e-6;
pub const T: f64 = 1e-3;
const PERIOD_TICKS: u64 = 170_000;

/// Mass and damper under a constant force over the period.
pub struct Rig {
    pub mass: f64,
    pub damping: f64,
    pub x: f64,
    pub v: f64,
    pub load_n: f64,
    pub accel: f64,
    ticks: u64,
    count: i64,
    edge: u64,
}

impl Rig {
    pub fn new(mass: f64, damping: f64, x: f64) -> Self {
        let mut rig = Self { mass, damping, x, v: 0.0, load_n: 0.0, accel: 0.0, ticks: 0, count: 0, edge: 0 };
        rig.count = cell(x);
        rig
    }

    /// Like the default device.
    pub fn of(device: &Device) -> Self {
        Self::new(f64::from(device.mass), f64::from(device.damping), 0.0)
    }

    /// [thesis, eq. 4.15] at time t into a period under force f.
    fn at(&self, f: f64, t: f64) -> (f64, f64) {
        let (b, tau) = (self.damping, self.mass / self.damping);
        let e = (-t / tau).exp();
        let settled = f / b;
        (settled * t - tau * (self.v - settled) * (e - 1.0) + self.x, settled + (self.v - settled) * e)
    }

    /// One period under a force.
    pub fn push(&mut self, f: f64) {
        let path = |t: f64| self.at(f, t).0;
        let (count, edge) = edges(&path, self.count, self.ticks, self.edge);
        let v = self.v;
        (self.x, self.v) = self.at(f, T);
        self.accel = (self.v - v) / T;
        (self.count, self.edge) = (count, edge);
        self.ticks += PERIOD_TICKS;
    }

    /// One period along a prescribed straight line.
    pub fn carry(&mut self, v: f64) {
        let start = self.x;
        let (count, edge) = edges(&|t: f64| start + v * t, self.count, self.ticks, self.edge);
        (self.x, self.v) = (start + v * T, v);
        (self.count, self.edge) = (count, edge);
        self.ticks += PERIOD_TICKS;
    }

    pub fn inputs(&self) -> Inputs {
        let device = Device::default();
        let code = |si: f64, channel: haptics::Channel| {
            (si / f64::from(channel.unit_per_code) + f64::from(channel.offset_code)).round() as u16
        };
        Inputs {
            sample_ticks: self.ticks as u32,
            count: self.count as u32,
            edge_ticks: self.edge as u32,
            load_code: code(self.load_n, device.load),
            accel_code: code(self.accel, device.accel),
        }
    }
}

fn cell(x: f64) -> i64 {
    (x / COUNT).floor() as i64
}

/// Count and time of the last edge after a period along `path`.
fn edges(path: &dyn Fn(f64) -> f64, mut count: i64, ticks: u64, mut edge: u64) -> (i64, u64) {
    let at = |tick: u64| cell(path(tick as f64 / HZ));
    let pieces = 16;
    for piece in 0..pieces {
        let (from, to) = (PERIOD_TICKS * piece / pieces, PERIOD_TICKS * (piece + 1) / pieces);
        while at(to) != count {
            let up = at(to) > count;
            let (mut low, mut high) = (from, to);
            while high - low > 1 {
                let middle = low.midpoint(high);
                let beyond = if up { at(middle) > count } else { at(middle) < count };
                if beyond { high = middle } else { low = middle }
            }
            count += if up { 1 } else { -1 };
            edge = ticks + high;
        }
    }
    (count, edge)
}

/// A running loop.
pub fn control(settings: &Settings) -> Control {
    Control::referenced(settings.build(&Device::default()).expect("valid settings"))
}

/// Turns rendering on.
pub fn render(control: &mut Control, rig: &mut Rig) -> Outputs {
    control.step(None, &rig.inputs());
    rig.push(0.0);
    let outputs = control.step(Some(&Request::Render(true)), &rig.inputs());
    assert_eq!(outputs.denied, None);
    outputs
}
