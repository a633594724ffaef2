//! A device that does not know the middle of its stroke.

use crate::browser::Lab;
use crate::cable::Cable;
use haptics::ModeId;
use plant::RigConfig;
use serde_json::json;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tribos_firmware::{VirtualConfig, VirtualDevice};

/// A virtual device that has just started, 9 mm off the middle.
fn device() -> VirtualDevice {
    let rig = RigConfig { start_position: 0.009, ..RigConfig::free_handle() };
    VirtualDevice::new(&VirtualConfig { seed: 1, rig }).expect("a place in the stroke")
}

/// Waits until the device is in a mode.
fn until(cable: &Cable, mode: ModeId, seconds: f64) {
    let began = Instant::now();
    while cable.now.0.load(Ordering::SeqCst) != mode.code() {
        assert!(began.elapsed().as_secs_f64() < seconds, "not {} within {seconds} s", mode.id());
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub fn a_virtual_device_on_a_port_is_homed_by_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let cable = Cable::to(device(), |_| {});
    let _lab = Lab::start(folder.path(), &[&cable.name]);
    until(&cable, ModeId::Homing, 10.0);
    until(&cable, ModeId::Idle, 20.0);
}

pub fn a_real_device_is_homed_only_when_the_page_asks() {
    let folder = tempfile::tempdir().expect("a folder");
    // its version names another board
    let cable = Cable::to(device(), |bytes| {
        let (virtual_name, real_name) = (b"the simulated rig", b"a board like real");
        if let Some(at) = bytes.windows(virtual_name.len()).position(|part| part == virtual_name) {
            bytes[at..at + virtual_name.len()].copy_from_slice(real_name);
        }
    });
    let lab = Lab::start(folder.path(), &[&cable.name]);
    // a page for each request, none of which reads what it is sent; all stay open, as the lab lets go without a page
    let mut pages = Vec::new();
    let mut ask = |what: serde_json::Value| {
        pages.push(lab.socket(Some(&format!("http://{}", lab.host()))).expect("its own page"));
        let socket = pages.last_mut().expect("just opened");
        socket.send(tungstenite::Message::text(what.to_string())).expect("the lab hears");
    };
    let drive = json!({ "do": "move", "wave": "sine", "amplitude": 0.008, "frequency": 2.0, "seconds": 5.0 });
    // connected, and refused
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(3) {
        ask(drive.clone());
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(cable.now.0.load(Ordering::SeqCst), ModeId::Idle.code(), "nobody asked for it");
    }
    ask(json!({ "do": "home" }));
    until(&cable, ModeId::Homing, 5.0);
    until(&cable, ModeId::Idle, 20.0);
    // the state reaches the lab a moment later
    std::thread::sleep(Duration::from_millis(300));
    ask(drive);
    until(&cable, ModeId::Exciting, 5.0);
    ask(json!({ "do": "stop" }));
    until(&cable, ModeId::Idle, 5.0);
}
