use super::shapes::Met;
use crate::geometry::emission;
use crate::geometry::textures::{color, scalar};
use crate::prepare::PreparedScene;
use glam::{DVec3, Vec3};
use kiln_formats::scene::{ColorInput, Phong, Surface};

/// The material of a `.ray` file at a point, in its own terms.
#[derive(Default)]
pub(super) struct Matter {
    pub emission: DVec3,
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
    pub exponent: f64,
    pub mirror: DVec3,
    pub transmission: DVec3,
    /// Whether k_t counts surfaces, and not lengths.
    pub at_surfaces: bool,
    pub ior: f64,
    /// The normal as a map of normals bends it.
    pub bent: Option<DVec3>,
}

impl Matter {
    pub(super) fn at(prepared: &PreparedScene, met: &Met) -> Self {
        let (scene, geometry) = (&prepared.scene, &prepared.geometry);
        let material = &scene.materials[geometry.material(scene, met.triangle) as usize];
        let emission = emission::emitted(scene, geometry, met.triangle, met.b, !met.inside).as_dvec3();
        let attributes = geometry.attributes(scene, met.triangle, met.b);
        let (uv, tint) = (&attributes.uv, attributes.color.truncate().as_dvec3());
        let rgb = |input: &ColorInput| color(scene, input, uv).as_dvec3();
        let mut matter = Self { emission, ..Self::default() };
        if let (Some(map), Some((tangent, handedness))) = (&material.normal_map, attributes.tangent) {
            let texel = rgb(&ColorInput { factor: [1.0; 3], texture: Some(map.texture) }) * 2.0 - 1.0;
            let (normal, tangent) = (met.normal, tangent.as_dvec3().normalize_or_zero());
            let bitangent = normal.cross(tangent) * f64::from(handedness);
            let scale = f64::from(map.scale);
            matter.bent =
                (tangent * (texel.x * scale) + bitangent * (texel.y * scale) + normal * texel.z).try_normalize();
        }
        match &material.surface {
            Surface::Unlit(_) => {}
            // The nearest thing: metals are mirrors, the rest is matt.
            Surface::MetalRough(m) => {
                let metal = f64::from(scalar(scene, &m.metallic, uv)).clamp(0.0, 1.0);
                let base = rgb(&m.base_color) * tint;
                let rough = f64::from(scalar(scene, &m.roughness, uv)).clamp(0.0, 1.0);
                matter.diffuse = base * (1.0 - metal * (1.0 - rough));
                matter.mirror = base * (metal * (1.0 - rough));
                (matter.ambient, matter.ior) = (matter.diffuse, f64::from(m.ior).max(1.0));
            }
            Surface::Phong(own) => {
                let (mesh, corners) = geometry.source(scene, met.triangle);
                let mut add = |p: &Phong, weight: f32| {
                    let share = f64::from(weight);
                    matter.ambient += rgb(&p.ambient) * share;
                    matter.diffuse += rgb(&p.diffuse) * share;
                    matter.specular += rgb(&p.specular) * share;
                    matter.exponent += f64::from(scalar(scene, &p.exponent, uv)) * share;
                    matter.mirror += rgb(&p.mirror) * share;
                    matter.transmission += rgb(&p.transmission) * share;
                    matter.ior += f64::from(scalar(scene, &p.ior, uv)) * share;
                };
                if mesh.vertex_materials.is_empty() {
                    add(own, 1.0);
                } else {
                    for (corner, weight) in corners.iter().zip(met.b) {
                        let id = mesh.vertex_materials[*corner];
                        if let Surface::Phong(phong) = &scene.materials[id as usize].surface {
                            add(phong, weight);
                        }
                    }
                }
                matter.diffuse *= tint;
                matter.at_surfaces = own.transmission_at_surfaces;
            }
        }
        matter
    }

    /// What a surface that is crossed leaves of light.
    pub(super) fn kept_across(&self) -> DVec3 {
        if self.at_surfaces { self.transmission.clamp(DVec3::ZERO, DVec3::ONE) } else { DVec3::ONE }
    }

    /// What a way inside leaves of light: k_t for each world unit.
    pub(super) fn kept_along(&self, distance: f64) -> DVec3 {
        let kept = self.transmission.as_vec3().max(Vec3::ZERO).min(Vec3::ONE).as_dvec3();
        if kept == DVec3::ZERO || self.at_surfaces {
            DVec3::ONE
        } else {
            DVec3::from_array(kept.to_array().map(|k| libm::pow(k, distance)))
        }
    }
}
