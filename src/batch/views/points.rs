use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::Mesh;

/// Transformed points after which instances are taken by the corners of their boxes.
const POINT_BUDGET: u64 = 16_000_000;

/// Calls `visit` with world-space points whose convex hull holds everything drawn.
///
/// These are the vertices that triangles use, and the corners of object-space boxes for the instances beyond a budget
/// that bounds the time.
pub fn for_each(scene: &Scene, mut visit: impl FnMut(DVec3)) {
    let meshes: Vec<Drawn> = scene.meshes.iter().map(Drawn::of).collect();
    let mut left = POINT_BUDGET;
    for instance in &scene.instances {
        let Some((mesh, drawn)) = scene.meshes.get(instance.mesh as usize).zip(meshes.get(instance.mesh as usize))
        else {
            continue;
        };
        let mut visit_object = |p: DVec3| visit(instance.transform.transform_point3(p));
        if drawn.count <= left {
            left -= drawn.count;
            for (position, used) in mesh.positions.iter().zip(&drawn.used) {
                if *used {
                    visit_object(to_f64(*position));
                }
            }
        } else if let Some((low, high)) = drawn.bounds {
            for corner in 0..8 {
                let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
                visit_object(DVec3::new(pick(0), pick(1), pick(2)));
            }
        }
    }
}

/// Lower and upper corner of everything drawn; `None` when nothing is.
pub fn bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for_each(scene, |p| {
        let (low, high) = bounds.unwrap_or((p, p));
        bounds = Some((low.min(p), high.max(p)));
    });
    bounds
}

/// Which vertices of a mesh its triangles use, and their box.
struct Drawn {
    used: Vec<bool>,
    count: u64,
    bounds: Option<(DVec3, DVec3)>,
}

impl Drawn {
    fn of(mesh: &Mesh) -> Self {
        let mut used = vec![false; mesh.positions.len()];
        for index in mesh.triangles.as_flattened() {
            if let Some(flag) = used.get_mut(*index as usize) {
                *flag = true;
            }
        }
        let (mut count, mut bounds) = (0, None);
        for (position, _) in mesh.positions.iter().zip(&used).filter(|(_, used)| **used) {
            let p = to_f64(*position);
            let (low, high): (DVec3, DVec3) = bounds.unwrap_or((p, p));
            bounds = Some((low.min(p), high.max(p)));
            count += 1;
        }
        Self { used, count, bounds }
    }
}

fn to_f64([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use kiln_formats::scene::Instance;

    #[test]
    fn vertices_that_no_triangle_uses_do_not_count() {
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e6; 3]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let place = |x| Instance {
            name: String::new(),
            mesh: 0,
            transform: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
        };
        let scene = Scene { meshes: vec![mesh], instances: vec![place(0.0), place(5.0)], ..Scene::default() };
        assert_eq!(bounds(&scene), Some((DVec3::ZERO, DVec3::new(6.0, 1.0, 0.0))));
        assert_eq!(bounds(&Scene::default()), None);
    }
}
