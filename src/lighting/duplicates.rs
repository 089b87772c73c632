//! Triangles in the very same place. A ray meets the first of them alone (ties go to the lower number), so light samples
//! must not count the others.

use crate::geometry::Geometry;
use crate::sampling::hash_combine;
use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// A triangle's corners as numbers, in an order of their own.
type Key = [[u32; 3]; 3];

fn key(corners: [Vec3; 3]) -> Key {
    // Adding zero makes the negative zero a positive one.
    let mut key = corners.map(|c| (c + Vec3::ZERO).to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}

/// A number that the order of corners does not change.
fn mark(corners: [Vec3; 3]) -> u32 {
    let of = |c: Vec3| {
        let [x, y, z] = (c + Vec3::ZERO).to_array().map(f32::to_bits);
        hash_combine(hash_combine(x, y), z)
    };
    corners.map(of).into_iter().fold(0, u32::wrapping_add)
}

/// The emissive triangles behind a triangle of lower number with the same corners, through which nothing is seen.
pub(super) fn hidden(geometry: &Geometry, emits: impl Fn(u32) -> bool, covers: impl Fn(u32) -> bool) -> HashSet<u32> {
    let count = geometry.len() as u32;
    // Most scenes end here: a bit for each emissive triangle, met by no other.
    let bits = (2 * count).next_power_of_two().max(64);
    let place = |mark: u32| ((mark % bits / 64) as usize, 1u64 << (mark % 64));
    let mut emissive = vec![0u64; bits as usize / 64];
    let marks: Vec<u32> = (0..count).filter(|t| emits(*t)).map(|t| mark(geometry.corners(t))).collect();
    if marks.is_empty() {
        return HashSet::new();
    }
    for mark in &marks {
        let (word, bit) = place(*mark);
        emissive[word] |= bit;
    }
    let mut first: HashMap<Key, u32> = HashMap::new();
    let mut hidden = HashSet::new();
    for triangle in 0..count {
        let corners = geometry.corners(triangle);
        let (word, bit) = place(mark(corners));
        if emissive[word] & bit == 0 {
            continue;
        }
        let at = first.entry(key(corners)).or_insert(triangle);
        if *at == triangle {
            continue;
        }
        // What is seen through does not hide; the next one may.
        if !covers(*at) {
            *at = triangle;
        } else if emits(triangle) {
            hidden.insert(triangle);
        }
    }
    hidden
}
