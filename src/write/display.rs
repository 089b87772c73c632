//! From a linear picture to what a screen shows: exposure, tone mapping, background, sRGB.

use super::{srgb, tonemap};
use crate::film::Picture;
use crate::lanes::{Floats, Lanes, V3};
use crate::settings::{Background, ToneMap};

/// Encoded sRGB with straight alpha, all in [0, 1], row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Whether every alpha is 1 by intent, so that files need not store it.
    pub opaque: bool,
    /// `width · height` pixels.
    pub pixels: Vec<[f32; 4]>,
}

/// Exposes, tone-maps and encodes a picture.
///
/// The colour of partly covered pixels is divided by the coverage first, so that an edge keeps the surface's colour
/// whatever lies behind it later. A coloured background is laid under in linear light after tone mapping: it comes
/// out as exactly the colour that was asked for.
pub fn develop(picture: &Picture, exposure_ev: f64, operator: ToneMap, background: Background) -> DisplayPicture {
    let developer = Developer::new(exposure_ev, operator, background);
    DisplayPicture {
        width: picture.width,
        height: picture.height,
        opaque: background != Background::Transparent || operator == ToneMap::Course,
        pixels: picture.pixels.iter().map(|pixel| developer.develop(*pixel)).collect(),
    }
}

/// Develops one pixel at a time, as [`develop`] does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Developer {
    scale: f32,
    operator: ToneMap,
    under: Option<[f32; 3]>,
}

impl Developer {
    /// For an exposure in EV.
    pub fn new(exposure_ev: f64, operator: ToneMap, background: Background) -> Self {
        let under = match background {
            Background::Color(rgb) => Some(rgb.map(|c| srgb::decode(f32::from(c) / 255.0))),
            Background::Transparent | Background::Environment => None,
        };
        Self { scale: libm::exp2(exposure_ev) as f32, operator, under }
    }

    /// Encoded sRGB with straight alpha of a linear pixel with premultiplied alpha.
    pub fn develop(&self, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        if self.operator == ToneMap::Course {
            return course([r, g, b], self.scale);
        }
        let alpha = alpha.max(0.0).min(1.0);
        let straight = if alpha > 0.0 { [r, g, b].map(|c| c / alpha * self.scale) } else { [0.0; 3] };
        let shown = tonemap::apply(self.operator, straight);
        let (shown, alpha) = match self.under {
            Some(under) => (std::array::from_fn(|i| shown[i] * alpha + under[i] * (1.0 - alpha)), 1.0),
            None => (shown, alpha),
        };
        let [r, g, b] = shown.map(srgb::encode);
        // What nobody sees is black, not the colour that the tone map gives to nothing.
        if alpha > 0.0 { [r, g, b, alpha] } else { [0.0; 4] }
    }
}

impl Developer {
    /// [`Self::develop`] of sixteen pixels: the same bits.
    #[inline(always)]
    pub fn develop_lanes<L: Lanes>(&self, lanes: L, (color, alpha): (V3<L::F>, L::F)) -> (V3<L::F>, L::F) {
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        if self.operator == ToneMap::Course {
            let levels = V3::new(cut(color.x * self.scale), cut(color.y * self.scale), cut(color.z * self.scale));
            return (levels, one);
        }
        let alpha = alpha.max(zero).min(one);
        let seen = alpha.gt(zero);
        let straight =
            V3::new(color.x / alpha * self.scale, color.y / alpha * self.scale, color.z / alpha * self.scale);
        let straight = V3::new(straight.x.only(seen), straight.y.only(seen), straight.z.only(seen));
        let mut shown = tonemap::apply_lanes(lanes, self.operator, straight);
        let mut over = alpha;
        if let Some([r, g, b]) = self.under {
            let rest = one - alpha;
            shown = V3::new(shown.x * alpha + rest * r, shown.y * alpha + rest * g, shown.z * alpha + rest * b);
            over = one;
        }
        // What nobody sees is black, not the colour that the tone map gives to nothing.
        let seen = over.gt(zero);
        let encoded = V3::new(srgb::encode_lanes(shown.x), srgb::encode_lanes(shown.y), srgb::encode_lanes(shown.z));
        (V3::new(encoded.x.only(seen), encoded.y.only(seen), encoded.z.only(seen)), over)
    }
}

/// [`course`] of a channel of sixteen pixels.
#[inline(always)]
fn cut<F: Floats>(c: F) -> F {
    (c.max(c.fill(0.0)).min(c.fill(1.0)) * 255.0).floor() / 255.0
}

/// 8 bits of linear light over black, cut off and not rounded, as the course tracers of `.ray` scenes write their files.
fn course(color: [f32; 3], scale: f32) -> [f32; 4] {
    // A whole number of 255ths is what quantising gives back.
    let [r, g, b] = color.map(|c| ((c * scale).max(0.0).min(1.0) * 255.0).floor() / 255.0);
    [r, g, b, 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, LANES, Work};
    use crate::math::simd::SimdTier;
    use crate::sampling::{hash_combine, unit_float};

    fn one(pixel: [f32; 4], background: Background) -> [f32; 4] {
        let picture = Picture { width: 1, height: 1, pixels: vec![pixel] };
        develop(&picture, 0.0, ToneMap::Neutral, background).pixels[0]
    }

    #[test]
    fn coverage_does_not_change_the_colour() {
        let whole = one([0.4, 0.3, 0.2, 1.0], Background::Transparent);
        let half = one([0.2, 0.15, 0.1, 0.5], Background::Transparent);
        assert_eq!(whole[..3], half[..3]);
        assert_eq!(half[3], 0.5);
        assert_eq!(one([0.3, 0.3, 0.3, 0.0], Background::Transparent), [0.0; 4]);
        assert_eq!(one([f32::NAN, 0.0, 0.0, f32::NAN], Background::Transparent), [0.0; 4]);
    }

    #[test]
    fn the_background_is_the_colour_asked_for() {
        let empty = one([0.0; 4], Background::Color([18, 52, 240]));
        let bytes = empty.map(|c| srgb::quantise(c, 255.0));
        assert_eq!(bytes, [18, 52, 240, 255]);
        let covered = one([0.4, 0.3, 0.2, 1.0], Background::Color([255; 3]));
        assert_eq!(covered, one([0.4, 0.3, 0.2, 1.0], Background::Transparent));
    }

    /// Sixteen pixels.
    struct Develop<'a>(&'a Developer, &'a [[f32; 4]]);

    impl Work for Develop<'_> {
        type Output = Vec<[f32; 4]>;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Vec<[f32; 4]> {
            let channel = |c: usize| lanes.load(&std::array::from_fn(|i| self.1[i][c]));
            let (color, alpha) = self.0.develop_lanes(lanes, (V3::new(channel(0), channel(1), channel(2)), channel(3)));
            let [r, g, b, a] = [color.x.array(), color.y.array(), color.z.array(), alpha.array()];
            (0..LANES).map(|i| [r[i], g[i], b[i], a[i]]).collect()
        }
    }

    #[test]
    fn sixteen_at_a_time_are_the_same_bits() {
        let odd = [0.0, -0.5, 1e-40, 0.003_130_8, 0.08, 0.76, 0.999, 1.0, 3.7, 1e30, f32::INFINITY, f32::NAN];
        let number = |k: u32| {
            let u = unit_float(hash_combine(7, k));
            if k.is_multiple_of(3) { odd[(u * odd.len() as f32) as usize] } else { libm::powf(10.0, 4.0 * u - 3.0) }
        };
        let pixels: Vec<[f32; 4]> = (0..40 * LANES as u32)
            .map(|k| {
                [number(8 * k), number(8 * k + 1), number(8 * k + 2), [1.0, number(8 * k + 4), 0.3][k as usize % 3]]
            })
            .collect();
        for operator in [ToneMap::Neutral, ToneMap::Aces, ToneMap::Agx, ToneMap::None, ToneMap::Course] {
            for background in [Background::Transparent, Background::Color([10, 200, 90])] {
                let developer = Developer::new(0.3, operator, background);
                for sixteen in pixels.chunks(LANES) {
                    let want: Vec<[f32; 4]> = sixteen.iter().map(|pixel| developer.develop(*pixel)).collect();
                    for tier in SimdTier::ALL {
                        let got = AnyLanes::new(tier).run(Develop(&developer, sixteen));
                        assert_eq!(got, want, "{operator:?} {background:?} {tier:?} {sixteen:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_ev_doubles_the_light() {
        let picture = |v| Picture { width: 1, height: 1, pixels: vec![[v, v, v, 1.0]] };
        let brighter = develop(&picture(0.125), 1.0, ToneMap::None, Background::Transparent);
        assert_eq!(brighter, develop(&picture(0.25), 0.0, ToneMap::None, Background::Transparent));
    }
}
