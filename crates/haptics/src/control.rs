//! Configuration and state in one, where one thread has both.

use crate::{Config, Inputs, Outputs, Request, State, step};

/// Configuration and state together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    config: Config,
    state: State,
}

impl Control {
    /// A loop at rest: idle, force off.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self { state: State::new(&config.device), config }
    }

    /// Replaces what runs, without a jump in force.
    pub fn configure(&mut self, config: Config) {
        self.state.reconfigured(config.period_ticks() != self.config.period_ticks());
        self.config = config;
    }

    /// Handles the request, then one control step.
    pub fn step(&mut self, request: Option<&Request>, inputs: &Inputs) -> Outputs {
        step(&self.config, &mut self.state, request, inputs)
    }

    /// What runs.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// What it remembers.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }
}
