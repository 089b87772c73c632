//! The metal-rough model with the layers that glTF's extensions put on and into it.

use super::albedo::GgxAlbedo;
use super::colour::{luminance, unit, unit_colour};
use super::fresnel::{Schlick, schlick_weight};
use super::lobe::Lobe;
use super::metal_rough::{Base, MetalRoughParams, SMALLEST_ALPHA, reflection_lobe};
use super::sheen::{self, Charlie};
use super::thin_film::ThinFilm;
use super::{Bsdf, coat};
use glam::{Vec2, Vec3};

/// Parameters of the layers at a point, textures already looked up: KHR_materials_clearcoat, _sheen, _iridescence,
/// _anisotropy, _diffuse_transmission and _diffuse_roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerParams {
    /// Strength of the clear coat, in [0, 1].
    pub clearcoat: f32,
    /// Perceptual roughness of the coat.
    pub clearcoat_roughness: f32,
    /// The coat's own normal in the shading frame, on the viewer's side; +z where it has none of its own.
    pub clearcoat_normal: Vec3,
    /// Colour of the sheen; black for none.
    pub sheen_color: Vec3,
    /// Perceptual roughness of the sheen.
    pub sheen_roughness: f32,
    /// Strength of the thin film, in [0, 1].
    pub iridescence: f32,
    /// Index of the film.
    pub iridescence_ior: f32,
    /// Thickness of the film in nanometres.
    pub iridescence_thickness: f32,
    /// Strength of the anisotropy, in [0, 1]; the x axis of the shading frame is the rough direction.
    pub anisotropy: f32,
    /// Share of the diffuse part that goes to the other side, in [0, 1].
    pub diffuse_transmission: f32,
    /// Its colour.
    pub diffuse_transmission_color: Vec3,
    /// Roughness of the diffuse part (0: Lambert), in [0, 1].
    pub diffuse_roughness: f32,
}

impl LayerParams {
    /// No layer at all.
    pub const NONE: Self = Self {
        clearcoat: 0.0,
        clearcoat_roughness: 0.0,
        clearcoat_normal: Vec3::Z,
        sheen_color: Vec3::ZERO,
        sheen_roughness: 0.0,
        iridescence: 0.0,
        iridescence_ior: 1.3,
        iridescence_thickness: 0.0,
        anisotropy: 0.0,
        diffuse_transmission: 0.0,
        diffuse_transmission_color: Vec3::ONE,
        diffuse_roughness: 0.0,
    };
}

impl Bsdf {
    /// Clear coat over sheen over the metal-rough base with its film, as KHR_materials_clearcoat orders them. Each layer
    /// takes what it reflects to the viewer (its directional albedo) from what lies below, so that all together never
    /// reflect more than they get.
    pub fn layered(p: &MetalRoughParams, layers: &LayerParams, wo: Vec3) -> Self {
        let cos_o = unit(wo.z);
        let mut base = Base::new(p, cos_o);
        let mut bsdf = Self::BLACK;
        // From inside a body, what lies on its outside is not met first; the base's interface stands for all.
        let outside = p.entering || p.thin_walled;
        let mut left = 1.0;
        if outside {
            left *= bsdf.push_coat(layers, wo);
            left *= bsdf.push_sheen(layers, cos_o, left);
        }

        let rough = unit(layers.anisotropy);
        let alpha = Vec2::new(base.alpha + (1.0 - base.alpha) * rough * rough, base.alpha);
        if rough > 0.0 {
            base.alpha = base.alpha.max(SMALLEST_ALPHA);
            // The mean of the albedos of both roughnesses: seldom too low (by 0.055 at most), exact where they are equal.
            let [x, y] = alpha.to_array().map(|a| GgxAlbedo::at(cos_o, a.max(SMALLEST_ALPHA)));
            base.albedo = Some(x.between(&y));
        }
        let not_metal = 1.0 - base.metallic;
        let solid = base.solid(p.thin_walled);
        let reflecting = base.metallic + not_metal - solid;
        // Films far thinner than the waves of light are none.
        let film = if layers.iridescence_thickness > 0.03 { unit(layers.iridescence) } else { 0.0 };
        let (reflection, albedo, mut below) = base.reflection(not_metal - solid);
        let bare = left * (1.0 - film);
        let plain = Schlick { f0: reflection.f0 * bare, f90: reflection.f90 * bare };
        let lobe = if rough > 0.0 {
            Lobe::GgxAnisotropic { alpha: alpha.max(Vec2::splat(SMALLEST_ALPHA)), fresnel: plain }
        } else {
            reflection_lobe(base.alpha, plain)
        };
        bsdf.push_known(lobe, plain.importance(albedo * bare));
        if film > 0.0 {
            let f0 = base.dielectric.f0.lerp(base.colour, base.metallic);
            let (thickness, ior) = (layers.iridescence_thickness.min(1e6), layers.iridescence_ior.max(1.0).min(1e2));
            let thin = ThinFilm { ior, thickness, base_f0: f0 };
            let seen = thin.at(cos_o);
            let (scaled, own) = base.compensated(&Schlick::constant(seen));
            below += film * ((1.0 - own.max_element()).max(0.0) - below);
            let scale = scaled.f0 / seen.max(Vec3::splat(1e-6));
            let tint = scale * (left * film * reflecting);
            let alpha = alpha.max(Vec2::splat(SMALLEST_ALPHA));
            bsdf.push_known(Lobe::ThinFilm { alpha, film: thin, tint }, luminance(own) * (left * film * reflecting));
            // A body's interface gets the film's colour for this viewer: F0 such that Schlick's form has it.
            let rise = schlick_weight(cos_o).min(0.999);
            let wanted = ((seen - rise) / (1.0 - rise)).clamp(Vec3::ZERO, Vec3::ONE);
            base.dielectric.f0 = base.dielectric.f0.lerp(wanted, film);
        }

        let diffuse = not_metal * (1.0 - base.transmission) * below * left;
        let through = unit(layers.diffuse_transmission);
        let albedo = base.colour * (diffuse * (1.0 - through));
        let roughness = unit(layers.diffuse_roughness);
        bsdf.push(
            if roughness > 0.0 { Lobe::RoughDiffuse { albedo, roughness } } else { Lobe::Lambert { albedo } },
            cos_o,
        );
        let tint = unit_colour(layers.diffuse_transmission_color) * (diffuse * through);
        bsdf.push(Lobe::DiffuseTransmission { tint }, cos_o);
        if p.thin_walled {
            let tint = base.colour * (not_metal * base.transmission * below * left);
            bsdf.push_known(base.wall_lobe(tint), luminance(tint));
        } else if solid > 0.0 {
            bsdf.push(base.interface_lobe(p, solid * left), cos_o);
        }
        bsdf.normalised()
    }

    /// Adds the clear coat and gives what is left below it.
    fn push_coat(&mut self, layers: &LayerParams, wo: Vec3) -> f32 {
        let strength = unit(layers.clearcoat);
        let normal = layers.clearcoat_normal;
        let cos = wo.dot(normal);
        if strength == 0.0 || !(cos > 0.0) {
            return 1.0;
        }
        let own = normal != Vec3::Z;
        let roughness = unit(layers.clearcoat_roughness);
        let alpha = if own { (roughness * roughness).max(SMALLEST_ALPHA) } else { roughness * roughness };
        let bare = Schlick { f0: Vec3::splat(coat::F0 * strength), f90: Vec3::splat(strength) };
        let (scale, albedo) = if alpha < SMALLEST_ALPHA {
            (1.0, bare.at(cos).x)
        } else {
            let table = GgxAlbedo::at(cos, alpha);
            let scale = table.compensation(&bare).x;
            (scale, table.single(&bare).x * scale)
        };
        let fresnel = Schlick { f0: bare.f0 * scale, f90: bare.f90 * scale };
        let lobe = if own {
            Lobe::Coat { alpha, strength: strength * scale, normal }
        } else {
            reflection_lobe(alpha, fresnel)
        };
        self.push_known(lobe, fresnel.importance(Vec3::splat(albedo)));
        (1.0 - albedo).max(0.0)
    }

    /// Adds the sheen, seen through what lies above, and gives what is left below it.
    fn push_sheen(&mut self, layers: &LayerParams, cos_o: f32, left: f32) -> f32 {
        let color = unit_colour(layers.sheen_color);
        if color == Vec3::ZERO {
            return 1.0;
        }
        let albedo = sheen::albedo(cos_o, layers.sheen_roughness);
        // The fit of the shadowing gives smooth fibres more than all light at the horizon.
        let color = color / albedo.max(1.0);
        let lobe = Lobe::Sheen { color: color * left, charlie: Charlie::new(layers.sheen_roughness) };
        self.push_known(lobe, luminance(color) * left * albedo.max(0.01));
        (1.0 - color.max_element() * albedo).max(0.0)
    }
}
