//! Triangles that several placements share.
//!
//! A mesh that is drawn many times, or many meshes that differ in their materials alone, are one *shape*: their triangles are kept
//! once, in the mesh's coordinates, and placed when they are asked for. Numbers come out as if each placement had triangles of
//! its own, bit for bit.

use crate::math::Placement;
use glam::{DMat3, DVec3, Vec3};
use kiln_formats::Scene;
use kiln_formats::scene::Mesh;
use rayon::prelude::*;
use std::collections::HashMap;

/// From when on triangles are shared. A question of numbers alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sharing {
    /// Shapes of fewer triangles are copied.
    pub least_triangles: u64,
    /// Nothing is shared unless it saves the copies of so many triangles.
    pub least_saved: u64,
}

impl Sharing {
    /// Every placement has triangles of its own.
    pub const NEVER: Self = Self { least_triangles: u64::MAX, least_saved: u64::MAX };
    /// Whatever can be shared is.
    pub const ALWAYS: Self = Self { least_triangles: 0, least_saved: 0 };
}

/// The triangles of several placements, in the coordinates of their meshes.
#[derive(Debug)]
pub struct Shape {
    /// Corners.
    pub(super) positions: Vec<[f32; 3]>,
    /// Indices of a triangle's corners.
    pub(super) corners: Vec<[u32; 3]>,
    /// Numbers of the triangles within their meshes.
    pub(super) local: Vec<u32>,
    /// Unit normals at the corners, or none.
    pub(super) normals: Vec<Vec3>,
    /// Triangles of the mesh that are left out.
    pub(super) degenerate: u64,
}

impl Shape {
    /// Triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The corners of a triangle, in the coordinates of the mesh.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.corners[triangle as usize].map(|i| Vec3::from(self.positions[i as usize]))
    }

    fn new(mesh: &Mesh, kept: &[bool]) -> Self {
        let local: Vec<u32> = (0..kept.len() as u32).filter(|k| kept[*k as usize]).collect();
        Self {
            positions: mesh.positions.clone(),
            corners: local.iter().map(|k| mesh.triangles[*k as usize]).collect(),
            normals: mesh.normals.iter().map(|n| Vec3::from(*n).normalize_or_zero()).collect(),
            degenerate: (kept.len() - local.len()) as u64,
            local,
        }
    }
}

/// What instances share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// The shapes.
    pub shapes: Vec<Shape>,
    /// For each instance of the scene, its shape and its box in the rays' frame, if it shares.
    pub of_instance: Vec<Option<(u32, (Vec3, Vec3))>>,
}

impl Shared {
    /// Finds what is worth sharing. `placements` are those of the scene's instances.
    pub fn find(scene: &Scene, placements: &[Placement], sharing: &Sharing) -> Self {
        let mut shared = Self { shapes: Vec::new(), of_instance: vec![None; scene.instances.len()] };
        let count = |users: &[u32]| scene.meshes[mesh_of(scene, users[0])].triangles.len() as u64;
        let worth = |users: &&Vec<u32>| users.len() > 1 && count(users) >= sharing.least_triangles.max(1);
        if *sharing == Sharing::NEVER {
            return shared;
        }
        let alike = alike(scene);
        let groups: Vec<&Vec<u32>> = alike.iter().filter(worth).collect();
        let saved: u64 = groups.iter().map(|users| (users.len() as u64 - 1) * count(users)).sum();
        if saved < sharing.least_saved {
            return shared;
        }
        for users in groups {
            shared.share(scene, users, placements);
        }
        shared
    }

    /// Makes a shape of those of some instances that draw the same triangles of it.
    fn share(&mut self, scene: &Scene, users: &[u32], placements: &[Placement]) {
        let mesh = &scene.meshes[mesh_of(scene, users[0])];
        let Some(size) = Size::of(mesh) else { return };
        let tame = |user: &u32| size.is_tame(&placements[*user as usize]);
        let users: Vec<u32> = users.iter().copied().filter(tame).collect();
        let Some(first) = users.first() else { return };
        let kept = kept(mesh, &placements[*first as usize]);
        let bounds = |user: &u32| Some(*user).zip(bounds_if_kept(mesh, &placements[*user as usize], &kept));
        let members: Vec<_> = users.par_iter().filter_map(bounds).collect();
        if members.len() < 2 {
            return;
        }
        for (user, bounds) in members {
            self.of_instance[user as usize] = Some((self.shapes.len() as u32, bounds));
        }
        self.shapes.push(Shape::new(mesh, &kept));
    }
}

fn mesh_of(scene: &Scene, instance: u32) -> usize {
    scene.instances[instance as usize].mesh as usize
}

/// Groups of instances whose meshes have the same positions, normals and triangles, in the scene's order.
fn alike(scene: &Scene) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut of_mesh: Vec<Option<usize>> = vec![None; scene.meshes.len()];
    // Numbers that tell most meshes apart, then the meshes of each group that has them.
    let mut by_key: HashMap<_, Vec<(usize, usize)>> = HashMap::new();
    for instance in 0..scene.instances.len() as u32 {
        let number = mesh_of(scene, instance);
        let mesh = &scene.meshes[number];
        let group = of_mesh[number].unwrap_or_else(|| {
            let key = (mesh.positions.len(), mesh.triangles.len(), mesh.normals.len(), a_place(mesh));
            let known = by_key.entry(key).or_default();
            let same = known.iter().find(|(other, _)| same_triangles(mesh, &scene.meshes[*other]));
            same.map(|(_, group)| *group).unwrap_or_else(|| {
                known.push((number, groups.len()));
                groups.push(Vec::new());
                groups.len() - 1
            })
        });
        of_mesh[number] = Some(group);
        groups[group].push(instance);
    }
    groups
}

/// The bits of one corner, which tell shapes of the same counts apart.
fn a_place(mesh: &Mesh) -> Option<[u32; 3]> {
    let [corner, ..] = mesh.triangles.get(mesh.triangles.len() / 2)?;
    mesh.positions.get(*corner as usize).map(|p| p.map(f32::to_bits))
}

fn same_triangles(a: &Mesh, b: &Mesh) -> bool {
    let same = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits))
    };
    a.triangles == b.triangles && same(&a.positions, &b.positions) && same(&a.normals, &b.normals)
}

/// How large a mesh is in its own coordinates.
struct Size {
    /// The largest extent along an axis.
    extent: f64,
    /// The coordinate farthest from zero.
    reach: f64,
}

/// Coordinates of shapes lie within this, so that all arithmetic with them stays within f32's range.
const REACH: [f64; 2] = [1e-6, 1e6];
/// The rounding of coordinates near 1 in the rays' frame and what follows from it, roughly.
const FRAME_ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// Rounding of the rays' frame may be this share of a shape's extent when it is seen from there: beyond, rays would have to
/// look at more than they need.
const MOST_BLUR: f64 = 1.0 / 512.0;

impl Size {
    /// `None` for coordinates that are no numbers or that f32 cannot work with.
    fn of(mesh: &Mesh) -> Option<Self> {
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in &mesh.positions {
            let p = Vec3::from(*p).as_dvec3();
            if !p.is_finite() {
                return None;
            }
            (lo, hi) = (lo.min(p), hi.max(p));
        }
        let reach = lo.abs().max(hi.abs()).max_element();
        let extent = (hi - lo).max_element();
        ((REACH[0]..=REACH[1]).contains(&reach) && extent * 1024.0 >= reach).then_some(Self { extent, reach })
    }

    /// Whether a placement can be undone precisely enough.
    fn is_tame(&self, placement: &Placement) -> bool {
        let matrix: DMat3 = placement.affine().matrix3;
        let inverse = matrix.inverse();
        let rows = [inverse.row(0), inverse.row(1), inverse.row(2)].map(|row| row.abs().element_sum());
        let blur = rows.into_iter().fold(0.0, f64::max) * FRAME_ROUNDING;
        let undone =
            (inverse * matrix - DMat3::IDENTITY).to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let translation = placement.affine().translation.abs().max_element();
        matrix.determinant() != 0.0
            && inverse.is_finite()
            && translation <= 1e3
            && blur <= self.extent * MOST_BLUR
            && undone * self.reach <= self.extent * 1e-6
    }
}

/// Whether a triangle has an area, and its corners are numbers.
pub(super) fn normal_of([a, b, c]: [Vec3; 3]) -> Option<DVec3> {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    // Double precision: products of f32 differences cannot underflow to zero there.
    let normal = (b - a).cross(c - a);
    (normal.is_finite() && normal != DVec3::ZERO).then_some(normal)
}

fn placed(mesh: &Mesh, placement: &Placement) -> Vec<Vec3> {
    mesh.positions.iter().map(|p| placement.point(*p)).collect()
}

/// Which triangles of a mesh a placement draws.
fn kept(mesh: &Mesh, placement: &Placement) -> Vec<bool> {
    let places = placed(mesh, placement);
    mesh.triangles.iter().map(|t| normal_of(t.map(|i| places[i as usize])).is_some()).collect()
}

/// The box around the triangles that a placement draws, if they are those of `expected` and any at all.
fn bounds_if_kept(mesh: &Mesh, placement: &Placement, expected: &[bool]) -> Option<(Vec3, Vec3)> {
    let places = placed(mesh, placement);
    let mut bounds: Option<(Vec3, Vec3)> = None;
    for (t, expected) in mesh.triangles.iter().zip(expected) {
        let corners = t.map(|i| places[i as usize]);
        if normal_of(corners).is_some() != *expected {
            return None;
        }
        if *expected {
            let [a, b, c] = corners;
            let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
            bounds = Some(bounds.map_or((lo, hi), |(l, h)| (l.min(lo), h.max(hi))));
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::super::{Geometry, WorldFrame, world_bounds};
    use super::*;
    use glam::DAffine3;
    use kiln_formats::repair::shapes::icosphere;
    use kiln_formats::scene::{Instance, Material};

    /// Two spheres of different materials, of which one is drawn twice, and once flat.
    fn spheres() -> Scene {
        let (positions, triangles) = icosphere(1);
        let mesh = |material| Mesh {
            normals: positions.clone(),
            positions: positions.clone(),
            triangles: triangles.clone(),
            material,
            ..Mesh::default()
        };
        let at = |mesh, x: f64, scale: DVec3| Instance {
            name: String::new(),
            mesh,
            transform: DAffine3::from_translation(DVec3::X * x) * DAffine3::from_scale(scale),
        };
        let flat = DVec3::new(1.0, 0.0, 1.0);
        Scene {
            materials: vec![Material::default(), Material::default()],
            meshes: vec![mesh(0), mesh(1)],
            instances: vec![
                at(0, 0.0, DVec3::ONE),
                at(0, 3.0, flat),
                at(1, 6.0, DVec3::new(-0.5, 0.7, 0.3)),
                at(0, 9.0, DVec3::splat(0.1)),
            ],
            ..Scene::default()
        }
    }

    #[test]
    fn shared_triangles_answer_as_copies_do() {
        let scene = spheres();
        let frame = WorldFrame::new(&scene, world_bounds(&scene));
        let copied = Geometry::new(&scene, &frame);
        let shared = Geometry::sharing(&scene, &frame, &Sharing::ALWAYS);
        assert_eq!((copied.shapes().len(), shared.shapes().len()), (0, 1), "materials do not matter");
        let sharing: Vec<u32> = shared.shared_parts().map(|(part, ..)| part.mesh).collect();
        assert_eq!(sharing, [0, 1, 0], "what is flat is copied");
        assert_eq!((copied.len(), copied.degenerate), (shared.len(), shared.degenerate));
        for t in 0..copied.len() as u32 {
            let answers = |g: &Geometry| {
                (
                    g.corners(t),
                    g.unit_normal(t),
                    g.front_normal(t),
                    g.corner_normals(t),
                    g.part_index(t),
                    g.number_in_mesh(t),
                )
            };
            assert_eq!(answers(&copied), answers(&shared));
        }
    }

    #[test]
    fn nothing_is_shared_for_small_gains() {
        let scene = spheres();
        let frame = WorldFrame::new(&scene, world_bounds(&scene));
        let shapes = |least_triangles, least_saved| {
            Geometry::sharing(&scene, &frame, &Sharing { least_triangles, least_saved }).shapes().len()
        };
        let triangles = scene.meshes[0].triangles.len() as u64;
        assert_eq!(
            (shapes(triangles, 3 * triangles), shapes(triangles + 1, 0), shapes(0, 3 * triangles + 1)),
            (1, 0, 0)
        );
    }
}
