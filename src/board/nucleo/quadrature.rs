//! The quadrature encoder: TIM2 counts its edges, TIM5 has the time of the last one.

use crate::board::{Middle, MiddleNews};
use embassy_stm32::pac;
use haptics::{Device, FaultKind};

/// Longest time from the stamp of a sample to the reading of its edge, ticks: 6 µs.
const SAMPLING_TICKS: u32 = 1_000;

/// The position of the handle from the quadrature encoder, which knows no middle of the stroke.
pub struct Quadrature;

impl Quadrature {
    /// Travel in a count, m: that of the default device.
    pub const fn metre_per_count(default: f32) -> f32 {
        default
    }

    /// No item of the flash is its own.
    pub const fn load(_: u8, _: &[u8]) {}

    /// It counts since the boot. False: from anywhere.
    pub const fn begin(&mut self, _: &Device) -> bool {
        false
    }

    /// It needs no trigger.
    pub const fn follow() {}

    /// Time of the sample, count, and time of the count's last edge.
    #[inline(always)]
    pub fn sample(&mut self) -> (u32, u32, u32) {
        encoder()
    }

    /// What is wrong with it shows in its counts.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        None
    }

    /// Its counts mean nothing after a start.
    pub const fn middle(_: Middle) -> MiddleNews {
        MiddleNews::None
    }
}

/// Time of the sample, count, and time of the count's last edge.
///
/// The stamp comes first, so that every edge after this sample is younger than its stamp, and the next sample finds it within
/// the period. The time of the edge is read before and after the count: if both readings agree, no edge came in between, and
/// the count belongs to it. Only an edge whose capture takes longer than two reads is counted but not yet timed; the estimator
/// waits for its time ([`haptics::estimator`]). Edges are at least 1 µs apart, so the second attempt succeeds; a limit of three
/// bounds the time.
#[inline]
fn encoder() -> (u32, u32, u32) {
    let (tim2, tim5) = (pac::TIM2, pac::TIM5);
    let stamp = tim5.cnt().read();
    let mut edge = tim5.ccr(0).read();
    let mut count = tim2.cnt().read();
    for _ in 0..3 {
        let after = tim5.ccr(0).read();
        if after == edge {
            break;
        }
        edge = after;
        count = tim2.cnt().read();
    }
    // an edge since the stamp is at the sample: none is in the future
    let sample = if edge.wrapping_sub(stamp) < SAMPLING_TICKS { edge } else { stamp };
    (sample, count, edge)
}
