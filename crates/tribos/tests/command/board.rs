//! Commands of the book that need a board: run against the virtual device on a pseudo-terminal, in the order of the page.

use serialport::{SerialPort, TTYPort};
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tribos_firmware::VirtualDevice;
use tribos_firmware::board::simulated::Holder;

/// Seconds of a recording, instead of those of the book: the device runs in real time.
const SECONDS: &str = "6";
/// What waits for a person; `crates/tribos/tests/lab` and `live.rs` run these.
const INTERACTIVE: [&str; 2] = ["connect", "lab"];

/// A virtual device at the other end of a line, in real time.
struct Line {
    name: String,
    /// A hand moves the handle to and fro.
    is_held: Arc<AtomicBool>,
    is_closed: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Line {
    fn open() -> Self {
        let mut device = VirtualDevice::new(&Default::default()).expect("a device");
        device.home().expect("both stops");
        let (mut ours, theirs) = TTYPort::pair().expect("a pseudo-terminal");
        let name = theirs.name().expect("its name");
        ours.set_timeout(Duration::from_millis(1)).expect("a time-out");
        let [is_held, is_closed] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        let (held, closed) = (is_held.clone(), is_closed.clone());
        let thread = std::thread::spawn(move || {
            let _theirs = theirs;
            let (mut due, mut out, mut chunk) = (Instant::now(), Vec::new(), [0; 512]);
            let mut holds = false;
            while !closed.load(Ordering::SeqCst) {
                if let Ok(count) = ours.read(&mut chunk) {
                    device.write(&chunk[..count]);
                }
                if held.load(Ordering::SeqCst) != holds {
                    holds = !holds;
                    device.hold(if holds { Holder::to_and_fro(0.01, 0.8) } else { Holder::Nobody });
                }
                while due <= Instant::now() {
                    device.tick();
                    due += Duration::from_millis(1);
                }
                device.read(&mut out);
                // a line that is full waits
                while let Ok(count @ 1..) = ours.write(&out) {
                    out.drain(..count);
                }
            }
        });
        Self { name, is_held, is_closed, thread: Some(thread) }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.is_closed.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Words of a command line; double quotes hold blanks together.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    parts
        .flat_map(|(i, part)| match i % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect::<Vec<_>>(),
            _ => vec![part.to_owned()],
        })
        .collect()
}

/// Commands in the `text` blocks of a page, without what follows a `#`.
fn commands(page: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(page).expect("a page");
    let blocks = text.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next());
    let lines = blocks.flat_map(str::lines).filter(|line| line.starts_with("tribos "));
    lines.map(|line| words(line.split(" # ").next().unwrap_or(line))).collect()
}

#[test]
fn commands_for_a_board_run_on_the_virtual_device() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book");
    let mut pages: Vec<_> =
        fs::read_dir(book).expect("the book").map(|e| e.expect("an entry").path()).collect();
    pages.retain(|page| page.extension().is_some_and(|e| e == "md"));
    pages.sort();
    let mut ran = 0;
    for page in pages {
        let commands = commands(&page);
        if commands.iter().all(|words| INTERACTIVE.contains(&&*words[1])) {
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let line = Line::open();
        for mut words in commands {
            if INTERACTIVE.contains(&&*words[1]) {
                continue;
            }
            let asked = words.join(" ");
            for i in 0..words.len() {
                if words[i].starts_with("/dev/") {
                    words[i].clone_from(&line.name);
                } else if words[i] == "--seconds" {
                    words[i + 1] = SECONDS.to_owned();
                }
            }
            // what renders is moved by a hand, as the page says
            line.is_held.store(words.iter().any(|word| word == "--preset"), Ordering::SeqCst);
            let done = Command::new(env!("CARGO_BIN_EXE_tribos"))
                .args(&words[1..])
                .current_dir(folder.path())
                .output()
                .expect("tribos runs");
            let said = String::from_utf8_lossy(&done.stderr);
            println!("{}: `{asked}`: {}", page.display(), done.status);
            assert!(done.status.success(), "{}: `{asked}`: {said}", page.display());
            for pair in words.windows(2).filter(|pair| ["--out", "--report"].contains(&&*pair[0])) {
                assert!(folder.path().join(&pair[1]).exists(), "`{asked}` wrote no {}", pair[1]);
            }
            ran += 1;
        }
    }
    assert!(ran >= 10, "{ran} commands: blocks are not read");
}
