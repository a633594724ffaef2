//! Binary batches of samples for the pages.
//!
//! ```text
//! header   16 bytes   kind u8 = 1 │ epoch u8 │ count u16 │ batch u32 │ lost samples u32 │ clock u32, ms
//! sample   32 bytes   time f64, s │ position, velocity, force, command, reference f32, SI │ mode u8 │ fault u8 │ 0 u16
//! ```
//!
//! Little endian. `epoch` changes when time restarts; `batch` counts up by one, so a page notices a lost batch.

use client::Sample;

/// First byte of a batch.
pub const KIND: u8 = 1;
/// Bytes before the first sample.
pub const HEADER: usize = 16;
/// Bytes of a sample.
pub const SAMPLE: usize = 32;

/// A batch being filled.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    samples: Vec<u8>,
    count: u16,
    next: u32,
}

impl Batch {
    /// Appends a sample.
    pub fn push(&mut self, s: &Sample) {
        self.samples.extend_from_slice(&s.time.to_le_bytes());
        for value in [s.position, s.velocity, s.force, s.command, s.reference] {
            self.samples.extend_from_slice(&(value as f32).to_le_bytes());
        }
        self.samples.extend_from_slice(&[s.mode, s.fault, 0, 0]);
        self.count = self.count.saturating_add(1);
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        usize::from(self.count)
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The bytes to send; starts the next batch.
    pub fn take(&mut self, epoch: u8, lost: u64, clock_ms: u32) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + self.samples.len());
        bytes.extend_from_slice(&[KIND, epoch]);
        bytes.extend_from_slice(&self.count.to_le_bytes());
        bytes.extend_from_slice(&self.next.to_le_bytes());
        bytes.extend_from_slice(&u32::try_from(lost).unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend_from_slice(&clock_ms.to_le_bytes());
        bytes.append(&mut self.samples);
        self.count = 0;
        self.next = self.next.wrapping_add(1);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_batch_is_what_the_page_reads() {
        let mut batch = Batch::default();
        let sample = Sample { time: 1.5, position: -2e-3, mode: 1, fault: 3, ..Sample::default() };
        batch.push(&Sample::default());
        batch.push(&sample);
        assert_eq!(batch.len(), 2);
        let bytes = batch.take(7, 9, 1000);
        assert_eq!(bytes.len(), HEADER + 2 * SAMPLE);
        assert_eq!(&bytes[..16], &[1, 7, 2, 0, 0, 0, 0, 0, 9, 0, 0, 0, 232, 3, 0, 0]);
        let second = &bytes[HEADER + SAMPLE..];
        assert_eq!(f64::from_le_bytes(second[..8].try_into().unwrap()), 1.5);
        assert_eq!(f32::from_le_bytes(second[8..12].try_into().unwrap()), -2e-3);
        assert_eq!(&second[28..], &[1, 3, 0, 0]);
        assert!(batch.is_empty());
        assert_eq!(batch.take(7, 0, 0)[4], 1, "batches are counted");
    }
}
