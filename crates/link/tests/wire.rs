//! Frames and text on one line, intact and corrupted.

use haptics::Device;
use link::{Channel, Corrupt, Decoder, Frame, Header, Item, MAX_WIRE, Mechanics, Sample, encode};
use proptest::prelude::*;

fn sample() -> impl Strategy<Value = Sample> {
    let words = (any::<u32>(), any::<u32>(), any::<i32>(), any::<u32>(), any::<u16>(), any::<u16>());
    let rest = (-1e3_f32..1e3, -1.0_f32..1.0, any::<u8>(), any::<u8>(), any::<u32>(), any::<bool>());
    (words, rest).prop_map(|(w, r)| Sample {
        step: w.0,
        sample_ticks: w.1,
        count: w.2,
        edge_age: w.3,
        load_code: w.4,
        accel_code: w.5,
        force: r.0,
        reference: r.1,
        mode: r.2,
        fault: r.3,
        dropped: r.4,
        referenced: r.5,
    })
}

/// An owned item, for comparison.
#[derive(Debug, PartialEq)]
enum Got {
    Text(String),
    Frame(u32, Frame),
    Corrupt(Corrupt),
}

fn decode(bytes: &[u8]) -> Vec<Got> {
    let mut decoder = Decoder::new();
    let mut got = Vec::new();
    for byte in bytes {
        match decoder.push(*byte) {
            Some(Item::Text(text)) => got.push(Got::Text(text.into())),
            Some(Item::Frame(seq, frame)) => got.push(Got::Frame(seq, frame)),
            Some(Item::Corrupt(corrupt)) => got.push(Got::Corrupt(corrupt)),
            None => {}
        }
    }
    got
}

#[test]
fn the_longest_frames_fit() {
    let device = Device::default();
    let channel = Channel { offset_code: device.load.offset_code, unit_per_code: device.load.unit_per_code };
    let header = Header {
        tick_hz: u32::MAX,
        period_ticks: u32::MAX,
        metre_per_count: device.metre_per_count,
        load: channel,
        accel: channel,
        decimation: u32::MAX,
        preset: "abcdefghijklmnopqrstuvwx".try_into().unwrap(),
        origin_count: i32::MIN,
        mechanics: Mechanics {
            rotary: true,
            stroke: 2.0,
            mass: 1e-4,
            damping: 1e-3,
            force_max: 0.2,
            overspeed: 60.0,
        },
    };
    let widest = Sample {
        step: u32::MAX,
        sample_ticks: u32::MAX,
        count: i32::MIN,
        edge_age: u32::MAX,
        load_code: u16::MAX,
        accel_code: u16::MAX,
        force: -9.48,
        reference: -0.01,
        mode: 255,
        fault: 255,
        referenced: true,
        dropped: u32::MAX,
    };
    for frame in [Frame::Header(header), Frame::Sample(widest)] {
        let wire = encode(u32::MAX, &frame).unwrap();
        println!("format {}: {} of {MAX_WIRE} bytes at most", frame.format(), wire.len());
        assert_eq!((wire[0], wire[wire.len() - 1]), (1, 0), "SOH first, zero last");
        assert!(!wire[..wire.len() - 1].contains(&0));
        assert_eq!(decode(&wire), [Got::Frame(u32::MAX, frame)]);
    }
}

proptest! {
    #[test]
    fn frames_and_text_come_back_as_they_were_sent(
        items in prop::collection::vec((any::<u32>(), sample(), "[ -~]{1,80}"), 1..20)
    ) {
        let mut wire = Vec::new();
        let mut expected = Vec::new();
        for (seq, sample, text) in items {
            wire.extend(encode(seq, &Frame::Sample(sample)).unwrap());
            wire.extend(text.as_bytes());
            wire.extend(b"\r\n");
            expected.extend([Got::Frame(seq, Frame::Sample(sample)), Got::Text(text)]);
        }
        prop_assert_eq!(decode(&wire), expected);
    }

    #[test]
    fn a_changed_byte_is_never_taken_for_data(sample in sample(), at in 0_usize..40, to: u8) {
        let mut wire = encode(7, &Frame::Sample(sample)).unwrap().to_vec();
        let at = at % wire.len();
        prop_assume!(wire[at] != to);
        wire[at] = to;
        for got in decode(&wire) {
            prop_assert!(!matches!(got, Got::Frame(..)), "{got:?}");
        }
    }

    #[test]
    fn whatever_was_lost_the_frame_after_the_next_end_is_read(garbage: Vec<u8>, sample in sample()) {
        let frame = encode(1, &Frame::Sample(sample)).unwrap();
        let mut wire = garbage;
        wire.extend([b'\n', 0]);
        wire.extend(&frame);
        prop_assert_eq!(decode(&wire).pop(), Some(Got::Frame(1, Frame::Sample(sample))));
    }
}
