//! What the whole program promises, on real input: it ends, it says what went wrong, it repeats, it stays small, and
//! its light is that of another renderer.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod cornell;
mod corpus;
mod memory;
mod samples;
#[path = "../cli/support.rs"]
#[allow(dead_code, reason = "each test crate uses a part")]
mod support;
mod whitted;

#[path = "../common/mod.rs"]
mod common;
