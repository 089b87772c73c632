//! Tangent spaces by MikkTSpace, the algorithm that glTF names for meshes without tangents (glTF 2.0, 3.7.2.1).

use crate::scene::{Mesh, UvTransform};
use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::Vec3;
use std::collections::HashMap;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};

/// Corners that share position, normal and texture coordinates. MikkTSpace recurses over them and takes their square
/// in time, so that more would exhaust the stack or the patience.
const MAX_FAN: u16 = 2048;

/// Corners around which any thread's stack is large enough.
const SMALL_FAN: u16 = 128;

/// Stack of the thread that runs MikkTSpace for larger fans; enough for `MAX_FAN` nested calls many times over.
const STACK_BYTES: usize = 16 << 20;

/// Why a mesh can have no tangents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoTangents {
    /// Not one normal for each position.
    #[error("the mesh lacks normals")]
    Normals,
    /// The set of texture coordinates is missing.
    #[error("the mesh lacks the texture coordinates")]
    TextureCoordinates,
    /// Too many triangles around one vertex.
    #[error("more than {MAX_FAN} triangles meet in one vertex")]
    Fan,
    /// The generator failed.
    #[error("the tangent generator failed")]
    Generator,
}

/// Gives a mesh tangents for a set of texture coordinates (0 or 1), which `transform` maps first.
///
/// Vertices at which tangent spaces differ, such as those on mirrored seams, are doubled; vertices that no triangle
/// names are dropped. A mesh without normals gets those of its faces. Handedness is glTF's: the bitangent `cross(normal, tangent) · w` points against v.
///
/// # Errors
/// [`NoTangents`]; the mesh is left as it was.
pub fn generate(mesh: &mut Mesh, uv_set: usize, transform: &UvTransform) -> Result<(), NoTangents> {
    if mesh.uvs.get(uv_set).is_none_or(|uvs| uvs.is_empty() || uvs.len() != mesh.positions.len()) {
        return Err(NoTangents::TextureCoordinates);
    }
    if mesh.normals.is_empty() {
        flatten(mesh);
    }
    if mesh.normals.len() != mesh.positions.len() {
        return Err(NoTangents::Normals);
    }
    let uvs = mesh.uvs.get(uv_set).ok_or(NoTangents::TextureCoordinates)?;
    let vertices = mesh.positions.iter().zip(&mesh.normals).zip(uvs);
    let vertices = vertices.map(|((position, normal), uv)| Vertex {
        position: *position,
        normal: unit(*normal),
        uv: transform.apply(*uv),
    });
    let mut corners = Corners {
        triangles: &mesh.triangles,
        vertices: vertices.collect(),
        tangents: vec![[0.0; 4]; 3 * mesh.triangles.len()],
    };
    let fan = largest_fan(&corners);
    if fan > MAX_FAN {
        return Err(NoTangents::Fan);
    }
    let mut run = || generate_tangents(&mut corners).map(|()| std::mem::take(&mut corners.tangents));
    let tangents = match fan <= SMALL_FAN {
        true => run().ok(),
        false => std::thread::scope(|scope| {
            let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run).ok()?;
            thread.join().ok()?.ok()
        }),
    };
    let tangents = tangents.ok_or(NoTangents::Generator)?;
    weld(mesh, &tangents);
    Ok(())
}

/// Gives each triangle vertices of its own, with the normal of its plane.
fn flatten(mesh: &mut Mesh) {
    let sources: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    gather(&mut mesh.positions, &sources);
    mesh.uvs.iter_mut().for_each(|uvs| gather(uvs, &sources));
    gather(&mut mesh.colors, &sources);
    gather(&mut mesh.vertex_materials, &sources);
    mesh.triangles.iter_mut().enumerate().for_each(|(k, t)| *t = [0, 1, 2].map(|c| (3 * k + c) as u32));
    let normal = |[a, b, c]: &[[f32; 3]; 3]| {
        let [a, b, c] = [a, b, c].map(|p| Vec3::from_array(*p).as_dvec3());
        let normal = (b - a).cross(c - a).try_normalize().map_or(Vec3::Z, |n| n.as_vec3());
        [normal.to_array(); 3]
    };
    mesh.normals = mesh.positions.as_chunks().0.iter().flat_map(normal).collect();
}

/// What MikkTSpace asks of a corner, which it does several times.
#[derive(Clone, Copy, Default)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

impl Vertex {
    fn bits(&self) -> [u32; 8] {
        let ([x, y, z], [a, b, c], [u, v]) = (self.position, self.normal, self.uv);
        [x, y, z, a, b, c, u, v].map(f32::to_bits)
    }
}

/// The mesh as MikkTSpace sees it: corners of triangles.
struct Corners<'a> {
    triangles: &'a [[u32; 3]],
    vertices: Vec<Vertex>,
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> Vertex {
        let index = self.triangles.get(face).and_then(|t| t.get(corner));
        index.and_then(|i| self.vertices.get(*i as usize)).copied().unwrap_or_default()
    }
}

/// Functions that give the same bits on every machine.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

impl Geometry<Portable> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).position
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).normal
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.vertex(face, corner).uv
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = Vec3::from_array(self.normal(face, corner));
        let Some(slot) = self.tangents.get_mut(3 * face + corner) else { return };
        let [x, y, z, w] = space.unwrap_or_default().tangent_encoded();
        let tangent = Vec3::new(x, y, z);
        let sound = tangent.is_finite() && tangent.cross(normal).length_squared() > 1e-12;
        // Where texture coordinates are degenerate, any direction in the surface will do.
        let [x, y, z] = if sound { tangent.to_array() } else { perpendicular(normal).to_array() };
        // MikkTSpace takes v upwards, glTF downwards.
        *slot = [x, y, z, -w];
    }
}

fn unit(normal: [f32; 3]) -> [f32; 3] {
    Vec3::from_array(normal).normalize_or_zero().to_array()
}

fn perpendicular(normal: Vec3) -> Vec3 {
    let axis = if normal.x.abs() < 0.5 { Vec3::X } else { Vec3::Y };
    axis.cross(normal).try_normalize().unwrap_or(Vec3::X)
}

/// A hasher with fixed keys; the maps below are only asked, never walked.
type Fixed = BuildHasherDefault<DefaultHasher>;

/// How many corners may be welded into one vertex at most, or `MAX_FAN + 1` if there are more. Hash collisions only err on the safe side.
fn largest_fan(corners: &Corners) -> u16 {
    let triangles = corners.num_faces();
    if triangles <= usize::from(SMALL_FAN) {
        return triangles as u16;
    }
    let mut counts = vec![0u16; (2 * triangles).next_power_of_two()];
    let mask = counts.len() - 1;
    let hasher = Fixed::default();
    // One hash a vertex, then one count a corner.
    let buckets: Vec<usize> =
        corners.vertices.iter().map(|vertex| hasher.hash_one(vertex.bits()) as usize & mask).collect();
    let mut largest = 0;
    for corner in corners.triangles.as_flattened() {
        if let Some(count) = buckets.get(*corner as usize).and_then(|b| counts.get_mut(*b)) {
            *count += 1;
            largest = largest.max(*count);
            if largest > MAX_FAN {
                break;
            }
        }
    }
    largest
}

/// Indexes the mesh anew, so that each vertex has one tangent.
fn weld(mesh: &mut Mesh, tangents: &[[f32; 4]]) {
    let mut ids: HashMap<(u32, [u32; 4]), u32, Fixed> = HashMap::default();
    let mut sources: Vec<u32> = Vec::with_capacity(mesh.positions.len());
    let mut welded: Vec<[f32; 4]> = Vec::with_capacity(mesh.positions.len());
    for (corner, tangent) in mesh.triangles.as_flattened_mut().iter_mut().zip(tangents) {
        let source = *corner;
        *corner = *ids.entry((source, tangent.map(f32::to_bits))).or_insert_with(|| {
            sources.push(source);
            welded.push(*tangent);
            (sources.len() - 1) as u32
        });
    }
    mesh.tangents = welded;
    gather(&mut mesh.positions, &sources);
    gather(&mut mesh.normals, &sources);
    mesh.uvs.iter_mut().for_each(|uvs| gather(uvs, &sources));
    gather(&mut mesh.colors, &sources);
    gather(&mut mesh.vertex_materials, &sources);
}

fn gather<T: Copy + Default>(values: &mut Vec<T>, sources: &[u32]) {
    if !values.is_empty() {
        *values = sources.iter().map(|i| values.get(*i as usize).copied().unwrap_or_default()).collect();
    }
}
