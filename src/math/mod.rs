//! Mathematics without policy.

mod ray;
pub mod simd;
pub mod triangle;

pub use ray::{Hit, Ray};
