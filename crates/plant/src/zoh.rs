//! The mass-damper of [thesis, eq. 4.14] with the exact solution over a step of constant force [thesis, eq. 4.15].

/// m·ẍ + b·ẋ = F over one step h with F constant:
/// v′ = E·v + A·F, x′ = x + B·v + C·F, with E = e^(−bh/m). Coefficients are exact for every b ≥ 0, including the limit
/// b → 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoh {
    /// Length of the step, s.
    pub step: f64,
    /// E, the factor on the velocity.
    pub decay: f64,
    /// A, velocity per force, m/s/N.
    pub velocity_per_force: f64,
    /// B, displacement per velocity, s.
    pub displacement_per_velocity: f64,
    /// C, displacement per force, m/N.
    pub displacement_per_force: f64,
    /// Mass m_stop, kg, for which the force F = −(m_stop/h − b)·v ends the step exactly at rest. Equals the mass without
    /// damping.
    pub stopping_mass: f64,
}

impl Zoh {
    /// Coefficients for `mass` in kg (> 0), `damping` in N·s/m (≥ 0) and a `step` in s (> 0).
    #[must_use]
    pub fn new(mass: f64, damping: f64, step: f64) -> Self {
        let y = damping * step / mass;
        let decay = libm::exp(-y);
        let (phi_1, phi_2) = phi(y);
        let velocity_per_force = step / mass * phi_1;
        Self {
            step,
            decay,
            velocity_per_force,
            displacement_per_velocity: step * phi_1,
            displacement_per_force: step * step / mass * phi_2,
            stopping_mass: step * (decay / velocity_per_force + damping),
        }
    }

    /// Displacement in m and velocity in m/s at the end of the step, from `velocity` and the net `force`.
    #[inline]
    #[must_use]
    pub fn advance(&self, velocity: f64, force: f64) -> (f64, f64) {
        (
            self.displacement_per_velocity * velocity + self.displacement_per_force * force,
            self.decay * velocity + self.velocity_per_force * force,
        )
    }
}

/// φ₁ = (1 − e^−y)/y and φ₂ = (y − 1 + e^−y)/y², by series where the closed form cancels.
fn phi(y: f64) -> (f64, f64) {
    if y < 0.25 {
        // Σ (−y)^k / (k+2)!; the 12th term is below 1e-17 here
        let mut term = 0.5;
        let mut phi_2 = 0.0;
        for k in 0..14 {
            phi_2 += term;
            term *= -y / f64::from(k + 3);
        }
        (1.0 - y * phi_2, phi_2)
    } else {
        let phi_1 = -libm::expm1(-y) / y;
        (phi_1, (1.0 - phi_1) / y)
    }
}
