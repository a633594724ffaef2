//! Stick-slip with the frequency of the interface instead of the loop [thesis, ch. 6.2]: a block pulled at constant speed,
//! through the encoder and its edge times, at 1, 2 and 5 kHz, against the block in continuous time.

use haptics::{Control, Device, Inputs, LawKind, RendererKind, Request, Settings};

const HZ: f64 = 170e6;
const COUNT: f64 = 2.57e-6;

/// A block with static and dynamic friction, pulled at constant speed through a spring and a damper.
#[derive(Clone, Copy)]
struct Drawn {
    mass: f64,
    stiffness: f64,
    damping: f64,
    fixed: f64,
    moving: f64,
    speed: f64,
}

impl Drawn {
    /// Frequency in continuous time, Hz, from event to event. A slip is integrated by a fourth-order Runge-Kutta method in steps
    /// of 5 µs, its end found between two steps.
    fn continuous(&self) -> f64 {
        // e: stretch of the spring, m; w: velocity of the block, m/s
        let rate = |(e, w): (f64, f64)| {
            let drive = self.stiffness * e + self.damping * (self.speed - w) - self.moving;
            (self.speed - w, drive / self.mass)
        };
        let step = |(e, w): (f64, f64), h: f64| {
            let k1 = rate((e, w));
            let k2 = rate((e + 0.5 * h * k1.0, w + 0.5 * h * k1.1));
            let k3 = rate((e + 0.5 * h * k2.0, w + 0.5 * h * k2.1));
            let k4 = rate((e + h * k3.0, w + h * k3.1));
            (
                e + h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0),
                w + h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1),
            )
        };
        let release = (self.fixed - self.damping * self.speed) / self.stiffness;
        let h = 5e-6;
        let (mut state, mut slip) = ((release, 0.0), 0.0);
        loop {
            let next = step(state, h);
            if slip > 0.0 && next.1 <= 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if step(state, middle).1 > 0.0 { low = middle } else { high = middle }
                }
                state = step(state, low);
                slip += low;
                break;
            }
            state = next;
            slip += h;
            assert!(slip < 10.0, "slides on: no stick-slip at this speed");
        }
        1.0 / (slip + (release - state.0) / self.speed)
    }

    /// Frequency of backward Euler with the period divided into `parts`, Hz.
    fn backward_euler(&self, period: f64, parts: u32) -> Option<f64> {
        let h = period / f64::from(parts);
        let inertia = self.mass / h + self.stiffness * h + self.damping;
        let (mut p, mut w, mut x) = (0.0, 0.0, 0.0);
        frequency(
            period,
            (0..).map(|_| {
                let stuck = w == 0.0;
                for _ in 0..parts {
                    let drive = self.mass / h * w + self.stiffness * (x - p) + self.damping * self.speed;
                    let hold = if w > 0.0 { self.moving } else { self.fixed };
                    w = if drive > hold { (drive - self.moving) / inertia } else { 0.0 };
                    p += h * w;
                }
                x += self.speed * period;
                stuck && w != 0.0
            }),
        )
    }

    fn settings(&self, renderer: RendererKind) -> Settings {
        let narrow = |x: f64| x as f32;
        Settings {
            law: LawKind::Karnopp,
            renderer,
            f_static_p: narrow(self.fixed),
            f_static_n: narrow(self.fixed),
            f_dynamic_p: narrow(self.moving),
            f_dynamic_n: narrow(self.moving),
            damping_p: 0.0,
            damping_n: 0.0,
            dv: 0.02,
            mass: narrow(self.mass),
            k_vc: narrow(self.stiffness),
            b_vc: narrow(self.damping),
            ..Settings::rubber()
        }
    }

    /// Frequency of the rendered block, Hz, with the complete control step and the handle moved along the stroke.
    fn rendered(&self, renderer: RendererKind, rate: u32) -> Option<f64> {
        let device = Device { period: 1.0 / rate as f32, ..Device::default() };
        let mut control =
            Control::referenced(self.settings(renderer).build(&device).expect("within the bounds"));
        let ticks = u64::from(device.period_ticks());
        let start = -0.0145;
        let mut last = true;
        let mut k = 0;
        frequency(
            1.0 / f64::from(rate),
            (0..).map(|_| {
                let now = k * ticks;
                let x = start + self.speed * now as f64 / HZ;
                assert!(x < 0.0155, "the stroke ends before the slips are counted");
                let count = (x / COUNT).floor();
                let edge = ((count * COUNT - start) / self.speed * HZ).max(0.0).ceil();
                let inputs = Inputs {
                    sample_ticks: now as u32,
                    count: count as i64 as u32,
                    edge_ticks: edge as u64 as u32,
                    load_code: 32_768,
                    accel_code: 32_768,
                };
                let outputs = control.step((k == 10).then_some(&Request::Render(true)), &inputs);
                assert_eq!((outputs.denied, outputs.fault), (None, None));
                k += 1;
                let slips = last && !outputs.stuck && k > 20;
                last = outputs.stuck;
                slips
            }),
        )
    }
}

/// Frequency of the slips that begin in these periods, Hz, over ten slips after the first two. `None` if there are fewer.
fn frequency(period: f64, begins: impl Iterator<Item = bool>) -> Option<f64> {
    let began = begins.take((20.0 / period) as usize).enumerate().filter_map(|(k, slips)| slips.then_some(k));
    let at: Vec<usize> = began.skip(2).take(11).collect();
    Some(10.0 / (period * (at.get(10)? - at[0]) as f64))
}

#[test]
fn stick_slip_frequency_is_independent_of_the_rate() {
    let interfaces = [
        Drawn { mass: 0.4, stiffness: 3_000.0, damping: 1.0, fixed: 3.0, moving: 1.5, speed: 0.012 },
        Drawn { mass: 0.4, stiffness: 8_000.0, damping: 15.0, fixed: 3.5, moving: 2.0, speed: 0.01 },
        Drawn { mass: 1.0, stiffness: 8_000.0, damping: 2.0, fixed: 2.5, moving: 2.0, speed: 0.01 },
        Drawn { mass: 0.2, stiffness: 12_000.0, damping: 3.0, fixed: 4.0, moving: 1.0, speed: 0.015 },
    ];
    println!("continuous | rate Hz | stopping force | table 4-1 | backward Euler in 1, 2, 4, 8 parts");
    let mut worst = 0.0_f64;
    for interface in interfaces {
        let exact = interface.continuous();
        for rate in [1_000, 2_000, 5_000] {
            let ours = interface.rendered(RendererKind::StoppingForce, rate).expect("sticks and slips");
            let table = interface.rendered(RendererKind::Impedance, rate).expect("chatters");
            let off = |f: f64| 100.0 * (f / exact - 1.0);
            let euler = |n| interface.backward_euler(1.0 / f64::from(rate), n);
            let parts = [1, 2, 4, 8].map(|n| match euler(n) {
                Some(f) => format!("{:+.2} %", off(f)),
                None => "slides on".to_owned(),
            });
            println!(
                "{exact:7.3} Hz | {rate:7} | {ours:7.3} Hz {:+.2} % | {table:6.1} Hz | {}",
                off(ours),
                parts.join(", ")
            );
            worst = worst.max(off(ours).abs());
            assert!(off(ours).abs() < 2.0, "{ours} Hz rendered, {exact} Hz continuous");
            // about every second period, for any interface
            let of_loop = table / f64::from(rate);
            assert!((0.4..0.51).contains(&of_loop), "table 4-1 at {table} Hz");
        }
    }
    println!("largest difference to the continuous block {worst:.2} %");
}
