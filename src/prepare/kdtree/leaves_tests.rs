//! Leaves give back what was put into them.

use super::Triangles;
use super::block::POOL;
use super::bounds::Bounds;
use super::built::{Built, BuiltCell, BuiltKind};
use super::leaves::{Contents, LeafStore, Planner};
use super::wide::collapse::Places;
use crate::cpu_clock::CpuMeter;
use glam::Vec3;

/// Forty-six triangles two by two, which share an edge, then as many alone.
struct Some92;

impl Triangles for Some92 {
    fn len(&self) -> usize {
        92
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        let (x, z) = if triangle < 46 { (triangle / 2, triangle % 2) } else { (triangle, 0) };
        let (x, z) = (x as f32, z as f32);
        [Vec3::new(x, 1.0, 0.5), Vec3::new(x, 2.0, 0.5), Vec3::new(x, 3.0, z)]
    }
}

#[test]
fn leaves_give_back_their_triangles_whichever_blocks_have_pools() {
    let sizes = [4u32, 46, 0, 42];
    let cells = sizes.map(|count| BuiltCell { bounds: Bounds::EMPTY, kind: BuiltKind::Leaf { count } });
    let built = Built { cells: cells.to_vec(), triangles: (0..92).collect(), thickness: 0.0 };
    for (most, pooled) in [(POOL, 2), (POOL / 2, 0)] {
        let cpu = CpuMeter::default();
        let contents = Contents::new(&built, &Some92, most, &cpu);
        assert_eq!(contents.pools[1].0, pooled, "of the second leaf's three blocks, two are whole and of pairs");
        let mut planner = Planner::new(&contents.pools);
        for number in [1, 0, 3, 2] {
            planner.place(number, sizes[number as usize]);
        }
        let store = LeafStore::new(&contents, &planner, &Some92, &cpu);
        let mut next = 0;
        for leaf in planner.leaves() {
            for block in store.blocks(*leaf) {
                for i in 0..block.len {
                    assert_eq!(block.triangle(i), next);
                    assert_eq!(block.corners(i), Some92.vertices(next).map(|v| v.to_array()));
                    next += 1;
                }
            }
            if leaf.count > 16 {
                assert_eq!(store.large(leaf.first), *leaf);
            }
        }
        assert_eq!(next, 92);
    }
}
