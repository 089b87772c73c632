//! Passes, the error that a picture states, and asking for one.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod adaptive;
mod calibration;
#[path = "../common/mod.rs"]
mod common;
mod passes;
mod specks;
