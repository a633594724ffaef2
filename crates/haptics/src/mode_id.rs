//! Names of the modes, for the wire and for people.

/// [`crate::Mode`] without its data.
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
    /// Handle driven to the stops.
    Homing = 5,
}

impl ModeId {
    /// Whether the device moves the handle by itself.
    #[must_use]
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Exciting | Self::Identifying | Self::Homing)
    }

    /// All, in order of their codes.
    pub const ALL: &'static [Self] =
        &[Self::Idle, Self::Rendering, Self::Exciting, Self::Identifying, Self::Fault, Self::Homing];

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

    /// Name, one word.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Rendering => "rendering",
            Self::Exciting => "exciting",
            Self::Identifying => "identifying",
            Self::Fault => "fault",
            Self::Homing => "homing",
        }
    }
}
