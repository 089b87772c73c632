//! Which texels of cut-out and blended images can be seen, and so count where colours are averaged.
//!
//! What an image says of colour where it says that nothing is there (often black) is never seen at a texel, but filters would mix it into its
//! neighbours: dark fringes around leaves. So averages go by coverage, and where nothing is there, the colour of what is next to it goes on.

use kiln_formats::scene::{AlphaMode, Channel, Image, Material, Pixels, TextureId, TextureRef};
use kiln_formats::{Control, Scene, Stopped};

/// How much the texels of an image count in averages of its colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Weighing {
    /// All the same.
    #[default]
    Even,
    /// By their alpha: the bits of the least alpha that counts in full, or `None` where each counts as much as it covers.
    Coverage(Option<u32>),
}

impl Weighing {
    /// As much as each texel covers.
    pub fn by_alpha() -> Self {
        Self::Coverage(None)
    }

    /// Those alone with an alpha of at least `cutoff`.
    pub fn by_cutoff(cutoff: f32) -> Self {
        Self::Coverage(Some(cutoff.to_bits()))
    }

    /// The weight of a texel with an alpha in [0, 1].
    fn weigh(self, alpha: f32) -> f32 {
        match self {
            Self::Even => 1.0,
            Self::Coverage(None) => alpha.clamp(0.0, 1.0),
            Self::Coverage(Some(cutoff)) => f32::from(u8::from(alpha >= f32::from_bits(cutoff))),
        }
    }

    /// The weights of an image's texels, in 1/65535; `None` where all count the same.
    pub fn of(self, image: &Image) -> Option<Vec<u16>> {
        if self == Self::Even {
            return None;
        }
        let weigh = |alpha| (self.weigh(alpha) * 65535.0) as u16;
        let weights: Vec<u16> = match &image.pixels {
            Pixels::Rgba8(p) => p.as_chunks::<4>().0.iter().map(|t| weigh(f32::from(t[3]) / 255.0)).collect(),
            Pixels::Rgba16(p) => p.as_chunks::<4>().0.iter().map(|t| weigh(f32::from(t[3]) / 65535.0)).collect(),
            Pixels::RgbaF32(p) => p.as_chunks::<4>().0.iter().map(|t| weigh(t[3])).collect(),
        };
        let first = *weights.first()?;
        weights.iter().any(|w| *w != first).then_some(weights)
    }
}

/// How the texels of each texture count. By coverage where all materials that read it take their coverage from the alpha of the same image,
/// at the same place.
pub(super) fn weighings(scene: &Scene) -> Vec<Weighing> {
    let mut asked: Vec<Option<Weighing>> = vec![None; scene.textures.len()];
    for material in &scene.materials {
        for reference in material.textures() {
            let weighing = weighing(scene, material, &reference);
            let known = &mut asked[reference.texture as usize];
            *known = Some(match *known {
                Some(other) if other != weighing => Weighing::Even,
                _ => weighing,
            });
        }
    }
    asked.into_iter().map(Option::unwrap_or_default).collect()
}

fn weighing(scene: &Scene, material: &Material, reference: &TextureRef) -> Weighing {
    let image = |texture: TextureId| scene.textures[texture as usize].image;
    let value = &material.alpha.value;
    let by_same_image = value.texture.is_some_and(|coverage| {
        let same_place = (coverage.uv_set, coverage.transform) == (reference.uv_set, reference.transform);
        same_place && image(coverage.texture) == image(reference.texture)
    });
    if !by_same_image || value.channel != Channel::A || value.bias != 0.0 || value.factor <= 0.0 {
        return Weighing::Even;
    }
    match material.alpha.mode {
        AlphaMode::Opaque => Weighing::Even,
        AlphaMode::Mask { cutoff } => Weighing::by_cutoff(cutoff / value.factor),
        AlphaMode::Blend => Weighing::by_alpha(),
    }
}

/// Gives the texels that cover nothing the colour of those beside them that do, in images whose colours all go by coverage, so that what is
/// interpolated between both has no colour of what nobody is to see.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn bleed(scene: &mut Scene, control: &Control) -> Result<(), Stopped> {
    let mut by_coverage: Vec<Option<bool>> = vec![None; scene.images.len()];
    for (texture, weighing) in scene.textures.iter().zip(weighings(scene)) {
        let known = &mut by_coverage[texture.image as usize];
        *known = Some(known.unwrap_or(true) && weighing != Weighing::Even);
    }
    for (image, _) in scene.images.iter_mut().zip(by_coverage).filter(|(_, by_coverage)| *by_coverage == Some(true)) {
        control.check()?;
        if let Some(weights) = Weighing::by_alpha().of(image) {
            spread(image, &weights);
        }
    }
    Ok(())
}

/// Gives texels without weight the mean colour of their eight neighbours, by weight. Further away nothing that can be seen is mixed with them.
/// Stored values are averaged as they are: neighbours of one edge have much the same colour.
pub(super) fn spread(image: &mut Image, weights: &[u16]) {
    let size = (image.width as usize, image.height as usize);
    match &mut image.pixels {
        Pixels::Rgba8(p) => spread_texels(p, size, weights, |x| (x + 0.5) as u8),
        Pixels::Rgba16(p) => spread_texels(p, size, weights, |x| (x + 0.5) as u16),
        Pixels::RgbaF32(p) => spread_texels(p, size, weights, |x| x),
    }
}

fn spread_texels<T: Copy + Into<f32>>(
    values: &mut [T],
    (width, height): (usize, usize),
    weights: &[u16],
    store: impl Fn(f32) -> T,
) {
    let texels: &mut [[T; 4]] = values.as_chunks_mut().0;
    for y in 0..height {
        for x in 0..width {
            if weights[y * width + x] != 0 {
                continue;
            }
            // Across the border too: most images tile, and what does not has no neighbour there to tell.
            let rows = [(y + height - 1) % height, y, (y + 1) % height];
            let columns = [(x + width - 1) % width, x, (x + 1) % width];
            let (mut sum, mut weight) = ([0.0; 3], 0.0);
            for at in rows.iter().flat_map(|row| columns.map(|column| row * width + column)) {
                let part = f32::from(weights[at]);
                if part > 0.0 {
                    weight += part;
                    sum.iter_mut().zip(texels[at]).for_each(|(sum, x)| *sum += part * x.into());
                }
            }
            if weight > 0.0 {
                let [r, g, b] = sum.map(|sum| store(sum / weight));
                texels[y * width + x] = [r, g, b, texels[y * width + x][3]];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiln_formats::scene::{
        Alpha, ColorInput, ColorSpace, Filter, NormalMap, ScalarInput, Surface, Texture, UvTransform, Wrap,
    };

    /// Images of one texel row; textures 0 and 1 of the first one, 2 of the second.
    fn scene(texels: &[[u8; 4]]) -> Scene {
        let image = |texels: &[[u8; 4]]| Image {
            name: String::new(),
            width: texels.len() as u32,
            height: 1,
            pixels: Pixels::Rgba8(texels.as_flattened().to_vec()),
        };
        let texture = |image| Texture {
            image,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Linear,
            color_space: ColorSpace::Srgb,
        };
        let images = vec![image(texels), image(texels)];
        Scene { images, textures: [0, 0, 1].map(texture).to_vec(), ..Scene::default() }
    }

    fn cut_out(color: TextureId, coverage: TextureId, mode: AlphaMode) -> Material {
        let value =
            ScalarInput { factor: 0.8, texture: Some(TextureRef::new(coverage)), channel: Channel::A, bias: 0.0 };
        let color = ColorInput { factor: [1.0; 3], texture: Some(TextureRef::new(color)) };
        Material { surface: Surface::Unlit(color), alpha: Alpha { mode, value }, ..Material::default() }
    }

    #[test]
    fn texels_count_by_coverage_where_everybody_sees_them_through_it() {
        let told = |materials: &[Material]| weighings(&Scene { materials: materials.to_vec(), ..scene(&[[0; 4]]) });
        let mask = AlphaMode::Mask { cutoff: 0.4 };
        let (even, blend, cut) = (Weighing::Even, Weighing::by_alpha(), Weighing::by_cutoff(0.5));
        assert_eq!(told(&[cut_out(0, 0, AlphaMode::Blend)]), [blend, even, even]);
        assert_eq!(told(&[cut_out(0, 1, mask)]), [cut, cut, even], "two textures of one image");
        assert_eq!(told(&[cut_out(0, 2, mask)]), [even, even, cut], "colours of another image");
        assert_eq!(told(&[cut_out(0, 0, AlphaMode::Opaque)]), [even; 3]);
        assert_eq!(told(&[cut_out(0, 0, mask), cut_out(0, 0, AlphaMode::Opaque)]), [even; 3], "one sees them all");
        assert_eq!(told(&[cut_out(0, 0, mask), cut_out(0, 0, AlphaMode::Blend)]), [even; 3], "one sees more");
        let mut moved = cut_out(0, 0, mask);
        let transform = UvTransform { offset: [0.5, 0.0], ..UvTransform::IDENTITY };
        moved.normal_map = Some(NormalMap { texture: TextureRef { transform, ..TextureRef::new(1) }, scale: 1.0 });
        assert_eq!(told(&[moved]), [cut, even, even], "read at another place");
        let mut red = cut_out(0, 0, mask);
        red.alpha.value.channel = Channel::R;
        assert_eq!(told(&[red]), [even; 3]);
    }

    #[test]
    fn what_covers_nothing_takes_on_the_colour_beside_it() {
        let texels = [[0, 0, 0, 0], [90, 60, 30, 255], [9, 9, 9, 0], [30, 60, 90, 85], [7, 7, 7, 0], [8, 8, 8, 0]];
        let mut seen = scene(&texels);
        seen.materials = vec![cut_out(0, 1, AlphaMode::Blend)];
        bleed(&mut seen, &Control::default()).expect("not stopped");
        let of = |scene: &Scene, image: usize| match &scene.images[image].pixels {
            Pixels::Rgba8(p) => p.as_chunks().0.to_vec(),
            _ => panic!("bytes stay bytes"),
        };
        let want: [[u8; 4]; 6] =
            [[90, 60, 30, 0], texels[1], [75, 60, 45, 0], texels[3], [30, 60, 90, 0], [8, 8, 8, 0]];
        assert_eq!(of(&seen, 0), want);
        assert_eq!(of(&seen, 1), texels, "another image");
        let mut whole = scene(&texels);
        whole.materials = vec![cut_out(0, 1, AlphaMode::Blend), cut_out(0, 1, AlphaMode::Opaque)];
        bleed(&mut whole, &Control::default()).expect("not stopped");
        assert_eq!(of(&whole, 0), texels, "somebody sees it all");
    }
}
