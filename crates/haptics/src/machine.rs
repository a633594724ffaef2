//! The state machine. States carry what only they know.
//!
//! ```text
//!                 Render(true)                    Excite, Identify
//!        ┌──────────────────────▶ RENDERING ───────────────────────┐
//!        │                            │                            ▼
//!      IDLE ◀── Render(false), Stop ──┘                        EXCITING
//!        ▲ │                                                       │
//!        │ └──────────────── Excite, Identify ────────────────────▶│
//!        │◀───────── ramp-out over: time is up, or Stop ───────────┘
//!        │
//!        │  ClearFault, and the handle is at rest,       any check, or Raise(kind)
//!        │  let go of, inside the stroke             ┌───────── from every state
//!        └──────────────────────────────── FAULT ◀───┘
//! ```
//!
//! Force is on in RENDERING and EXCITING only. The step that finds a fault already gives force 0 with the amplifier
//! off. The first fault is kept with the moment and the motion it was found at; later ones do not overwrite it.

use crate::excitation::{Drive, Excitation};
use crate::renderer::Contact;
use crate::streaming_identify::Procedure;
use crate::{FaultKind, Probe};

/// Something asked of the loop; handled between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one copy per request, not per step
pub enum Request {
    /// Puts the virtual contact on the handle, or takes it off.
    Render(bool),
    /// Moves the handle for identification.
    Excite(Excitation),
    /// The thesis's identification procedure: excite, warm up, accumulate the normal equations.
    Identify(Procedure),
    /// The push of the self-test.
    Probe,
    /// Ends whatever runs; an excitation ramps out first.
    Stop,
    /// Leaves the fault state, if the handle is at rest and let go of.
    ClearFault,
    /// The board or a person reports a fault.
    Raise(FaultKind),
    /// The host promises another such request within so many seconds while force is on; 0 takes the promise back.
    HostWatch {
        /// Length of the promise, s.
        seconds: f32,
    },
}

/// What the machine is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // lives in one place, never moved in the hot path
pub enum Mode {
    /// Force 0, amplifier off.
    Idle,
    /// A virtual contact is on the handle.
    Rendering {
        /// Timer when it was put there, ticks.
        since_ticks: u32,
        /// The contact and its memory.
        contact: Contact,
    },
    /// The handle is driven.
    Exciting {
        /// Progress of the excitation.
        drive: Drive,
        /// Sums are accumulated.
        identifying: bool,
    },
    /// The handle is pushed for the self-test.
    Probing(Probe),
    /// Force withdrawn until cleared.
    Fault(Fault),
}

/// What is kept of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// The first fault.
    pub kind: FaultKind,
    /// Timer when it was found, ticks.
    pub at_ticks: u32,
    /// Handle position then, m.
    pub position: f32,
    /// Handle velocity then, m/s.
    pub velocity: f32,
    /// Force commanded in the step before, N.
    pub force: f32,
}

/// [`Mode`] without its data, for the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ModeId {
    /// Force off.
    #[default]
    Idle = 0,
    /// Virtual contact on the handle.
    Rendering = 1,
    /// Handle driven.
    Exciting = 2,
    /// Handle driven and the normal equations accumulated.
    Identifying = 3,
    /// Fault latched.
    Fault = 4,
}

impl ModeId {
    /// All of them, in order of their codes.
    pub const ALL: &'static [Self] =
        &[Self::Idle, Self::Rendering, Self::Exciting, Self::Identifying, Self::Fault];

    /// Code on the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The one with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|mode| mode.code() == code)
    }

    /// One word for it.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Rendering => "rendering",
            Self::Exciting => "exciting",
            Self::Identifying => "identifying",
            Self::Fault => "fault",
        }
    }
}

impl Mode {
    /// The mode without its data.
    #[must_use]
    pub const fn id(&self) -> ModeId {
        match self {
            Self::Idle => ModeId::Idle,
            Self::Rendering { .. } => ModeId::Rendering,
            Self::Exciting { identifying: false, .. } => ModeId::Exciting,
            Self::Exciting { .. } => ModeId::Identifying,
            Self::Probing(_) => ModeId::Exciting,
            Self::Fault(_) => ModeId::Fault,
        }
    }
}
