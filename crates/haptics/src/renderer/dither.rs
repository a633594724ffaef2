//! Position of a handle at rest between two counts.
//!
//! A stiff spring on whole counts cannot balance a hand whose force lies between those of two counts. The handle oscillates
//! across the edges, with a force step of K times a count, as long as the hand rests. The time it spends on each count shows
//! the balance: the mean force over whole oscillations *is* that of the hand.
//!
//! After [`CROSSINGS`] crossings within [`WIDEST`] counts these counts become one place, at their mean over that time, and
//! the force is constant there. Beyond it the force steps up: force over position remains a rising staircase without
//! hysteresis, which adds no energy beyond that of the encoder. A handle that leaves on one side shows that the place was too
//! far on the other. The place is moved, by half as much after each change of side. Farther out it is forgotten; a
//! travelling handle never stays within so few counts.
//!
//! An oscillating handle is also braked ([`Dither::brake`]). Its velocity is known in the period in which it crosses an edge
//! and stale in the following ones, so the damping of the coupling drives as much as it damps. For that one period the handle
//! is damped with m/2T, which halves the speed of a free handle.

use super::Handle;

/// Number of crossings that count as dither.
const CROSSINGS: u8 = 9;
/// Largest width of a place, counts.
const WIDEST: f32 = 4.0;
/// First correction of a place, counts.
const CORRECTION: f32 = 0.25;
/// Smallest correction, counts.
const FINEST: f32 = 1.0 / 256.0;
/// Assumed distance of a handle that is one count beside the place, counts. A force step comes a period late and drives the
/// handle, more so for a larger step.
const BESIDE: f32 = 0.25;

/// Marks an unknown place.
const NOWHERE: f32 = -1.0;

/// State of a handle at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dither {
    /// Lowest count, m, and number of counts above it.
    low: f32,
    span: f32,
    /// Number of crossings since then.
    crossings: u8,
    /// Number of samples since then, and the sum of their positions from `low`, counts.
    samples: f32,
    sum: f32,
    /// Place from `low`, counts. Negative until known.
    place: f32,
    /// Next correction, counts, positive upwards.
    correction: f32,
}

impl Default for Dither {
    #[inline(always)] // constructed in a control step
    fn default() -> Self {
        Self { low: 0.0, span: 0.0, crossings: 0, samples: 0.0, sum: 0.0, place: NOWHERE, correction: 0.0 }
    }
}

impl Dither {
    /// Braking force of `damping`, N·s/m, on a handle that oscillates across an edge, N.
    #[inline(always)]
    pub(super) fn brake(&self, handle: &Handle, damping: f32) -> f32 {
        if handle.displacement != 0.0 && self.crossings > 1 { damping * handle.velocity } else { 0.0 }
    }

    /// Position of the handle, m, for a count of `count` m.
    #[inline(always)]
    pub(super) fn settle(&mut self, handle: &Handle, count: f32, per_count: f32) -> f32 {
        let (position, displacement) = (handle.position, handle.displacement);
        let crossed = displacement != 0.0;
        if self.crossings == 0 && !crossed {
            return position;
        }
        let at = (position - self.low) * per_count;
        let inside = at > -0.5 && at < self.span + 0.5;
        let place = self.place;
        if place >= 0.0 {
            if inside {
                return self.low + place * count;
            }
            if at > -1.5 && at < self.span + 1.5 {
                let place = if crossed { self.correct(place, at > 0.0) } else { place };
                let beside = if at > 0.0 { place + BESIDE } else { place - BESIDE };
                return self.low + beside * count;
            }
            (self.crossings, self.place) = (0, NOWHERE);
        } else if inside && self.crossings > 0 {
            self.crossings += u8::from(crossed);
            if self.crossings >= CROSSINGS {
                let place = self.sum / self.samples;
                (self.place, self.correction) = (place, CORRECTION);
                return self.low + place * count;
            }
            self.samples += 1.0;
            self.sum += at;
            return position;
        }
        // a new count: joins the others, or starts a new set
        let (low, span) = if self.crossings > 0 {
            if at < 0.0 { (position, self.span - at) } else { (self.low, at) }
        } else {
            (position, WIDEST)
        };
        (self.low, self.span) = if span < WIDEST - 0.5 {
            (low, span)
        } else if displacement > 0.0 {
            (position - displacement, displacement * per_count)
        } else {
            (position, -displacement * per_count)
        };
        self.crossings = u8::from(self.span < WIDEST - 0.5);
        (self.samples, self.sum) = (0.0, 0.0);
        position
    }

    /// Corrects the place after the handle left it, upwards or downwards.
    fn correct(&mut self, place: f32, upwards: bool) -> f32 {
        if (self.correction > 0.0) != upwards {
            let half = -0.5 * self.correction;
            self.correction = if half * half > FINEST * FINEST { half } else { -self.correction };
        }
        let moved = place + self.correction;
        let moved = if moved > self.span {
            self.span
        } else if moved > 0.0 {
            moved
        } else {
            0.0
        };
        self.place = moved;
        moved
    }
}
