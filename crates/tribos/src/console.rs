//! The console of `connect`: live plot, answers, and command line; plain lines without a terminal.

use crate::failure::{Failure, Result};
use client::{Event, Sample, Session, Streams};
use ratatui::crossterm::event::{self, Event as Key, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph};
use ratatui::{DefaultTerminal, Frame};
use std::collections::VecDeque;
use std::io::{BufRead, Write};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

/// Length of the plot, s.
const WINDOW_S: f64 = 5.0;
/// Number of plotted points, more than the width of a terminal.
const MAX_POINTS: usize = 2000;
/// Number of answer lines kept.
const MAX_LINES: usize = 500;
/// Longest line accepted by the device, characters.
const MAX_INPUT: usize = 200;

/// What the screen shows.
#[derive(Debug, Default)]
struct Screen {
    points: VecDeque<Sample>,
    lines: VecDeque<String>,
    input: String,
    history: Vec<String>,
    recalled: usize,
    lost: u64,
}

impl Screen {
    fn take(&mut self, event: Event) {
        match event {
            Event::Text(line) => self.say(line),
            Event::Header(header) => {
                self.points.clear();
                self.say(header.describe());
            }
            Event::Sample(sample) => {
                let newest = sample.time;
                // more points than the terminal has columns show nothing more
                let apart = WINDOW_S / MAX_POINTS as f64;
                if self.points.back().is_some_and(|last| (0.0..apart).contains(&(newest - last.time))) {
                    return;
                }
                self.points.push_back(sample);
                while self.points.len() > MAX_POINTS
                    || self.points.front().is_some_and(|p| p.time < newest - WINDOW_S)
                {
                    self.points.pop_front();
                }
            }
            Event::Lost(frames) => self.lost += frames,
        }
    }

    fn say(&mut self, line: String) {
        self.lines.push_back(line);
        if self.lines.len() > MAX_LINES {
            self.lines.pop_front();
        }
    }

    /// Handles a key. `None` ends the console.
    fn key(&mut self, code: KeyCode, control: bool) -> Option<Option<String>> {
        match code {
            KeyCode::Esc => return self.off(),
            KeyCode::Char(' ') if self.input.is_empty() => return self.off(),
            KeyCode::Char('c' | 'd') if control => return None,
            KeyCode::Char('q') if self.input.is_empty() => return None,
            KeyCode::Char(c) if !control && self.input.chars().count() < MAX_INPUT => self.input.push(c),
            KeyCode::Backspace => {
                self.input.pop();
            }
            KeyCode::Up => {
                self.recalled = (self.recalled + 1).min(self.history.len());
                self.recall();
            }
            KeyCode::Down => {
                self.recalled = self.recalled.saturating_sub(1);
                self.recall();
            }
            KeyCode::Enter if !self.input.trim().is_empty() => {
                let line = std::mem::take(&mut self.input);
                self.recalled = 0;
                self.history.push(line.clone());
                self.say(format!("> {line}"));
                return Some(Some(line));
            }
            _ => {}
        }
        Some(None)
    }

    /// The command that takes the force away. What is typed stays.
    fn off(&mut self) -> Option<Option<String>> {
        self.say("> off".into());
        Some(Some("off".into()))
    }

    fn recall(&mut self) {
        let at = self.history.len().checked_sub(self.recalled);
        self.input = at.and_then(|at| self.history.get(at)).cloned().unwrap_or_default();
    }

    fn draw(&self, frame: &mut Frame) {
        let area = frame.area();
        let text_height = (area.height / 3).clamp(3, 14);
        let [plots, answers, input, foot] = Layout::vertical([
            Constraint::Min(6),
            Constraint::Length(text_height),
            Constraint::Length(3),
            Constraint::Length(1),
        ])
        .areas(area);
        if self.points.len() < 2 {
            let hint = "No stream yet: type  stream on 10  to see the handle move.";
            frame.render_widget(Paragraph::new(hint).block(Block::bordered().title(" live ")), plots);
        } else {
            let [a, b, c] = Layout::vertical([Constraint::Fill(1); 3]).areas(plots);
            self.plot(frame, a, "position, mm", Color::Cyan, |p| 1e3 * p.position);
            self.plot(frame, b, "velocity, mm/s", Color::Green, |p| 1e3 * p.velocity);
            self.plot(frame, c, "force, N", Color::Yellow, |p| p.command);
        }
        let shown = usize::from(answers.height.saturating_sub(2));
        let skip = self.lines.len().saturating_sub(shown);
        let lines: Vec<Line> = self.lines.iter().skip(skip).map(|l| paint(l)).collect();
        frame.render_widget(Paragraph::new(lines).block(Block::bordered().title(" device ")), answers);
        let typed = Paragraph::new(format!("{}▏", self.input)).block(Block::bordered().title(" command "));
        frame.render_widget(typed, input);
        let lost = if self.lost > 0 { format!("   {} frames lost", self.lost) } else { String::new() };
        let keys = format!(
            " Esc or space: force off · Enter sends · ↑↓ recall · help lists the commands · Ctrl-C quits{lost}"
        );
        frame.render_widget(Paragraph::new(keys).style(Style::new().add_modifier(Modifier::DIM)), foot);
    }

    fn plot(
        &self,
        frame: &mut Frame,
        area: Rect,
        title: &str,
        colour: Color,
        value: impl Fn(&Sample) -> f64,
    ) {
        let data: Vec<(f64, f64)> = self.points.iter().map(|p| (p.time, value(p))).collect();
        let newest = data.last().map_or(0.0, |d| d.0);
        let (mut low, mut high) =
            data.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d.1), h.max(d.1)));
        if !(low.is_finite() && high.is_finite()) {
            (low, high) = (-1.0, 1.0);
        }
        let room = 0.05 * (high - low).max(1e-3);
        (low, high) = (low - room, high + room);
        let dataset = Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::new().fg(colour))
            .data(&data);
        let labels = [format!("{low:>8.2}"), format!("{high:>8.2}")];
        let chart = Chart::new(vec![dataset])
            .block(Block::bordered().title(format!(" {title}  {:.3} ", data.last().map_or(0.0, |d| d.1))))
            .x_axis(Axis::default().bounds([newest - WINDOW_S, newest]))
            .y_axis(Axis::default().bounds([low, high]).labels(labels));
        frame.render_widget(chart, area);
    }
}

/// Style of an answer by its first word: errors stand out.
fn paint(line: &str) -> Line<'_> {
    let colour = if line.starts_with("err") {
        Color::Red
    } else if line.starts_with("ok warn") {
        Color::Yellow
    } else if line.starts_with('>') {
        Color::DarkGray
    } else {
        Color::Reset
    };
    Line::from(Span::styled(line, Style::new().fg(colour)))
}

/// Passes an event on to the live streams.
fn pass(event: &Event, live: &mut Streams) {
    match event {
        Event::Header(header) => live.header(header),
        Event::Sample(sample) => live.sample(sample),
        _ => {}
    }
}

/// Runs the full-screen console until the user leaves it.
///
/// # Errors
/// The line or the terminal failed. The terminal is restored first.
pub(crate) fn screen(session: &mut Session, name: &str, live: &mut Streams) -> Result<()> {
    let mut terminal =
        ratatui::try_init().map_err(|e| Failure::new(format!("the terminal cannot be used: {e}")))?;
    let ended = run(&mut terminal, session, name, live);
    ratatui::restore();
    ended
}

fn run(terminal: &mut DefaultTerminal, session: &mut Session, name: &str, live: &mut Streams) -> Result<()> {
    let lost = |e: std::io::Error| Failure::new(format!("the terminal is gone: {e}"));
    let mut screen = Screen::default();
    session.in_real_time();
    screen.say(format!("connected to {name}"));
    session.send_line("version")?;
    session.send_line(if live.is_any() { "stream on" } else { "stream on 10" })?;
    let mut drawn = Instant::now() - Duration::from_secs(1);
    loop {
        for event in session.poll()? {
            pass(&event, live);
            screen.take(event);
        }
        if drawn.elapsed() >= Duration::from_millis(33) {
            terminal.draw(|frame| screen.draw(frame)).map_err(lost)?;
            drawn = Instant::now();
        }
        while event::poll(Duration::from_millis(2)).map_err(lost)? {
            let Key::Key(key) = event::read().map_err(lost)? else { continue };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            match screen.key(key.code, key.modifiers.contains(KeyModifiers::CONTROL)) {
                None => {
                    // leave the line with text only, as found
                    session.send_line("stream off")?;
                    return Ok(());
                }
                Some(Some(line)) => session.send_line(&line)?,
                Some(None) => {}
            }
        }
    }
}

/// Lines of standard input, as they are typed.
fn typed_lines() -> Receiver<std::io::Result<String>> {
    let (typed, lines) = sync_channel(0);
    // it ends with the input, or with the program
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            if typed.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Line mode: sends each line of standard input and prints the answer, until the input ends. A live stream goes on between
/// the lines.
///
/// # Errors
/// The line failed, or a line of input is not text.
pub(crate) fn lines(session: &mut Session, live: &mut Streams) -> Result<()> {
    let mut out = std::io::stdout().lock();
    if live.is_any() {
        session.in_real_time();
        session.command("stream on")?;
    }
    let typed = typed_lines();
    loop {
        let line = if live.is_any() {
            for event in session.poll()? {
                pass(&event, live);
            }
            typed.try_recv()
        } else {
            typed.recv().map_err(|_| TryRecvError::Disconnected)
        };
        let line = match line {
            Ok(line) => line.map_err(|e| Failure::new(format!("standard input: {e}")))?,
            Err(TryRecvError::Empty) => continue,
            Err(TryRecvError::Disconnected) => break,
        };
        let line = line.trim();
        if matches!(line, "quit" | "exit") {
            break;
        }
        if line.is_empty() {
            continue;
        }
        for answer in session.exchange(line)? {
            if writeln!(out, "{answer}").is_err() {
                return Ok(());
            }
        }
    }
    if live.is_any() {
        session.command("stream off")?;
        for event in session.poll()? {
            pass(&event, live);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn typed(screen: &mut Screen, text: &str) {
        for c in text.chars() {
            screen.key(KeyCode::Char(c), false);
        }
    }

    #[test]
    fn keys_edit_send_recall_and_quit() {
        let mut screen = Screen::default();
        typed(&mut screen, "preset lisq");
        screen.key(KeyCode::Backspace, false);
        typed(&mut screen, "t");
        assert_eq!(screen.key(KeyCode::Enter, false), Some(Some("preset list".into())));
        screen.key(KeyCode::Up, false);
        assert_eq!(screen.input, "preset list");
        screen.key(KeyCode::Down, false);
        assert_eq!(screen.input, "");
        assert_eq!(screen.key(KeyCode::Char('q'), false), None);
        typed(&mut screen, "se");
        assert_eq!(screen.key(KeyCode::Char('q'), false), Some(None), "q inside a word is a letter");
        for key in [KeyCode::Esc, KeyCode::Char(' ')] {
            screen.input.clear();
            assert_eq!(screen.key(key, false), Some(Some("off".into())), "{key:?}");
        }
        typed(&mut screen, "set dv");
        assert_eq!(screen.key(KeyCode::Char(' '), false), Some(None), "a space inside a command");
        assert_eq!(screen.key(KeyCode::Esc, false), Some(Some("off".into())));
        assert_eq!(screen.input, "set dv ");
        assert_eq!(screen.key(KeyCode::Char('c'), true), None);
    }

    #[test]
    fn draws_motion_and_answers_at_any_size() {
        let mut screen = Screen::default();
        for k in 0..3000 {
            let t = f64::from(k) * 1e-2;
            screen.take(Event::Sample(Sample {
                time: t,
                position: 0.01 * t.sin(),
                command: f64::NAN,
                ..Sample::default()
            }));
        }
        screen.say("err RANGE: f_static".into());
        assert!(screen.points.iter().all(|p| p.time >= 29.99 - WINDOW_S));
        for (width, height) in [(100, 40), (20, 6), (1, 1)] {
            let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
            terminal.draw(|frame| screen.draw(frame)).unwrap();
            if width == 100 {
                let drawn = format!("{}", terminal.backend());
                assert!(drawn.contains("position, mm") && drawn.contains("err RANGE"), "{drawn}");
            }
        }
    }
}
