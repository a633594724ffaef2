//! Which move would show, or tell apart, what this recording cannot: the table of DIAGNOSIS.md as commands.

/// Serial commands use metres and hertz; an amplitude is half the stroke, from the recording.
#[derive(Debug, Clone, Copy)]
pub struct Bench {
    /// Half the stroke that was used, m or rad.
    pub amplitude: f64,
    /// Dominant frequency of the recording, Hz.
    pub frequency: f64,
}

impl Bench {
    fn command(&self, wave: &str, amplitude: f64, frequency: f64, seconds: f64) -> String {
        let round = |x: f64| {
            let scale = 10f64.powf(2.0 - x.abs().max(1e-12).log10().ceil());
            (x * scale).round() / scale
        };
        format!(
            "move {wave} {} {} {seconds:.0}",
            round(self.amplitude * amplitude),
            round(self.frequency.max(0.05) * frequency)
        )
    }

    /// The move that shows an effect best, and why.
    pub fn shows(&self, id: &str) -> String {
        match id {
            "spring" | "nonlinear_spring" | "compliance" | "actuator_lag" | "time_skew"
            | "frictional_lag" => {
                format!(
                    "{}: several frequencies at once separate stiffness, mass and delay",
                    self.command("multisine", 1.0, 1.0, 20.0)
                )
            }
            "back_emf" => {
                "open and short the winding while the slide is pushed: motion alone cannot tell".into()
            }
            "force_crosstalk" => {
                "hang weights, then shake the free load cell: motion alone cannot tell".into()
            }
            "offset" | "gravity" => {
                format!(
                    "{}: rest at several places, and turn the axis over",
                    self.command("dwell", 1.0, 0.5, 20.0)
                )
            }
            "accelerometer_error" => {
                "compare with the second difference of the position on a faster move".into()
            }
            "stribeck" | "sublinear_viscous" | "quadratic_drag" => {
                format!(
                    "{}: slow constant speeds, then the same at ten times the rate",
                    self.command("triangle", 1.0, 0.2, 30.0)
                )
            }
            "presliding" | "nonlocal_memory" | "cable_hysteresis" | "velocity_lag" | "backlash" => {
                format!("{}: many short reversals", self.command("sine", 0.05, 2.0, 20.0))
            }
            "rising_static_friction" => {
                format!("{}: rests of different length", self.command("dwell", 1.0, 0.5, 30.0))
            }
            "friction_drift" => format!(
                "{}: the same move again, long enough to warm up",
                self.command("sine", 1.0, 1.0, 120.0)
            ),
            "cogging" | "periodic_friction" | "torque_ripple" | "encoder_eccentricity" => {
                format!(
                    "{} and again at three times the rate: a line in position does not move with speed",
                    self.command("triangle", 1.0, 0.3, 30.0)
                )
            }
            "position_dependent_friction" | "force_gain_asymmetry" => {
                format!("{} at three centres along the stroke", self.command("sine", 0.2, 2.0, 10.0))
            }
            "load_dependent_friction" => "add a known weight and repeat the move".into(),
            "hard_stop" => format!("{}: reach the end of the stroke", self.command("sine", 1.2, 0.5, 10.0)),
            "saturation" => format!(
                "{}: an amplitude ladder up to the largest force",
                self.command("multisine", 1.2, 1.5, 20.0)
            ),
            _ => format!("{}: a richer move", self.command("multisine", 1.0, 1.0, 20.0)),
        }
    }

    /// The move that tells `a` from `b`.
    pub fn separates(&self, a: &str, b: &str) -> String {
        let either = |x: &str| a == x || b == x;
        if either("force_crosstalk") {
            return self.shows("force_crosstalk");
        }
        if either("back_emf") {
            return self.shows("back_emf");
        }
        if either("presliding")
            && (either("frictional_lag") || either("velocity_lag") || either("rising_static_friction"))
        {
            return format!("{}: moves and dwells", self.command("dwell", 0.5, 1.0, 30.0));
        }
        if either("presliding") || either("backlash") {
            return self.shows("presliding");
        }
        if either("stribeck") || either("sublinear_viscous") || either("quadratic_drag") {
            return self.shows("stribeck");
        }
        if either("cogging")
            || either("periodic_friction")
            || either("torque_ripple")
            || either("encoder_eccentricity")
        {
            return self.shows("cogging");
        }
        if either("friction_drift") {
            return self.shows("friction_drift");
        }
        if either("load_dependent_friction") || either("saturation") {
            return "repeat the move with a known weight added, and at half the amplitude".into();
        }
        if either("position_dependent_friction") || either("force_gain_asymmetry") {
            return self.shows("position_dependent_friction");
        }
        self.shows("spring")
    }
}
