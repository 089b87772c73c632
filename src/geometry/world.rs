use crate::math::Placement;
use glam::{DAffine3, DVec3, Vec3};
use kiln_formats::Scene;
use kiln_formats::scene::Mesh;

/// The frame that rays live in: the asset's world, moved so that its centre is the origin and scaled by a power of
/// two so that twice the largest distance from there along an axis lies in [1, 2).
///
/// The centre is that of the bounds, but where nearly all triangles are crowded in a small part of them, because something
/// strayed far away, it is in that part: numbers are fine only near zero.
///
/// Moving happens in double precision before anything becomes `f32`; scaling by powers of two is exact. So the same
/// asset gives the same picture a million units from the origin, and bit for bit the same at 2ᵏ times its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldFrame {
    center: DVec3,
    scale: f64,
}

impl WorldFrame {
    /// For a scene with these bounds (none: the identity).
    pub fn new(scene: &Scene, bounds: Option<(DVec3, DVec3)>) -> Self {
        let Some((lo, hi)) = bounds else { return Self { center: DVec3::ZERO, scale: 1.0 } };
        let middle = lo + (hi - lo) * 0.5;
        let center = crowd(scene, (hi - lo).max_element()).unwrap_or(middle);
        let extent = (hi - lo + (center - middle).abs() * 2.0).max_element();
        let scale = if extent > 0.0 && extent.is_finite() {
            libm::ldexp(1.0, -libm::ilogb(extent).clamp(-1000, 1000))
        } else {
            1.0
        };
        Self { center, scale }
    }

    /// A world point in the rays' frame.
    pub fn point(&self, world: DVec3) -> Vec3 {
        self.exact_point(world).as_vec3()
    }

    /// A world point in the rays' frame, in double precision.
    pub fn exact_point(&self, world: DVec3) -> DVec3 {
        (world - self.center) * self.scale
    }

    /// The map from a mesh's coordinates, which `transform` takes to the world, to the rays' frame.
    pub fn placement(&self, transform: &DAffine3) -> Placement {
        let scaled = |axis: DVec3| axis * self.scale;
        let m = transform.matrix3;
        Placement::new(&DAffine3::from_cols(
            scaled(m.x_axis),
            scaled(m.y_axis),
            scaled(m.z_axis),
            self.exact_point(transform.translation),
        ))
    }

    /// The world point of one in the rays' frame.
    pub fn world_point(&self, point: Vec3) -> DVec3 {
        point.as_dvec3() / self.scale + self.center
    }

    /// A world vector in the rays' frame.
    pub fn vector(&self, world: DVec3) -> Vec3 {
        (world * self.scale).as_vec3()
    }

    /// Units of the rays' frame per world unit.
    pub fn scale(&self) -> f64 {
        self.scale
    }
}

/// World-space bounds of everything drawn: lower and upper corner, or nothing. Vertices that no triangle uses do not
/// count.
pub fn world_bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let used: Vec<Vec<bool>> = scene.meshes.iter().map(used_vertices).collect();
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for instance in &scene.instances {
        let positions = scene.meshes[instance.mesh as usize].positions.iter();
        for (p, _) in positions.zip(&used[instance.mesh as usize]).filter(|(_, used)| **used) {
            let [x, y, z] = p.map(f64::from);
            let p = instance.transform.transform_point3(DVec3::new(x, y, z));
            if p.is_finite() {
                bounds = Some(bounds.map_or((p, p), |(lo, hi)| (lo.min(p), hi.max(p))));
            }
        }
    }
    bounds
}

/// Triangles that are looked at to find where most of them are.
const LOOKED_AT: u64 = 4096;
/// Fewer are no crowd.
const FEWEST: usize = 8;
/// A part of the world that is this share of it, or less, is worth being the centre: 14 bits of f32 are left for what is in it.
const SMALL_PART: f64 = 1.0 / 1024.0;

/// The median of the triangles' places, if half of them are within a small part of a world of this extent.
fn crowd(scene: &Scene, extent: f64) -> Option<DVec3> {
    let step = usize::try_from(scene.triangle_count().div_ceil(LOOKED_AT)).unwrap_or(usize::MAX).max(1);
    let mut places: [Vec<f64>; 3] = Default::default();
    let mut next = 0;
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        while next < mesh.triangles.len() {
            let corner = |i: u32| {
                let [x, y, z] = mesh.positions[i as usize].map(f64::from);
                instance.transform.transform_point3(DVec3::new(x, y, z))
            };
            let place = mesh.triangles[next].map(corner).into_iter().sum::<DVec3>() / 3.0;
            if place.is_finite() {
                places.iter_mut().zip(place.to_array()).for_each(|(all, x)| all.push(x));
            }
            next += step;
        }
        next -= mesh.triangles.len();
    }
    let count = places[0].len();
    if count < FEWEST {
        return None;
    }
    let mut rank = |axis: usize, k: usize| *places[axis].select_nth_unstable_by(k, f64::total_cmp).1;
    let spread = (0..3).map(|axis| rank(axis, 3 * count / 4) - rank(axis, count / 4)).fold(0.0, f64::max);
    (spread <= extent * SMALL_PART).then(|| DVec3::from_array([0, 1, 2].map(|axis| rank(axis, count / 2))))
}

fn used_vertices(mesh: &Mesh) -> Vec<bool> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|i| used[*i as usize] = true);
    used
}
