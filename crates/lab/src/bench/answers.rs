//! Handles the lines that the device sends.

use super::{Bench, WATCH_S};
use crate::orders::{About, Answer, Reply};
use crate::say::Tone;
use link::reply;

impl Bench {
    pub(super) fn line(&mut self, line: String) {
        match self.orders.receive(line) {
            Reply::Nothing => {}
            Reply::News(news) => {
                // the state says faults by itself, in more room
                if !news.starts_with("fault") {
                    self.say(Tone::News, "device", news);
                }
            }
            Reply::Answer(answer) => self.answered(answer),
        }
    }

    fn answered(&mut self, answer: Answer) {
        let refused = reply::refusal(&answer.first).map(|(_, why)| why.trim().to_owned());
        let text = answer.first.trim_start_matches("ok").trim().to_owned();
        match answer.order.about {
            About::Version => {
                // a faster loop is streamed 1 000 times a second all the same: the line carries no more
                let hz =
                    text.trim_end_matches(" Hz").rsplit(' ').next().and_then(|hz| hz.parse::<u32>().ok());
                let decimation = hz.map_or(1, |hz| (hz / 1_000).max(1));
                self.orders.first(format!("stream on {decimation}"), About::Stream);
                if text.contains(" on the simulated rig") {
                    self.orders.push("status", About::Origin);
                }
                self.shared.known(|known| {
                    known.version = text;
                    known.connected = true;
                    known.absent.clear();
                });
                self.dirty = true;
            }
            About::Get | About::Sent => {
                self.shared.known(|known| known.listing(&answer.rest));
                self.dirty = true;
                self.settings_listed(answer.order.about == About::Sent);
            }
            About::Presets => {
                self.shared.known(|known| known.preset_list(&answer.first));
                self.dirty = true;
            }
            // nobody has to be asked before a virtual device moves
            About::Origin => {
                if text.split(", ").any(|part| part == "unreferenced") {
                    self.orders.push("home", About::Page("home"));
                }
            }
            About::Watch => {
                // `watch 30 s: …`, or `watch off: …`
                let before = text.split_whitespace().nth(1).map(|word| word.trim_end_matches(':'));
                self.watch = before.map(|word| if word == "off" { "0" } else { word }.to_owned());
                self.orders.first(format!("watch {WATCH_S}"), About::Hand);
            }
            About::Stream | About::Hand => {
                if let Some(why) = refused {
                    self.say(Tone::Error, "device", why);
                }
            }
            About::Quiet => {
                if let Some(why) = refused {
                    self.stop();
                    self.say(Tone::Refused, "experiment", why);
                }
            }
            About::Set => {
                if let Some(why) = refused {
                    self.say(Tone::Refused, "set", why);
                }
            }
            About::Page(what) => self.told_page(what, refused, &text),
        }
    }

    fn told_page(&mut self, what: &'static str, refused: Option<String>, text: &str) {
        self.dirty = true;
        if let Some(why) = refused {
            if what == "arm" {
                self.shared.known(|known| known.armed = false);
            }
            if what == "move"
                && let Some(recording) = self.recording.take()
            {
                recording.abandon();
                self.shared.known(|known| known.recording = None);
            }
            return self.say(Tone::Refused, what, why);
        }
        match what {
            "stop" => {}
            _ if text.starts_with("warn") => self.say(Tone::Warning, what, text),
            "arm" | "disarm" => {}
            _ => self.say(Tone::Done, what, text),
        }
    }
}
