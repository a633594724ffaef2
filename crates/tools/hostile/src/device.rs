//! The serial line, from both ends, and what a device finds in its flash.

use client::{Event, Session, Transport};
use link::{Decoder, PresetStore, decode_payload};
use tribos_firmware::VirtualDevice;
use tribos_firmware::board::simulated::flash::SimulatedFlash;

/// Longest simulated time of an input, ms.
const LONGEST_MS: usize = 300;

/// A device after its start.
pub(crate) fn virtual_device() -> VirtualDevice {
    VirtualDevice::new(&Default::default()).expect("the default device")
}

/// Lines to a device: each is answered, the force stays within the device's, and `off` still works.
pub(crate) fn console(bytes: &[u8]) {
    let mut device = virtual_device();
    device.write(bytes);
    let mut said = Vec::new();
    let mut run = |device: &mut VirtualDevice, ms: usize| {
        for _ in 0..ms {
            device.tick();
            device.read(&mut said);
            // nobody reads more than this at once
            said.clear();
            let (force, limit) = (device.outputs().force, device.device().force_max);
            assert!(force.abs() <= limit, "{force} N commanded, {limit} N accepted");
        }
    };
    run(&mut device, LONGEST_MS.min(20 + bytes.len()));
    device.write(b"\noff\n");
    run(&mut device, 2);
    assert!(!device.outputs().amplifier, "`off` is not obeyed");
}

/// A transport that gives these bytes.
struct Given(Vec<u8>);

impl Transport for Given {
    fn send(&mut self, _: &[u8]) -> client::Result<()> {
        Ok(())
    }

    fn receive(&mut self, out: &mut Vec<u8>) -> client::Result<()> {
        out.append(&mut self.0);
        Ok(())
    }
}

/// Checksum of a frame, as `link` documents it.
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);

/// Frames with a right checksum, of bodies that are length, format id and content, one behind the other.
fn framed(bytes: &[u8]) -> Vec<u8> {
    let (mut wire, mut rest) = (Vec::new(), bytes);
    while let [length, after @ ..] = rest {
        let (body, behind) = after.split_at(usize::from(*length).min(after.len()));
        let mut payload = [&[0], body].concat();
        payload.extend(CRC.checksum(&payload).to_le_bytes());
        assert!(
            body.first().is_some_and(|format| matches!(format, 4 | 5)) || decode_payload(&payload).is_none()
        );
        let mut encoded = vec![0; cobs::max_encoding_length(payload.len())];
        let used = cobs::encode(&payload, &mut encoded);
        wire.extend(&encoded[..used]);
        wire.push(0);
        rest = behind;
    }
    wire
}

/// The bodies of the frames in what a device sent: what [`framed`] takes.
pub(crate) fn bodies(said: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for frame in said.split(|byte| *byte == 0) {
        let mut payload = frame.to_vec();
        let Ok(length) = cobs::decode_in_place(&mut payload) else { continue };
        if let [0, body @ .., _, _] = &payload[..length] {
            out.push(u8::try_from(body.len()).unwrap_or(u8::MAX));
            out.extend(body);
        }
    }
    out
}

/// Bytes from a device: lines, headers and samples; and frames of these bytes whose checksum is right.
pub(crate) fn frame(bytes: &[u8]) {
    received(bytes);
    received(&framed(bytes));
}

fn received(bytes: &[u8]) {
    let mut decoder = Decoder::default();
    for byte in bytes {
        let _ = decoder.push(*byte);
    }
    let mut session = Session::over("line", Box::new(Given(bytes.to_vec())));
    for event in session.poll().expect("this line does not fail") {
        if let Event::Header(header) = event {
            let _ = (header.describe(), header.notes(), header.device().unreferenced_force());
        }
    }
}

/// The flash of a device, as it starts; and items of it: key, length and content, one behind the other.
pub(crate) fn flash(bytes: &[u8]) {
    match VirtualDevice::with_flash(&Default::default(), SimulatedFlash::of(bytes)) {
        Ok(mut device) => {
            device.write(b"preset list\nrender on\n");
            for _ in 0..20 {
                device.tick();
            }
        }
        Err(unfit) => crate::one_line::is_one_line(&unfit.to_string()),
    }
    let mut store = PresetStore::default();
    let mut rest = bytes;
    while let [key, length, after @ ..] = rest {
        let (item, behind) = after.split_at(usize::from(*length).min(after.len()));
        store.load(*key, item);
        rest = behind;
    }
    let _ = store.loaded();
    let names: Vec<String> = store.names().map(str::to_owned).collect();
    for name in &names {
        if let Ok(settings) = store.find(name) {
            let _ = settings.validate(&haptics::Device::default());
        }
    }
}
