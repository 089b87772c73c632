use super::WorldFrame;
use glam::{DVec3, Mat3, Vec2, Vec3, Vec4};
use kiln_formats::Scene;
use kiln_formats::scene::{MaterialId, Mesh};

/// One placement of a mesh: a run of triangles with the attributes of one mesh.
#[derive(Clone, Debug)]
pub struct Part {
    /// Index of the mesh in the scene.
    pub mesh: u32,
    /// The first of its triangles in [`Geometry`].
    pub first_triangle: u32,
    /// Where the normals of its vertices begin in [`Geometry::vertex_normals`], if it has any, and where its vertices begin.
    normals_from: Option<(u32, u32)>,
    /// Object directions to world directions (for tangents).
    direction_matrix: Mat3,
    /// −1 where the placement mirrors the mesh and clockwise corners show the front, else 1.
    winding: f32,
}

/// All triangles in the rays' frame. Positions are copied, once for each placement; attributes
/// are read from the scene's meshes.
#[derive(Debug, Default)]
pub struct Geometry {
    positions: Vec<Vec3>,
    corners: Vec<[u32; 3]>,
    /// Unit normals on the front.
    normals: Vec<Vec3>,
    /// Normals at the vertices of placements that have them, in the rays' frame: one vote each, which a placement that is no
    /// rigid motion may have made longer or shorter.
    vertex_normals: Vec<Vec3>,
    /// Index of each triangle within its mesh.
    local: Vec<u32>,
    part_of: Vec<u32>,
    /// Placements, in the scene's order.
    pub parts: Vec<Part>,
    /// Triangles left out because they have no area.
    pub degenerate: u64,
}

/// Attributes of a mesh at a point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Attributes {
    /// Both sets of texture coordinates.
    pub uv: [[f32; 2]; 2],
    /// Linear RGBA factor.
    pub color: Vec4,
    /// World-space shading normal of unit length, where the mesh has normals.
    pub normal: Option<Vec3>,
    /// World-space tangent (not of unit length) and handedness, where the mesh has tangents.
    pub tangent: Option<(Vec3, f32)>,
}

impl Geometry {
    /// Places all meshes in the world. Triangles without area, and with coordinates beyond `f32`, are left out.
    pub fn new(scene: &Scene, frame: &WorldFrame) -> Self {
        let vertices: usize = scene.instances.iter().map(|i| scene.meshes[i.mesh as usize].positions.len()).sum();
        let triangles = usize::try_from(scene.triangle_count()).unwrap_or(0);
        let mut all = Self {
            positions: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(triangles),
            normals: Vec::with_capacity(triangles),
            local: Vec::with_capacity(triangles),
            part_of: Vec::with_capacity(triangles),
            ..Self::default()
        };
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            let first_vertex = all.positions.len() as u32;
            let place = |p: &[f32; 3]| {
                let [x, y, z] = p.map(f64::from);
                frame.point(instance.transform.transform_point3(DVec3::new(x, y, z)))
            };
            all.positions.extend(mesh.positions.iter().map(place));
            // Cofactors, det·M⁻ᵀ, instead of the inverse transpose: right for singular matrices too.
            let m = instance.transform.matrix3;
            let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
            let size = x.abs().max(y.abs()).max(z.abs()).max_element();
            let unit = if size > 0.0 && size.is_finite() { 1.0 / size } else { 1.0 };
            let (x, y, z) = (x * unit, y * unit, z * unit);
            let winding = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
            let normals = [y.cross(z), z.cross(x), x.cross(y)].map(|n| n.as_vec3() * winding);
            let normal_matrix = Mat3::from_cols(normals[0], normals[1], normals[2]);
            let first_normal = all.vertex_normals.len() as u32;
            // Unit length first: files hold normals of any length, and each is one vote.
            let vote = |n: &[f32; 3]| normal_matrix * Vec3::from(*n).normalize_or_zero();
            all.vertex_normals.extend(mesh.normals.iter().map(vote));
            let part = Part {
                mesh: instance.mesh,
                first_triangle: all.corners.len() as u32,
                normals_from: (!mesh.normals.is_empty()).then_some((first_normal, first_vertex)),
                direction_matrix: Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()),
                winding,
            };
            for (k, t) in mesh.triangles.iter().enumerate() {
                let corners = t.map(|i| first_vertex + i);
                let [a, b, c] = corners.map(|i| all.positions[i as usize].as_dvec3());
                let normal = (b - a).cross(c - a);
                // Double precision: products of f32 differences cannot underflow to zero there.
                if normal.is_finite() && normal != DVec3::ZERO {
                    all.corners.push(corners);
                    all.normals.push((normal * f64::from(winding)).normalize().as_vec3());
                    all.local.push(k as u32);
                    all.part_of.push(all.parts.len() as u32);
                } else {
                    all.degenerate += 1;
                }
            }
            all.parts.push(part);
        }
        all
    }

    /// Triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.corners[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// Normal on the front of a triangle, twice its area long (in double precision: it cannot underflow).
    pub fn front_normal(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        (b - a).cross(c - a) * f64::from(self.part(triangle).winding)
    }

    /// Unit normal on the front of a triangle.
    pub fn unit_normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    /// The placement that a triangle belongs to.
    pub fn part(&self, triangle: u32) -> &Part {
        &self.parts[self.part_of[triangle as usize] as usize]
    }

    /// Index of the placement that a triangle belongs to.
    pub fn part_index(&self, triangle: u32) -> u32 {
        self.part_of[triangle as usize]
    }

    /// The mesh of a triangle, and the triangle's vertices in it.
    pub fn source<'s>(&self, scene: &'s Scene, triangle: u32) -> (&'s Mesh, [usize; 3]) {
        let mesh = &scene.meshes[self.part(triangle).mesh as usize];
        (mesh, mesh.triangles[self.local[triangle as usize] as usize].map(|i| i as usize))
    }

    /// Number of a triangle within its mesh.
    pub fn number_in_mesh(&self, triangle: u32) -> u32 {
        self.local[triangle as usize]
    }

    /// The material of a triangle.
    pub fn material(&self, scene: &Scene, triangle: u32) -> MaterialId {
        scene.meshes[self.part(triangle).mesh as usize].material
    }

    /// Texture coordinates alone, at barycentric weights `b`.
    pub fn uv(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> [[f32; 2]; 2] {
        let (mesh, v) = self.source(scene, triangle);
        uv_at(mesh, v, b)
    }

    /// Area in each set of texture coordinates over area in the rays' frame; 0 where there are no coordinates.
    pub fn texture_density(&self, scene: &Scene, triangle: u32) -> [f32; 2] {
        let (mesh, v) = self.source(scene, triangle);
        let [a, b, c] = self.corners(triangle);
        let area = (b - a).cross(c - a).length();
        [0, 1].map(|set| {
            let uvs = &mesh.uvs[set];
            if uvs.is_empty() {
                return 0.0;
            }
            let [a, b, c] = v.map(|i| Vec2::from(uvs[i]));
            (b - a).perp_dot(c - a).abs() / area
        })
    }

    /// Alpha of the vertex colours, at barycentric weights `b`.
    pub fn vertex_alpha(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> f32 {
        let (mesh, v) = self.source(scene, triangle);
        if mesh.colors.is_empty() { 1.0 } else { (0..3).map(|k| b[k] * mesh.colors[v[k]][3]).sum() }
    }

    /// Normals at the corners of a triangle on its front, in the rays' frame and not of unit length, where the mesh has normals
    /// (zero where they are no vectors).
    pub fn corner_normals(&self, triangle: u32) -> Option<[Vec3; 3]> {
        let (first_normal, first_vertex) = self.part(triangle).normals_from?;
        Some(self.corners[triangle as usize].map(|i| self.vertex_normals[(i - first_vertex + first_normal) as usize]))
    }

    /// The vertex colour, at barycentric weights `b`: linear RGBA.
    pub fn color(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> Vec4 {
        let (mesh, v) = self.source(scene, triangle);
        color_at(mesh, v, b)
    }

    /// Everything that the mesh says about the point with barycentric weights `b`.
    pub fn attributes(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> Attributes {
        let part = self.part(triangle);
        let (mesh, v) = self.source(scene, triangle);
        let votes = self.corner_normals(triangle);
        let normal = votes.and_then(|n| (n[0] * b[0] + n[1] * b[1] + n[2] * b[2]).try_normalize());
        let tangent = (!mesh.tangents.is_empty()).then(|| {
            // A mirrored placement turns the cross product of normal and tangent around, but not the bitangent.
            let handedness = mesh.tangents[v[0]][3] * part.winding;
            (part.direction_matrix * mix4(&mesh.tangents, v, b).truncate(), handedness)
        });
        Attributes { uv: uv_at(mesh, v, b), color: color_at(mesh, v, b), normal, tangent }
    }
}

fn mix4(values: &[[f32; 4]], v: [usize; 3], b: [f32; 3]) -> Vec4 {
    (0..3).map(|k| Vec4::from(values[v[k]]) * b[k]).sum()
}

fn color_at(mesh: &Mesh, v: [usize; 3], b: [f32; 3]) -> Vec4 {
    if mesh.colors.is_empty() { Vec4::ONE } else { mix4(&mesh.colors, v, b) }
}

fn uv_at(mesh: &Mesh, v: [usize; 3], b: [f32; 3]) -> [[f32; 2]; 2] {
    let set = |uvs: &[[f32; 2]]| {
        if uvs.is_empty() { [0.0; 2] } else { (0..3).map(|k| Vec2::from(uvs[v[k]]) * b[k]).sum::<Vec2>().into() }
    };
    [set(&mesh.uvs[0]), set(&mesh.uvs[1])]
}
