use glam::{DVec3, Vec3};
use kiln_formats::Scene;
use kiln_formats::scene::Mesh;

/// The frame that rays live in: the asset's world, moved so that its centre is the origin and scaled by a power of
/// two so that its largest extent lies in [1, 2).
///
/// Moving happens in double precision before anything becomes `f32`; scaling by powers of two is exact. So the same
/// asset gives the same picture a million units from the origin, and bit for bit the same at 2ᵏ times its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldFrame {
    center: DVec3,
    scale: f64,
}

impl WorldFrame {
    /// For a world with these bounds (none: the identity).
    pub fn new(bounds: Option<(DVec3, DVec3)>) -> Self {
        let Some((lo, hi)) = bounds else { return Self { center: DVec3::ZERO, scale: 1.0 } };
        let extent = (hi - lo).max_element();
        let scale = if extent > 0.0 && extent.is_finite() {
            libm::ldexp(1.0, -libm::ilogb(extent).clamp(-1000, 1000))
        } else {
            1.0
        };
        Self { center: lo + (hi - lo) * 0.5, scale }
    }

    /// A world point in the rays' frame.
    pub fn point(&self, world: DVec3) -> Vec3 {
        self.exact_point(world).as_vec3()
    }

    /// A world point in the rays' frame, in double precision.
    pub fn exact_point(&self, world: DVec3) -> DVec3 {
        (world - self.center) * self.scale
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

fn used_vertices(mesh: &Mesh) -> Vec<bool> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|i| used[*i as usize] = true);
    used
}
