//! Where a handle at rest is between two counts.
//!
//! A stiff spring on whole counts cannot balance a hand that presses with a force between those of two counts: the
//! handle is driven to and fro over the edges beside the balance, at K times a count, for as long as the hand rests. But
//! how long it stays on each count tells where the balance is: the mean force over whole swings *is* the hand's.
//!
//! So after [`CROSSINGS`] crossings within [`WIDEST`] counts these count as one place, their mean over that time, and
//! the force is constant while the handle stays there. Beyond it the force steps up, so force over position stays a
//! staircase that only rises, without hysteresis: no more energy than the encoder's own. A handle that leaves to one
//! side says that the place was too far to the other: it is moved, by half as much after every change of side. Farther
//! out all is forgotten, and a handle that travels never stays within so few counts.
//!
//! A handle that goes to and fro so little is braked, too ([`Dither::brake`]): its velocity is known in the period in
//! which it crosses an edge and stale in those after, so the damping of the coupling, which acts in all of them, drives
//! as much as it damps. For that one period it is damped by m/2T, which takes half the speed of a free handle.

use super::Handle;

/// Crossings after which it is dither.
const CROSSINGS: u8 = 9;
/// Counts that may count as one place.
const WIDEST: f32 = 4.0;
/// First correction of the place, counts.
const CORRECTION: f32 = 0.25;
/// Smallest correction, counts.
const FINEST: f32 = 1.0 / 256.0;
/// How far a handle one count beside the place is taken to be from it, counts. A step that comes a period late drives
/// what it should hold, the more the larger it is.
const BESIDE: f32 = 0.25;

/// No place is known.
const NOWHERE: f32 = -1.0;

/// What is known of a handle at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dither {
    /// The lowest count, m, and how many beside it, upwards.
    low: f32,
    span: f32,
    /// Crossings since.
    crossings: u8,
    /// Samples since, and the sum of their positions from `low`, counts.
    samples: f32,
    sum: f32,
    /// The place from `low`, counts, once it is known; before that, something negative.
    place: f32,
    /// Next correction, positive upwards, counts.
    correction: f32,
}

impl Default for Dither {
    #[inline(always)] // made in a control step
    fn default() -> Self {
        Self { low: 0.0, span: 0.0, crossings: 0, samples: 0.0, sum: 0.0, place: NOWHERE, correction: 0.0 }
    }
}

impl Dither {
    /// Force of `damping` N·s/m on a handle that crosses an edge to and fro, N, against its velocity.
    #[inline(always)]
    pub(super) fn brake(&self, handle: &Handle, damping: f32) -> f32 {
        if handle.displacement != 0.0 && self.crossings > 1 { damping * handle.velocity } else { 0.0 }
    }

    /// The position of the handle, m, with a count of `count` m.
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
        // a count that was not among those so far: it joins them, or others begin with it
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

    /// The handle left the place, upwards or downwards.
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
