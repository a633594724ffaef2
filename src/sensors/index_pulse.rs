//! The index pulse of a quadrature encoder, which comes at one place of the stroke.
//!
//! Once the middle of the stroke is known its distance from the index is kept, and after the next start the first pulse tells the
//! middle. While the middle is known each pulse checks the counts since the last one.

use crate::board::{Middle, MiddleNews};

/// Counts by which a pulse may differ from the one before: it is up to a period of the encoder wide, and comes at either of its ends.
const WIDTH: u32 = 8;

/// What is known of the index. Counts are those of the encoder.
#[derive(Debug, Clone, Copy, Default)]
pub struct IndexPulse {
    /// Count at the last pulse since the counts were in doubt.
    index: Option<u32>,
    /// Count of the middle.
    middle: Option<u32>,
    /// Count at the first pulse with this middle.
    expected: Option<u32>,
    /// Counts from the index to the middle, as stored.
    kept: Option<u32>,
}

impl IndexPulse {
    /// None seen, and no middle stored.
    pub const fn new() -> Self {
        Self { index: None, middle: None, expected: None, kept: None }
    }

    /// Takes the stored item.
    pub fn load(&mut self, item: &[u8]) {
        if let Ok(bytes) = <[u8; 4]>::try_from(item) {
            self.kept = Some(u32::from_le_bytes(bytes));
        }
    }

    /// What follows from a pulse at this count, if one has come, and from what the control loop knows. Call it every few
    /// milliseconds.
    pub fn update(&mut self, pulse: Option<u32>, now: Middle) -> MiddleNews {
        let Middle::At(middle) = now else {
            // counts from before the doubt mean nothing
            let doubt = now == Middle::InDoubt || self.middle.take().is_some();
            self.index = if doubt { None } else { pulse.or(self.index) };
            return match (self.index, self.kept) {
                (Some(index), Some(kept)) => MiddleNews::Is(index.wrapping_add(kept)),
                _ => MiddleNews::None,
            };
        };
        if self.middle.replace(middle) != Some(middle) {
            self.expected = None;
        }
        if let (Some(pulse), Some(expected)) = (pulse, self.expected)
            && is_apart(pulse, expected)
        {
            self.index = None;
            return MiddleNews::Moved;
        }
        self.index = pulse.or(self.index);
        let Some(index) = self.index else { return MiddleNews::None };
        self.expected = self.expected.or(Some(index));
        let kept = middle.wrapping_sub(index);
        if self.kept.is_some_and(|before| !is_apart(before, kept)) {
            return MiddleNews::None;
        }
        self.kept = Some(kept);
        MiddleNews::Keep(kept.to_le_bytes())
    }
}

fn is_apart(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32).unsigned_abs() > WIDTH
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Found the index at 700 and the middle at 1 000.
    fn found() -> IndexPulse {
        let mut index = IndexPulse::new();
        assert_eq!(index.update(None, Middle::Unknown), MiddleNews::None);
        assert_eq!(index.update(Some(700), Middle::Unknown), MiddleNews::None);
        assert_eq!(index.update(None, Middle::At(1_000)), MiddleNews::Keep(300_u32.to_le_bytes()));
        assert_eq!(index.update(None, Middle::At(1_000)), MiddleNews::None);
        index
    }

    #[test]
    fn the_first_pulse_after_a_start_tells_the_middle() {
        found();
        let mut index = IndexPulse::new();
        index.load(&300_u32.to_le_bytes());
        assert_eq!(index.update(None, Middle::Unknown), MiddleNews::None);
        // counts began elsewhere, and below zero
        let at = 0_u32.wrapping_sub(40);
        assert_eq!(index.update(Some(at), Middle::Unknown), MiddleNews::Is(260));
        // until the loop takes it
        assert_eq!(index.update(None, Middle::Unknown), MiddleNews::Is(260));
        assert_eq!(index.update(None, Middle::At(260)), MiddleNews::None);
    }

    #[test]
    fn a_pulse_elsewhere_is_a_lost_count_and_an_end_of_the_pulse_is_none() {
        let mut index = found();
        for at in [700, 704, 697, 700] {
            assert_eq!(index.update(Some(at), Middle::At(1_000)), MiddleNews::None);
        }
        // counts that are lost a few at a time add up
        assert_eq!(index.update(Some(706), Middle::At(1_000)), MiddleNews::None);
        assert_eq!(index.update(Some(712), Middle::At(1_000)), MiddleNews::Moved);
        let mut index = found();
        assert_eq!(index.update(Some(740), Middle::At(1_000)), MiddleNews::Moved);
        // the fault leaves the middle unknown; the next pulse tells it
        assert_eq!(index.update(None, Middle::InDoubt), MiddleNews::None);
        assert_eq!(index.update(None, Middle::Unknown), MiddleNews::None);
        assert_eq!(index.update(Some(741), Middle::Unknown), MiddleNews::Is(1_041));
    }

    #[test]
    fn what_came_before_a_doubt_tells_nothing() {
        let mut index = found();
        // a jump while the force is off: from known to unknown without a fault
        assert_eq!(index.update(Some(700), Middle::Unknown), MiddleNews::None);
        assert_eq!(index.update(None, Middle::Unknown), MiddleNews::None);
        assert_eq!(index.update(Some(3_700), Middle::Unknown), MiddleNews::Is(4_000));
    }

    #[test]
    fn another_middle_is_kept_and_nearly_the_same_one_wears_no_flash() {
        let mut index = found();
        assert_eq!(index.update(None, Middle::At(1_003)), MiddleNews::None);
        assert_eq!(index.update(None, Middle::At(1_200)), MiddleNews::Keep(500_u32.to_le_bytes()));
        // told by hand before the first pulse, and not where it was stored
        let mut unseen = IndexPulse::new();
        unseen.load(&300_u32.to_le_bytes());
        assert_eq!(unseen.update(None, Middle::At(5)), MiddleNews::None);
        assert_eq!(unseen.update(Some(2), Middle::At(5)), MiddleNews::Keep(3_u32.to_le_bytes()));
    }

    #[test]
    fn a_broken_item_is_none() {
        let mut index = IndexPulse::new();
        index.load(&[1, 2, 3]);
        assert_eq!(index.update(Some(9), Middle::Unknown), MiddleNews::None);
    }
}
