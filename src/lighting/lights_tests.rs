use super::*;
use crate::geometry::world_bounds;
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, Mask, V3, Work};
use crate::lighting::{EnvironmentSource, LightRoom, ReceiverLanes};
use crate::math::simd::SimdTier;
use crate::sampling::{hash_combine, unit_float};
use glam::DAffine3;
use kiln_formats::scene::{
    ColorInput, ColorSpace, Extent, Falloff, Filter, Image, Instance, Light, LightKind, Material, Mesh, Pixels,
    Texture, TextureRef, UpAxis, Wrap,
};

fn number(i: u32, k: u32) -> f32 {
    unit_float(hash_combine(i, k))
}

/// Lamps of `count` triangles, some of them with a back, and `punctual` lights.
fn scene(count: u32, punctual: u32) -> Scene {
    let mut scene = Scene::default();
    let vector = |i: u32, k: u32, size: f32| [0, 1, 2].map(|c| (number(i, k + c) - 0.5) * size);
    for two_sided in [false, true] {
        let material = scene.materials.len() as u32;
        scene.materials.push(Material {
            emission: ColorInput::constant([3.0, 2.0, 1.0]),
            emission_two_sided: two_sided,
            ..Material::default()
        });
        let own: Vec<u32> = (0..count).filter(|i| (i % 3 == 0) == two_sided).collect();
        let corner = |i: u32, k: u32| {
            let (middle, off) = (vector(i, 0, 2.0), vector(i, 3 * k, 0.2));
            [0, 1, 2].map(|c| middle[c] + off[c])
        };
        let mesh = Mesh {
            positions: own.iter().flat_map(|i| [1, 2, 3].map(|k| corner(*i, k))).collect(),
            triangles: (0..own.len() as u32).map(|t| [0, 1, 2].map(|k| 3 * t + k)).collect(),
            material,
            ..Mesh::default()
        };
        scene.meshes.push(mesh);
        let mesh = scene.meshes.len() as u32 - 1;
        scene.instances.push(Instance { name: String::new(), mesh, transform: DAffine3::IDENTITY });
    }
    for i in 0..punctual {
        let falloff = Falloff::InverseSquare { range: None };
        let kind = match i % 3 {
            0 => LightKind::Directional,
            1 => LightKind::Point { falloff, extent: Extent::Point },
            _ => LightKind::Spot { falloff, inner: 0.2, outer: 0.9 },
        };
        scene.lights.push(Light {
            name: String::new(),
            kind,
            color: [1.0, 2.0, 3.0],
            position: Vec3::from(vector(i, 50, 2.0)).as_dvec3(),
            direction: Vec3::from(vector(i, 60, 1.0)).normalize().as_dvec3(),
            through_glass: false,
        });
    }
    scene
}

fn picture() -> EnvironmentSource {
    let (width, height) = (24, 12);
    let pixels =
        (0..width * height).flat_map(|i| [0, 1, 2, 3].map(|k| number(i, k) * if i % 17 == 3 { 30.0 } else { 0.4 }));
    let image = Image { name: String::new(), width, height, pixels: Pixels::RgbaF32(pixels.collect()) };
    EnvironmentSource::Image { image, rotation_y: 0.8, intensity: 1.5 }
}

struct Lit {
    scene: Scene,
    geometry: Geometry,
    lights: Lights,
}

fn lit(scene: Scene, environment: &EnvironmentSource, up: UpAxis) -> Lit {
    let frame = WorldFrame::new(&scene, world_bounds(&scene));
    let geometry = Geometry::new(&scene, &frame);
    let environment = Environment::new(environment, up);
    let lights = Lights::new(&scene, &geometry, &frame, environment, &PrepareSettings::default());
    Lit { scene, geometry, lights }
}

/// Has the surfaces with a back emit by a texture, and the others be seen through in part.
fn varied(mut scene: Scene) -> Scene {
    let pixels = (0..4 * 8 * 8).map(|k| (number(k, 5) * 255.0) as u8).collect();
    scene.images.push(Image { name: String::new(), width: 8, height: 8, pixels: Pixels::Rgba8(pixels) });
    scene.textures.push(Texture {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Mirror,
        filter: Filter::Linear,
        color_space: ColorSpace::Srgb,
    });
    scene.materials[1].emission.texture = Some(TextureRef::new(0));
    scene.materials[0].alpha.mode = AlphaMode::Blend;
    scene.materials[0].alpha.value.factor = 0.7;
    for mesh in &mut scene.meshes {
        mesh.uvs[0] = (0..mesh.positions.len() as u32).map(|k| [number(k, 6) * 3.0, number(k, 7) * 3.0]).collect();
    }
    scene
}

/// The same with parallelograms of two triangles, in all orders of their corners, in place of each triangle.
fn panels(mut scene: Scene) -> Scene {
    for mesh in &mut scene.meshes {
        for (k, [a, b, c]) in std::mem::take(&mut mesh.triangles).into_iter().enumerate() {
            let [p, q, r] = [a, b, c].map(|i| Vec3::from(mesh.positions[i as usize]));
            mesh.positions.push((q + r - p).to_array());
            let mut both = [[a, b, c], [mesh.positions.len() as u32 - 1, c, b]];
            both[0].rotate_left(k % 3);
            both[1].rotate_left(k / 3 % 3);
            mesh.triangles.extend(both);
        }
    }
    scene
}

fn receiver(i: u32) -> Receiver {
    let v = |k: u32| Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2)) * 2.0 - 1.0;
    Receiver { point: v(70) * 0.5, normal: v(80).normalize(), both_sides: i.is_multiple_of(3) }
}

const REACHES: [LightReach; 3] = [LightReach::Punctual, LightReach::Mis, LightReach::All];

/// Sixteen samples of many groups of receivers; those of the environment with the density that is stated for it afterwards.
struct Samples<'a>(&'a Lit, LightReach);

/// Valid, direction, weight, pdf, target, triangle, the pdf asked for again.
type Row = (bool, [f32; 3], [f32; 3], f32, [f32; 3], u32, f32);

impl Work for Samples<'_> {
    type Output = Vec<[Row; LANES]>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let Self(lit, reach) = self;
        let (mut out, mut room) = (Vec::new(), LightRoom::default());
        for group in 0..40 {
            let places: [Receiver; LANES] = std::array::from_fn(|i| receiver(group * 16 + i as u32));
            let lanes = |f: &dyn Fn(&Receiver) -> f32| l.load(&std::array::from_fn(|i| f(&places[i])));
            let vector =
                |f: &dyn Fn(&Receiver) -> Vec3| V3::new(lanes(&|r| f(r).x), lanes(&|r| f(r).y), lanes(&|r| f(r).z));
            let side = lanes(&|r| if r.both_sides { -1.0 } else { 1.0 });
            let receiver = ReceiverLanes::<L> { point: vector(&|r| r.point), normal: vector(&|r| r.normal), side };
            let random = |k: u32| l.load(&std::array::from_fn(|i| number(group * 16 + i as u32, 90 + k)));
            let (of, u) = ((&lit.scene, &lit.geometry), [random(1), random(2)]);
            let s = lit.lights.sample_lanes(l, of, &receiver, l.first(16), reach, random(0), u, &mut room);
            let (_, escaped) = lit.lights.environment_lanes(l, s.direction, reach);
            let again = L::F::select(s.infinite & s.pdf.gt(l.splat(0.0)), escaped, s.pdf);
            let (valid, pdf, again) = (s.valid.bits(), s.pdf.array(), again.array());
            let triangle = crate::lanes::Words::array(s.triangle);
            out.push(std::array::from_fn(|i| {
                (
                    valid >> i & 1 == 1,
                    s.direction.lane(i),
                    s.weight.lane(i),
                    pdf[i],
                    s.target.lane(i),
                    triangle[i],
                    again[i],
                )
            }));
        }
        out
    }
}

fn near(a: [f32; 3], b: Vec3, tolerance: f32) -> bool {
    (Vec3::from(a) - b).abs().max_element() <= tolerance * (1e-3 + b.abs().max_element())
}

/// Lanes find the light that samples one by one find, with the same weight and density, and the densities asked for
/// afterwards are those of the samples; all tiers give the same bits.
#[test]
fn lanes_sample_as_one_by_one() {
    let none = EnvironmentSource::None;
    for (count, punctual, environment, up) in [
        (2, 0, &none, UpAxis::Y),
        (40, 5, &none, UpAxis::Y),
        (700, 0, &none, UpAxis::Y),
        (100, 0, &none, UpAxis::Y),
        (0, 0, &picture(), UpAxis::Z),
        (0, 0, &picture(), UpAxis::Y),
        (200, 7, &picture(), UpAxis::Y),
        (3, 1, &EnvironmentSource::Constant([0.5, 0.6, 0.7]), UpAxis::Y),
    ] {
        let scene = scene(count, punctual);
        let scene = match count {
            2 | 700 => panels(scene),
            200 => varied(panels(scene)),
            _ => scene,
        };
        let lit = lit(scene, environment, up);
        assert!(lit.lights.lanes_can());
        assert_eq!(lit.lights.emitters.iter().any(Emitter::is_pair), [2, 700].contains(&count));
        for reach in REACHES {
            let plain = AnyLanes::new(SimdTier::Scalar).run(Samples(&lit, reach));
            for tier in SimdTier::ALL {
                let all = AnyLanes::new(tier).run(Samples(&lit, reach));
                assert_eq!(format!("{all:?}"), format!("{plain:?}"), "{tier}");
            }
            let (mut differ, mut found) = (0, 0);
            for (i, row) in plain.iter().flatten().enumerate() {
                let i = i as u32;
                let u = [number(i, 91), number(i, 92)];
                let one = lit.lights.sample(&lit.scene, &lit.geometry, &receiver(i), reach, number(i, 90), u);
                let (valid, direction, weight, pdf, target, triangle, again) = *row;
                let Some(one) = one else {
                    differ += u32::from(valid);
                    continue;
                };
                found += 1;
                let stated = one.pdf.unwrap_or(0.0);
                let same = valid
                    && near(direction, one.direction, 1e-3)
                    && near(weight, one.weight, 2e-3)
                    && (pdf - stated).abs() <= 2e-3 * stated
                    && (again - pdf).abs() <= 2e-3 * pdf
                    && match one.target {
                        Target::Triangle { triangle: t, point, .. } => t == triangle && near(target, point, 1e-4),
                        Target::Point(point) => near(target, point, 1e-4),
                        Target::Infinity => near(target, one.direction, 1e-3),
                    };
                differ += u32::from(!same);
            }
            // Rounding may tip a number over the border between two lights or cells.
            assert!(differ * 50 <= found, "{count} {punctual} {reach:?}: {differ} of {found} differ");
        }
    }
}

/// Radiance and density of the environment along sixteen directions.
struct Escaped<'a>(&'a Lit, LightReach);

impl Work for Escaped<'_> {
    type Output = Vec<([f32; 3], f32)>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let normals: [Vec3; LANES] = std::array::from_fn(|i| receiver(i as u32).normal);
        let row = |k: usize| l.load(&normals.map(|n| n[k]));
        let (radiance, pdf) = self.0.lights.environment_lanes(l, V3::new(row(0), row(1), row(2)), self.1);
        (0..LANES).map(|i| (radiance.lane(i), pdf.array()[i])).collect()
    }
}

/// Also where lights are sampled one by one, because some of them are not what lanes know.
#[test]
fn what_escapes_in_lanes_meets_the_environment_of_one_by_one() {
    for through in [false, true] {
        let mut scene = scene(5, 2);
        scene.lights[0].through_glass = through;
        let lit = lit(scene, &picture(), UpAxis::Y);
        assert_eq!(lit.lights.lanes_can(), !through);
        let environment = lit.lights.environment.as_ref().unwrap();
        for reach in REACHES {
            let all = AnyLanes::new(SimdTier::detect()).run(Escaped(&lit, reach));
            for (i, (radiance, pdf)) in all.into_iter().enumerate() {
                let uv = environment.locate(receiver(i as u32).normal);
                let expected = lit.lights.pdf_environment(uv, reach);
                assert_eq!(expected > 0.0, reach != LightReach::Punctual);
                assert!((pdf - expected).abs() <= 1e-3 * expected, "{pdf} {expected}");
                assert!(near(radiance, environment.radiance_at(uv), 1e-3));
            }
        }
    }
}

/// The mean of 1 / pdf over samples is the solid angle of all that they reach, if the density is that of the samples.
#[test]
fn densities_of_triangles_are_those_of_the_samples() {
    for of_two in [false, true] {
        let lamps = scene(90, 0);
        let lit = lit(if of_two { panels(lamps) } else { lamps }, &EnvironmentSource::None, UpAxis::Y);
        assert_eq!((lit.lights.count(), lit.lights.emitters.len()), (if of_two { 180 } else { 90 }, 90));
        for k in 0..6 {
            // Near the middle, so that there are triangles on all sides.
            let place = Receiver { point: receiver(k).point * 0.3, ..receiver(k) };
            let mut counts = std::collections::BTreeMap::new();
            let tries = 40_000u32;
            let mut missed = 0.0;
            for j in 0..tries {
                let u = [number(j, 1 + 9 * k), number(j, 2 + 9 * k)];
                let choice = number(j, 3 + 9 * k);
                match lit.lights.sample(&lit.scene, &lit.geometry, &place, LightReach::All, choice, u) {
                    Some(LightSample { pdf: Some(pdf), target: Target::Triangle { triangle, point, .. }, .. }) => {
                        let asked = lit.lights.pdf_triangle(&lit.geometry, triangle, &place, point, LightReach::All);
                        assert!((asked - pdf).abs() <= 1e-3 * pdf, "{asked} {pdf}");
                        let (number, sum) = counts.entry(triangle).or_insert((0, 0.0));
                        (*number, *sum) = (*number + 1, *sum + 1.0 / f64::from(pdf) / f64::from(tries));
                    }
                    _ => missed += 1.0 / f64::from(tries),
                }
            }
            // One of few samples says nothing: it stands for as much as they should be together.
            counts.retain(|_, (number, _)| *number > 30);
            let total: f64 = counts.values().map(|(_, sum)| sum).sum();
            let exact: f64 = counts.keys().map(|t| solid_angle(lit.geometry.corners(*t), place.point)).sum();
            assert!(missed < 0.5 && (total / exact - 1.0).abs() < 0.05, "{k}: {total} {exact}, {missed} missed");
        }
    }
}

/// Van Oosterom & Strackee 1983.
fn solid_angle(corners: [Vec3; 3], point: Vec3) -> f64 {
    let [a, b, c] = corners.map(|x| (x - point).as_dvec3().normalize());
    let volume = a.dot(b.cross(c)).abs();
    2.0 * libm::atan2(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// A triangle that lies exactly behind another one is not met by rays, and so is no light.
#[test]
fn what_is_hidden_by_a_twin_is_no_light() {
    let mut twice = scene(9, 0);
    let (one, two) = (twice.instances[0].clone(), twice.instances[1].clone());
    twice.instances.extend([one, two]);
    let (once, twice) =
        (lit(scene(9, 0), &EnvironmentSource::None, UpAxis::Y), lit(twice, &EnvironmentSource::None, UpAxis::Y));
    assert_eq!((once.lights.count(), twice.geometry.len()), (9, 18));
    assert_eq!(twice.lights.count(), 9);
    let place = receiver(1);
    for triangle in 9..18 {
        let point = twice.geometry.corners(triangle).into_iter().sum::<Vec3>() / 3.0;
        assert_eq!(twice.lights.pdf_triangle(&twice.geometry, triangle, &place, point, LightReach::All), 0.0);
    }
}

/// Of one lamp without extent, samples at a receiver are all the same; else they differ, as drawing them shows.
#[test]
fn samples_are_said_to_vary_where_they_do() {
    let grey = EnvironmentSource::Constant([0.3; 3]);
    let none = EnvironmentSource::None;
    let worlds = [(0, 1, &none), (0, 1, &grey), (0, 1, &picture()), (0, 3, &none), (4, 0, &none), (4, 1, &grey)];
    for (triangles, punctual, environment) in worlds {
        let lit = lit(scene(triangles, punctual), environment, UpAxis::Y);
        for reach in REACHES {
            let differ = (0..40).any(|i| {
                let draw = |k: u32| {
                    let [choice, u, v] = [0, 1, 2].map(|n| number(k, 90 + n));
                    lit.lights.sample(&lit.scene, &lit.geometry, &receiver(i), reach, choice, [u, v])
                };
                let directions: Vec<Vec3> = (0..60).filter_map(|k| Some(draw(k)?.direction)).collect();
                directions.windows(2).any(|two| two[0] != two[1])
            });
            let what = format!("{triangles} triangles, {punctual} lamps, {environment:?}, {reach:?}");
            assert_eq!(lit.lights.varies(reach), differ, "{what}");
        }
    }
}
