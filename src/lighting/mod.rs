//! Everything that lights: emissive triangles, punctual lights and the environment, each with `sample` and `pdf`.

mod area;
mod area_lanes;
mod bounds;
pub mod casters;
mod casters_lanes;
mod clusters;
mod clusters_lanes;
mod distribution;
mod duplicates;
mod emitter;
mod environment;
mod environment_lanes;
mod lights;
mod lights_lanes;
mod punctual;
mod sample;
mod spherical;
mod studio;
mod tree;

pub use casters_lanes::ConesLanes;
pub use clusters::Receiver;
pub use clusters_lanes::{LightRoom, ReceiverLanes};
pub use environment::{Environment, EnvironmentSource, SharedEnvironment};
pub use lights::Lights;
pub use lights_lanes::LightSampleLanes;
pub use sample::{LightReach, LightSample, Target};
