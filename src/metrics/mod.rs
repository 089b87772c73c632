//! How much two pictures differ: as displayed, in linear light, in structure, and to the eye.
//!
//! All metrics are functions of two [`Shown`] pictures of one size; the second is the reference.

mod comparison;
mod difference;
pub mod flip;
mod heat_map;
mod plane;
mod shown;
pub mod ssim;

pub use comparison::{Comparison, compare};
pub use difference::{RELMSE_EPSILON, alpha_rmse, relmse, rmse};
pub use heat_map::heat_map;
pub use plane::Plane;
pub use shown::{Show, Shown};
