//! Commands that wait for their turn: one is on the line at a time, and its answer is known to be its own.

use link::reply;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long a device may take to answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Commands that may wait; more come from a page gone wild.
const MOST: usize = 200;

/// Why a command was sent; what its answer means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum About {
    Version,
    Get,
    Presets,
    Stream,
    /// How long the device waits for a host; put back at the end.
    Watch,
    /// A page asked for it: what it is called, if it goes wrong.
    Page(&'static str),
    /// A parameter.
    Set,
    /// An experiment's; the subject is not to read its answer.
    Quiet,
    /// The simulated hand; its answer tells nothing.
    Hand,
}

/// One command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Order {
    pub line: String,
    pub about: About,
}

/// An answer, whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Answer {
    pub order: Order,
    /// First line.
    pub first: String,
    /// Those that follow.
    pub rest: Vec<String>,
}

/// What a line was.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Heard {
    /// The end of an answer.
    Answer(Answer),
    /// News nobody asked for.
    News(String),
    /// Part of something longer.
    Nothing,
}

struct Waiting {
    order: Order,
    since: Instant,
    first: Option<String>,
    rest: Vec<String>,
    left: usize,
}

/// The queue.
#[derive(Default)]
pub(crate) struct Orders {
    queue: VecDeque<Order>,
    waiting: Option<Waiting>,
}

impl Orders {
    /// Puts a command at the end. A hand that has not moved yet goes to the newest place at once.
    pub fn push(&mut self, line: impl Into<String>, about: About) {
        let order = Order { line: line.into(), about };
        if order.about == About::Hand
            && let Some(old) = self.queue.iter_mut().find(|old| old.about == About::Hand)
        {
            old.line = order.line;
        } else if self.queue.len() < MOST {
            self.queue.push_back(order);
        }
    }

    /// Forgets what was not sent yet.
    pub fn forget(&mut self) {
        self.queue.clear();
    }

    /// The line is another one.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Puts a command before all others.
    pub fn first(&mut self, line: impl Into<String>, about: About) {
        self.queue.push_front(Order { line: line.into(), about });
    }

    /// The next command to send, if none is on the line.
    pub fn next(&mut self) -> Option<String> {
        if self.waiting.is_some() {
            return None;
        }
        let order = self.queue.pop_front()?;
        let line = order.line.clone();
        self.waiting = Some(Waiting { order, since: Instant::now(), first: None, rest: Vec::new(), left: 0 });
        Some(line)
    }

    /// The command that was never answered.
    pub fn overdue(&mut self) -> Option<Order> {
        let late = self.waiting.as_ref().is_some_and(|waiting| waiting.since.elapsed() > PATIENCE);
        late.then(|| self.waiting.take().map(|waiting| waiting.order)).flatten()
    }

    /// Takes a line of the device.
    pub fn hear(&mut self, line: String) -> Heard {
        if reply::is_news(&line) {
            return Heard::News(line.trim_start_matches('!').trim().to_owned());
        }
        let Some(waiting) = &mut self.waiting else { return Heard::Nothing };
        if waiting.first.is_none() {
            if !reply::is_answer(&line) {
                return Heard::Nothing;
            }
            waiting.left = reply::lines_to_follow(&line);
            waiting.first = Some(line);
        } else {
            waiting.rest.push(line);
            waiting.left = waiting.left.saturating_sub(1);
        }
        if waiting.left > 0 {
            return Heard::Nothing;
        }
        match self.waiting.take() {
            Some(Waiting { order, first: Some(first), rest, .. }) => {
                Heard::Answer(Answer { order, first, rest })
            }
            _ => Heard::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_answer_finds_its_command() {
        let mut orders = Orders::default();
        orders.push("get", About::Get);
        orders.push("sim hand at 0.001", About::Hand);
        orders.push("sim hand at 0.002", About::Hand);
        assert_eq!(orders.next().as_deref(), Some("get"));
        assert_eq!(orders.next(), None);
        assert_eq!(orders.hear("ok brass, 2 lines:".into()), Heard::Nothing);
        assert_eq!(orders.hear("! the motion has ended".into()), Heard::News("the motion has ended".into()));
        assert_eq!(orders.hear("  a 1".into()), Heard::Nothing);
        let Heard::Answer(answer) = orders.hear("  b 2".into()) else { panic!("an answer") };
        assert_eq!((answer.order.about, answer.rest.len()), (About::Get, 2));
        orders.first("stop", About::Page("stop"));
        assert_eq!(orders.next().as_deref(), Some("stop"));
        orders.hear("ok stop".into());
        assert_eq!(orders.next().as_deref(), Some("sim hand at 0.002"), "the newest place");
    }
}
