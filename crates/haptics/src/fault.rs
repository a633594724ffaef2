//! Reasons why force was withdrawn or a request was denied.

use core::fmt;

macro_rules! kinds {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal, $id:literal, $why:literal;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* $variant = $code,)* }

        impl $name {
            /// All, in order of their codes.
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

            /// One sentence: what happened, and what to do.
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
    /// A fault. The same step gives force 0 with the amplifier off; the fault is latched until cleared at rest.
    FaultKind {
        /// Speed above `Device::overspeed`.
        Overspeed = 1, "overspeed", "the handle moved faster than the device allows; let it come to rest";
        /// Position beyond the stroke while force was on.
        EndOfStroke = 2, "end_of_stroke", "the handle ran to the end of its stroke; move it back inside";
        /// Counts beyond the largest acceleration of the device.
        EncoderJump = 3, "encoder_jump", "the encoder moved more than physics allows in one period, or its index pulse came elsewhere; check its cable and shield";
        /// A converter at the end of its scale.
        SensorRail = 4, "sensor_rail", "load cell or accelerometer is at the end of its scale; check cable and load";
        /// NaN or infinity in the loop.
        NonFinite = 5, "non_finite", "the control law gave a force that is not a number; choose another preset";
        /// A sample that came too late or too early.
        MissedDeadline = 6, "missed_deadline", "a control period was missed; if it happens again, report it";
        /// The host broke its promise to report in time.
        HostSilent = 7, "host_silent", "the host was silent for too long while the force was on; check host and cable, see `watch`";
        /// Raised by the board: amplifier, supply or watchdog.
        Hardware = 8, "hardware", "the board reports a fault of amplifier, supply or watchdog";
        /// Emergency stop.
        EmergencyStop = 9, "emergency_stop", "the emergency stop is pressed or its wire is broken; release it";
        /// Force and acceleration show motion, the encoder shows rest.
        EncoderSilent = 10, "encoder_silent", "force and acceleration show motion, the encoder shows rest; check its cable and supply";
        /// The supply fell below the minimum of the chip.
        BrownOut = 11, "brown_out", "the 3.3 V supply broke down; check USB power, regulator, and the current of the amplifier";
        /// The firmware panicked.
        Panic = 12, "panic", "the firmware panicked and restarted; report what happened before";
        /// The loop stopped and the watchdog reset the chip.
        Watchdog = 13, "watchdog", "the control loop stopped and the watchdog restarted the chip; if it happens again, report it";
        /// A fault exception of the processor.
        Crash = 14, "crash", "the processor met an invalid address or instruction and restarted; report what happened before";
        /// The force of several steps in a row came out one period late.
        LateForce = 15, "late_force", "the control step took too long, so the force came a period late; choose a lower rate or another law";
        /// The fault output of the amplifier.
        Amplifier = 16, "amplifier", "the amplifier reports a fault, or the wire of its fault output is broken; check its supply, its current and the wire";
        /// Load cell and motion contradict the commanded force.
        ForceContradicted = 17, "force_contradicted", "load cell and motion contradict the commanded force; check the wire of the command, the supply of the amplifier, and the load cell (`calibrate load`)";
        /// A sensor without any noise, or one that does not follow the motion.
        SensorDead = 18, "sensor_dead", "load cell or accelerometer shows nothing of what the handle does; check its cable and supply, then `selftest`";
        /// I²t from the command.
        MotorHot = 19, "motor_hot", "the motor took more force than it bears for this long; let it cool for a minute";
        /// The crystal stopped.
        Clock = 20, "clock", "the crystal of the board stopped, and the device restarted; `version` shows whether the crystal runs again";
    }
}

kinds! {
    /// Reason why a request was denied. Nothing has changed.
    Denied {
        /// A fault is latched.
        FaultLatched = 1, "fault_latched", "a fault is latched: clear it first";
        /// The handle moves or is pushed.
        NotAtRest = 2, "not_at_rest", "release the handle and wait until it rests; if it does, its load cell is off: `calibrate`, `device`";
        /// The handle is outside the stroke.
        OutsideStroke = 3, "outside_stroke", "the handle is outside its stroke: move it back by hand; if it is inside, `device` has another stroke or resolution";
        /// Another mode is running.
        Busy = 4, "busy", "something else is running: stop it first";
        /// An excitation the device cannot follow.
        BadExcitation = 5, "bad_excitation", "the device cannot follow this excitation";
        /// A sensor is at its rail.
        SensorRail = 6, "sensor_rail", "load cell or accelerometer is at the end of its scale";
        /// Too close to the end of the stroke.
        NoRoom = 7, "no_room", "the handle is too near the end of its stroke: move it to the middle by hand";
        /// The handle is driven, not rendered.
        Driven = 8, "busy", "a motion is running: `stop` ramps it out, `off` switches the amplifier off at once";
        /// A request that `off` overtook.
        SwitchedOff = 9, "switched_off", "`off` came after this command";
        /// The middle of the stroke is unknown.
        Unreferenced = 10, "unreferenced", "the middle of the stroke is unknown since the start: type `home` (the handle searches both stops, hands off), or move the handle to the middle by hand and type `zero`";
        /// The handle moves.
        Moving = 11, "not_at_rest", "the handle moves: hold it still in the middle of its stroke";
    }
}
