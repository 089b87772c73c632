//! Foretells what a batch takes: [`probe()`] does each asset small, [`Forecast`] scales that up and plays the batch through.

mod forecast;
mod memory;
mod probe;
mod schedule;

pub use forecast::{Entry, Forecast, Interval};
pub use memory::held as held_bytes;
pub use probe::{Foretold, probe};
