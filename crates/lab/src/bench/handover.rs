//! The handover: records, has it diagnosed, sends what the device renders of it, and shows the force before and after.

use super::Bench;
use crate::handover::{Bins, Curves, Handover, Moved, Step, differences, rounded};
use crate::orders::About;
use crate::say::Tone;
use crate::tools::Found;
use crate::verdict;
use client::Sample;
use haptics::{Device, ModeId, Settings};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Length of the recording, s.
const SECONDS: f64 = 10.0;
/// How the device drives the body: harmonics tell velocity and acceleration apart. Amplitude on the default device, m.
const WAVE: &str = "multisine";
const AMPLITUDE: f32 = 0.01;
const FREQUENCY: f64 = 1.0;
/// Body on a virtual handle that has none.
const BLOCK: &str = "rubber";
/// How a simulated hand feels what was sent: amplitude, m, and frequency, Hz.
const HAND: &str = "sine 0.010000 0.8000";
/// Interval between two pictures of the force felt.
const SHOW: Duration = Duration::from_millis(500);

impl Bench {
    /// First step.
    pub(super) fn handover_record(&mut self, by_hand: bool) -> Result<(), String> {
        if by_hand {
            self.begin_recording(&[("moved_by".to_owned(), "hand".to_owned())])?;
            if let Some(recording) = &mut self.recording {
                recording.length = Some(SECONDS);
            }
            return Ok(());
        }
        let (device, bare) = self.shared.known(|known| (known.device, known.sim && known.block == "none"));
        if bare {
            self.orders.push(format!("sim block {BLOCK}"), About::Page("block"));
            self.block_is(BLOCK);
            self.say(
                Tone::News,
                "block",
                format!("the virtual handle was bare: a block on {BLOCK} is mounted"),
            );
        }
        // the shortest decimal of the device's own precision
        let amplitude = device.length(AMPLITUDE).to_string().parse().unwrap_or(f64::from(AMPLITUDE));
        self.drive(WAVE, [amplitude, FREQUENCY, SECONDS], true, false)?;
        if let Some(recording) = &mut self.recording {
            // a move that is stopped ends it no more
            recording.length = Some(SECONDS);
        }
        Ok(())
    }

    /// Second step.
    pub(super) fn handover_diagnose(&mut self) -> Result<(), String> {
        let recording = self.shared.known(|known| known.handover.recording.clone());
        let name = recording.ok_or("nothing was recorded yet: record first")?;
        self.start_job("diagnose", &[name], true)
    }

    /// The diagnosis of a handover has ended.
    pub(super) fn diagnosed(&mut self, of: &str, found: Result<Found, String>, report: Option<String>) {
        let cancelled = self.cancel.load(Ordering::Relaxed);
        if cancelled || self.shared.known(|known| known.handover.recording.as_deref() != Some(of)) {
            return;
        }
        match found {
            Ok(found) => {
                self.shared.known(|known| {
                    known.handover.summary.clone_from(&found.summary);
                    known.handover.report = report;
                });
                self.found = Some(found);
                self.plan();
            }
            Err(why) => self.shared.known(|known| {
                known.handover.step = Step::Refused;
                known.handover.refused = why;
            }),
        }
    }

    /// What would be sent now, on the pages; the settings, if it can be sent.
    fn plan(&mut self) -> Option<Settings> {
        let found = self.found.as_ref()?;
        let (active, device) = self.shared.known(|known| (known.settings, known.device));
        let planned = if found.preset.is_empty() {
            Err("no model was found, so there is nothing to render; the report says why".to_owned())
        } else {
            design::renderable(&found.preset, &active, &device)
        };
        let mut next = self.shared.known(|known| Handover {
            differences: Vec::new(),
            moved: Vec::new(),
            left_out: Vec::new(),
            refused: String::new(),
            felt: Curves::default(),
            ..known.handover.clone()
        });
        let mass = found.preset.iter().find(|(name, _)| name == "mass").and_then(|(_, x)| x.parse().ok());
        if let Some(bins) = &self.recorded {
            next.recorded = bins.curves(mass.unwrap_or(0.0));
        }
        let settings = match planned {
            Ok(design::Renderable { settings, moved, left_out, warning }) => {
                next.before = felt_of(&active, &device, &next);
                next.after = felt_of(&settings, &device, &next);
                next.differences = differences(&active, &settings, &device);
                next.moved = moved.into_iter().map(|change| Moved::of(change, &device)).collect();
                next.warning = warning;
                next.left_out = [left_out, found.left_out.clone()].concat();
                if next.is_felt(&device) {
                    next.step = Step::Send;
                    Some(settings)
                } else {
                    next.refused =
                        "no friction was found that a hand would feel: is a body mounted on the handle?"
                            .into();
                    None
                }
            }
            Err(why) => {
                next.left_out.clone_from(&found.left_out);
                next.refused = why;
                None
            }
        };
        if settings.is_none() {
            next.step = Step::Refused;
        }
        self.shared.known(|known| known.handover = next);
        self.dirty = true;
        settings
    }

    /// Third step.
    pub(super) fn handover_send(&mut self) -> Result<(), String> {
        if self.shared.known(|known| matches!(known.handover.step, Step::Sending | Step::Sent)) {
            return Err("it is on the handle already".into());
        }
        if self.found.is_none() {
            let refused = self.shared.known(|known| known.handover.refused.clone());
            let nothing = "nothing was diagnosed yet: record and diagnose first".to_owned();
            return Err(if refused.is_empty() { nothing } else { refused });
        }
        if let Some(fault) = self.shared.known(|known| known.fault.clone()) {
            return Err(format!("a fault is latched: {}; clear it first", fault.says));
        }
        let Some(settings) = self.plan() else {
            return Err(self.shared.known(|known| known.handover.refused.clone()));
        };
        let (active, device, sim) = self.shared.known(|known| (known.settings, known.device, known.sim));
        let changes: Vec<(String, String)> =
            differences(&active, &settings, &device).into_iter().map(|d| (d.name, d.after)).collect();
        let steps = verdict::steps(&active, &device, &changes)?;
        if sim {
            // what is rendered is felt alone
            self.orders.push("sim block none", About::Page("block"));
            self.block_is("none");
        }
        for (name, value) in steps {
            self.orders.push(format!("set {name} {value}"), About::Set);
        }
        self.refresh();
        self.orders.push("get", About::Sent);
        self.arm().map_err(|(_, why)| why)?;
        if sim {
            self.orders.push(format!("sim hand {HAND}"), About::Hand);
        }
        let felt_before = self.felt.curves(block_mass(&active));
        self.felt = self.bins().in_a_hand();
        self.shared.known(|known| {
            known.handover.step = Step::Sending;
            known.handover.felt_before = felt_before;
            known.handover.before_name.clone_from(&known.preset);
        });
        self.sent = Some(settings);
        self.dirty = true;
        Ok(())
    }

    /// The device has listed its settings; `sent`: those of the handover.
    pub(super) fn settings_listed(&mut self, sent: bool) {
        let (step, now, device) =
            self.shared.known(|known| (known.handover.step, known.settings, known.device));
        let not_taken = self.sent.map(|target| differences(&now, &target, &device)).unwrap_or_default();
        match step {
            Step::Sending if sent => {
                self.felt = self.bins().in_a_hand();
                let names: Vec<&str> = not_taken.iter().map(|d| d.name.as_str()).collect();
                self.shared.known(|known| match names.is_empty() {
                    true => known.handover.step = Step::Sent,
                    false => {
                        known.handover.step = Step::Refused;
                        known.handover.refused = format!("the device did not take {}", names.join(", "));
                    }
                });
            }
            // another preset is active: what was found is compared with that one
            Step::Sent if !not_taken.is_empty() => {
                self.felt = self.bins().in_a_hand();
                self.plan();
            }
            Step::Send | Step::Refused => {
                self.felt = self.bins().in_a_hand();
                self.plan();
            }
            Step::Record | Step::Diagnose => self.felt = self.bins(),
            Step::Sending | Step::Sent => {}
        }
        self.dirty = true;
    }

    /// A stop or a lost device: what was on its way may have arrived in part.
    pub(super) fn interrupt_handover(&mut self) {
        let was_sending = self.shared.known(|known| {
            let sending = known.handover.step == Step::Sending;
            if sending {
                known.handover.step = Step::Send;
            }
            sending
        });
        if was_sending && self.device.is_some() {
            // it is compared with what the device has now
            self.sent = None;
            self.refresh();
        }
    }

    /// Force felt under the active preset.
    pub(super) fn feel_handover(&mut self, sample: &Sample) {
        if ModeId::from_code(sample.mode) != Some(ModeId::Rendering) {
            return;
        }
        // the actuator pushes against the motion
        self.felt.push(sample, -sample.command);
        if self.felt_shown.elapsed() < SHOW || self.shared.known(|known| known.handover.step != Step::Sent) {
            return;
        }
        self.felt_shown = Instant::now();
        self.shared.known(|known| known.handover.felt = self.felt.curves(block_mass(&known.settings)));
        self.dirty = true;
    }

    /// What the virtual handle slides on.
    pub(super) fn block_is(&self, name: &str) {
        if self.shared.known(|known| known.sim) {
            self.shared.known(|known| known.block = name.into());
        }
    }

    /// Empty bins for samples of this device.
    pub(super) fn bins(&self) -> Bins {
        self.shared.known(|known| Bins::new(&known.device, known.period))
    }
}

fn felt_of(settings: &Settings, device: &Device, shown: &Handover) -> Curves {
    let compared = shown.speeds.get(shown.compared).copied().unwrap_or(0.0);
    let curve = |forces: Vec<f32>| forces.iter().map(|f| f.is_finite().then(|| rounded(*f))).collect();
    Curves {
        over_speed: curve(design::felt_over_speed(settings, device, &shown.speeds)),
        over_position: curve(design::felt_over_position(settings, device, compared, &shown.positions)),
    }
}

/// Mass of the virtual block, kg, whose inertia the actuator renders besides friction.
fn block_mass(settings: &Settings) -> f64 {
    if settings.renderer.has_block() { f64::from(settings.mass) } else { 0.0 }
}
