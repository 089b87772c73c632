//! Many placements of one mesh: shared as instances, copied, and as Embree's instances.

use crate::meshes::{Mesh, hash};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use kiln::Control;
use kiln::math::Placement;
use kiln::prepare::kdtree::{BuildOptions, Instanced, KdTree, Placed};

/// Placements of a mesh, and all of it as one mesh.
pub struct Many {
    pub maps: Vec<DAffine3>,
    pub all: Mesh,
    placed: Vec<Placed>,
}

impl Many {
    /// A hundred, turned and strewn in a cube.
    pub fn new(mesh: &Mesh) -> Self {
        let mut many =
            Self { maps: Vec::new(), all: Mesh { points: Vec::new(), faces: Vec::new() }, placed: Vec::new() };
        for k in 0..100u32 {
            let h = |i: u32| f64::from(hash(k, i) * 2.0 - 1.0);
            let turn = DQuat::from_xyzw(h(0), h(1), h(2), 0.1 + h(3).abs()).normalize();
            let at = DVec3::new(h(4), h(5), h(6)) * 10.0;
            let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.7 + 0.3 * h(7)), turn, at);
            let placement = Placement::new(&map);
            let points: Vec<Vec3> = mesh.points.iter().map(|p| placement.point(p.to_array())).collect();
            let ends = points.iter().fold((points[0], points[0]), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
            let (base, first) = (many.all.points.len() as u32, many.all.faces.len() as u32);
            many.all.points.extend(points);
            many.all.faces.extend(mesh.faces.iter().map(|face| face.map(|i| i + base)));
            many.placed.push(Placed { mesh: 0, placement, first, bounds: ends });
            many.maps.push(map);
        }
        many
    }

    /// One tree of the mesh, under one over the placements.
    pub fn tree(&self, mesh: &Mesh, options: &BuildOptions) -> KdTree {
        let own = Mesh { points: Vec::new(), faces: Vec::new() };
        let meshes = [Mesh { points: mesh.points.clone(), faces: mesh.faces.clone() }];
        let scene = Instanced { meshes: &meshes, placed: &self.placed, own: &own };
        KdTree::build_instances(&scene, options, &Control::default()).expect("not stopped")
    }
}
