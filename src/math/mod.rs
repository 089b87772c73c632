//! Mathematics without policy.

mod ray;

pub use ray::{Hit, Ray};
