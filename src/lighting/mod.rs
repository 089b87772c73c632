//! Everything that lights: emissive triangles, punctual lights and the environment, each with `sample` and `pdf`.

mod bounds;
mod distribution;
mod environment;
mod lights;
mod punctual;
mod studio;
mod tree;

pub use environment::{Environment, EnvironmentSource};
pub use lights::{LightReach, LightSample, Lights, Target};
pub use tree::Receiver;
