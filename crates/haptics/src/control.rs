//! The one place where a configuration is replaced.

use crate::{Config, Inputs, Outputs, Request, State, step};

/// Configuration and state together: what the control interrupt owns.
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

    /// Handles the request, then one control step.
    pub fn step(&mut self, request: Option<&Request>, inputs: &Inputs) -> Outputs {
        if let Some(Request::Configure(config)) = request {
            self.config = *config;
        }
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
