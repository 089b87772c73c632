//! What a material is at a hit: its normals and its BSDF, textures looked up.

use crate::geometry::Attributes;
use crate::geometry::textures::Reader;
use crate::prepare::PreparedScene;
use crate::shading::{Bsdf, LayerParams, MetalRoughParams, PhongParams};
use glam::{Vec2, Vec3};
use kiln_formats::scene::{ColorInput, Layers, Material, MetalRough, NormalMap, Phong, Surface};

/// A point of a triangle with its material.
#[derive(Clone, Copy)]
pub(super) struct Point<'a> {
    pub prepared: &'a PreparedScene,
    pub triangle: u32,
    pub material: &'a Material,
    pub attributes: &'a Attributes,
    /// Barycentric weights.
    pub b: [f32; 3],
    /// Whether the viewer is in front of the triangle.
    pub front: bool,
    /// Reads textures there.
    pub textures: Reader<'a>,
}

impl Point<'_> {
    /// Perturbed normal from a tangent-space map: glTF's `normalize(sampled · vec3(scale, scale, 1))` in the basis of
    /// tangent, bitangent and normal.
    pub(super) fn mapped_normal(&self, map: &NormalMap, normal: Vec3) -> Option<Vec3> {
        let (tangent, bitangent) = self.tangents(normal)?;
        let texel = self.textures.lookup(&map.texture).truncate() * 2.0 - 1.0;
        (tangent * (texel.x * map.scale) + bitangent * (texel.y * map.scale) + normal * texel.z).try_normalize()
    }

    /// Unit tangent and bitangent at right angles to a normal.
    fn tangents(&self, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let (tangent, handedness) = self.attributes.tangent?;
        let tangent = (tangent - normal * normal.dot(tangent)).try_normalize()?;
        Some((tangent, normal.cross(tangent) * handedness))
    }

    /// Whether what is seen here is mainly reflected or refracted by the surface itself: metal with a normal map, glass, and
    /// mirrors. (Metal whose normals are only interpolated is left to lanes.)
    pub(super) fn reflects_most(&self) -> bool {
        match &self.material.surface {
            Surface::MetalRough(m) => {
                let read = &self.textures;
                let glass = m.volume.is_some() && read.scalar(&m.transmission) >= 0.5;
                glass || (self.material.normal_map.is_some() && (m.ior == 0.0 || read.scalar(&m.metallic) >= 0.5))
            }
            Surface::Phong(p) => {
                let largest = |color: &ColorInput| color.factor.into_iter().fold(0.0, f32::max);
                largest(&p.mirror).max(largest(&p.transmission)) > largest(&p.diffuse)
            }
            Surface::Unlit(_) => false,
        }
    }

    /// The direction in which an anisotropic surface is rough, and how strongly (KHR_materials_anisotropy).
    pub(super) fn grain(&self, layers: &Layers) -> Option<(Vec3, f32)> {
        if layers.anisotropy == 0.0 {
            return None;
        }
        let (mut direction, mut strength) = (Vec2::X, layers.anisotropy);
        if let Some(texture) = &layers.anisotropy_texture {
            let texel = self.textures.lookup(texture).truncate();
            direction = (texel.truncate() * 2.0 - 1.0).try_normalize().unwrap_or(Vec2::X);
            strength *= texel.z;
        }
        let (sin, cos) = libm::sincosf(layers.anisotropy_rotation);
        let direction = Vec2::new(cos, sin).rotate(direction);
        let (tangent, handedness) = self.attributes.tangent?;
        let normal = self.attributes.normal?;
        let bitangent = normal.cross(tangent).normalize_or_zero() * handedness;
        Some((tangent.try_normalize()? * direction.x + bitangent * direction.y, strength))
    }

    /// The normal of a clear coat that has not that of the surface: its own map's, or the unbent one above a base with a
    /// map.
    pub(super) fn coat_normal(&self, layers: &Layers, unmapped: Vec3) -> Option<Vec3> {
        if layers.clearcoat_normal_map == self.material.normal_map {
            return None;
        }
        match &layers.clearcoat_normal_map {
            Some(map) => Some(self.mapped_normal(map, unmapped).unwrap_or(unmapped)),
            None => Some(unmapped),
        }
    }

    /// The scattering seen from `wo` in the shading frame. `index_around` is the index of refraction around the body that
    /// the surface bounds; `grain` the strength of the anisotropy along the frame's x; `coat` gives the normal of a clear
    /// coat in the frame.
    pub(super) fn bsdf(&self, index_around: f32, wo: Vec3, grain: f32, coat: impl FnOnce(&Layers) -> Vec3) -> Bsdf {
        match &self.material.surface {
            Surface::Unlit(_) => Bsdf::BLACK,
            Surface::MetalRough(m) => {
                let params = self.metal_rough(m, index_around);
                match &m.layers {
                    None => Bsdf::metal_rough(&params, wo.z),
                    Some(layers) => Bsdf::layered(&params, &self.layers(layers, grain, coat(layers)), wo),
                }
            }
            Surface::Phong(own) => Bsdf::phong(&self.phong(own), wo.z),
        }
    }

    fn metal_rough(&self, m: &MetalRough, index_around: f32) -> MetalRoughParams {
        let read = &self.textures;
        MetalRoughParams {
            base_color: read.color(&m.base_color) * self.attributes.color.truncate(),
            metallic: read.scalar(&m.metallic),
            roughness: read.scalar(&m.roughness),
            specular: read.scalar(&m.specular),
            specular_color: read.color(&m.specular_color),
            ior: if m.volume.is_some() { m.ior / index_around } else { m.ior },
            transmission: read.scalar(&m.transmission),
            thin_walled: m.volume.is_none(),
            entering: self.front,
        }
    }

    fn layers(&self, layers: &Layers, anisotropy: f32, clearcoat_normal: Vec3) -> LayerParams {
        let read = &self.textures;
        LayerParams {
            clearcoat: read.scalar(&layers.clearcoat),
            clearcoat_roughness: read.scalar(&layers.clearcoat_roughness),
            clearcoat_normal,
            sheen_color: read.color(&layers.sheen_color),
            sheen_roughness: read.scalar(&layers.sheen_roughness),
            iridescence: read.scalar(&layers.iridescence),
            iridescence_ior: layers.iridescence_ior,
            iridescence_thickness: read.scalar(&layers.iridescence_thickness),
            anisotropy,
            diffuse_transmission: read.scalar(&layers.diffuse_transmission),
            diffuse_transmission_color: read.color(&layers.diffuse_transmission_color),
            diffuse_roughness: read.scalar(&layers.diffuse_roughness),
        }
    }

    fn phong(&self, own: &Phong) -> PhongParams {
        let read = &self.textures;
        let scene = &self.prepared.scene;
        let (mesh, corners) = self.prepared.geometry.source(scene, self.triangle);
        let mut p = PhongParams {
            diffuse: Vec3::ZERO,
            specular: Vec3::ZERO,
            exponent: 0.0,
            mirror: Vec3::ZERO,
            transmission: Vec3::ZERO,
            through: Vec3::ONE,
            ior: 0.0,
            entering: self.front,
        };
        let mut add = |phong: &Phong, weight: f32| {
            p.diffuse += read.color(&phong.diffuse) * weight;
            p.specular += read.color(&phong.specular) * weight;
            p.exponent += read.scalar(&phong.exponent) * weight;
            p.mirror += read.color(&phong.mirror) * weight;
            p.transmission += read.color(&phong.transmission) * weight;
            p.ior += read.scalar(&phong.ior) * weight;
        };
        if mesh.vertex_materials.is_empty() {
            add(own, 1.0);
        } else {
            for (corner, weight) in corners.into_iter().zip(self.b) {
                let id = mesh.vertex_materials[corner];
                if let Surface::Phong(phong) = &scene.materials[id as usize].surface {
                    add(phong, weight);
                }
            }
        }
        p.diffuse *= self.attributes.color.truncate();
        if own.transmission_at_surfaces {
            p.through = p.transmission;
        }
        p
    }
}
