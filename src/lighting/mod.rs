//! Everything that lights: emissive triangles, punctual lights and the environment, each with `sample` and `pdf`.

pub mod distribution;
pub mod environment;
pub mod lights;
pub mod punctual;
mod studio;

pub use environment::{Environment, EnvironmentSource};
pub use lights::{LightReach, LightSample, Lights, Target};
