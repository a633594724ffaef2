//! What a search result means: where, how much, what else it could be.

pub mod ambiguity;
pub mod channel;
pub mod event;
pub mod export;
pub mod floor;
pub mod free_run;
pub mod known_error;
pub mod locate;
pub mod nuisance;
pub mod unnamed;
pub mod validate;
pub mod words;
