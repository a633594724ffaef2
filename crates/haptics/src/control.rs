//! Configuration and state together, for a single thread.

use crate::{Config, Inputs, Outputs, Request, State, step};

/// Configuration and state together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    config: Config,
    state: State,
}

impl Control {
    /// An idle, unreferenced loop with the force off.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self { state: State::new(&config.device), config }
    }

    /// The same, referenced: count 0 is the middle of the stroke. For a simulation, which knows it.
    #[must_use]
    pub fn referenced(config: Config) -> Self {
        Self { state: State::referenced(&config.device), config }
    }

    /// Replaces the configuration without a jump in force.
    pub fn configure(&mut self, config: Config) {
        self.state.reconfigured(config.period_ticks() != self.config.period_ticks());
        self.config = config;
    }

    /// Handles the request and runs one control step.
    pub fn step(&mut self, request: Option<&Request>, inputs: &Inputs) -> Outputs {
        step(&self.config, &mut self.state, request, inputs)
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }
}
