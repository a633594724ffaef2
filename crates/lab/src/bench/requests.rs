//! Checks the requests of a page and turns them into commands.

use super::Bench;
use crate::message::Ask;
use crate::orders::About;
use crate::say::Tone;
use crate::session_file;
use crate::verdict::{self, word};
use haptics::{Excitation, Wave};

impl Bench {
    pub(super) fn asked(&mut self, ask: Ask) {
        let without = matches!(
            ask,
            Ask::Identify { .. }
                | Ask::Diagnose { .. }
                | Ask::HandoverDiagnose
                | Ask::Cancel
                | Ask::Analyse { .. }
                | Ask::Leave
        );
        if self.device.is_none() && !without {
            return self.say(Tone::Refused, "device", "no device is connected");
        }
        if self.held(&ask) {
            return self.say(Tone::Refused, "experiment", session_file::OPEN);
        }
        if self.unreferenced(&ask) {
            return self.say(
                Tone::Refused,
                "device",
                "the device does not know the middle of its stroke: let it search both stops, or move the handle there and say so",
            );
        }
        if let Err((about, why)) = self.obey(ask) {
            self.say(Tone::Refused, about, why);
        }
    }

    /// What needs all of the force, or moves the handle, while the device does not know the middle of its stroke.
    fn unreferenced(&self, ask: &Ask) -> bool {
        let needs = matches!(
            ask,
            Ask::Move { .. }
                | Ask::HandoverRecord { by_hand: false }
                | Ask::BeginTargeting { .. }
                | Ask::BeginChoice { .. }
                | Ask::Resume { .. }
                | Ask::Ready
        );
        needs && self.shared.known(|known| known.unreferenced)
    }

    /// What must not be changed while a session is open: it would change what is felt.
    fn held(&self, ask: &Ask) -> bool {
        let changes = matches!(
            ask,
            Ask::Arm
                | Ask::Home
                | Ask::Zero
                | Ask::Use { .. }
                | Ask::Set { .. }
                | Ask::Move { .. }
                | Ask::HandoverRecord { .. }
                | Ask::HandoverSend
                | Ask::Block { .. }
                | Ask::HandSine { .. }
        );
        changes && self.experiment.is_some()
    }

    fn obey(&mut self, ask: Ask) -> Result<(), (&'static str, String)> {
        match ask {
            Ask::Arm => self.arm(),
            Ask::Disarm if self.experiment.is_some() => {
                self.stop();
                Ok(())
            }
            Ask::Disarm => {
                self.shared.known(|known| known.armed = false);
                self.off_at_once();
                self.dirty = true;
                Ok(())
            }
            Ask::Stop => {
                self.stop();
                Ok(())
            }
            Ask::Clear => {
                if self.shared.known(|known| known.sim) {
                    // the simulated hand is hands off, as the device asks for
                    self.orders.push("sim hand off", About::Hand);
                }
                self.orders.push("clear", About::Page("clear"));
                Ok(())
            }
            Ask::Home => {
                if self.shared.known(|known| known.sim) {
                    self.orders.push("sim hand off", About::Hand);
                }
                self.shared.known(|known| known.armed = false);
                self.orders.push("home", About::Page("home"));
                Ok(())
            }
            Ask::Zero => {
                self.orders.push("zero", About::Page("zero"));
                Ok(())
            }
            Ask::Use { name } => self.use_preset(&name).map_err(|why| ("preset", why)),
            Ask::Set { changes } => self.set(&changes).map_err(|why| ("set", why)),
            Ask::Save { name } => {
                let name = word(&name).map_err(|why| ("save", why))?;
                self.orders.push(format!("preset save {name}"), About::Page("save"));
                self.orders.push("preset list", About::Presets);
                Ok(())
            }
            Ask::Move { wave, amplitude, frequency, seconds, record, identify } => self
                .drive(&wave, [amplitude, frequency, seconds], record, identify)
                .map_err(|why| ("move", why)),
            Ask::Hand { at } => self.hand(at.map(|x| format!("at {x:.6}"))).map_err(|why| ("hand", why)),
            Ask::HandSine { amplitude, frequency } => {
                self.hand(Some(format!("sine {amplitude:.6} {frequency:.4}"))).map_err(|why| ("hand", why))
            }
            Ask::Block { name } => {
                self.only_simulated().map_err(|why| ("block", why))?;
                let name = word(&name).map_err(|why| ("block", why))?;
                self.orders.push(format!("sim block {name}"), About::Page("block"));
                self.block_is(name);
                Ok(())
            }
            Ask::Record => self.begin_recording(&[]).map_err(|why| ("record", why)),
            Ask::RecordEnd => {
                self.end_recording();
                Ok(())
            }
            Ask::Identify { recordings } => {
                self.analyse("identify", &recordings).map_err(|why| ("identify", why))
            }
            Ask::Diagnose { recordings } => {
                self.analyse("diagnose", &recordings).map_err(|why| ("diagnose", why))
            }
            Ask::HandoverRecord { by_hand } => self.handover_record(by_hand).map_err(|why| ("record", why)),
            Ask::HandoverDiagnose => self.handover_diagnose().map_err(|why| ("diagnose", why)),
            Ask::HandoverSend => self.handover_send().map_err(|why| ("send", why)),
            Ask::Cancel => self.cancel().map_err(|why| ("cancel", why)),
            Ask::Analyse { sessions } => self.analyse("analyse", &sessions).map_err(|why| ("analyse", why)),
            Ask::BeginTargeting { subject, seed, practice } => {
                self.begin_targeting(&subject, seed, practice).map_err(|why| ("experiment", why))
            }
            Ask::BeginChoice { subject, seed, batches } => {
                self.begin_choice(&subject, seed, &batches).map_err(|why| ("experiment", why))
            }
            Ask::Resume { name } => self.resume(&name).map_err(|why| ("experiment", why)),
            Ask::Ready => self.ready().map_err(|why| ("experiment", why)),
            Ask::Click => self.click().map_err(|why| ("experiment", why)),
            Ask::Advance => self.advance().map_err(|why| ("experiment", why)),
            Ask::Answer { answer } => self.answer(answer).map_err(|why| ("experiment", why)),
            Ask::Leave => {
                self.leave();
                Ok(())
            }
            // answered where they arrive
            Ask::Propose { .. } | Ask::Plane { .. } | Ask::Ping { .. } => Ok(()),
        }
    }

    pub(super) fn arm(&mut self) -> Result<(), (&'static str, String)> {
        if let Some(fault) = self.shared.known(|known| known.fault.clone()) {
            return Err(("arm", format!("a fault is latched: {}; clear it first", fault.says)));
        }
        self.shared.known(|known| known.armed = true);
        self.orders.push("render on", About::Page("arm"));
        self.dirty = true;
        Ok(())
    }

    fn use_preset(&mut self, name: &str) -> Result<(), String> {
        let name = word(name)?;
        let known = self.shared.known(|known| known.presets.clone());
        if !known.iter().any(|preset| preset == name) {
            return Err(format!("no preset `{name}`; there are {}", known.join(", ")));
        }
        self.orders.push(format!("preset use {name}"), About::Page("preset"));
        self.refresh();
        Ok(())
    }

    pub(super) fn refresh(&mut self) {
        self.orders.push("preset list", About::Presets);
        self.orders.push("get", About::Get);
    }

    fn set(&mut self, changes: &verdict::Changes) -> Result<(), String> {
        let (settings, device) = self.shared.known(|known| (known.settings, known.device));
        let order = verdict::steps(&settings, &device, changes)?;
        for (name, value) in order {
            self.orders.push(format!("set {name} {value}"), About::Set);
        }
        self.refresh();
        Ok(())
    }

    pub(super) fn drive(
        &mut self,
        wave: &str,
        [amplitude, frequency, seconds]: [f64; 3],
        record: bool,
        identify: bool,
    ) -> Result<(), String> {
        let names = || Wave::ALL.iter().map(|wave| wave.id()).collect::<Vec<_>>().join(", ");
        let wave =
            Wave::from_id(wave).ok_or_else(|| format!("no wave `{wave}`; accepted are {}", names()))?;
        let excitation = Excitation {
            wave,
            amplitude_m: amplitude as f32,
            frequency_hz: frequency as f32,
            seconds: seconds as f32,
        };
        let device = self.shared.known(|known| known.device);
        excitation.validate(&device).map_err(|refused| refused.to_string())?;
        if record && !(1.0..=3_600.0).contains(&seconds) {
            return Err(format!("seconds = {seconds}: accepted from 1 to 3600 for a move that is recorded"));
        }
        let mut length = seconds;
        if record {
            // the ramp-in comes before it
            length += f64::from(haptics::excitation::RAMP_IN_S) + 0.6;
            let line = format!("{} {amplitude} {frequency}", wave.id());
            self.begin_recording(&[("move".to_owned(), line)])?;
            if let Some(recording) = &mut self.recording {
                recording.of_a_move(seconds, identify);
            }
        }
        if self.shared.known(|known| known.sim) {
            self.orders.push("sim hand off", About::Hand);
        }
        if self.shared.known(|known| std::mem::take(&mut known.armed)) {
            self.orders.push("render off", About::Page("disarm"));
        }
        self.orders.push(format!("move {} {amplitude} {frequency} {length}", wave.id()), About::Page("move"));
        Ok(())
    }

    fn only_simulated(&self) -> Result<(), String> {
        if self.shared.known(|known| known.sim) {
            Ok(())
        } else {
            Err("a real handle is held by a real hand; accepted with `tribos lab sim`".into())
        }
    }

    fn hand(&mut self, how: Option<String>) -> Result<(), String> {
        self.only_simulated()?;
        self.orders.push(format!("sim hand {}", how.as_deref().unwrap_or("off")), About::Hand);
        Ok(())
    }
}
