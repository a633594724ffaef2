//! `identify` typed at the virtual device, many times over: are its deviations what it says they are?
#![cfg(not(target_os = "none"))]

use plant::materials::{BRASS, Material, RUBBER, TEFLON};
use tribos_firmware::VirtualDevice;
use tribos_firmware::board::simulated::VirtualConfig;

const NAMES: [&str; 8] = ["mass", "C_p", "C_n", "b_p", "b_n", "dv", "D_p", "D_n"];

fn truth(m: &Material) -> [f64; 8] {
    let l = &m.law;
    [m.mass, l.c_p, l.c_n, l.b_p, l.b_n, l.delta_v, l.d_p, l.d_n]
}

/// Value and deviation of each parameter in the line the device says.
fn read(line: &str) -> [Option<(f64, f64)>; 8] {
    NAMES.map(|name| {
        let rest = line.split(&format!(" {name} ")).nth(1)?;
        let mut words = rest.split_whitespace();
        let value = words.next()?.parse().ok()?;
        (words.next()? == "±").then_some(())?;
        Some((value, words.next()?.parse().ok()?))
    })
}

/// Types `identify` at a device whose accelerometer is a little wrong, as each is.
fn identify(material: &Material, seed: u64) -> String {
    let mut config = VirtualConfig { seed, ..VirtualConfig::default() };
    (config.rig.accel.gain, config.rig.accel.offset) = (0.94, 0.5);
    let mut device = VirtualDevice::new(&config).expect("the rig");
    device.set_block(material.mass, material.law, &[]).expect("printed parameters");
    device.write(b"identify\n");
    let mut heard = Vec::new();
    for _ in 0..13_500 {
        device.tick();
        device.read(&mut heard);
    }
    let text = String::from_utf8_lossy(&heard).into_owned();
    text.lines().find(|l| l.starts_with("! identified")).unwrap_or_else(|| panic!("{text}")).to_owned()
}

#[test]
fn what_the_device_identifies_is_within_the_deviations_it_tells() {
    let seeds = 20;
    for material in [&BRASS, &TEFLON, &RUBBER] {
        let truth = truth(material);
        let lines: Vec<String> = (1..=seeds).map(|seed| identify(material, seed)).collect();
        println!("{}: {}", material.name, lines[0]);
        let found: Vec<_> = lines.iter().map(|line| read(line)).collect();
        for (k, name) in NAMES.iter().enumerate() {
            let pulls: Vec<f64> =
                found.iter().filter_map(|f| f[k]).map(|(value, std)| (value - truth[k]) / std).collect();
            let n = pulls.len() as f64;
            let mean = pulls.iter().sum::<f64>() / n;
            let rms = (pulls.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
            let worst = pulls.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            println!(
                "  {name:5} truth {:8.4}; {n} runs off by, in told deviations: mean {mean:+.2}, rms {rms:.2}, worst {worst:.2}",
                truth[k],
            );
            assert!(pulls.len() >= 18, "{name} was not seen");
            // 20 draws: beyond 3.5 once in 100 such rows; dv is a band, and its error is uniform
            assert!(worst < 3.5 && rms < if *name == "dv" { 2.0 } else { 1.5 }, "{name}");
        }
    }
}

#[test]
fn what_was_identified_is_rendered_at_once() {
    let mut device = VirtualDevice::new(&VirtualConfig::default()).expect("the rig");
    device.set_block(RUBBER.mass, RUBBER.law, &[]).expect("printed parameters");
    device.write(b"identify\n");
    for _ in 0..13_500 {
        device.tick();
    }
    device.set_block(0.0, RUBBER.law, &[]).expect("no block");
    device.read(&mut Vec::new());
    device.write(b"preset use identified\nget\nrender on\n");
    let mut heard = Vec::new();
    for _ in 0..200 {
        device.tick();
        device.read(&mut heard);
    }
    let text = String::from_utf8_lossy(&heard).into_owned();
    println!("{text}");
    assert!(text.contains("ok identified") && text.contains("ok render on"));
    assert!(device.outputs().amplifier);
}
