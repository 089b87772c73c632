use super::exit::{Exit, Fatal};
use clap::Args;
use std::path::PathBuf;

/// `kiln inspect`.
#[derive(Args)]
pub struct InspectCommand {
    /// A .gltf, .glb, .obj or .ray file
    asset: PathBuf,
}

impl InspectCommand {
    /// Does it.
    pub fn run(self) -> Result<Exit, Fatal> {
        Err(Fatal::failed(format!("{}", self.asset.display())))
    }
}
