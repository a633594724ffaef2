//! The state machine. Each state carries its own data.
//!
//! ```text
//!                 Render(true)                    Excite, Identify
//!        ┌──────────────────────▶ RENDERING ───────────────────────┐
//!        │                            │                            ▼
//!      IDLE ◀── Render(false), Stop ──┘                        EXCITING
//!        ▲ │                                                       │
//!        │ └──────────────── Excite, Identify ────────────────────▶│
//!        │◀───────── end of the ramp-out, after time or Stop ──────┘
//!        │
//!        │  ClearFault, with the handle at rest,         any check, or Raise(kind)
//!        │  released, inside the stroke              ┌───────── from every state
//!        └──────────────────────────────── FAULT ◀───┘
//! ```
//!
//! Off returns to IDLE from RENDERING, EXCITING and HOMING within its step.
//!
//! Beside the mode stands the *reference*: whether the middle of the stroke is known. It is not after every start, and no longer
//! after a fault that doubts the count of the encoder.
//!
//! ```text
//!                 Zero, while idle and at rest
//!  UNREFERENCED ─────────────────────────────────▶ REFERENCED
//!   rendering with │                           ▲    everything
//!   little force   └── Home ──▶ HOMING ── end ─┘
//!        ▲                         │                    │
//!        └── any other end ────────┘   Home, encoder ───┘ (back to UNREFERENCED)
//! ```
//!
//! HOMING is entered from IDLE and RENDERING and ends in IDLE.
//!
//! Force is on only in RENDERING, EXCITING and HOMING. The step that finds a fault gives force 0 with the amplifier off. The first
//! fault is kept with its time and motion; later faults do not overwrite it.

use crate::drive::Drive;
use crate::renderer::Contact;
use crate::streaming_identify::Procedure;
use crate::{Excitation, FaultKind, Homing, ModeId, Probe};

/// A request to the loop, handled between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one copy per request, not per step
pub enum Request {
    /// Turns the virtual contact on or off.
    Render(bool),
    /// Moves the handle for identification.
    Excite(Excitation),
    /// Identifies: excite, warm up, accumulate the normal equations [thesis, ch. 3.5].
    Identify(Procedure),
    /// The push of the self-test.
    Probe,
    /// The ramp of the calibration of the force.
    Ramp,
    /// The handle is in the middle of its stroke.
    Zero,
    /// The middle of the stroke is at this encoder count.
    Middle(u32),
    /// Searches both stops, and the middle between them.
    Home,
    /// Returns to idle. An excitation ramps out first.
    Stop,
    /// Switches the force off in this step, whatever runs. A latched fault stays. Never denied.
    Off,
    /// Leaves the fault state if the handle is at rest and released.
    ClearFault,
    /// Raises a fault, from the board or a person.
    Raise(FaultKind),
    /// Promise of the host to repeat this request in time while force is on.
    HostWatch {
        /// Longest time to the next request, s. 0 withdraws the promise.
        seconds: f32,
    },
}

/// State of the machine.
// a tag of its own: in the niche of a contact it has an impossible value, for which the compiler adds a trap
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // in one place, never moved in the hot path
pub enum Mode {
    /// Force 0, amplifier off.
    Idle,
    /// A virtual contact is on the handle.
    Rendering {
        /// Time at which it began, ticks.
        since_ticks: u32,
        /// The contact with its state.
        contact: Contact,
    },
    /// The handle is driven.
    Exciting {
        /// Progress of the excitation.
        drive: Drive,
        /// Whether sums are accumulated.
        identifying: bool,
    },
    /// The handle is pushed for the self-test, or for the calibration of the force.
    Probing(Probe),
    /// The handle searches the stops.
    Homing(Homing),
    /// Force withdrawn until cleared.
    Fault(Fault),
}

/// Record of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// The first fault.
    pub kind: FaultKind,
    /// Time of the fault, ticks.
    pub at_ticks: u32,
    /// Handle position at that time, m.
    pub position: f32,
    /// Handle velocity at that time, m/s.
    pub velocity: f32,
    /// Force commanded in the previous step, N.
    pub force: f32,
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
            Self::Homing(_) => ModeId::Homing,
            Self::Fault(_) => ModeId::Fault,
        }
    }
}
