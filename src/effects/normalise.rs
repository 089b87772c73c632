use super::images;
use crate::geometry::textures::lookup;
use glam::{Vec3, Vec4};
use kiln_formats::Scene;
use kiln_formats::scene::{
    AlphaMode, Channel, ColorInput, Image, Layers, Material, MetalRough, NormalMap, Phong, Pixels, ScalarInput,
    Surface, TextureRef,
};
use serde::Serialize;
use std::collections::BTreeSet;

/// Something in a file that has no effect, and is left away.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Rewrite {
    /// Name of the material or mesh, or its number where it has no name.
    pub place: String,
    /// What was done, as `a clearcoat without strength is none`.
    pub what: &'static str,
}

/// Rewrites what has no effect; what it did. The picture stays the same but for rounding: a flat normal map may say
/// (0.002, 0.002, 1), and numbers that were multiplied at every hit are multiplied once.
pub fn normalise(scene: &mut Scene) -> Vec<Rewrite> {
    let mut rewrites = Vec::new();
    let mut materials = std::mem::take(&mut scene.materials);
    for (number, material) in materials.iter_mut().enumerate() {
        let mut done = Vec::new();
        Inputs { scene, done: &mut done }.of_material(material);
        if material.alpha.mode != AlphaMode::Opaque && is_whole(scene, number as u32, material) {
            material.alpha.mode = AlphaMode::Opaque;
            material.alpha.value = ScalarInput::constant(1.0);
            done.push("an alpha without transparent places is opaque");
        }
        let place = if material.name.is_empty() { format!("material {number}") } else { material.name.clone() };
        rewrites.extend(done.into_iter().map(|what| Rewrite { place: place.clone(), what }));
    }
    scene.materials = materials;
    drop_attributes(scene, &mut rewrites);
    drop_images(scene);
    rewrites
}

/// The inputs of a material.
struct Inputs<'a> {
    /// Without its materials.
    scene: &'a Scene,
    done: &'a mut Vec<&'static str>,
}

impl Inputs<'_> {
    fn of_material(&mut self, material: &mut Material) {
        self.color(&mut material.emission);
        if material.emission.texture.is_some_and(|t| images::is_black(self.image(&t))) {
            material.emission = ColorInput::BLACK;
            self.done.push("a black emissive texture is no light");
        }
        self.scalar(&mut material.alpha.value);
        self.normal_map(&mut material.normal_map);
        match &mut material.surface {
            Surface::MetalRough(m) => self.metal_rough(m),
            Surface::Phong(p) => self.phong(p),
            Surface::Unlit(shown) => self.color(shown),
        }
    }

    fn metal_rough(&mut self, m: &mut MetalRough) {
        self.color(&mut m.base_color);
        self.color(&mut m.specular_color);
        [&mut m.metallic, &mut m.roughness, &mut m.specular, &mut m.transmission]
            .into_iter()
            .for_each(|s| self.scalar(s));
        if is_zero(&m.metallic) && is_zero(&m.specular) && is_zero(&m.transmission) && m.layers.is_none() {
            let textured = m.roughness.texture.is_some() || m.specular_color.texture.is_some();
            m.roughness = ScalarInput::constant(1.0);
            m.specular_color = ColorInput::WHITE;
            if textured {
                self.done.push("textures of a reflection without strength are not read");
            }
        }
        if let Some(layers) = &mut m.layers {
            self.layers(layers);
            if *layers == Layers::default() {
                m.layers = None;
                self.done.push("layers without strength are none");
            }
        }
    }

    fn layers(&mut self, layers: &mut Layers) {
        let none = Layers::default();
        for slot in [&mut layers.sheen_color, &mut layers.diffuse_transmission_color] {
            self.color(slot);
        }
        self.scalar(&mut layers.clearcoat);
        self.scalar(&mut layers.clearcoat_roughness);
        self.scalar(&mut layers.sheen_roughness);
        self.scalar(&mut layers.iridescence);
        self.scalar(&mut layers.iridescence_thickness);
        self.scalar(&mut layers.diffuse_transmission);
        self.scalar(&mut layers.diffuse_roughness);
        self.normal_map(&mut layers.clearcoat_normal_map);
        let before = *layers;
        if is_zero(&layers.clearcoat) {
            layers.clearcoat_roughness = none.clearcoat_roughness;
            layers.clearcoat_normal_map = None;
        }
        if layers.sheen_color.is_black() {
            layers.sheen_roughness = none.sheen_roughness;
        }
        if is_zero(&layers.iridescence) {
            layers.iridescence_ior = none.iridescence_ior;
            layers.iridescence_thickness = none.iridescence_thickness;
        }
        if layers.anisotropy == 0.0 {
            layers.anisotropy_rotation = 0.0;
            layers.anisotropy_texture = None;
        }
        if is_zero(&layers.diffuse_transmission) {
            layers.diffuse_transmission_color = none.diffuse_transmission_color;
        }
        if *layers != before {
            self.done.push("inputs of a layer without strength are not read");
        }
    }

    fn phong(&mut self, p: &mut Phong) {
        let colors = [&mut p.ambient, &mut p.diffuse, &mut p.specular, &mut p.mirror, &mut p.transmission];
        colors.into_iter().for_each(|c| self.color(c));
        [&mut p.exponent, &mut p.ior].into_iter().for_each(|s| self.scalar(s));
    }

    fn color(&mut self, input: &mut ColorInput) {
        let Some(reference) = input.texture else { return };
        if input.is_black() {
            input.texture = None;
        } else if [Channel::R, Channel::G, Channel::B].into_iter().all(|c| self.is_constant(&reference, c)) {
            let value = Vec3::from(input.factor) * self.first_texel(&reference).truncate();
            *input = ColorInput::constant(value.to_array());
            self.done.push("a texture of one colour is a factor");
        }
    }

    fn scalar(&mut self, input: &mut ScalarInput) {
        let Some(reference) = input.texture else { return };
        if input.factor == 0.0 {
            input.texture = None;
        } else if self.is_constant(&reference, input.channel) {
            input.factor *= self.first_texel(&reference)[input.channel as usize];
            input.texture = None;
            self.done.push("a texture of one value is a factor");
        }
    }

    fn normal_map(&mut self, map: &mut Option<NormalMap>) {
        if map.is_some_and(|m| m.scale == 0.0 || images::is_flat(self.image(&m.texture))) {
            *map = None;
            self.done.push("a flat normal map bends nothing");
        }
    }

    /// Decoded.
    fn first_texel(&self, reference: &TextureRef) -> Vec4 {
        let image = self.image(reference);
        let corner = [0.5 / image.width as f32, 0.5 / image.height as f32];
        lookup(self.scene, &TextureRef::new(reference.texture), &[corner; 2])
    }

    fn is_constant(&self, reference: &TextureRef, channel: Channel) -> bool {
        images::is_constant(self.image(reference), channel)
    }

    fn image(&self, reference: &TextureRef) -> &Image {
        image(self.scene, reference)
    }
}

fn image<'a>(scene: &'a Scene, reference: &TextureRef) -> &'a Image {
    &scene.images[scene.textures[reference.texture as usize].image as usize]
}

fn is_zero(input: &ScalarInput) -> bool {
    input.factor == 0.0 && input.bias == 0.0
}

/// Whether alpha leaves no place transparent.
fn is_whole(scene: &Scene, number: u32, material: &Material) -> bool {
    let least = match material.alpha.mode {
        AlphaMode::Opaque => return true,
        AlphaMode::Mask { cutoff } => cutoff,
        AlphaMode::Blend => 1.0,
    };
    let value = &material.alpha.value;
    let of_vertices = scene.meshes.iter().filter(|m| m.material == number).flat_map(|m| &m.colors).map(|c| c[3]);
    let vertices = of_vertices.fold(1.0, f32::min);
    match &value.texture {
        None => (value.bias + value.factor) * vertices >= least,
        // A product of two that vary is not worth the pain, nor is an inverted texture.
        Some(_) if vertices < 1.0 || value.factor <= 0.0 => false,
        Some(reference) => {
            let texel = (least - value.bias) / value.factor;
            images::is_at_least(image(scene, reference), value.channel, texel)
        }
    }
}

/// Leaves away what no material of a mesh reads.
fn drop_attributes(scene: &mut Scene, rewrites: &mut Vec<Rewrite>) {
    for (number, mesh) in scene.meshes.iter_mut().enumerate() {
        let own: BTreeSet<_> = std::iter::once(mesh.material).chain(mesh.vertex_materials.iter().copied()).collect();
        let materials: Vec<_> = own.into_iter().map(|id| &scene.materials[id as usize]).collect();
        let place = || if mesh.name.is_empty() { format!("mesh {number}") } else { mesh.name.clone() };
        let mut done = Vec::new();
        let bends = |m: &&Material| m.normal_map.is_some() || m.layers().is_some_and(Layers::need_tangents);
        if !mesh.tangents.is_empty() && !materials.iter().any(bends) {
            mesh.tangents = Vec::new();
            done.push("tangents without a normal map are not kept");
        }
        for set in 0..2 {
            let reads = |m: &&Material| m.textures().iter().any(|t| usize::from(t.uv_set & 1) == set);
            if !mesh.uvs[set].is_empty() && !materials.iter().any(reads) {
                mesh.uvs[set] = Vec::new();
                done.push("texture coordinates without a texture are not kept");
            }
        }
        if !mesh.colors.is_empty() && mesh.colors.iter().all(|c| *c == [1.0; 4]) {
            mesh.colors = Vec::new();
            done.push("white vertex colours are none");
        }
        rewrites.extend(done.into_iter().map(|what| Rewrite { place: place(), what }));
    }
}

/// Empties images that no material reads.
fn drop_images(scene: &mut Scene) {
    let mut read = vec![false; scene.images.len()];
    for texture in scene.materials.iter().flat_map(Material::textures) {
        read[scene.textures[texture.texture as usize].image as usize] = true;
    }
    for (image, _) in scene.images.iter_mut().zip(read).filter(|(_, read)| !read) {
        (image.width, image.height, image.pixels) = (1, 1, Pixels::Rgba8(vec![0; 4]));
    }
}
