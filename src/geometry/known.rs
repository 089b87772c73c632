//! What holds all over a triangle, whatever the point: whether it stops every ray or none, and whether it is dark. Found once
//! for what images say of materials, so that most hits ask no image.

use super::emission;
use super::marks::{Area, Marks};
use super::textures::texel;
use kiln_formats::Scene;
use kiln_formats::scene::{AlphaMode, Channel, Image, Material, Mesh, Pixels, Texture, TextureRef};

/// Every ray is stopped.
const WHOLE: u8 = 1;
/// No ray is stopped.
const OPEN: u8 = 2;
/// No point emits.
const DARK: u8 = 4;

/// Meshes with fewer triangles are not looked at: a few triangles that show a whole image are seldom all alike, and an image
/// that is the same everywhere is gone before (`effects::normalise`).
const FEWEST: usize = 8;
/// So many words of marks are read at most for a scene, some tens of milliseconds, those counted that making them takes ([`Fact::cost`]);
/// triangles beyond are asked at each hit.
const MOST_WORDS: u64 = 1 << 24;
/// By how much texels have to be beyond a limit so that what is mixed of them is beyond it as well, whatever the rounding.
const ROUNDING: f32 = 1e-5;

/// What is known of each triangle.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Empty where nothing is known of any.
    bits: Vec<u8>,
}

impl Known {
    /// Of `count` triangles that come in runs of one mesh, each with the numbers of its triangles in the mesh.
    pub fn new<'a>(scene: &Scene, runs: impl Iterator<Item = (&'a Mesh, &'a [u32])>, count: usize) -> Self {
        let facts: Vec<Vec<Fact>> = scene.materials.iter().map(|material| facts(scene, material)).collect();
        let mut known = Self::default();
        if facts.iter().all(Vec::is_empty) {
            return known;
        }
        let mut marks: Vec<Vec<Option<Marks>>> =
            facts.iter().map(|facts| facts.iter().map(|_| None).collect()).collect();
        let (mut at, mut words) = (0, MOST_WORDS);
        for (mesh, numbers) in runs {
            let material = mesh.material as usize;
            // What vertex colours do to alpha is asked at each hit.
            let plain = mesh.colors.iter().all(|color| color[3] == 1.0);
            let blends = matches!(scene.materials[material].alpha.mode, AlphaMode::Blend) && !mesh.colors.is_empty();
            for (fact, marks) in facts[material].iter().zip(&mut marks[material]) {
                let holds = fact.bit == DARK || plain && !(blends && fact.bit == WHOLE);
                if numbers.len() < FEWEST || !holds {
                    continue;
                }
                let uvs = &mesh.uvs[fact.reference.uv_set as usize & 1];
                if marks.is_none() {
                    let Some(left) = words.checked_sub(fact.cost()) else { continue };
                    words = left;
                }
                let marks = marks.get_or_insert_with(|| fact.marks());
                for (k, number) in numbers.iter().enumerate() {
                    let corner = |v: u32| uvs.get(v as usize).copied().unwrap_or_default();
                    let corners = mesh.triangles[*number as usize].map(corner);
                    let area = Area::of(fact.image, fact.texture, fact.reference, corners);
                    if area.is_some_and(|area| marks.all_in(&area, &mut words)) {
                        if known.bits.is_empty() {
                            known.bits = vec![0; count];
                        }
                        known.bits[at + k] |= fact.bit;
                    }
                }
            }
            at += numbers.len();
        }
        known
    }

    /// Whether a triangle stops every ray, or none; `None` where that depends on the point, or is not known.
    #[inline]
    pub fn coverage(&self, triangle: usize) -> Option<bool> {
        match self.bits.get(triangle).map_or(0, |bits| bits & (WHOLE | OPEN)) {
            WHOLE => Some(true),
            OPEN => Some(false),
            _ => None,
        }
    }

    /// Whether it is known that no point of a triangle emits.
    #[inline]
    pub fn dark(&self, triangle: usize) -> bool {
        self.bits.get(triangle).is_some_and(|bits| bits & DARK != 0)
    }
}

/// Something that is true of a triangle where it is true of all texels that the triangle shows.
struct Fact<'s> {
    bit: u8,
    image: &'s Image,
    texture: &'s Texture,
    reference: &'s TextureRef,
    of: Property,
}

/// Properties of texels.
#[derive(Clone, Copy)]
enum Property {
    /// `bias` + `factor` times a channel is at least, or at most, a limit; `exactly` where a texel that is just there will do,
    /// since mixing ones, and zeros, gives just these.
    Alpha { channel: Channel, factor: f32, bias: f32, limit: f32, above: bool, exactly: Option<f32> },
    /// These channels are zero.
    Black([bool; 3]),
}

/// What there is to be found out about the triangles of a material.
fn facts<'s>(scene: &'s Scene, material: &'s Material) -> Vec<Fact<'s>> {
    let fact = |bit, reference: &'s TextureRef, of| {
        let texture = &scene.textures[reference.texture as usize];
        Fact { bit, image: &scene.images[texture.image as usize], texture, reference, of }
    };
    let mut facts = Vec::new();
    let value = &material.alpha.value;
    let limits = match material.alpha.mode {
        AlphaMode::Opaque => None,
        AlphaMode::Mask { cutoff } => Some(((cutoff, None), (cutoff, None))),
        AlphaMode::Blend => Some(((1.0, Some(1.0)), (0.0, Some(0.0)))),
    };
    if let (Some((whole, open)), Some(reference)) = (limits, &value.texture)
        && value.factor != 0.0
    {
        let (channel, factor, bias) = (value.channel, value.factor, value.bias);
        let alpha = |(limit, exactly), above| Property::Alpha { channel, factor, bias, limit, above, exactly };
        facts.push(fact(WHOLE, reference, alpha(whole, true)));
        facts.push(fact(OPEN, reference, alpha(open, false)));
    }
    let (input, _) = emission::input(material);
    if let Some(reference) = &input.texture
        && !input.is_black()
    {
        facts.push(fact(DARK, reference, Property::Black(input.factor.map(|factor| factor != 0.0))));
    }
    facts
}

impl Fact<'_> {
    /// What making the marks costs, in words that could be read meanwhile: a sixteenth of one for a texel that tables judge, one for others.
    fn cost(&self) -> u64 {
        let texels = u64::from(self.image.width) * u64::from(self.image.height);
        if matches!(self.image.pixels, Pixels::Rgba8(_)) { texels / 16 } else { texels }
    }

    /// The texels of which it is true.
    fn marks(&self) -> Marks {
        let (width, height) = (self.image.width, self.image.height);
        let value = |x, y| texel(self.image, self.texture.color_space, x, y).to_array();
        match (&self.image.pixels, self.of) {
            (Pixels::Rgba8(bytes), of) => {
                // Each byte once, in each of the channels.
                let row = Image { name: String::new(), width: 256, height: 1, pixels: Pixels::Rgba8(all_bytes()) };
                let holds = |channel: usize| {
                    let value = |k| texel(&row, self.texture.color_space, k, 0).to_array();
                    std::array::from_fn::<_, 256, _>(|k| of.holds(channel, value(k as u32)[channel]))
                };
                let table = [0, 1, 2, 3].map(holds);
                let at = |x: u32, y: u32| 4 * (y as usize * width as usize + x as usize);
                Marks::new(width, height, |x, y| {
                    bytes[at(x, y)..][..4].iter().zip(&table).all(|(byte, holds)| holds[*byte as usize])
                })
            }
            (_, of) => Marks::new(width, height, |x, y| {
                value(x, y).into_iter().enumerate().all(|(channel, value)| of.holds(channel, value))
            }),
        }
    }
}

/// All bytes, each as the four channels of a texel.
fn all_bytes() -> Vec<u8> {
    (0..=255).flat_map(|byte| [byte; 4]).collect()
}

impl Property {
    /// Whether a channel of a texel has it; channels that do not matter have.
    fn holds(&self, number: usize, value: f32) -> bool {
        match *self {
            Self::Alpha { channel, factor, bias, limit, above, exactly } => {
                if number != channel as usize {
                    return true;
                }
                let alpha = bias + factor * value;
                let margin = ROUNDING * (1.0 + bias.abs() + factor.abs());
                let just = exactly == Some(value);
                if above {
                    alpha >= limit + margin || just && alpha >= limit
                } else {
                    alpha <= limit - margin || just && alpha <= limit
                }
            }
            Self::Black(counts) => value == 0.0 || !counts.get(number).is_some_and(|counts| *counts),
        }
    }
}

#[cfg(test)]
#[path = "known_tests.rs"]
mod tests;
