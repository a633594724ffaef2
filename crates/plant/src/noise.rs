//! Seeded sensor noise: the same seed gives the same codes on every platform.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// White Gaussian noise. Each sensor has its own stream: changing the noise of one leaves the draws of the others.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    rng: ChaCha8Rng,
}

impl Noise {
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self { rng }
    }

    /// A draw with standard deviation `std`. Advances the stream also for `std` = 0.
    #[inline]
    pub(crate) fn draw(&mut self, std: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.rng);
        unit * std
    }
}
