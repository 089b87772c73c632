use super::distribution::Grid;
use super::environment_lanes::MapTable;
use super::studio;
use crate::math::luminance;
use glam::Vec3;
use kiln_formats::scene::{Image, Pixels, UpAxis};
use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::{Arc, OnceLock};

/// What a scene is lit by beside its own lights.
#[derive(Clone, Debug, Default)]
pub enum EnvironmentSource {
    /// Nothing.
    None,
    /// The same radiance from everywhere.
    Constant([f32; 3]),
    /// An equirectangular picture: u = 0.5 + atan2(z, x)/2π, v = acos(y)/π from the top row, for assets with +Y up.
    Image {
        /// Linear pixels.
        image: Image,
        /// Turns the environment about the up axis, radians, counter-clockwise seen from above.
        rotation_y: f32,
        /// Multiplies its radiance.
        intensity: f32,
    },
    /// A picture that lights many scenes.
    Shared(Arc<SharedEnvironment>),
    /// A soft key, fill and rim light of our own.
    #[default]
    Studio,
}

/// A picture as in [`EnvironmentSource::Image`] whose tables are made once for all scenes with the same up axis: of a picture with half
/// a million pixels that takes fifty times longer than a tiny asset does.
#[derive(Debug)]
pub struct SharedEnvironment {
    image: Arc<Image>,
    rotation_y: f32,
    intensity: f32,
    /// For +Y and +Z up.
    maps: [OnceLock<Option<Arc<EnvironmentMap>>>; 2],
}

impl SharedEnvironment {
    /// Of linear pixels; the numbers are those of [`EnvironmentSource::Image`].
    pub fn new(image: Arc<Image>, rotation_y: f32, intensity: f32) -> Self {
        Self { image, rotation_y, intensity, maps: Default::default() }
    }

    fn map(&self, up: UpAxis) -> Option<Arc<EnvironmentMap>> {
        let make = || EnvironmentMap::new(&self.image, self.rotation_y, self.intensity, up).map(Arc::new);
        self.maps[usize::from(up == UpAxis::Z)].get_or_init(make).clone()
    }
}

/// Light from infinitely far away.
#[derive(Debug)]
pub enum Environment {
    /// The same from everywhere.
    Constant(Vec3),
    /// An equirectangular picture.
    Map(Arc<EnvironmentMap>),
}

/// An equirectangular environment, read with bilinear interpolation and sampled by how much brighter than its mean it is.
#[derive(Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    rotation: f32,
    up: UpAxis,
    grid: Grid,
    mean: Vec3,
    /// Holds the pixels as well.
    table: MapTable,
}

/// Share of the light up to the mean that light samples look for all the same.
const LEFT: f32 = 0.05;

/// Texels along each side of the sampling grid at most.
const GRID: usize = 1024;

impl Environment {
    /// Builds the environment for an asset with this up axis; `None` when there is none or it is black.
    pub fn new(source: &EnvironmentSource, up: UpAxis) -> Option<Self> {
        match source {
            EnvironmentSource::None => None,
            EnvironmentSource::Constant(c) => (*c != [0.0; 3]).then(|| Self::Constant(Vec3::from(*c))),
            EnvironmentSource::Image { image, rotation_y, intensity } => {
                EnvironmentMap::new(image, *rotation_y, *intensity, up).map(|m| Self::Map(Arc::new(m)))
            }
            EnvironmentSource::Shared(shared) => shared.map(up).map(Self::Map),
            EnvironmentSource::Studio => EnvironmentMap::studio(up).map(Self::Map),
        }
    }

    /// The place of a unit vector in the picture, for [`Environment::radiance_at`] and [`Environment::pdf_at`].
    pub fn locate(&self, dir: Vec3) -> [f32; 2] {
        match self {
            Self::Constant(_) => [0.0; 2],
            Self::Map(map) => map.uv(dir),
        }
    }

    /// Radiance that arrives from a place of the picture.
    pub fn radiance_at(&self, uv: [f32; 2]) -> Vec3 {
        match self {
            Self::Constant(c) => *c,
            Self::Map(map) => map.interpolate(uv),
        }
    }

    /// Radiance that arrives against the unit vector `dir`.
    pub fn radiance(&self, dir: Vec3) -> Vec3 {
        self.radiance_at(self.locate(dir))
    }

    /// A unit direction to the environment, its radiance and the solid angle density.
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, Vec3, f32)> {
        match self {
            Self::Constant(c) => {
                let z = 1.0 - 2.0 * u[0];
                let r = (1.0 - z * z).max(0.0).sqrt();
                let phi = 2.0 * PI * u[1];
                Some((Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z), *c, 0.25 * FRAC_1_PI))
            }
            Self::Map(map) => map.sample(u),
        }
    }

    /// The solid angle density with which [`Environment::sample`] makes the direction of a place of the picture.
    pub fn pdf_at(&self, uv: [f32; 2]) -> f32 {
        match self {
            Self::Constant(_) => 0.25 * FRAC_1_PI,
            Self::Map(map) => map.density(uv),
        }
    }

    /// The solid angle density with which [`Environment::sample`] makes `dir`.
    pub fn pdf(&self, dir: Vec3) -> f32 {
        self.pdf_at(self.locate(dir))
    }

    /// Mean radiance over the sphere.
    pub fn mean(&self) -> Vec3 {
        match self {
            Self::Constant(c) => *c,
            Self::Map(map) => map.mean,
        }
    }
}

impl EnvironmentMap {
    /// The studio, which takes longer to make than a tiny asset does to render: made once a process.
    fn studio(up: UpAxis) -> Option<Arc<Self>> {
        static STUDIOS: [OnceLock<Option<Arc<EnvironmentMap>>>; 2] = [OnceLock::new(), OnceLock::new()];
        let make = || Self::new(&studio::picture(), 0.0, 1.0, up).map(Arc::new);
        STUDIOS[usize::from(up == UpAxis::Z)].get_or_init(make).clone()
    }

    fn new(image: &Image, rotation: f32, intensity: f32, up: UpAxis) -> Option<Self> {
        let (width, height) = (image.width as usize, image.height as usize);
        let decode = crate::geometry::textures::srgb_to_linear;
        let pixels: Vec<Vec3> = match &image.pixels {
            Pixels::RgbaF32(p) => p.chunks_exact(4).map(|c| Vec3::new(c[0], c[1], c[2])).collect(),
            Pixels::Rgba8(p) => {
                let c = |x: u8| decode(f32::from(x) / 255.0);
                p.chunks_exact(4).map(|p| Vec3::new(c(p[0]), c(p[1]), c(p[2]))).collect()
            }
            Pixels::Rgba16(p) => {
                let c = |x: u16| decode(f32::from(x) / 65535.0);
                p.chunks_exact(4).map(|p| Vec3::new(c(p[0]), c(p[1]), c(p[2]))).collect()
            }
        };
        // Brighter than anything: sums of this many texels stay finite.
        let most = Vec3::splat(1e24);
        let clean = |c: Vec3| if c.is_finite() { (c * intensity).clamp(Vec3::ZERO, most) } else { Vec3::ZERO };
        let pixels: Vec<Vec3> = pixels.into_iter().map(clean).collect();
        let (grid_width, grid_height) = (width.min(GRID), height.min(GRID / 2));
        let (mut weights, mut mean) = (vec![0f32; grid_width * grid_height], glam::DVec3::ZERO);
        let mut solid = 0.0;
        for y in 0..height {
            let sine = libm::sin((y as f64 + 0.5) / height as f64 * std::f64::consts::PI);
            let cell = y * grid_height / height * grid_width;
            for x in 0..width {
                let c = pixels[y * width + x];
                mean += c.as_dvec3() * sine;
                solid += sine;
                weights[cell + x * grid_width / width] += luminance(c);
            }
        }
        // Light samples bring what stands out: scattering finds the rest with less noise (Karlík et al. 2019, "MIS Compensation:
        // Optimizing Sampling Techniques in Multiple Importance Sampling"). Something is left for light samples alone.
        let texels = (width * height) as f32 / (grid_width * grid_height) as f32;
        let common = texels * luminance((mean / solid).as_vec3());
        for weight in &mut weights {
            *weight = (*weight - common).max(LEFT * *weight);
        }
        // Interpolation carries light into neighbouring texels, so their cells need density as well.
        let spread = |x: usize, y: usize| {
            let mut sum = 0.0;
            for dy in [-1i64, 0, 1] {
                let row = (y as i64 + dy).clamp(0, grid_height as i64 - 1) as usize;
                for dx in [grid_width - 1, 0, 1] {
                    let share = if dy == 0 && dx == 0 { 8.0 } else { 1.0 };
                    sum += share * weights[row * grid_width + (x + dx) % grid_width];
                }
            }
            sum * libm::sinf((y as f32 + 0.5) / grid_height as f32 * PI)
        };
        let spread: Vec<f32> = (0..grid_width * grid_height).map(|i| spread(i % grid_width, i / grid_width)).collect();
        let grid = Grid::new(&spread, grid_width);
        (grid.total() > 0.0).then(|| {
            let mean = (mean / solid).as_vec3();
            let table = MapTable::new(&pixels, [width, height], &spread, [grid_width, grid_height], rotation, up);
            Self { width, height, rotation, up, grid, mean, table }
        })
    }

    /// What code in lanes reads.
    pub(super) fn table(&self) -> &MapTable {
        &self.table
    }

    fn uv(&self, dir: Vec3) -> [f32; 2] {
        let d = match self.up {
            UpAxis::Y => dir,
            UpAxis::Z => Vec3::new(dir.x, dir.z, -dir.y),
        };
        let u = 0.5 + (libm::atan2f(d.z, d.x) + self.rotation) * (0.5 * FRAC_1_PI);
        // Near the poles acos of y alone loses all precision.
        let v = libm::atan2f((d.x * d.x + d.z * d.z).sqrt(), d.y) * FRAC_1_PI;
        [u - u.floor(), v]
    }

    fn interpolate(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = |x: f32| (x as i64).rem_euclid(self.width as i64) as usize;
        let row = |y: f32| (y as i64).clamp(0, self.height as i64 - 1) as usize * self.width;
        let (xa, xb, ya, yb) = (column(x0), column(x0 + 1.0), row(y0), row(y0 + 1.0));
        let p = |at: usize| self.table.pixel(at);
        (p(ya + xa) * (1.0 - fx) + p(ya + xb) * fx) * (1.0 - fy) + (p(yb + xa) * (1.0 - fx) + p(yb + xb) * fx) * fy
    }

    fn sample(&self, u: [f32; 2]) -> Option<(Vec3, Vec3, f32)> {
        let ([u, v], _) = self.grid.sample(u)?;
        let (theta, phi) = (v * PI, (u - 0.5) * 2.0 * PI - self.rotation);
        let sine = libm::sinf(theta);
        if sine <= 0.0 {
            return None;
        }
        let d = Vec3::new(sine * libm::cosf(phi), libm::cosf(theta), sine * libm::sinf(phi));
        let dir = match self.up {
            UpAxis::Y => d,
            UpAxis::Z => Vec3::new(d.x, -d.z, d.y),
        };
        // Rounding may carry the direction over a cell's border. Its density is looked up again there, so that `pdf`
        // gives the same number for it and the weights of all strategies add up to one.
        let uv = self.uv(dir);
        let pdf = self.density(uv);
        (pdf > 0.0).then(|| (dir, self.interpolate(uv), pdf))
    }

    /// Solid angle density at a point of the picture.
    fn density(&self, uv: [f32; 2]) -> f32 {
        let sine = libm::sinf(uv[1] * PI);
        if sine <= 0.0 { 0.0 } else { self.grid.density(uv) / (2.0 * PI * PI * sine) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash_combine, unit_float};

    fn environment(up: UpAxis, rotation_y: f32) -> Environment {
        let mut pixels = vec![0.05f32; 4 * 32 * 16];
        for (x, y, l) in [(5, 3, 40.0), (6, 3, 25.0), (20, 12, 8.0), (31, 8, 3.0)] {
            pixels[4 * (y * 32 + x)..][..3].fill(l);
        }
        let image = Image { name: String::new(), width: 32, height: 16, pixels: Pixels::RgbaF32(pixels) };
        Environment::new(&EnvironmentSource::Image { image, rotation_y, intensity: 1.0 }, up).unwrap()
    }

    /// The centres of n × n cells of the unit square.
    fn grid(n: u32) -> impl Iterator<Item = [f32; 2]> {
        let centre = move |i: u32| (i as f32 + 0.5) / n as f32;
        (0..n * n).map(move |k| [centre(k % n), centre(k / n)])
    }

    /// Importance sampling and uniform sampling must integrate the map to the same value, and the stated density must
    /// be that of the samples.
    #[test]
    fn sampling_matches_its_density_and_the_integral() {
        for (up, rotation) in [(UpAxis::Y, 0.0), (UpAxis::Y, 1.0), (UpAxis::Z, -2.5)] {
            let map = environment(up, rotation);
            let uniform = Environment::Constant(Vec3::ONE);
            let (mut by_importance, mut by_uniform, mut density, mut poles) = (0.0, 0.0, 0.0, 0);
            // Few samples go where it is dark, so it takes many.
            for i in 0..1 << 21 {
                let u = [1, 2].map(|k| unit_float(hash_combine(i, k)));
                let Some((dir, radiance, pdf)) = map.sample(u) else {
                    // A pole, which has no area.
                    poles += 1;
                    continue;
                };
                assert_eq!(pdf, map.pdf(dir), "at {dir}");
                by_importance += f64::from(radiance.x / pdf) / f64::from(1 << 21);
            }
            assert!(poles < 5, "{poles}");
            // The density jumps at cells' borders, so that a sum over a grid of directions comes near slowly.
            for u in grid(1024) {
                let (dir, _, pdf) = uniform.sample(u).unwrap();
                by_uniform += f64::from(map.radiance(dir).x / pdf) / 1048576.0;
                density += f64::from(map.pdf(dir) / pdf) / 1048576.0;
            }
            assert!((density - 1.0).abs() < 5e-3, "{density}");
            assert!((by_importance / by_uniform - 1.0).abs() < 5e-3, "{by_importance} {by_uniform}");
            let mean = f64::from(map.mean().x) * 4.0 * std::f64::consts::PI;
            assert!((by_importance / mean - 1.0).abs() < 0.02, "{by_importance} {mean}");
        }
    }

    #[test]
    fn directions_follow_the_stated_convention() {
        // u = 0.5 + atan2(z, x)/2π: +X is the middle column, +Z three quarters, and the top row is +Y.
        let mut pixels = vec![0f32; 4 * 8 * 4];
        pixels[4 * (8 + 4)] = 1.0;
        pixels[4 * (8 + 6) + 1] = 1.0;
        pixels[2..4 * 8].iter_mut().step_by(4).for_each(|b| *b = 1.0);
        let image = Image { name: String::new(), width: 8, height: 4, pixels: Pixels::RgbaF32(pixels) };
        let source = EnvironmentSource::Image { image, rotation_y: 0.0, intensity: 2.0 };
        let map = Environment::new(&source, UpAxis::Y).unwrap();
        let at = |phi: f32, theta: f32| {
            map.radiance(Vec3::new(
                libm::sinf(theta) * libm::cosf(phi),
                libm::cosf(theta),
                libm::sinf(theta) * libm::sinf(phi),
            ))
        };
        let row = PI * 1.5 / 4.0;
        assert!((at(PI / 8.0, row) - Vec3::X * 2.0).length() < 1e-5);
        assert!((at(PI / 2.0 + PI / 8.0, row) - Vec3::Y * 2.0).length() < 1e-5);
        assert!((at(1.0, 0.01) - Vec3::Z * 2.0).length() < 1e-5);
    }
}
