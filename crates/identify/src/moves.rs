//! The move that would determine what this recording does not: a line for the device's console.

/// Size of the recorded motion, to which a proposed move is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moves {
    /// Half the stroke, m.
    pub amplitude: f64,
    /// Of the recorded motion, Hz.
    pub frequency: f64,
}

/// Two significant digits.
fn short(x: f64) -> String {
    if !(x > 0.0 && x.is_finite()) {
        return "0.01".into();
    }
    let digits = 10f64.powf(x.log10().floor() - 1.0);
    format!("{}", ((x / digits).round() * digits * 1e9).round() / 1e9)
}

impl Moves {
    /// From position and velocity `dt` seconds apart.
    pub fn of(position: &[f64], velocity: &[f64], dt: f64) -> Self {
        let finite = position.iter().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let fastest = velocity.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
        // Reversals beyond a tenth of the top speed: noise about rest does not count.
        let (mut way, mut turns) = (0.0, 0usize);
        for v in velocity.iter().filter(|v| v.abs() > 0.1 * fastest) {
            if v.signum() != way {
                turns += usize::from(way != 0.0);
                way = v.signum();
            }
        }
        let seconds = velocity.len() as f64 * dt;
        let frequency = if turns > 0 && seconds > 0.0 { 0.5 * turns as f64 / seconds } else { 1.0 };
        Self {
            amplitude: if high > low { 0.5 * (high - low) } else { 0.01 },
            frequency: frequency.clamp(0.05, 20.0),
        }
    }

    fn line(wave: &str, amplitude: f64, frequency: f64, seconds: u32) -> String {
        format!("move {wave} {} {} {seconds}", short(amplitude), short(frequency))
    }

    /// More acceleration, for a mass.
    pub fn faster(&self) -> String {
        Self::line("sine", self.amplitude, 2.0 * self.frequency, 10)
    }

    /// Both directions at many speeds, for levels and viscous friction.
    pub fn reversing(&self) -> String {
        Self::line("multisine", self.amplitude, self.frequency, 20)
    }

    /// Leaving rest again and again, for static friction.
    pub fn break_away(&self) -> String {
        Self::line("dwell", self.amplitude, (0.5 * self.frequency).min(0.5), 20)
    }

    /// Short slow strokes, for a bristle that bends by little.
    pub fn presliding(&self) -> String {
        Self::line("triangle", 0.02 * self.amplitude, (0.25 * self.frequency).min(0.5), 20)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_are_of_the_size_of_the_recording() {
        let t: Vec<f64> = (0..2000).map(|i| 1e-3 * f64::from(i)).collect();
        let x: Vec<f64> = t.iter().map(|t| 0.01 * (4.0 * std::f64::consts::PI * t).sin()).collect();
        let v: Vec<f64> = t.iter().map(|t| 0.126 * (4.0 * std::f64::consts::PI * t).cos()).collect();
        let moves = Moves::of(&x, &v, 1e-3);
        assert_eq!(moves.faster(), "move sine 0.01 4 10");
        assert_eq!(moves.presliding(), "move triangle 0.0002 0.5 20");
        // nothing to go by still gives a move that can be typed
        assert_eq!(Moves::of(&[], &[], 1e-3).faster(), "move sine 0.01 2 10");
    }
}
