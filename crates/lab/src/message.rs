//! Requests of a page. Anything else is refused and changes nothing.

use crate::plane::AskPlane;
use serde::Deserialize;

/// Longest message from a page, bytes.
pub const LONGEST: usize = 32 * 1024;

/// Longest reason of a refusal, characters.
const LONGEST_REFUSAL: usize = 500;

/// One request of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Ask {
    /// Friction on the handle, as the active settings say.
    Arm,
    /// Force off.
    Disarm,
    /// Everything that runs ends, at once.
    Stop,
    /// Leaves the fault state.
    Clear,
    /// Searches both stops, and the middle between them.
    Home,
    /// The handle is in the middle of its stroke.
    Zero,
    /// Another preset.
    Use {
        /// Its name.
        name: String,
    },
    /// What these changes would mean; nothing is sent to the device.
    Propose {
        /// Comes back with the answer.
        id: u32,
        /// Names and values.
        changes: Vec<(String, String)>,
    },
    /// These changes, if the device takes them.
    Set {
        /// Names and values.
        changes: Vec<(String, String)>,
    },
    /// Keeps the active settings under a name.
    Save {
        /// The name.
        name: String,
    },
    /// Drives the handle.
    Move {
        /// Shape.
        wave: String,
        /// m.
        amplitude: f64,
        /// Hz.
        frequency: f64,
        /// s.
        seconds: f64,
        /// Recorded once the ramp-in is over, if said.
        #[serde(default)]
        record: bool,
        /// And what was recorded is identified.
        #[serde(default)]
        identify: bool,
    },
    /// The simulated hand goes there, m; or lets go. Virtual device only.
    Hand {
        /// m; none lets go.
        at: Option<f64>,
    },
    /// The simulated hand moves by itself. Virtual device only.
    HandSine {
        /// m.
        amplitude: f64,
        /// Hz.
        frequency: f64,
    },
    /// What the virtual handle slides on besides what is rendered.
    Block {
        /// Material, or none.
        name: String,
    },
    /// Records what happens.
    Record,
    /// Ends the recording.
    RecordEnd,
    /// Identifies friction from recordings of this session.
    Identify {
        /// Their names.
        recordings: Vec<String>,
    },
    /// Diagnoses recordings of this session.
    Diagnose {
        /// Their names.
        recordings: Vec<String>,
    },
    /// Records ten seconds: the device drives the handle, or a hand moves it.
    HandoverRecord {
        /// A hand moves it.
        by_hand: bool,
    },
    /// Diagnoses what was just recorded.
    HandoverDiagnose,
    /// Sends what was found to the device, and switches the force on.
    HandoverSend,
    /// Ends the analysis that runs, without a result.
    Cancel,
    /// Analyses sessions of the folder.
    Analyse {
        /// Their files.
        sessions: Vec<String>,
    },
    /// Opens a session of the targeting task.
    BeginTargeting {
        /// Label of the subject.
        subject: String,
        /// Seed of the order.
        seed: u64,
        /// Practice first.
        practice: bool,
    },
    /// Opens a session of the forced choice.
    BeginChoice {
        /// Label of the subject.
        subject: String,
        /// Seed of the order.
        seed: u64,
        /// `thesis`, `adaptive`, or batches of one's own as TOML.
        batches: String,
    },
    /// Goes on with a session of the folder.
    Resume {
        /// Its file.
        name: String,
    },
    /// The subject arms the handle, or begins the trial.
    Ready,
    /// The button of the targeting task.
    Click,
    /// The next case of the forced choice.
    Advance,
    /// The case that differs.
    Answer {
        /// Which.
        answer: perception::Answer,
    },
    /// Closes the session; what is finished stays.
    Leave,
    /// About the planar handle of this page; it needs no device.
    Plane {
        /// What.
        ask: AskPlane,
    },
    /// For the delay between page and server.
    Ping {
        /// Comes back as it is.
        id: f64,
    },
}

impl Ask {
    /// Reads a message.
    ///
    /// # Errors
    /// What is wrong with it, in one line.
    pub fn read(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("a message of {} bytes: accepted are {LONGEST}", text.len()));
        }
        // the error quotes the message, which may hold anything
        let printable = |c: char| if c.is_control() { ' ' } else { c };
        serde_json::from_str(text).map_err(|e| {
            let why: String = e.to_string().chars().map(printable).take(LONGEST_REFUSAL).collect();
            format!("not a message of this page: {why}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_page_messages_are_parsed() {
        assert_eq!(Ask::read(r#"{"do":"arm"}"#), Ok(Ask::Arm));
        assert_eq!(Ask::read(r#"{"do":"hand","at":null}"#), Ok(Ask::Hand { at: None }));
        for bad in
            ["", "{}", "[]", r#"{"do":"format"}"#, r#"{"do":"use"}"#, r#"{"do":"use","name":"a","x":1}"#]
        {
            let why = Ask::read(bad).expect_err(bad);
            println!("{bad:40} {why}");
            assert!(!why.contains('\n'));
        }
    }

    #[test]
    fn a_line_end_in_a_message_split_its_refusal() {
        for bad in [format!(r#"{{"do":"{}"}}"#, "x".repeat(20_000)), r#"{"do":"begin\nchoice"}"#.into()] {
            let why = Ask::read(&bad).expect_err("refused");
            println!("{why}");
            assert!(!why.contains('\n') && why.len() < 600);
        }
    }
}
