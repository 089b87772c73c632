use crate::geometry::coverage;
use crate::math::Ray;
use crate::prepare::PreparedScene;
use glam::{DAffine3, DVec3, Vec3};
use kiln_formats::scene::{AlphaMode, Mesh, Primitive};

/// Distance in units of the rays' frame within which a ray does not meet what it leaves again: the triangle's neighbours.
/// Other surfaces may be as near: where walls meet.
const NEAREST: f32 = 4e-6;
/// Distance in radii within which a sphere is the one that a ray leaves.
const NEAREST_RADIUS: f64 = 1e-9;

/// Surfaces in world space: triangles by the kd-tree, and spheres.
pub(super) struct Shapes<'a> {
    prepared: &'a PreparedScene,
    spheres: Vec<Sphere>,
    /// Which parts of the geometry are spheres.
    is_sphere: Vec<bool>,
}

struct Sphere {
    to_object: DAffine3,
    /// A triangle of it, which tells its material.
    triangle: u32,
}

/// Where a ray met a surface.
pub(super) struct Met {
    /// From the ray's origin, world units.
    pub distance: f64,
    pub point: DVec3,
    /// The shading normal, of unit length: outward; towards the viewer for sheets.
    pub normal: DVec3,
    /// Whether the ray came from inside of what the surface bounds.
    pub inside: bool,
    /// The triangle, or one of the sphere.
    pub triangle: u32,
    /// Barycentric weights in the triangle.
    pub b: [f32; 3],
    is_sphere: bool,
}

impl Met {
    /// The triangle that rays from here leave.
    pub(super) fn leaves(&self) -> Option<u32> {
        (!self.is_sphere).then_some(self.triangle)
    }
}

fn mesh_of(prepared: &PreparedScene, part: usize) -> &Mesh {
    &prepared.scene.meshes[prepared.geometry.parts[part].mesh as usize]
}

impl<'a> Shapes<'a> {
    pub(super) fn new(prepared: &'a PreparedScene) -> Self {
        let parts = &prepared.geometry.parts;
        let (mut spheres, mut is_sphere) = (Vec::new(), vec![false; parts.len()]);
        for (k, (part, instance)) in parts.iter().zip(&prepared.scene.instances).enumerate() {
            let to_object = instance.transform.inverse();
            let whole = mesh_of(prepared, k).primitive == Some(Primitive::Sphere) && to_object.is_finite();
            let next = parts.get(k + 1).map_or(prepared.geometry.len() as u32, |p| p.first_triangle);
            if whole && next > part.first_triangle {
                spheres.push(Sphere { to_object, triangle: part.first_triangle });
                is_sphere[k] = true;
            }
        }
        Self { prepared, spheres, is_sphere }
    }

    /// The nearest surface along a unit vector.
    pub(super) fn closest(&self, origin: DVec3, dir: DVec3, leaves: Option<u32>) -> Option<Met> {
        let triangle = self.triangle(origin, dir, leaves);
        let mut least = triangle.as_ref().map_or(f64::INFINITY, |met| met.distance);
        let mut nearest = None;
        for sphere in &self.spheres {
            if let Some(t) = sphere.distance(origin, dir).filter(|t| *t < least) {
                least = t;
                nearest = Some(sphere);
            }
        }
        match nearest {
            Some(sphere) => sphere.met(origin, dir, least),
            None => triangle,
        }
    }

    fn triangle(&self, origin: DVec3, dir: DVec3, leaves: Option<u32>) -> Option<Met> {
        let (geometry, frame) = (&self.prepared.geometry, &self.prepared.frame);
        let start = frame.exact_point(origin);
        // From far away the ray begins just before it can meet anything, where `f32` is fine enough.
        let skipped = (-start.dot(dir) - 2.0).max(0.0);
        let start = start + dir * skipped;
        let ray = Ray { origin: start.as_vec3(), dir: dir.as_vec3(), t_max: f32::INFINITY };
        let left = leaves.map(|triangle| geometry.part_index(triangle));
        let hit = self.prepared.tree.closest(&ray, |hit| {
            Some(hit.triangle) != leaves
                && {
                    let part = geometry.part_index(hit.triangle);
                    (hit.t > NEAREST || Some(part) != left) && !self.is_sphere[part as usize]
                }
                && self.is_there(hit.triangle, [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2])
        })?;
        let flat = geometry.front_normal(hit.triangle).try_normalize()?;
        // The distance again, in double precision, where the plane is not too oblique for it.
        let corner = geometry.corners(hit.triangle)[0].as_dvec3();
        let again = (corner - start).dot(flat) / dir.dot(flat);
        let t = if (again - f64::from(hit.t)).abs() < 1e-4 { again } else { f64::from(hit.t) };
        let distance = (t + skipped) / frame.scale();
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let smooth = geometry.attributes(&self.prepared.scene, hit.triangle, b).normal.map(Vec3::as_dvec3);
        let normal = smooth.and_then(DVec3::try_normalize).unwrap_or(flat);
        let behind = dir.dot(flat) > 0.0;
        let part = geometry.part_index(hit.triangle) as usize;
        let sheet = mesh_of(self.prepared, part).primitive == Some(Primitive::Sheet);
        let normal = if sheet && behind { -normal } else { normal };
        let point = origin + dir * distance;
        Some(Met { distance, point, normal, inside: behind && !sheet, triangle: hit.triangle, b, is_sphere: false })
    }

    /// Cut-outs are there or not.
    fn is_there(&self, triangle: u32, b: [f32; 3]) -> bool {
        let (scene, geometry) = (&self.prepared.scene, &self.prepared.geometry);
        let material = &scene.materials[geometry.material(scene, triangle) as usize];
        material.alpha.mode == AlphaMode::Opaque || coverage(scene, geometry, triangle, b) >= 0.5
    }
}

impl Sphere {
    fn distance(&self, origin: DVec3, dir: DVec3) -> Option<f64> {
        let o = self.to_object.transform_point3(origin);
        let d = self.to_object.transform_vector3(dir);
        let (a, half_b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let root = half_b * half_b - a * c;
        if root < 0.0 {
            return None;
        }
        let root = root.sqrt();
        let least = NEAREST_RADIUS / a.sqrt();
        [(-half_b - root) / a, (-half_b + root) / a].into_iter().find(|t| *t > least)
    }

    fn met(&self, origin: DVec3, dir: DVec3, distance: f64) -> Option<Met> {
        let point = origin + dir * distance;
        let on_sphere = self.to_object.transform_point3(point);
        let normal = (self.to_object.matrix3.transpose() * on_sphere).try_normalize()?;
        let inside = dir.dot(normal) > 0.0;
        let b = [1.0, 0.0, 0.0];
        Some(Met { distance, point, normal, inside, triangle: self.triangle, b, is_sphere: true })
    }
}
