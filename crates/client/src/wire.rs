//! Decodes bytes into text, headers and samples, and counts losses.

use crate::sample::{Calibration, Header, Raw};
use link::{Decoder, Frame};

/// Decoded item.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Item {
    /// A line of text.
    Text(String),
    /// Start of a stream.
    Header(Header),
    /// A sample.
    Sample(Raw),
    /// Number of samples lost.
    Lost(u64),
}

/// Decoder of a line.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wire {
    decoder: Decoder,
    /// Next expected sequence number.
    next: Option<u32>,
}

impl Wire {
    /// Decodes bytes into complete items.
    pub(crate) fn decode(&mut self, bytes: &[u8]) -> Vec<Item> {
        let mut items = Vec::new();
        for byte in bytes {
            match self.decoder.push(*byte) {
                Some(link::Item::Text(line)) => items.push(Item::Text(line.to_owned())),
                Some(link::Item::Frame(seq, frame)) => match frame {
                    Frame::Header(header) => {
                        self.next = Some(seq.wrapping_add(1));
                        items.push(Item::Header(of_header(&header)));
                    }
                    Frame::Sample(sample) => {
                        let missing = seq.wrapping_sub(self.next.unwrap_or(seq));
                        if missing > 0 {
                            items.push(Item::Lost(u64::from(missing)));
                        }
                        self.next = Some(seq.wrapping_add(1));
                        let raw = Raw {
                            sample_ticks: sample.sample_ticks,
                            count: sample.count as u32,
                            edge_ticks: sample.edge_ticks(),
                            load_code: sample.load_code,
                            accel_code: sample.accel_code,
                            command: sample.force,
                            reference: sample.reference,
                            mode: sample.mode,
                            fault: sample.fault,
                            referenced: sample.referenced,
                        };
                        items.push(Item::Sample(raw));
                    }
                },
                // a corrupt frame shows as a gap in the sequence; a corrupt line is ignored
                Some(link::Item::Corrupt(_)) | None => {}
            }
        }
        items
    }
}

fn of_header(h: &link::Header) -> Header {
    Header {
        calibration: Calibration {
            tick_hz: f64::from(h.tick_hz),
            metre_per_count: f64::from(h.metre_per_count),
            origin_count: h.origin_count,
            load_offset: f64::from(h.load.offset_code),
            load_unit: f64::from(h.load.unit_per_code),
            accel_offset: f64::from(h.accel.offset_code),
            accel_unit: f64::from(h.accel.unit_per_code),
        },
        decimation: h.decimation,
        period: f64::from(h.period_ticks) / f64::from(h.tick_hz),
        preset: h.preset.to_string(),
        mechanics: h.mechanics,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tribos_firmware::VirtualDevice;

    #[test]
    fn a_gap_in_the_sequence_is_counted_and_nothing_else_is() {
        let mut device = VirtualDevice::new(&Default::default()).unwrap();
        device.write(b"stream on\n");
        let mut bytes = Vec::new();
        for _ in 0..100 {
            device.tick();
            device.read(&mut bytes);
        }
        let whole = Wire::default().decode(&bytes);
        let samples = |items: &[Item]| items.iter().filter(|i| matches!(i, Item::Sample(..))).count();
        assert!(matches!(&whole[0], Item::Text(line) if line.starts_with("ok stream on")));
        assert!(matches!(&whole[1], Item::Header(header) if header.period == 1e-3));
        assert!(!whole.iter().any(|i| matches!(i, Item::Lost(_))));
        // 200 bytes cut from the middle: some frames are lost, and one at either side is corrupt
        bytes.drain(1000..1200);
        let holed = Wire::default().decode(&bytes);
        let lost: u64 = holed.iter().map(|i| if let Item::Lost(n) = i { *n } else { 0 }).sum();
        println!("{} samples, {lost} lost", samples(&holed));
        assert!(lost > 0);
        assert_eq!(samples(&holed) as u64 + lost, samples(&whole) as u64);
    }
}
