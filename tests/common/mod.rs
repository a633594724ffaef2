//! A virtual device on any rig, and a terminal on its line.

use link::{Decoder, Frame, Item, reply};
use plant::RigConfig;
use tribos_firmware::{VirtualConfig, VirtualDevice};

pub struct Bench {
    pub device: VirtualDevice,
    decoder: Decoder,
    #[allow(dead_code)] // not every test streams
    pub frames: Vec<(u32, Frame)>,
}

impl Bench {
    pub fn new(rig: RigConfig, seed: u64) -> Self {
        let device = VirtualDevice::new(&VirtualConfig { seed, rig }).expect("a rig");
        let mut bench = Self { device, decoder: Decoder::new(), frames: Vec::new() };
        bench.run(200);
        bench
    }

    pub fn run(&mut self, periods: u32) -> Vec<String> {
        let (mut bytes, mut lines) = (Vec::new(), Vec::new());
        for _ in 0..periods {
            self.device.tick();
        }
        self.device.read(&mut bytes);
        for byte in bytes {
            match self.decoder.push(byte) {
                Some(Item::Text(line)) => lines.push(line.to_owned()),
                Some(Item::Frame(seq, frame)) => self.frames.push((seq, frame)),
                Some(Item::Corrupt(_)) | None => {}
            }
        }
        lines
    }

    /// Half a line before a power cut is no line after it.
    #[allow(dead_code)] // not every test cuts the power
    pub fn forget_line(&mut self) {
        self.decoder = Decoder::new();
    }

    /// The answer and the lines that belong to it.
    pub fn ask(&mut self, command: &str) -> Vec<String> {
        self.device.write(format!("{command}\n").as_bytes());
        let mut lines = Vec::new();
        for _ in 0..4_000 {
            lines.extend(self.run(1));
            let Some(at) = lines.iter().position(|line| reply::is_answer(line)) else { continue };
            let end = at + 1 + reply::lines_to_follow(&lines[at]);
            if lines.len() >= end {
                return lines[at..end].to_vec();
            }
        }
        panic!("`{command}` was not answered: {lines:?}");
    }

    pub fn say(&mut self, command: &str) -> String {
        self.ask(command).swap_remove(0)
    }
}
