//! Only the effects that a scene calls for: what a scene does not need is found out before anything is made for it.
//!
//! [`normalise()`] rewrites what the file says but has no effect (a texture of one colour is a factor, a flat normal map
//! is none), [`leave_out()`] takes away effects that were not wanted, and [`called_for`] names what is left, with reasons.
//! All of it works on the scene as the importers gave it; what is faster without an effect looks at the scene that it gets.

mod bytes;
mod call;
mod images;
mod knowledge;
mod leave_out;
mod normalise;

pub use bytes::{AttributeBytes, attribute_bytes};
pub use call::{Called, called_for, of_mesh};
pub use knowledge::Knowledge;
pub use leave_out::leave_out;
pub use normalise::{Rewrite, normalise};

#[cfg(test)]
mod tests;
