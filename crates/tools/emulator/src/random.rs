//! Random numbers that are the same on every machine.

/// SplitMix64 [steele-2014].
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// Any 64 bits.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// 0 … `n` − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.draw() % n as u64) as usize
    }

    /// −`most` … `most`.
    pub fn within(&mut self, most: i32) -> i32 {
        (self.draw() % (2 * most as u64 + 1)) as i32 - most
    }

    /// 0 … 1.
    pub fn share(&mut self) -> f64 {
        self.draw() as f64 / u64::MAX as f64
    }

    /// Random word in which each bit is set with this chance of 256.
    pub fn bits(&mut self, chance: u64) -> u8 {
        (0..8).fold(0, |bits, bit| bits | u8::from(self.draw() & 0xff < chance) << bit)
    }
}
