//! The binary stream: control periods that become frames, and losses.

use super::{Output, Telemetry};
use friction::Geometry;
use haptics::{Channel, Device};
use link::{Frame, Header, Mechanics, Name, Sample, encode};

/// A running stream. Frame `n` has sequence number `n` whether or not it is sent: a gap is a loss.
#[derive(Debug, Clone)]
pub(super) struct Stream {
    decimation: u32,
    /// Control step of sample 0. The stream begins with the next period seen.
    start: Option<u32>,
    /// Sequence number of the next frame.
    next: u32,
    dropped: u32,
    /// Origin of the header that was sent.
    header: Option<u32>,
    preset: Name,
}

impl Stream {
    pub fn new(decimation: u32, preset: Name) -> Self {
        Self { decimation: decimation.max(1), start: None, next: 1, dropped: 0, header: None, preset }
    }

    /// Number of frames lost.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Begins again with a new header: the device is another one.
    pub fn restart(&mut self) {
        *self = Self { dropped: self.dropped, ..Self::new(self.decimation, self.preset.clone()) };
    }

    /// One control period. `origin` is the encoder count at position 0.
    pub fn take(&mut self, telemetry: &Telemetry, origin: u32, device: &Device, output: &mut Output) {
        if self.header != Some(origin) {
            if self.header.is_some() {
                // positions have another zero: for the host this is another stream
                self.restart();
            }
            let header = Frame::Header(self.header(device, origin));
            if !encode(0, &header).is_some_and(|wire| output.frame(&wire)) {
                return;
            }
            self.header = Some(origin);
        }
        let start = *self.start.get_or_insert(telemetry.step);
        let since = telemetry.step.wrapping_sub(start);
        if !since.is_multiple_of(self.decimation) {
            return;
        }
        let seq = 1 + since / self.decimation;
        // periods without room in the queue
        self.dropped = self.dropped.saturating_add(seq.saturating_sub(self.next));
        self.next = seq.wrapping_add(1);
        let frame = Frame::Sample(self.sample(telemetry));
        if !encode(seq, &frame).is_some_and(|wire| output.frame(&wire)) {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    fn header(&self, device: &Device, origin: u32) -> Header {
        let channel =
            |c: &Channel| link::Channel { offset_code: c.offset_code, unit_per_code: c.unit_per_code };
        Header {
            tick_hz: device.tick_hz,
            period_ticks: device.period_ticks(),
            metre_per_count: device.metre_per_count,
            load: channel(&device.load),
            accel: channel(&device.accel),
            decimation: self.decimation,
            preset: self.preset.clone(),
            origin_count: origin as i32,
            mechanics: Mechanics {
                rotary: device.geometry == Geometry::Rotary,
                stroke: device.stroke,
                mass: device.mass,
                damping: device.damping,
                force_max: device.force_max,
                overspeed: device.overspeed,
            },
        }
    }

    fn sample(&self, telemetry: &Telemetry) -> Sample {
        let Telemetry { step, inputs, outputs } = telemetry;
        Sample {
            step: *step,
            sample_ticks: inputs.sample_ticks,
            count: inputs.count as i32,
            edge_age: inputs.sample_ticks.wrapping_sub(inputs.edge_ticks),
            load_code: inputs.load_code,
            accel_code: inputs.accel_code,
            force: outputs.force,
            reference: outputs.reference,
            mode: outputs.mode.code(),
            fault: outputs.fault.map_or(0, |fault| fault.code()),
            referenced: outputs.referenced,
            dropped: self.dropped,
        }
    }
}
