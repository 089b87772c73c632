use super::WorldFrame;
use super::known::Known;
use super::parts::{Part, PartIndex, Store};
use super::records::{MOST, Record};
use super::shapes::{Shape, Shared, Sharing, normal_of};
use crate::lanes::prefetch;
use crate::math::Placement;
use glam::{DVec3, Vec3};
use kiln_formats::Scene;
use kiln_formats::scene::{MaterialId, Mesh};
use std::collections::HashSet;

/// All triangles in the rays' frame. Positions are copied, once for each placement that does not share a [`Shape`] with
/// others; attributes are read from the scene's meshes.
#[derive(Debug, Default)]
pub struct Geometry {
    /// All triangles where none are shared and there are not too many of them; then `positions`, `corners` and `normals` are empty.
    records: Vec<Record>,
    positions: Vec<Vec3>,
    /// Corners of the triangles that are not shared; likewise the next rows but one.
    pub(super) corners: Vec<[u32; 3]>,
    /// Unit normals on the front.
    normals: Vec<Vec3>,
    /// Normals at the vertices of placements that have them, in the rays' frame: one vote each, which a placement that is no
    /// rigid motion may have made longer or shorter.
    pub(super) vertex_normals: Vec<Vec3>,
    /// Index of each triangle within its mesh.
    local: Vec<u32>,
    /// Placements, in the scene's order.
    pub parts: Vec<Part>,
    index: PartIndex,
    shapes: Vec<Shape>,
    /// All triangles.
    count: u32,
    known: Known,
    /// Triangles left out because they have no area.
    pub degenerate: u64,
}

/// Where a triangle is kept.
pub(super) enum At<'a> {
    /// Its number among those that are not shared.
    Own(usize),
    /// Its placement, shape, and number in the shape.
    Shared(&'a Part, &'a Shape, usize),
}

impl Geometry {
    /// Places all meshes in the world. Triangles without area, and with coordinates beyond `f32`, are left out.
    pub fn new(scene: &Scene, frame: &WorldFrame) -> Self {
        Self::sharing(scene, frame, &Sharing::NEVER)
    }

    /// The same, with triangles shared where that is worth it; whatever is asked of it, the answers are the same, bit for bit.
    pub fn sharing(scene: &Scene, frame: &WorldFrame, sharing: &Sharing) -> Self {
        let placements: Vec<Placement> = scene.instances.iter().map(|i| frame.placement(&i.transform)).collect();
        let shared = Shared::find(scene, &placements, sharing);
        let copied = || scene.instances.iter().zip(&shared.of_instance).filter(|(_, shape)| shape.is_none());
        let meshes = || copied().map(|(instance, _)| &scene.meshes[instance.mesh as usize]);
        let triangles = meshes().map(|mesh| mesh.triangles.len()).sum();
        let mut all = Self {
            positions: Vec::with_capacity(meshes().map(|mesh| mesh.positions.len()).sum()),
            corners: Vec::with_capacity(triangles),
            normals: Vec::with_capacity(triangles),
            local: Vec::with_capacity(triangles),
            parts: Vec::with_capacity(scene.instances.len()),
            shapes: shared.shapes,
            ..Self::default()
        };
        for ((instance, placement), shape) in scene.instances.iter().zip(placements).zip(shared.of_instance) {
            let store = match shape {
                Some((shape, bounds)) => Store::Shape { shape, bounds },
                None => Store::Own { first: all.corners.len() as u32, normals_from: None },
            };
            let part = Part::new(instance.mesh, all.count, &instance.transform, placement, store);
            match shape {
                Some((shape, _)) => all.add_shared(part, shape),
                None => all.add_own(part, &scene.meshes[instance.mesh as usize]),
            }
        }
        all.index = PartIndex::new(&all.parts, all.count);
        if all.shapes.is_empty() {
            let ends = all.parts.iter().skip(1).map(|part| part.first_triangle).chain([all.count]);
            let runs = all.parts.iter().zip(ends).map(|(part, end)| {
                (&scene.meshes[part.mesh as usize], &all.local[part.first_triangle as usize..end as usize])
            });
            // Meshes that are drawn more than once may be shared, and pictures are the same then: lamps must be, too.
            let mut drawn = HashSet::new();
            if scene.instances.iter().all(|instance| drawn.insert(instance.mesh)) {
                all.known = Known::new(scene, runs, all.count as usize);
            }
            if all.count as usize <= MOST {
                all.record(scene);
            }
        }
        all
    }

    /// Brings together what is known of each triangle.
    fn record(&mut self, scene: &Scene) {
        let record = |triangle: u32| Record {
            corners: self.corners(triangle),
            normal: self.unit_normal(triangle),
            part: self.part_index(triangle),
            vertices: self.source(scene, triangle).1.map(|v| v as u32),
        };
        self.records = (0..self.count).map(record).collect();
        (self.positions, self.corners, self.normals) = Default::default();
    }

    /// All that is asked of a triangle most, where it lies together.
    #[inline]
    pub fn known_record(&self, triangle: u32) -> Option<&Record> {
        self.records.get(triangle as usize)
    }

    fn add_shared(&mut self, part: Part, shape: u32) {
        let shape = &self.shapes[shape as usize];
        self.count += shape.len() as u32;
        self.degenerate += shape.degenerate;
        self.parts.push(part);
    }

    fn add_own(&mut self, mut part: Part, mesh: &Mesh) {
        let first_vertex = self.positions.len() as u32;
        self.positions.extend(mesh.positions.iter().map(|p| part.placement.point(*p)));
        let first_normal = self.vertex_normals.len() as u32;
        // Unit length first: files hold normals of any length, and each is one vote.
        let vote = |n: &[f32; 3]| part.normal_matrix * Vec3::from(*n).normalize_or_zero();
        self.vertex_normals.extend(mesh.normals.iter().map(vote));
        let first = self.corners.len() as u32;
        let normals_from = (!mesh.normals.is_empty()).then_some((first_normal, first_vertex));
        part.store = Store::Own { first, normals_from };
        for (k, t) in mesh.triangles.iter().enumerate() {
            let corners = t.map(|i| first_vertex + i);
            match normal_of(corners.map(|i| self.positions[i as usize])) {
                Some(normal) => {
                    self.corners.push(corners);
                    self.normals.push(unit(normal, &part));
                    self.local.push(k as u32);
                }
                None => self.degenerate += 1,
            }
        }
        self.count += self.corners.len() as u32 - first;
        self.parts.push(part);
    }

    /// Triangles.
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// What several placements share.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Placements that share a shape: the placement, its shape, and its box in the rays' frame.
    pub fn shared_parts(&self) -> impl Iterator<Item = (&Part, u32, (Vec3, Vec3))> {
        self.parts.iter().filter_map(|part| match part.store {
            Store::Shape { shape, bounds } => Some((part, shape, bounds)),
            Store::Own { .. } => None,
        })
    }

    /// Numbers of the triangles that no other placement shares, in order.
    pub fn own_triangles(&self) -> Vec<u32> {
        let ends = self.parts.iter().skip(1).map(|part| part.first_triangle).chain([self.count]);
        let runs = self.parts.iter().zip(ends).filter(|(part, _)| matches!(part.store, Store::Own { .. }));
        runs.flat_map(|(part, end)| part.first_triangle..end).collect()
    }

    #[inline]
    pub(super) fn at(&self, triangle: u32) -> At<'_> {
        if self.shapes.is_empty() { At::Own(triangle as usize) } else { self.at_among_shared(triangle) }
    }

    #[inline(never)]
    fn at_among_shared(&self, triangle: u32) -> At<'_> {
        let part = self.part(triangle);
        let number = triangle - part.first_triangle;
        match part.store {
            Store::Own { first, .. } => At::Own((first + number) as usize),
            Store::Shape { shape, .. } => At::Shared(part, &self.shapes[shape as usize], number as usize),
        }
    }

    /// Has fetched where a triangle's corners and normal are found: the first step. A hint, without which answers are the same.
    #[inline]
    pub fn expect_triangle(&self, triangle: u32) {
        let triangle = [triangle as usize];
        if !self.records.is_empty() {
            prefetch::items(&self.records, triangle);
        } else if self.shapes.is_empty() {
            prefetch::items(&self.corners, triangle);
            prefetch::items(&self.normals, triangle);
        }
    }

    /// Has the corners themselves fetched, where they are kept apart: the second step, some time after the first.
    #[inline]
    pub fn expect_corners(&self, triangle: u32) {
        if self.records.is_empty()
            && self.shapes.is_empty()
            && let Some(corners) = self.corners.get(triangle as usize)
        {
            prefetch::items(&self.positions, corners.map(|i| i as usize));
        }
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        match self.known_record(triangle) {
            Some(record) => record.corners,
            None => self.corners_looked_up(triangle),
        }
    }

    #[inline(never)]
    fn corners_looked_up(&self, triangle: u32) -> [Vec3; 3] {
        match self.at(triangle) {
            At::Own(at) => self.corners[at].map(|i| self.positions[i as usize]),
            At::Shared(part, shape, at) => shape.corners[at].map(|i| part.placement.point(shape.positions[i as usize])),
        }
    }

    /// Normal on the front of a triangle, twice its area long (in double precision: it cannot underflow).
    pub fn front_normal(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        (b - a).cross(c - a) * f64::from(self.part(triangle).winding)
    }

    /// Unit normal on the front of a triangle.
    #[inline]
    pub fn unit_normal(&self, triangle: u32) -> Vec3 {
        match self.known_record(triangle) {
            Some(record) => record.normal,
            None => self.normal_looked_up(triangle),
        }
    }

    #[inline(never)]
    fn normal_looked_up(&self, triangle: u32) -> Vec3 {
        match self.at(triangle) {
            At::Own(at) => self.normals[at],
            At::Shared(part, ..) => normal_of(self.corners(triangle)).map_or(Vec3::ZERO, |normal| unit(normal, part)),
        }
    }

    /// Whether a triangle stops every ray, or none; `None` where that depends on the point, or is not known.
    #[inline]
    pub fn known_coverage(&self, triangle: u32) -> Option<bool> {
        self.known.coverage(triangle as usize)
    }

    /// Whether it is known that an emissive texture is black all over a triangle.
    #[inline]
    pub fn is_dark(&self, triangle: u32) -> bool {
        self.known.dark(triangle as usize)
    }

    /// The placement that a triangle belongs to.
    pub fn part(&self, triangle: u32) -> &Part {
        &self.parts[self.part_index(triangle) as usize]
    }

    /// Index of the placement that a triangle belongs to.
    #[inline]
    pub fn part_index(&self, triangle: u32) -> u32 {
        match self.known_record(triangle) {
            Some(record) => record.part,
            None => self.index.find(triangle),
        }
    }

    /// The mesh of a triangle, and the triangle's vertices in it.
    pub fn source<'s>(&self, scene: &'s Scene, triangle: u32) -> (&'s Mesh, [usize; 3]) {
        let mesh = &scene.meshes[self.part(triangle).mesh as usize];
        if let Some(record) = self.known_record(triangle) {
            return (mesh, record.vertices.map(|v| v as usize));
        }
        (mesh, mesh.triangles[self.number_in_mesh(triangle) as usize].map(|i| i as usize))
    }

    /// Number of a triangle within its mesh.
    pub fn number_in_mesh(&self, triangle: u32) -> u32 {
        match self.at(triangle) {
            At::Own(at) => self.local[at],
            At::Shared(_, shape, at) => shape.local[at],
        }
    }

    /// The material of a triangle.
    pub fn material(&self, scene: &Scene, triangle: u32) -> MaterialId {
        scene.meshes[self.part(triangle).mesh as usize].material
    }
}

/// A normal on the front of a placement's triangle, of unit length.
fn unit(normal: DVec3, part: &Part) -> Vec3 {
    (normal * f64::from(part.winding)).normalize().as_vec3()
}
