//! Assets in worker processes: whatever goes wrong in one costs one asset.
//!
//! A worker is Kiln itself, started as `kiln worker`. It lives as long as it is well, takes a [`Request`] a line on its
//! standard input and answers with [`Report`]s on its standard output. It ends when its input does, so it never outlives
//! the process that started it by more than a moment.

mod death;
mod isolation;
mod machine;
mod memory;
mod protocol;
mod worker;

pub use isolation::Isolation;
pub use machine::available_memory;
pub use memory::{bound_memory, forget_peak, held_bytes};
pub use protocol::{Report, Request};

pub(super) use death::Death;
pub(super) use worker::Worker;
