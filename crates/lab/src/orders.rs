//! The queue of commands. One command is on the line at a time, so each answer belongs to it.

use link::reply;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Time in which a device must answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest queue. More commands come only from a faulty page.
const MAX_WAITING: usize = 200;

/// Purpose of a command, which says what its answer means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum About {
    Version,
    Get,
    /// The listing after a handover.
    Sent,
    Presets,
    Stream,
    /// The silence limit of the device, restored at the end.
    Watch,
    /// Whether a virtual device knows the middle of its stroke.
    Origin,
    /// Sent for a page; its name in an error.
    Page(&'static str),
    /// A parameter.
    Set,
    /// Sent by an experiment; the subject does not see its answer.
    Quiet,
    /// Position of the simulated hand; its answer is ignored.
    Hand,
}

/// One command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Order {
    pub line: String,
    pub about: About,
}

/// A complete answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Answer {
    pub order: Order,
    /// First line.
    pub first: String,
    /// The lines that follow.
    pub rest: Vec<String>,
}

/// Meaning of a line from the device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Reply {
    /// The last line of an answer.
    Answer(Answer),
    /// An unsolicited message.
    News(String),
    /// Part of an answer that is not complete.
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
    /// Number of answers to `off` that arrive outside the queue.
    offs: u32,
}

impl Orders {
    /// Appends a command. A queued position of the hand is replaced by the newest.
    pub fn push(&mut self, line: impl Into<String>, about: About) {
        let order = Order { line: line.into(), about };
        if order.about == About::Hand
            && let Some(old) = self.queue.iter_mut().find(|old| old.about == About::Hand)
        {
            old.line = order.line;
        } else if self.queue.len() < MAX_WAITING {
            self.queue.push_back(order);
        }
    }

    /// Drops the commands that are not sent yet.
    pub fn forget(&mut self) {
        self.queue.clear();
    }

    /// Starts over with another line.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Puts a command in front of all others.
    pub fn first(&mut self, line: impl Into<String>, about: About) {
        self.queue.push_front(Order { line: line.into(), about });
    }

    /// Notes that `off` was sent past the queue.
    pub fn sent_off(&mut self) {
        self.offs = self.offs.saturating_add(1);
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

    /// The command whose answer is overdue; given once.
    pub fn overdue(&mut self) -> Option<Order> {
        let late = self.waiting.as_ref().is_some_and(|waiting| waiting.since.elapsed() > PATIENCE);
        late.then(|| self.waiting.take().map(|waiting| waiting.order)).flatten()
    }

    /// Takes a line of the device.
    pub fn receive(&mut self, line: String) -> Reply {
        if reply::is_news(&line) {
            return Reply::News(line.trim_start_matches('!').trim().to_owned());
        }
        // it comes after the answer to what was on the line
        if self.offs > 0 && line.starts_with("ok off") {
            self.offs -= 1;
            return Reply::Nothing;
        }
        let Some(waiting) = &mut self.waiting else { return Reply::Nothing };
        if waiting.first.is_none() {
            if !reply::is_answer(&line) {
                return Reply::Nothing;
            }
            waiting.left = reply::lines_to_follow(&line);
            waiting.first = Some(line);
        } else {
            waiting.rest.push(line);
            waiting.left = waiting.left.saturating_sub(1);
        }
        if waiting.left > 0 {
            return Reply::Nothing;
        }
        match self.waiting.take() {
            Some(Waiting { order, first: Some(first), rest, .. }) => {
                Reply::Answer(Answer { order, first, rest })
            }
            _ => Reply::Nothing,
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
        assert_eq!(orders.receive("ok brass, 2 lines:".into()), Reply::Nothing);
        assert_eq!(
            orders.receive("! the motion has ended".into()),
            Reply::News("the motion has ended".into())
        );
        assert_eq!(orders.receive("  a 1".into()), Reply::Nothing);
        let Reply::Answer(answer) = orders.receive("  b 2".into()) else { panic!("an answer") };
        assert_eq!((answer.order.about, answer.rest.len()), (About::Get, 2));
        assert_eq!(orders.next().as_deref(), Some("sim hand at 0.002"), "the newest place");
        orders.sent_off();
        assert!(matches!(orders.receive("ok hand moves to 0.002 m".into()), Reply::Answer(_)));
        assert_eq!(
            orders.receive("ok off: the amplifier is off, rendering has ended".into()),
            Reply::Nothing
        );
    }
}
