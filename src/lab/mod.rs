//! The laboratory: what accuracy costs in time, measured.
//!
//! A [`Study`] renders assets in several [`Way`]s with growing numbers of samples and several seeds, each picture against a
//! [`Reference`] that is made once with its own error bar. What it measures are [`Cell`]s, kept one by one, so that a study
//! that was interrupted goes on where it was. [`analyse`] makes curves, a frontier and sentences of them, [`publish()`] files.

mod analysis;
mod bench;
mod bias;
mod cell;
mod climb;
mod identity;
mod machine;
pub mod plot;
mod point;
mod publish;
mod reference;
mod report;
mod run;
mod store;
mod strip;
mod verdict;
mod way;

pub use analysis::{Analysis, Curve, Versus, analyse};
pub use bias::Bias;
pub use cell::Cell;
pub use machine::machine;
pub use point::Point;
pub use publish::publish;
pub use reference::{Reference, ReferenceFacts};
pub use run::{Observer, Progress, Studied, Study, Subject, run};
pub use store::Store;
pub use verdict::Verdict;
pub use way::{WAYS, Way, effect_ways, ways};
