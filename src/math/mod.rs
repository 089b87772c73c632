//! Mathematics without policy.

mod frame;
mod ray;
pub mod statistics;
pub mod warp;

pub use frame::Frame;
pub use ray::{Hit, Ray};
