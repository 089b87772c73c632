//! Interference in a thin film on a surface: Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
//! Modeling of Varying Iridescence", as KHR_materials_iridescence lays it down.

use super::fresnel::{dielectric_f0, schlick_weight};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A film of a dielectric on a base, in air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    /// Index of refraction of the film.
    pub ior: f32,
    /// Nanometres.
    pub thickness: f32,
    /// Reflectance of the base at normal incidence without the film, in [0, 1].
    pub base_f0: Vec3,
}

/// CIE XYZ to linear Rec. 709.
const XYZ_TO_REC709: Mat3 = Mat3::from_cols(
    Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
    Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
    Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
);

impl ThinFilm {
    /// Reflectance for the cosine between direction and micronormal, each channel in [0, 1].
    pub fn at(&self, cos: f32) -> Vec3 {
        let cos = cos.clamp(0.0, 1.0);
        let film_ior = self.ior;
        let cos2_film = 1.0 - (1.0 - cos * cos) / (film_ior * film_ior);
        if !(cos2_film > 0.0) {
            return Vec3::ONE;
        }
        let cos_film = cos2_film.sqrt();

        let outer = schlick(Vec3::splat(dielectric_f0(film_ior)), cos).x;
        let through = 1.0 - outer;
        let outer_phase = if film_ior < 1.0 { PI } else { 0.0 };
        let root = self.base_f0.clamp(Vec3::ZERO, Vec3::splat(0.9999)).map(f32::sqrt);
        let base_ior = (Vec3::ONE + root) / (Vec3::ONE - root);
        let inner = schlick(base_ior.map(|n| dielectric_f0(n / film_ior)), cos_film);
        let inner_phase = base_ior.map(|n| if n < film_ior { PI } else { 0.0 });

        let path = 2.0 * film_ior * self.thickness * cos_film;
        let phase = Vec3::splat(PI - outer_phase) + inner_phase;
        let both = (inner * outer).clamp(Vec3::splat(1e-5), Vec3::splat(0.9999));
        let series = inner * (through * through) / (Vec3::ONE - both);
        // The mean over all wavelengths, and the first two orders of interference.
        let [first, second] = sensitivities(path, phase);
        let root = both.map(f32::sqrt);
        let order = (series - through) * root;
        let sum = series + outer + order * first * 2.0 + order * root * second * 2.0;
        sum.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * schlick_weight(cos)
}

/// The eye's response to a cosine over wave numbers, and to one of twice the frequency and shift: the Fourier transform of the
/// colour matching functions, fitted by Gaussians (section 4.2 of the paper). The path is in nanometres.
fn sensitivities(path: f32, shift: Vec3) -> [Vec3; 2] {
    let phase = TAU * path * 1e-9;
    // Height, position and variance; X has a second lobe.
    let lobe = |value: f32, position: f32, variance: f32, shift: f32| {
        let height = value * (TAU * variance).sqrt();
        let (cos, fade) = (libm::cosf(position * phase + shift), libm::expf(-phase * phase * variance));
        // cos 2θ, and the Gaussian twice as far out.
        let (square, twice) = (fade * fade, 2.0 * cos * cos - 1.0);
        Vec2::new(height * cos * fade, height * twice * square * square)
    };
    let x = lobe(5.4856e-13, 1.6810e6, 4.3278e9, shift.x) + lobe(9.7470e-14, 2.2399e6, 4.5282e9, shift.x);
    let y = lobe(4.4201e-13, 1.7953e6, 9.3046e9, shift.y);
    let z = lobe(5.2481e-13, 2.2084e6, 6.6121e9, shift.z);
    [Vec3::new(x.x, y.x, z.x), Vec3::new(x.y, y.y, z.y)].map(|xyz| XYZ_TO_REC709 * (xyz / 1.0685e-7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_of_no_thickness_is_not_there() {
        for f0 in [0.04, 0.5, 0.9] {
            let film = ThinFilm { ior: 1.8, thickness: 0.0, base_f0: Vec3::splat(f0) };
            // Two orders of interference leave 0.03; oblique, Schlick's form has the film reflect where its index is the air's.
            assert!((film.at(1.0) - f0).abs().max_element() < 0.04, "F0 {f0}: {}", film.at(1.0));
        }
    }

    #[test]
    fn the_second_order_is_the_first_of_twice_the_path_and_shift() {
        for k in 0..200u32 {
            let (path, shift) = (k as f32 * 11.0, Vec3::new(0.0, 3.1, k as f32 * 0.05));
            let (second, own) = (sensitivities(path, shift)[1], sensitivities(2.0 * path, shift * 2.0)[0]);
            assert!((second - own).abs().max_element() < 1e-5, "path {path}: {second} {own}");
        }
    }

    #[test]
    fn thick_films_lose_their_colours_and_thin_ones_have_them() {
        let spread = |thickness| {
            let c = ThinFilm { ior: 1.33, thickness, base_f0: Vec3::splat(0.04) }.at(0.9);
            c.max_element() - c.min_element()
        };
        assert!(spread(400.0) > 0.01 && spread(20_000.0) < 1e-4, "{} and {}", spread(400.0), spread(20_000.0));
    }

    #[test]
    fn reflectances_are_shares() {
        for thickness in [0.0, 1.0, 100.0, 380.0, 1200.0, f32::MAX] {
            for ior in [1.0, 1.3, 2.5] {
                for cos in [0.0, 1e-6, 0.3, 1.0] {
                    let f = ThinFilm { ior, thickness, base_f0: Vec3::new(0.0, 0.3, 1.0) }.at(cos);
                    assert!(f.is_finite() && f.min_element() >= 0.0 && f.max_element() <= 1.0, "{f}");
                }
            }
        }
    }
}
