use super::{Parser, Result};
use crate::ray::source::{At, Offset};
use crate::ray::tree::{MeshBlock, Node, Object, ObjectMap, Shape, VertexMaterial};

/// The keyword of a primitive, with a lifetime that outlasts the file's.
pub(super) fn primitive(word: &str) -> Option<&'static str> {
    const WORDS: [&str; 8] = ["sphere", "sphere_light", "box", "square", "cylinder", "cone", "trimesh", "polymesh"];
    WORDS.into_iter().find(|known| *known == word)
}

impl Parser<'_> {
    /// A primitive or mesh, behind the keyword.
    pub(super) fn object(&mut self, keyword: &'static str, opened: Offset) -> Result<()> {
        let shape = match keyword {
            "box" => Shape::Box,
            "square" => Shape::Square,
            "cylinder" => Shape::Cylinder { capped: true },
            "cone" => Shape::Cone { height: 1.0, bottom: 1.0, top: 0.0, capped: true },
            "trimesh" | "polymesh" => Shape::Mesh(Box::default()),
            _ => Shape::Sphere,
        };
        let mut object = Object { name: String::new(), materials: Vec::new(), maps: Vec::new(), emission: None, shape };
        self.block(keyword, opened, |p, word, at| match word {
            "material" => {
                object.materials.push(p.assigned_material()?);
                Ok(())
            }
            "diffuse_map" | "specular_map" | "normal_map" | "bump_map" => {
                let map = match word {
                    "diffuse_map" => ObjectMap::Diffuse,
                    "specular_map" => ObjectMap::Specular,
                    "normal_map" => ObjectMap::Normal,
                    _ => ObjectMap::Bump,
                };
                object.maps.push((map, p.assigned(Self::string)?.value));
                Ok(())
            }
            "emission" => {
                object.emission = Some(p.assigned(|p| p.tuple(Self::single))?);
                Ok(())
            }
            "name" => {
                object.name = p.assigned(Self::string)?.value.value;
                Ok(())
            }
            _ => {
                let known = match &mut object.shape {
                    Shape::Cylinder { capped } if word == "capped" => {
                        *capped = p.assigned(Self::boolean)?.value;
                        true
                    }
                    Shape::Cone { height, bottom, top, capped } => match word {
                        "height" => p.set_number(height)?,
                        "bottom_radius" => p.set_number(bottom)?,
                        "top_radius" => p.set_number(top)?,
                        "capped" => {
                            *capped = p.assigned(Self::boolean)?.value;
                            true
                        }
                        _ => false,
                    },
                    Shape::Mesh(mesh) => p.mesh_field(mesh, object.materials.len(), word)?,
                    _ => false,
                };
                if known { Ok(()) } else { p.unknown_field(keyword, word, at) }
            }
        })?;
        self.nodes.push(Node::Object(At { at: opened, value: object }));
        Ok(())
    }

    fn set_number(&mut self, slot: &mut f64) -> Result<bool> {
        // Shapes end in single precision.
        *slot = f64::from(self.assigned(Self::single)?.value);
        Ok(true)
    }

    /// A field that only meshes have. `after` counts the mesh's `material` fields so far. `false`: no such field.
    fn mesh_field(&mut self, mesh: &mut MeshBlock, after: usize, word: &str) -> Result<bool> {
        match word {
            "points" => self.vectors("points", &mut mesh.points)?,
            "normals" => self.vectors("normals", &mut mesh.normals)?,
            "faces" => self.faces(&mut mesh.faces)?,
            // One name per fork; the base dialect has no texture coordinates on meshes.
            "texture_uv" => self.vectors("texture_uv", &mut mesh.uvs)?,
            "map_points" => self.vectors("map_points", &mut mesh.uvs)?,
            "tex_coords" => self.vectors("tex_coords", &mut mesh.uvs)?,
            "has_tex_coords" => {
                self.assigned(Self::boolean)?;
            }
            "materials" => self.list("materials", |p| {
                mesh.vertex_materials.push(VertexMaterial { after, material: p.material()? });
                Ok(())
            })?,
            "gennormals" => {
                mesh.generate_normals = if self.at_punct(b'=') { self.assigned(Self::boolean)?.value } else { true };
            }
            "objfile" => mesh.objfile = Some(self.assigned(Self::string)?.value),
            _ => return Ok(false),
        }
        Ok(true)
    }
}
