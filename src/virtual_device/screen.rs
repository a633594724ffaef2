//! Console at a terminal: scrolling answers, one live line, and the command line.

use super::running::Running;
use crossterm::cursor::{MoveToColumn, MoveUp};
use crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use crossterm::style::{Print, Stylize};
use crossterm::terminal::{self, Clear, ClearType};
use crossterm::{execute, queue};
use haptics::ModeId;
use std::io::{Stdout, Write, stdout};
use std::time::{Duration, Instant};
use tribos_firmware::VirtualDevice;
use tribos_firmware::board::simulated::Holder;

/// Updates of the live line per second.
const RATE: Duration = Duration::from_millis(50);
/// Width of the stroke display, characters.
const TRACK: usize = 31;

/// Guard of the raw mode.
struct Raw;

impl Raw {
    fn enter() -> std::io::Result<Self> {
        terminal::enable_raw_mode()?;
        Ok(Self)
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // nothing to do about a closed terminal
        let _ = terminal::disable_raw_mode();
        let _ = execute!(stdout(), Print("\r\n"));
    }
}

/// Runs until the user leaves.
///
/// # Errors
/// The terminal is gone.
pub fn run(mut running: Running, serial_line: &str) -> std::io::Result<()> {
    let mut console = Console { out: stdout(), typed: String::new(), history: Vec::new(), recalled: 0 };
    println!("tribos {}: the firmware on a simulated rig, 1 kHz", env!("CARGO_PKG_VERSION"));
    println!("{serial_line}");
    println!(
        "A simulated hand moves the handle back and forth; the device makes it feel like a block on rubber."
    );
    println!(
        "Type  help,  preset use teflon,  sim hand off,  render off …   Esc or space: force off. Ctrl-C leaves.\n"
    );
    running.device.hold(Holder::to_and_fro(0.008, 0.5));
    let _raw = Raw::enter()?;
    for command in ["preset use rubber", "render on"] {
        console.answer(command, &running.obey(command.as_bytes()))?;
    }
    let mut drawn = Instant::now();
    console.draw(&running.device)?;
    loop {
        let news = running.live();
        if !news.is_empty() {
            console.above(&news)?;
            console.draw(&running.device)?;
        }
        if drawn.elapsed() >= RATE {
            console.erase()?;
            console.draw(&running.device)?;
            drawn = Instant::now();
        }
        while event::poll(Duration::from_millis(1))? {
            let Event::Key(key) = event::read()? else { continue };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            match console.key(key.code, key.modifiers.contains(KeyModifiers::CONTROL)) {
                Typed::Leave => return Ok(()),
                Typed::Command(line) => {
                    let said = running.obey(line.as_bytes());
                    console.erase()?;
                    console.answer(&line, &said)?;
                    console.draw(&running.device)?;
                }
                Typed::More => {
                    console.erase()?;
                    console.draw(&running.device)?;
                }
            }
        }
    }
}

/// Result of a key.
enum Typed {
    More,
    Command(String),
    Leave,
}

struct Console {
    out: Stdout,
    typed: String,
    history: Vec<String>,
    recalled: usize,
}

impl Console {
    fn key(&mut self, code: KeyCode, control: bool) -> Typed {
        match code {
            KeyCode::Char('c' | 'd') if control => return Typed::Leave,
            KeyCode::Esc => return Typed::Command("off".to_owned()),
            KeyCode::Char(' ') if self.typed.is_empty() => return Typed::Command("off".to_owned()),
            KeyCode::Char(c) if !control => self.typed.push(c),
            KeyCode::Backspace => {
                self.typed.pop();
            }
            KeyCode::Up => {
                self.recalled = (self.recalled + 1).min(self.history.len());
                self.recall();
            }
            KeyCode::Down => {
                self.recalled = self.recalled.saturating_sub(1);
                self.recall();
            }
            KeyCode::Enter if matches!(self.typed.trim(), "quit" | "exit") => return Typed::Leave,
            KeyCode::Enter if !self.typed.trim().is_empty() => {
                self.history.push(self.typed.clone());
                self.recalled = 0;
                return Typed::Command(std::mem::take(&mut self.typed));
            }
            _ => {}
        }
        Typed::More
    }

    fn recall(&mut self) {
        let at = self.history.len() - self.recalled;
        self.typed = self.history.get(at).cloned().unwrap_or_default();
    }

    /// Removes live line and prompt.
    fn erase(&mut self) -> std::io::Result<()> {
        queue!(self.out, MoveToColumn(0), MoveUp(1), Clear(ClearType::FromCursorDown))
    }

    fn above(&mut self, lines: &[String]) -> std::io::Result<()> {
        self.erase()?;
        self.lines(lines)
    }

    fn lines(&mut self, lines: &[String]) -> std::io::Result<()> {
        for line in lines {
            let painted = match line.split([' ', ':']).next() {
                Some("err") => line.as_str().red(),
                Some("!") => line.as_str().yellow(),
                _ => line.as_str().stylize(),
            };
            queue!(self.out, Print(painted), Print("\r\n"))?;
        }
        Ok(())
    }

    fn answer(&mut self, command: &str, lines: &[String]) -> std::io::Result<()> {
        queue!(self.out, Print(format!("> {command}").dim()), Print("\r\n"))?;
        self.lines(lines)
    }

    fn draw(&mut self, device: &VirtualDevice) -> std::io::Result<()> {
        let width = terminal::size().map_or(80, |(columns, _)| usize::from(columns)).saturating_sub(1);
        let cut = |text: String| text.chars().take(width).collect::<String>();
        let prompt = cut(format!("> {}", self.typed));
        queue!(self.out, Print(cut(live_line(device)).cyan()), Print("\r\n"), Print(prompt))?;
        self.out.flush()
    }
}

/// Live line with handle, block, mode and force.
fn live_line(device: &VirtualDevice) -> String {
    let o = device.outputs();
    let half = 0.5 * f64::from(device.device().stroke);
    let place = |x: f32| {
        let share = (f64::from(x) / half).clamp(-1.0, 1.0);
        ((share + 1.0) * 0.5 * (TRACK - 1) as f64).round() as usize
    };
    let mut track = ['─'; TRACK];
    let rendering = o.mode == ModeId::Rendering;
    if rendering {
        track[place(o.block_position)] = '▒';
    }
    track[place(o.position)] = '●';
    let track: String = track.iter().collect();
    let state = match o.mode {
        ModeId::Rendering if o.stuck => "stuck",
        ModeId::Rendering => "sliding",
        mode => mode.id(),
    };
    let (handle, force) = (1e3 * o.position, o.force);
    let block = if rendering { format!("{:+7.2} mm", 1e3 * o.block_position) } else { "   none   ".into() };
    format!(
        "[{track}] handle {handle:+7.2} mm  block {block}  {state:<11} force {force:+6.2} N  {}",
        device.preset()
    )
}
