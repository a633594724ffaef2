//! Why force was withdrawn, and why a request was not obeyed.

use core::fmt;

macro_rules! kinds {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal, $id:literal, $why:literal;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* $variant = $code,)* }

        impl $name {
            /// All of them, in order of their codes.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Code on the wire; 0 means none.
            #[must_use]
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// The one with this code.
            #[must_use]
            pub fn from_code(code: u8) -> Option<Self> {
                Self::ALL.iter().copied().find(|kind| kind.code() == code)
            }

            /// Short name, one word.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)* }
            }

            /// One sentence: what happened and what to do.
            #[must_use]
            pub const fn explain(self) -> &'static str {
                match self { $(Self::$variant => $why,)* }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.id())
            }
        }
    };
}

kinds! {
    /// A fault: force 0 and amplifier off in the same step, latched until cleared at rest.
    FaultKind {
        /// Speed above `Device::overspeed`.
        Overspeed = 1, "overspeed", "the handle moved faster than the device allows; let it come to rest";
        /// Position beyond the stroke while force was on.
        EndOfStroke = 2, "end_of_stroke", "the handle ran to the end of its stroke; move it back inside";
        /// Counts that no acceleration of this device explains.
        EncoderJump = 3, "encoder_jump", "the encoder moved more than physics allows in one period; check its cable and shield";
        /// A converter at the end of its scale.
        SensorRail = 4, "sensor_rail", "load cell or accelerometer is at the end of its scale; check cable and load";
        /// NaN or infinity in the loop.
        NonFinite = 5, "non_finite", "the control law gave a force that is not a number; choose another preset";
        /// A sample that came too late or too early.
        MissedDeadline = 6, "missed_deadline", "a control period was missed: something kept the processor from its step; if it comes again, report it";
        /// The host promised to be there and is not.
        HostSilent = 7, "host_silent", "nothing came over the serial line for too long while the handle was driven; check host and cable, see `watch`";
        /// Raised by the board: amplifier, supply, watchdog.
        Hardware = 8, "hardware", "the board reported a fault of amplifier, supply or watchdog";
        /// A person asked for it.
        EmergencyStop = 9, "emergency_stop", "the emergency stop was pressed, or its wire is broken; release it";
        /// Force and acceleration say motion, the encoder says rest.
        EncoderSilent = 10, "encoder_silent", "force and acceleration say that the handle moves, the encoder says rest; check its cable and supply";
        /// The supply fell below what the chip needs.
        BrownOut = 11, "brown_out", "the 3.3 V supply broke down; check the USB power or the regulator, and what the amplifier draws";
        /// The firmware gave up on a contradiction in itself.
        Panic = 12, "panic", "the firmware met a contradiction in itself and restarted; report what was done before";
        /// The loop had stopped.
        Watchdog = 13, "watchdog", "the control loop had stopped and the watchdog restarted the chip; if it comes again, report it";
        /// A fault exception of the processor.
        Crash = 14, "crash", "the processor met an address or instruction that cannot be and restarted; report what was done before";
    }
}

kinds! {
    /// Why a request was not obeyed; nothing has changed.
    Denied {
        /// A fault is latched.
        FaultLatched = 1, "fault_latched", "a fault is latched: clear it first";
        /// The handle moves or is pushed.
        NotAtRest = 2, "not_at_rest", "let go of the handle and wait until it rests";
        /// The handle is outside the stroke.
        OutsideStroke = 3, "outside_stroke", "the handle is outside its stroke: move it back by hand";
        /// Something else is running.
        Busy = 4, "busy", "something else is running: stop it first";
        /// An excitation the device cannot follow.
        BadExcitation = 5, "bad_excitation", "the device cannot follow this excitation";
        /// A sensor is at its rail.
        SensorRail = 6, "sensor_rail", "load cell or accelerometer is at the end of its scale";
        /// Too near the end of the stroke for what was asked.
        NoRoom = 7, "no_room", "the handle is within 5 mm of the end of its stroke: move it to the middle by hand";
    }
}
