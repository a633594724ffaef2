//! Excitations from text, `sine 0.01 2 4`, in the words of the device's `move` command.

use haptics::{Excitation, Wave};
use std::fmt;

/// An excitation: shape, amplitude, frequency and, optionally, length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Shape of the reference.
    pub wave: Wave,
    /// Amplitude, half of peak to peak, m (rad).
    pub amplitude: f64,
    /// Repetition rate, Hz. For a chirp, the highest frequency.
    pub frequency: f64,
    /// Length, s.
    pub seconds: Option<f64>,
}

impl Move {
    /// The excitation for the control step. 0 s runs until stopped.
    #[must_use]
    pub fn excitation(&self, seconds: f64) -> Excitation {
        Excitation {
            wave: self.wave,
            amplitude_m: self.amplitude as f32,
            frequency_hz: self.frequency as f32,
            seconds: seconds as f32,
        }
    }
}

impl fmt::Display for Move {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.wave.id(), self.amplitude, self.frequency)?;
        match self.seconds {
            Some(seconds) => write!(f, " {seconds}"),
            None => Ok(()),
        }
    }
}

impl std::str::FromStr for Move {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut words = text.split_whitespace().peekable();
        if words.peek() == Some(&"move") {
            words.next();
        }
        let names = || Wave::ALL.iter().map(|w| w.id()).collect::<Vec<_>>().join("|");
        let grammar = || format!("\"{} AMPLITUDE_M FREQUENCY_HZ [SECONDS]\" is accepted", names());
        let wave = words.next().ok_or_else(grammar)?;
        let wave = Wave::from_id(wave).ok_or_else(|| format!("no wave `{wave}`; {}", grammar()))?;
        let mut value = |what: &str| -> Result<Option<f64>, String> {
            let Some(word) = words.next() else { return Ok(None) };
            match word.parse::<f64>() {
                Ok(v) if v.is_finite() && v > 0.0 => Ok(Some(v)),
                _ => Err(format!("{what} `{word}` must be a number above 0; {}", grammar())),
            }
        };
        let amplitude = value("amplitude")?.ok_or_else(grammar)?;
        let frequency = value("frequency")?.ok_or_else(grammar)?;
        let seconds = value("seconds")?;
        match words.next() {
            Some(extra) => Err(format!("`{extra}` is one word too many; {}", grammar())),
            None => Ok(Self { wave, amplitude, frequency, seconds }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 2 Hz and 10 mm [thesis, ch. 3.5.2].
    const THESIS: Move = Move { wave: Wave::Sine, amplitude: 0.01, frequency: 2.0, seconds: None };

    #[test]
    fn speaks_the_words_of_the_device() {
        let m: Move = "sine 0.01 2 4".parse().unwrap();
        assert_eq!(m, Move { seconds: Some(4.0), ..THESIS });
        assert_eq!(m.to_string(), "sine 0.01 2 4");
        assert_eq!("move sine 0.01 2".parse::<Move>().unwrap(), THESIS);
        for bad in [
            "",
            "sine",
            "sine 0.01",
            "sine x 2",
            "sine 0.01 -2",
            "sine NaN 2",
            "sine inf 2",
            "saw 1 2",
            "sine 1 2 3 4",
        ] {
            let said = bad.parse::<Move>().unwrap_err();
            assert!(said.contains("is accepted"), "{bad:?}: {said}");
        }
    }
}
