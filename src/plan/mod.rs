//! Foretells what a batch takes: [`probe()`] does each asset small, [`Forecast`] scales that up and plays the batch through.

mod forecast;
mod probe;
mod schedule;
mod waiting;

pub use forecast::{Entry, Forecast, Interval};
pub use probe::{Foretold, probe};
pub use waiting::Waiting;
