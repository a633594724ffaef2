//! The quadrature encoder: a count and the time of its last edge.

/// Part of the motion with one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Segment {
    /// Start, s after the nominal start of the control period.
    pub start: f64,
    /// Length, s.
    pub length: f64,
    /// Position at the start, m.
    pub position: f64,
    /// Velocity at the start, m/s.
    pub velocity: f64,
    /// Displacement over the segment, m.
    pub displacement: f64,
}

/// Encoder without hysteresis. The count is the nearest multiple of the resolution and edges lie half-way between
/// multiples, so a handle at rest at 0 is not on an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Encoder {
    metre_per_count: f64,
    count_per_metre: f64,
    count: i64,
    /// Edges around the present count, m. Nothing changes while the handle stays between them.
    low: f64,
    high: f64,
    /// Segment with the last edge, and the count after it, until the time of the edge is needed.
    crossing: Option<(Segment, i64, bool)>,
    edge_ticks: u32,
}

impl Encoder {
    pub(crate) fn new(metre_per_count: f64, position: f64) -> Self {
        let mut encoder = Self {
            metre_per_count,
            count_per_metre: 1.0 / metre_per_count,
            count: 0,
            low: 0.0,
            high: 0.0,
            crossing: None,
            edge_ticks: 0,
        };
        encoder.settle(encoder.nearest(position));
        encoder
    }

    /// round(x / resolution); an edge belongs to the count above it. `as` saturates, so no position panics.
    fn nearest(&self, position: f64) -> i64 {
        let scaled = position * self.count_per_metre + 0.5;
        let truncated = scaled as i64;
        if (truncated as f64) > scaled { truncated - 1 } else { truncated }
    }

    fn settle(&mut self, count: i64) {
        self.count = count;
        self.low = (count as f64 - 0.5) * self.metre_per_count;
        self.high = (count as f64 + 0.5) * self.metre_per_count;
    }

    /// Records a segment that ended at `position`. The time of an edge is computed in [`Self::read`], because only the last
    /// edge of a control period is needed.
    #[inline]
    pub(crate) fn observe(&mut self, segment: &Segment, position: f64) {
        if position >= self.low && position < self.high {
            return;
        }
        let count = self.nearest(position);
        if count != self.count {
            self.crossing = Some((*segment, count, count > self.count));
            self.settle(count);
        }
    }

    /// Count, and time stamp of the last edge. `period_start` is the stamp of the nominal start of the control period that
    /// the segments refer to.
    pub(crate) fn read(&mut self, period_start: u32, tick_hz: f64) -> (u32, u32) {
        if let Some((segment, count, upwards)) = self.crossing.take() {
            // moving up, the last edge is the one below the new count; moving down, the one above it
            let half = if upwards { -0.5 } else { 0.5 };
            let distance = (count as f64 + half) * self.metre_per_count - segment.position;
            let seconds = segment.start + time_to(distance, &segment);
            let ticks = (seconds * tick_hz).floor() as i64;
            self.edge_ticks = period_start.wrapping_add(ticks as u32);
        }
        (self.count as u32, self.edge_ticks)
    }
}

/// Time at which a segment has covered `distance`, s after its start: the root of v·t + a·t²/2 = distance, in the form without
/// cancellation. a is chosen so that the parabola meets both ends of the exact trajectory.
fn time_to(distance: f64, segment: &Segment) -> f64 {
    let Segment { length, velocity, displacement, .. } = *segment;
    let acceleration = 2.0 * (displacement - velocity * length) / (length * length);
    let discriminant = (velocity * velocity + 2.0 * acceleration * distance).max(0.0);
    let denominator = velocity + discriminant.sqrt().copysign(displacement);
    let time = 2.0 * distance / denominator;
    if time.is_finite() { time.clamp(0.0, length) } else { length }
}
