//! The virtual device as another program meets it: a pseudo-terminal, in real time.
#![cfg(unix)]

use link::{Decoder, Frame, Item};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The running program; its standard input is held open, so that it goes on.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // it may have ended by itself
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Opens the line, which `serialport` locks. A test beside this one that starts a program copies every open file for the
/// moment between fork and exec, lock included: for that moment a line that was closed is still taken.
fn open(name: &str) -> Box<dyn serialport::SerialPort> {
    let begun = Instant::now();
    loop {
        match serialport::new(name, 921_600).timeout(Duration::from_millis(20)).open() {
            Ok(port) => return port,
            Err(e) if begun.elapsed() > Duration::from_secs(10) => panic!("{name}: {e}"),
            Err(_) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
}

fn start() -> (Program, Box<dyn serialport::SerialPort>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_tribos-firmware"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the virtual device");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    let program = Program(child);
    let name = loop {
        let line = lines.next().expect("the name of the pseudo-terminal").expect("text");
        if let Some(rest) = line.strip_prefix("serial line ") {
            break rest.split_whitespace().next().expect("a name").to_owned();
        }
    };
    // what it says later is read by nobody, and must not stop it
    std::thread::spawn(move || lines.count());
    let port = open(&name);
    (program, port)
}

/// Items of the line until `enough` says so, or a minute has passed.
fn listen(
    port: &mut dyn serialport::SerialPort,
    mut each: impl FnMut(&mut dyn serialport::SerialPort, &Item) -> bool,
) {
    let (mut decoder, mut chunk) = (Decoder::new(), [0; 4096]);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(120) {
        let Ok(count) = port.read(&mut chunk) else { continue };
        for byte in &chunk[..count] {
            if let Some(item) = decoder.push(*byte)
                && each(port, &item)
            {
                return;
            }
        }
    }
    panic!("not heard in two minutes");
}

#[test]
fn garbage_loses_no_frame() {
    let (_program, mut port) = start();
    port.write_all(b"preset use rubber\nrender on\nstream on\n").expect("the line");
    let (mut seqs, mut corrupt, mut answers, mut dropped) = (Vec::new(), 0, Vec::new(), u32::MAX);
    let begun = Instant::now();
    listen(port.as_mut(), |port, item| {
        match item {
            Item::Frame(seq, frame) => {
                seqs.push(*seq);
                if let Frame::Sample(sample) = frame {
                    dropped = sample.dropped;
                }
                if seq % 500 == 250 {
                    let garbage = b"\xff\x00\x01\x02 get dv\nset dv NaN\nrender o";
                    port.write_all(garbage).expect("the line");
                    port.write_all(&[b'x'; 400]).expect("the line");
                    port.write_all(b"\nget f_static_p\n").expect("the line");
                }
            }
            Item::Text(line) => answers.push((*line).to_owned()),
            Item::Corrupt(_) => corrupt += 1,
        }
        seqs.len() > 10_000
    });
    let seconds = begun.elapsed().as_secs_f64();
    println!("{} frames in {seconds:.2} s, {corrupt} corrupt, {dropped} dropped", seqs.len());
    assert!(seqs.iter().enumerate().all(|(k, seq)| *seq == k as u32), "every frame, in order, once");
    assert_eq!((corrupt, dropped), (0, 0));
    let count = |start: &str| answers.iter().filter(|line| line.starts_with(start)).count();
    for (start, least) in [
        ("err NOT_TEXT: byte 0xff in column 1", 20),
        ("err VALUE: dv = `NaN`", 20),
        ("err TOO_LONG: ", 20),
        // unchanged value of [thesis, table 3-3]
        ("ok f_static_p 3.8513 N", 20),
    ] {
        println!("{:3} × {start}", count(start));
        // the last ones may still be on their way
        assert!(count(start) + 1 >= least, "{start}: {answers:?}");
    }
}

#[test]
fn a_second_host_sees_no_old_answers() {
    let (_program, mut port) = start();
    let name = port.name().expect("a name");
    port.write_all(b"version\n").expect("the line");
    listen(port.as_mut(), |_, item| matches!(item, Item::Text(line) if line.starts_with("ok tribos")));
    drop(port);
    let mut port = open(&name);
    port.write_all(b"get dv\n").expect("the line");
    listen(port.as_mut(), |_, item| {
        assert_eq!(*item, Item::Text("ok dv 0.007 m/s"));
        true
    });
}

#[test]
fn piped_commands_are_answered() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_tribos-firmware"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the virtual device");
    let mut stdin = child.stdin.take().expect("piped");
    stdin.write_all(b"preset list\nzero\npreset use rubber\nrender on\nstatus").expect("input");
    drop(stdin);
    let output = child.wait_with_output().expect("an end");
    let text = String::from_utf8(output.stdout).expect("text");
    println!("{text}");
    assert!(output.status.success());
    for answer in [
        "ok brass teflon rubber viscous; active brass",
        "ok rubber\n",
        "ok render on\n",
        "ok rendering, preset rubber",
    ] {
        assert!(text.contains(answer), "{answer}");
    }
}
