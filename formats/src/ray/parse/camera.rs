use super::{Parser, Result};
use crate::ray::source::{At, Offset};
use crate::ray::tree::{CameraBlock, Node};

impl Parser<'_> {
    /// `camera { … }`, behind the keyword.
    pub(super) fn camera(&mut self, opened: Offset) -> Result<()> {
        let mut camera = CameraBlock::default();
        self.block("camera", opened, |p, word, at| {
            match word {
                "position" => camera.position = Some(p.assigned(Self::vec3)?.value),
                "viewdir" => camera.viewdir = Some(p.assigned(Self::vec3)?),
                "updir" => camera.updir = Some(p.assigned(Self::vec3)?),
                "look_at" => camera.look_at = Some(p.assigned(Self::vec3)?),
                "fov" => camera.fov = Some(p.assigned(Self::number)?),
                "aspectratio" => camera.aspect_ratio = Some(p.assigned(Self::number)?),
                "quaternian" | "quaternion" => {
                    camera.quaternion = Some(p.assigned(|p| p.tuple(Self::number))?.value);
                }
                "focaldistance" => {
                    p.assigned(Self::number)?;
                    camera.focal_distance = Some(at);
                }
                _ => p.unknown_field("camera", word, at)?,
            }
            Ok(())
        })?;
        let aimed = camera.look_at.is_some();
        let lonely = match (&camera.viewdir, &camera.updir) {
            (Some(_), None) => Some("camera has `viewdir` but no `updir` (both or neither)"),
            (None, Some(_)) if !aimed => Some("camera has `updir` but no `viewdir` (both or neither)"),
            _ => None,
        };
        if let Some(message) = lonely {
            return Err(self.syntax(opened, message));
        }
        self.nodes.push(Node::Camera(At { at: opened, value: camera }));
        Ok(())
    }
}
