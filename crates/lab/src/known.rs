//! State of the device as every page shows it.

use crate::verdict::{self, Shown, Verdict};
use haptics::{Device, FaultKind, ModeId, Settings};
use serde::Serialize;

/// A fault in plain words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FaultShown {
    /// One word.
    pub id: &'static str,
    /// What happened and what to do.
    pub says: &'static str,
}

/// A recording of this session.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Listed {
    /// File name.
    pub name: String,
    /// Samples in it.
    pub samples: u64,
    /// Of those, lost.
    pub lost: u64,
    /// Length, s.
    pub seconds: f64,
}

/// Something that takes a while.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Job {
    /// `identify`, `diagnose` or `analyse`.
    pub kind: &'static str,
    /// On what.
    pub of: String,
    /// 0 to 1.
    pub share: f32,
    /// What is being done.
    pub says: String,
}

/// What an analysis gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Done {
    /// `identify`, `diagnose` or `analyse`.
    pub kind: &'static str,
    /// On what.
    pub of: String,
    /// As the terminal would show it, or why it failed.
    pub text: String,
    /// It failed.
    pub failed: bool,
    /// Name of the report, if there is one.
    pub report: Option<String>,
    /// What it found, as a preset.
    pub preset: Vec<(String, String)>,
    /// Tables to download.
    pub tables: Vec<String>,
}

/// Everything a page shows besides samples.
#[derive(Debug, Clone, Serialize)]
pub struct Known {
    /// Port as the user named it.
    pub port: String,
    /// It is a virtual device.
    pub sim: bool,
    /// The line is open and the device has answered.
    pub connected: bool,
    /// Why it is not.
    pub absent: String,
    /// What runs there.
    pub version: String,
    /// Counts the streams; time restarts with each.
    pub epoch: u8,
    /// Time between samples, s.
    pub period: f64,
    /// Active preset.
    pub preset: String,
    /// The settings differ from it.
    pub changed: bool,
    /// All presets.
    pub presets: Vec<String>,
    /// State of the machine.
    pub mode: &'static str,
    /// The latched fault.
    pub fault: Option<FaultShown>,
    /// The device says that it does not know the middle of its stroke.
    pub unreferenced: bool,
    /// Largest force until it does, N.
    pub unreferenced_force: f64,
    /// Somebody asked for friction on the handle.
    pub armed: bool,
    /// Half the stroke, m.
    pub reach: f64,
    /// Largest force, N.
    pub force_max: f64,
    /// What validation says of the active settings, with every parameter and its limits.
    pub verdict: Verdict,
    /// What the virtual handle slides on besides what is rendered: a material, or `none`.
    pub block: String,
    /// Being recorded: samples until now.
    pub recording: Option<u64>,
    /// Finished recordings, the newest first.
    pub recordings: Vec<Listed>,
    /// What is being computed.
    pub job: Option<Job>,
    /// What was computed last.
    pub done: Option<Done>,
    /// From the last recording to the handle.
    pub handover: crate::handover::Handover,
    /// The session that is open.
    pub experiment: Option<crate::experiment::Shown>,
    /// Sessions of this folder.
    pub sessions: Vec<crate::experiment::Begun>,
    /// The settings themselves.
    #[serde(skip)]
    pub settings: Settings,
    /// Constants of the device.
    #[serde(skip)]
    pub device: Device,
}

impl Known {
    /// Nothing is known yet.
    #[must_use]
    pub fn new(port: &str) -> Self {
        let (settings, device) = (Settings::default(), Device::default());
        Self {
            port: port.to_owned(),
            sim: port == "sim",
            connected: false,
            absent: "connecting".into(),
            version: String::new(),
            epoch: 0,
            period: f64::from(device.period),
            preset: String::new(),
            changed: false,
            presets: Vec::new(),
            mode: ModeId::Idle.id(),
            fault: None,
            unreferenced: false,
            unreferenced_force: f64::from(device.unreferenced_force()),
            armed: false,
            reach: 0.5 * f64::from(device.stroke),
            force_max: f64::from(device.force_max),
            verdict: verdict::judge(&settings, &device),
            block: "none".into(),
            recording: None,
            recordings: Vec::new(),
            job: None,
            done: None,
            handover: crate::handover::Handover::default(),
            experiment: None,
            sessions: Vec::new(),
            settings,
            device,
        }
    }

    /// Takes over a listing of the device: `  k_vc 8000 N/m`.
    pub(crate) fn listing(&mut self, lines: &[String]) {
        let mut settings = Settings { effects: [None; haptics::settings::MAX_EFFECTS], ..self.settings };
        for line in lines {
            let mut words = line.split_whitespace();
            if let (Some(name), Some(value)) = (words.next(), words.next()) {
                // a parameter this host does not know is not shown
                let _ = settings.set(name, value);
            }
        }
        self.settings = settings;
        self.verdict = verdict::judge(&self.settings, &self.device);
    }

    /// `ok brass teflon; active brass (changed); …`
    pub(crate) fn preset_list(&mut self, line: &str) {
        let mut parts = line.trim_start_matches("ok").split(';');
        self.presets = parts.next().unwrap_or("").split_whitespace().map(str::to_owned).collect();
        if let Some(active) = parts.find_map(|part| part.trim().strip_prefix("active ")) {
            let mut words = active.split_whitespace();
            self.preset = words.next().unwrap_or("").to_owned();
            self.changed = words.next().is_some();
        }
    }

    /// State, fault and reference of a sample; true when they are others than before.
    pub(crate) fn state(&mut self, mode: u8, fault: u8, referenced: bool) -> bool {
        let mode = ModeId::from_code(mode).map_or("unknown", ModeId::id);
        let fault = (fault != 0).then(|| match FaultKind::from_code(fault) {
            Some(kind) => FaultShown { id: kind.id(), says: kind.explain() },
            None => FaultShown {
                id: "unknown",
                says: "a fault this host does not know; see `fault` on the device",
            },
        });
        let news = mode != self.mode || fault != self.fault || self.unreferenced == referenced;
        // after a fault the device must be armed again
        self.armed &= fault.is_none();
        (self.mode, self.fault, self.unreferenced) = (mode, fault, !referenced);
        news
    }

    /// A parameter of the active settings.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&Shown> {
        self.verdict.parameters.iter().find(|p| p.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_answers_are_parsed_for_the_page() {
        let mut known = Known::new("sim");
        known.preset_list("ok brass rubber mine; active mine (changed); default brass");
        assert_eq!((known.presets.len(), known.preset.as_str(), known.changed), (3, "mine", true));
        known.listing(&["  k_vc 9000 N/m".into(), "  stribeck.force_p 0.2 N".into(), "  law dahl".into()]);
        assert_eq!(known.parameter("k_vc").map(|p| p.value.as_str()), Some("9000"));
        assert_eq!(known.parameter("stribeck.force_p").map(|p| p.value.as_str()), Some("0.2"));
        known.listing(&["  k_vc 9000 N/m".into()]);
        assert!(known.parameter("stribeck.force_p").is_none(), "what is not listed is not there");
        known.armed = true;
        assert!(known.state(4, 1, true));
        assert!(!known.armed, "a fault takes the arming back");
        assert!(!known.state(4, 1, true));
        assert!(known.state(4, 1, false) && known.unreferenced);
        assert!(known.fault.as_ref().is_some_and(|f| f.says.contains("faster")));
    }
}
