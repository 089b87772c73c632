//! Mathematics without policy.

pub mod chi2;
mod frame;
mod ray;
pub mod statistics;
pub mod warp;
#[cfg(test)]
mod warp_tests;

pub use frame::Frame;
pub use ray::{Hit, Ray};
