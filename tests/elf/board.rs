//! The firmware's ELF on the emulated board, and a terminal on its serial line.

use crate::witness;
use emulator::firmware::{self, BuildError};
use emulator::{Image, Machine};
use link::{Decoder, Frame, Item, Sample, reply};
use plant::RigConfig;
use plant::materials::Material;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use untested::Need;

/// A compiler for the board.
pub static TOOLCHAIN: Need = Need::new(|| firmware::missing(Path::new(env!("CARGO_MANIFEST_DIR"))));

/// The image, built once for all tests.
pub fn image() -> &'static Image {
    static IMAGE: LazyLock<Image> = LazyLock::new(|| built(firmware::build));
    &IMAGE
}

/// The image with the absolute encoder, built once for all tests.
pub fn image_with_absolute_encoder() -> &'static Image {
    static IMAGE: LazyLock<Image> =
        LazyLock::new(|| built(|root, target| firmware::build_with(root, target, "absolute-encoder")));
    &IMAGE
}

/// The image that reads the encoder's index pulse, built once for all tests.
pub fn image_with_index_pulse() -> &'static Image {
    static IMAGE: LazyLock<Image> =
        LazyLock::new(|| built(|root, target| firmware::build_with(root, target, "index-pulse")));
    &IMAGE
}

/// The image with the absolute encoder and the converter of the load cell, built once for all tests.
pub fn image_with_both_sensors() -> &'static Image {
    const BOTH: &str = "absolute-encoder,load-cell-converter";
    static IMAGE: LazyLock<Image> =
        LazyLock::new(|| built(|root, target| firmware::build_with(root, target, BOTH)));
    &IMAGE
}

/// What this builds, given the workspace and the target directory.
pub fn built(build: impl Fn(&Path, &Path) -> Result<PathBuf, BuildError>) -> Image {
    // images with other features have the same path
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // …/target/debug/deps/elf-…: below the target directory that cargo was told to use
    let own = std::env::current_exe().expect("a test has a path");
    let target = own.ancestors().nth(3).expect("cargo's layout");
    let path = build(root, target).unwrap_or_else(|why| panic!("{why}"));
    Image::parse(&std::fs::read(path).expect("cargo built it")).expect("an image for this chip")
}

/// Where the presets are kept: the last 10 KiB.
const PRESETS: u32 = 0x0807_d800;

pub struct Board {
    pub machine: Machine,
    pub image: &'static Image,
    decoder: Decoder,
    pub lines: Vec<String>,
    pub frames: Vec<(u32, Frame)>,
    pub corrupt: usize,
}

impl Board {
    /// Powers a board up, with the rig of [thesis, ch. 3] and nothing on its handle.
    pub fn boot() -> Self {
        Self::of(Machine::free_handle(image(), 1))
    }

    /// A board whose handle is in the middle of its stroke, as a person tells it.
    pub fn ready() -> Self {
        let mut board = Self::boot();
        board.ok("zero");
        board
    }

    /// Powers a board up, with the handle at this position of the stroke, m.
    pub fn boot_at(start_position: f64) -> Self {
        let config = RigConfig { start_position, ..RigConfig::free_handle() };
        let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
        Self::of(Machine::boot(image(), config, no_block, 1).expect("a place in the stroke"))
    }

    /// Searches both stops; the result.
    pub fn home(&mut self) -> String {
        self.ok("home");
        for _ in 0..1_000 {
            self.run(10.0);
            let told = |line: &&String| line.starts_with("! home") || line.starts_with("! no home");
            if let Some(line) = self.lines.iter().find(told) {
                return line.clone();
            }
        }
        panic!("the search did not end within 10 s: {:?}", self.lines);
    }

    /// Powers a board up whose flash for presets holds this.
    pub fn with_presets(contents: &[u8]) -> Self {
        let mut machine = Machine::free_handle(image(), 1);
        machine.program_flash(PRESETS, contents);
        Self::of(machine)
    }

    /// What the flash for presets holds.
    pub fn presets(&self) -> Vec<u8> {
        self.machine.flash(PRESETS)
    }

    /// Powers a board up whose rig carries a block of this material, in the middle of the stroke; `None` without a compiler for it, unless CI is set.
    pub fn with_block(material: &Material) -> Option<Self> {
        if TOOLCHAIN.missing().is_some() && !untested::strict() {
            return None;
        }
        let config = RigConfig { block_mass: material.mass, ..RigConfig::default() };
        let machine = Machine::boot(image(), config, material.law, 1).expect("printed parameters");
        let mut board = Self::of(machine);
        board.ok("zero");
        Some(board)
    }

    /// A terminal at a machine with the firmware, 50 ms later.
    pub fn of(machine: Machine) -> Self {
        Self::with(image(), machine)
    }

    /// A terminal at a machine with this image, 50 ms later.
    pub fn with(image: &'static Image, mut machine: Machine) -> Self {
        witness::watch(&mut machine);
        let mut board = Self {
            machine,
            image,
            decoder: Decoder::new(),
            lines: Vec::new(),
            frames: Vec::new(),
            corrupt: 0,
        };
        board.run(50.0);
        board
    }

    pub fn run(&mut self, ms: f64) {
        self.machine.run_for(ms);
        witness::check(&self.machine);
        for byte in self.machine.serial_read() {
            match self.decoder.push(byte) {
                Some(Item::Text(line)) => self.lines.push(line.to_owned()),
                Some(Item::Frame(seq, frame)) => self.frames.push((seq, frame)),
                Some(Item::Corrupt(_)) => self.corrupt += 1,
                None => {}
            }
        }
    }

    /// Types bytes; the lines that came until `ms` after.
    pub fn say(&mut self, bytes: &[u8], ms: f64) -> Vec<String> {
        self.lines.clear();
        self.machine.serial_write(bytes);
        self.run(ms);
        self.lines.clone()
    }

    /// One command; its answer and the lines that belong to it.
    pub fn ask(&mut self, command: &str) -> Vec<String> {
        self.lines.clear();
        self.machine.serial_write(format!("{command}\n").as_bytes());
        for _ in 0..200 {
            self.run(5.0);
            let Some(at) = self.lines.iter().position(|line| reply::is_answer(line)) else { continue };
            let end = at + 1 + reply::lines_to_follow(&self.lines[at]);
            if self.lines.len() >= end {
                return self.lines[at..end].to_vec();
            }
        }
        panic!("`{command}` was not answered within 1 s: {:?}, {}", self.lines, self.machine.whereabouts());
    }

    /// One command that is obeyed.
    pub fn ok(&mut self, command: &str) -> String {
        let answer = self.ask(command).swap_remove(0);
        assert!(answer.starts_with("ok"), "{command}: {answer}");
        answer
    }

    pub fn samples(&self) -> impl Iterator<Item = (u32, Sample)> {
        self.frames.iter().filter_map(|(seq, frame)| match frame {
            Frame::Sample(sample) => Some((*seq, *sample)),
            Frame::Header(_) => None,
        })
    }
}
