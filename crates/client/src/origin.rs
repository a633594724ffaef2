//! The middle of the stroke: whether the device knows it, and the search for it.

use crate::error::{Error, Result};
use crate::session::{Event, Session};
use std::time::{Duration, Instant};

/// Longest wait for the end of a search, which the device itself limits.
const PATIENCE: Duration = Duration::from_secs(60);
/// Looks at the line, of at most 5 ms each, between two signs of life.
const ALIVE_POLLS: u32 = 20;

/// Makes sure that the device knows the middle of its stroke. An unreferenced virtual device searches its stops at once; a real
/// one only if `may_move` allows it. Returns the result of a search.
///
/// # Errors
/// The search is not allowed, or fails; the line failed.
pub fn reference(session: &mut Session, may_move: &mut dyn FnMut() -> bool) -> Result<Option<String>> {
    // a device that has just started answers this before it has a state
    let virtual_device = session.command("version")?.contains(" on the simulated rig");
    // `ok idle, unreferenced, preset brass, …`
    if !session.command("status")?.split(", ").any(|part| part == "unreferenced") {
        return Ok(None);
    }
    if !virtual_device && !may_move() {
        return Err(Error::Unreferenced { port: session.name().to_owned() });
    }
    session.command("home")?;
    let result = wait(session);
    if result.is_err() {
        // whatever happened to the search; the first failure is reported
        let _ = session.off();
    }
    result.map(Some)
}

/// Waits for the result of a search. Samples that arrive meanwhile are dropped.
fn wait(session: &mut Session) -> Result<String> {
    let port = session.name().to_owned();
    let began = Instant::now();
    for poll in 1_u32.. {
        for event in session.poll()? {
            let Event::Text(line) = event else { continue };
            let Some(news) = line.strip_prefix("! ") else { continue };
            if news.starts_with("home: ") {
                return Ok(news.to_owned());
            }
            if news.starts_with("no home: ") {
                return Err(Error::NotHomed { port, why: news.to_owned() });
            }
            if let Some(fault) = news.strip_prefix("fault ") {
                return Err(Error::Fault { port, fault: fault.to_owned() });
            }
        }
        if began.elapsed() > PATIENCE {
            break;
        }
        if poll.is_multiple_of(ALIVE_POLLS) {
            session.send_line("")?;
        }
    }
    Err(Error::NoAnswer { port, command: "home".to_owned(), seconds: PATIENCE.as_secs() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Transport;
    use plant::RigConfig;
    use tribos_firmware::{VirtualConfig, VirtualDevice};

    /// A virtual device as it boots, under another name of its board if it shall pass for a real one.
    struct Bare {
        device: VirtualDevice,
        real: bool,
    }

    impl Transport for Bare {
        fn send(&mut self, bytes: &[u8]) -> Result<()> {
            self.device.write(bytes);
            Ok(())
        }

        fn receive(&mut self, out: &mut Vec<u8>) -> Result<()> {
            let mut bytes = Vec::new();
            for _ in 0..5 {
                self.device.tick();
            }
            self.device.read(&mut bytes);
            let text = String::from_utf8_lossy(&bytes).into_owned();
            out.extend(if self.real { text.replace("simulated rig", "bench") } else { text }.into_bytes());
            Ok(())
        }
    }

    fn session(real: bool, stroke: f64) -> Session {
        let rig = RigConfig { start_position: 0.008, stroke: Some(stroke), ..RigConfig::free_handle() };
        let device = VirtualDevice::new(&VirtualConfig { seed: 1, rig }).expect("a rig");
        Session::over("bench", Box::new(Bare { device, real }))
    }

    #[test]
    fn a_real_device_is_asked_for_and_a_virtual_one_is_not() {
        let mut virtual_device = session(false, 0.032);
        let told = reference(&mut virtual_device, &mut || panic!("nobody asks")).expect("found");
        assert!(told.is_some_and(|told| told.starts_with("home: stroke 32.0")));
        assert_eq!(reference(&mut virtual_device, &mut || panic!("known")).expect("known"), None);

        let mut real = session(true, 0.032);
        let refused = reference(&mut real, &mut || false).expect_err("not allowed");
        println!("{refused}; {}", refused.help().unwrap_or_default());
        assert!(matches!(&refused, Error::Unreferenced { port } if port == "bench"));
        assert!(real.command("status").expect("an answer").contains("idle, unreferenced"), "nothing moved");
        assert!(reference(&mut real, &mut || true).expect("found").is_some());
    }

    #[test]
    fn a_failed_search_is_an_error_with_the_measured_stroke() {
        let mut short = session(true, 0.020);
        let failed = reference(&mut short, &mut || true).expect_err("another stroke").to_string();
        println!("{failed}");
        assert!(failed.starts_with("bench: no home: stops 20.0") && failed.contains("from 31.04 to 32.96"));
    }
}
