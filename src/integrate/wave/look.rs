//! Materials of sixteen points, their textures looked up: twin of `integrate/material.rs` for what lanes know.

use super::surface::Fetch;
use crate::geometry::TexturesLanes;
use crate::lanes::{Floats, Lanes, Mask, V3, Words};
use crate::prepare::PreparedScene;
use crate::shading::{ClearCoatLanes, MetalRoughLanes};
use kiln_formats::scene::{
    Channel, ColorInput, Layers, Material, MetalRough, NormalMap, ScalarInput, Surface, TextureRef,
};

/// What materials say at sixteen points.
pub(super) struct Look<L: Lanes> {
    pub params: MetalRoughLanes<L::F>,
    /// What normal maps say, between −1 and 1 and scaled; (0, 0, 1) where there are none.
    pub texel: V3<L::F>,
    /// Where there is a normal map.
    pub mapped: L::M,
    /// Where the normal has to be such that the mirror image of the viewer's direction is above the surface.
    pub bends: L::M,
    /// Clear coats, where there may be any.
    pub coat: Option<CoatLook<L>>,
    /// Radiance that is emitted to the fronts, and to the backs from where they emit: of whom it was asked.
    pub emitted: V3<L::F>,
    pub both_sides: L::M,
}

/// At which points materials are asked.
#[derive(Clone, Copy)]
pub(super) struct Asked<L: Lanes> {
    /// At all.
    pub active: L::M,
    /// For textures and colours.
    pub textured: L::M,
    /// For the light that they emit.
    pub glowing: L::M,
    /// Whether any may have a clear coat.
    pub coated: bool,
}

/// What materials say of their clear coats; their normals are still what the base has without its map.
pub(super) struct CoatLook<L: Lanes> {
    pub params: ClearCoatLanes<L::F>,
    /// As [`Look::texel`].
    pub texel: V3<L::F>,
    /// Where the coat has a normal map of its own.
    pub mapped: L::M,
}

/// Inputs of a material, in this order.
const INPUTS: usize = 7;
const BASE_COLOR: usize = 0;
const METALLIC: usize = 1;
const ROUGHNESS: usize = 2;
const SPECULAR: usize = 3;
const SPECULAR_COLOR: usize = 4;
const TRANSMISSION: usize = 5;
const NORMAL: usize = 6;

/// The textures that are read for each input; black and zero factors need none.
fn references<'a>(material: &'a Material, m: &'a MetalRough) -> [Option<&'a TextureRef>; INPUTS] {
    let color = |input: &'a ColorInput| input.texture.as_ref().filter(|_| !input.is_black());
    let scalar = |input: &'a ScalarInput| input.texture.as_ref().filter(|_| input.factor != 0.0);
    [
        color(&m.base_color),
        scalar(&m.metallic),
        scalar(&m.roughness),
        scalar(&m.specular),
        color(&m.specular_color),
        scalar(&m.transmission),
        material.normal_map.as_ref().map(|map| &map.texture),
    ]
}

impl<L: Lanes> Look<L> {
    /// Of the materials that were fetched.
    #[inline(always)]
    pub fn new(l: L, prepared: &PreparedScene, fetch: &Fetch, width: L::F, asked: Asked<L>) -> Self {
        let Asked { active, textured, glowing, coated } = asked;
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let mut look = Self {
            params: MetalRoughLanes {
                base_color: V3::splat(zero),
                metallic: zero,
                roughness: one,
                specular: zero,
                specular_color: V3::splat(one),
                ior: one,
                transmission: zero,
            },
            texel: V3::new(zero, zero, one),
            mapped: l.mask(0),
            bends: l.mask(0),
            coat: if coated { Some(CoatLook::none(l)) } else { None },
            emitted: V3::splat(zero),
            both_sides: l.mask(0),
        };
        let textures = if textured.any() { Some(fetch.textures(l, prepared, width)) } else { None };
        let ids = l.load_words(&fetch.material);
        let mut left = active.bits();
        // Neighbours mostly have one material: each of those there are, once.
        while left != 0 {
            let id = fetch.material[left.trailing_zeros() as usize];
            let here = ids.eq(l.word(id)) & l.mask(left);
            left &= !here.bits();
            let material = &prepared.scene.materials[id as usize];
            let glows = here & glowing;
            if glows.any()
                && let Some(textures) = &textures
            {
                look.take_emission(l, material, textures, glows);
            }
            if let Surface::MetalRough(m) = &material.surface {
                look.take(l, material, m, textures.as_ref(), here);
                if let (Some(coat), Some(layers)) = (&mut look.coat, &m.layers) {
                    coat.take(l, material, layers, textures.as_ref(), here);
                }
            }
        }
        if textures.is_some() {
            look.params.base_color = look.params.base_color.times(fetch.color(l, textured));
        }
        look
    }

    /// Takes what one material says, where `here`.
    #[inline(always)]
    fn take(&mut self, l: L, material: &Material, m: &MetalRough, textures: Option<&TexturesLanes<L>>, here: L::M) {
        let references = references(material, m);
        let mut texels = [[l.splat(1.0); 4]; INPUTS];
        for k in 0..INPUTS {
            let (Some(reference), Some(textures)) = (references[k], textures) else { continue };
            // Metalness and roughness mostly are channels of one texture.
            texels[k] = match (0..k).find(|other| references[*other] == references[k]) {
                Some(other) => texels[other],
                None => textures.lookup(l, reference, here),
            };
        }
        let p = &mut self.params;
        p.base_color = V3::select(here, color(l, &m.base_color, &texels[BASE_COLOR]), p.base_color);
        p.metallic = L::F::select(here, scalar(l, &m.metallic, &texels[METALLIC]), p.metallic);
        p.roughness = L::F::select(here, scalar(l, &m.roughness, &texels[ROUGHNESS]), p.roughness);
        p.specular = L::F::select(here, scalar(l, &m.specular, &texels[SPECULAR]), p.specular);
        p.specular_color = V3::select(here, color(l, &m.specular_color, &texels[SPECULAR_COLOR]), p.specular_color);
        p.transmission = L::F::select(here, scalar(l, &m.transmission, &texels[TRANSMISSION]), p.transmission);
        p.ior = L::F::select(here, l.splat(m.ior), p.ior);
        if let Some(map) = &material.normal_map {
            self.texel = V3::select(here, scaled::<L>(map, &texels[NORMAL]), self.texel);
            self.mapped = self.mapped | here;
            let metal = if m.ior == 0.0 { here } else { here & p.metallic.ge(l.splat(0.5)) };
            self.bends = self.bends | metal;
        }
    }
}

impl<L: Lanes> Look<L> {
    /// Takes the light that one material emits, where `here`: as `geometry::emission::seen` for what has no texture beside its own.
    #[inline(always)]
    fn take_emission(&mut self, l: L, material: &Material, textures: &TexturesLanes<L>, here: L::M) {
        let input = &material.emission;
        if input.is_black() {
            return;
        }
        let texel = match &input.texture {
            Some(reference) => textures.lookup(l, reference, here),
            None => [l.splat(1.0); 4],
        };
        self.emitted = V3::select(here, color(l, input, &texel), self.emitted);
        if material.emission_two_sided {
            self.both_sides = self.both_sides | here;
        }
    }
}

impl<L: Lanes> CoatLook<L> {
    /// No coat anywhere.
    #[inline(always)]
    fn none(l: L) -> Self {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let up = V3::new(zero, zero, one);
        let params = ClearCoatLanes { strength: zero, roughness: one, normal: up, own: l.mask(0), layered: l.mask(0) };
        Self { params, texel: up, mapped: l.mask(0) }
    }

    /// Takes what one material's layers say, where `here`.
    #[inline(always)]
    fn take(&mut self, l: L, material: &Material, layers: &Layers, textures: Option<&TexturesLanes<L>>, here: L::M) {
        let p = &mut self.params;
        let mut inputs = [l.splat(1.0); 2];
        for (value, input) in inputs.iter_mut().zip([&layers.clearcoat, &layers.clearcoat_roughness]) {
            let texel = match (&input.texture, textures) {
                (Some(reference), Some(textures)) if input.factor != 0.0 => textures.lookup(l, reference, here),
                _ => [*value; 4],
            };
            *value = scalar(l, input, &texel);
        }
        p.strength = L::F::select(here, inputs[0], p.strength);
        p.roughness = L::F::select(here, inputs[1], p.roughness);
        p.layered = p.layered | here;
        if layers.clearcoat_normal_map != material.normal_map {
            p.own = p.own | here;
            if let (Some(map), Some(textures)) = (&layers.clearcoat_normal_map, textures) {
                let texel = textures.lookup(l, &map.texture, here);
                self.texel = V3::select(here, scaled::<L>(map, &texel), self.texel);
                self.mapped = self.mapped | here;
            }
        }
    }
}

/// What a normal map says: between −1 and 1, and scaled.
#[inline(always)]
fn scaled<L: Lanes>(map: &NormalMap, [x, y, z, _]: &[L::F; 4]) -> V3<L::F> {
    V3::new((*x * 2.0 - 1.0) * map.scale, (*y * 2.0 - 1.0) * map.scale, *z * 2.0 - 1.0)
}

/// As `textures::color`, with a texel of ones where there is no texture.
#[inline(always)]
fn color<L: Lanes>(l: L, input: &ColorInput, [r, g, b, _]: &[L::F; 4]) -> V3<L::F> {
    l.splat_vector(input.factor).times(V3::new(*r, *g, *b))
}

/// As `textures::scalar`, with a texel of ones where there is no texture.
#[inline(always)]
fn scalar<L: Lanes>(l: L, input: &ScalarInput, [r, g, b, a]: &[L::F; 4]) -> L::F {
    let channel = match input.channel {
        Channel::R => *r,
        Channel::G => *g,
        Channel::B => *b,
        Channel::A => *a,
    };
    channel * input.factor + l.splat(input.bias)
}
