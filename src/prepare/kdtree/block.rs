//! A leaf block: up to 16 triangles for a kernel to test at once, in one of two forms.
//!
//! *Plain*: ten arrays of a word for each triangle: x, y, z of the first corners, of the second, of the third, and the
//! triangles' numbers. *Pooled*: neighbours in a mesh share corners, so that up to 32 different ones are kept once: x, y, z
//! in three arrays, three times sixteen bytes that say which is a triangle's first, second and third corner, and the
//! triangles' numbers. That is less than half as much to fetch where there are up to 16 corners, and two thirds for up to 32.

use super::Triangles;
use super::split::BLOCK;

/// Words of a triangle in a plain block.
const PLAIN: usize = 10;
/// Words of the indices in a pooled block.
const INDICES: usize = 12;

/// Different corners that a pooled block may have.
pub const POOL: usize = 32;

/// A block of up to 16 references.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// References in it.
    pub len: usize,
    /// Different corners in a pooled block; 0 for a plain one.
    pub pool: usize,
    /// Its words, and whatever follows.
    pub words: &'a [u32],
}

/// Words that a block takes.
#[inline(always)]
pub const fn words_of(len: usize, pool: usize) -> usize {
    if pool == 0 { PLAIN * len } else { 3 * pool + INDICES + len }
}

impl Block<'_> {
    /// The corners of a reference's triangle.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> [[f32; 3]; 3] {
        self.corners_along(i, [0, 1, 2])
    }

    /// The same with their coordinates in the order of these axes.
    #[inline(always)]
    pub fn corners_along(&self, i: usize, [x, y, z]: [usize; 3]) -> [[f32; 3]; 3] {
        let at = |k: usize| f32::from_bits(self.words[k]);
        if self.pool == 0 {
            let n = self.len;
            let corner = |k: usize| [at((3 * k + x) * n + i), at((3 * k + y) * n + i), at((3 * k + z) * n + i)];
            return [corner(0), corner(1), corner(2)];
        }
        let n = self.pool;
        let corner = |k: usize| {
            let word = self.words[3 * n + 4 * k + i / 4];
            let point = (word >> (8 * (i % 4))) as usize & (POOL - 1);
            [at(x * n + point), at(y * n + point), at(z * n + point)]
        };
        [corner(0), corner(1), corner(2)]
    }

    /// The number of a reference's triangle.
    #[inline(always)]
    pub fn triangle(&self, i: usize) -> u32 {
        self.words[words_of(self.len, self.pool) - self.len + i]
    }
}

/// Which of the different corners of a block's triangles are theirs: sixteen first ones, second ones, third ones.
pub type Indices = [[u8; BLOCK]; 3];

/// The different corners of a block's triangles, told apart by their bits.
struct Pool {
    points: [[u32; 3]; POOL],
    len: usize,
    indices: Indices,
}

impl Pool {
    /// `None` when there are more than 32 of them.
    fn find<T: Triangles>(ids: &[u32], triangles: &T) -> Option<Self> {
        let mut pool = Self { points: [[0; 3]; POOL], len: 0, indices: [[0; BLOCK]; 3] };
        // Where in the pool a point may be, by a hash of it; the next place if another one is there.
        let mut places = [FREE; 4 * POOL];
        for (i, &id) in ids.iter().enumerate() {
            for (k, corner) in triangles.vertices(id).into_iter().enumerate() {
                let point = corner.to_array().map(f32::to_bits);
                let mut place = hash(point);
                let at = loop {
                    let at = places[place];
                    if at == FREE {
                        places[place] = pool.len as u8;
                        *pool.points.get_mut(pool.len)? = point;
                        pool.len += 1;
                        break (pool.len - 1) as u8;
                    }
                    if pool.points[usize::from(at) % POOL] == point {
                        break at;
                    }
                    place = (place + 1) % places.len();
                };
                *pool.indices[k].get_mut(i)? = at;
            }
        }
        Some(pool)
    }
}

/// Stands where there is no point.
const FREE: u8 = u8::MAX;

/// Where to look for a point first, of four places for each in a full pool.
fn hash([x, y, z]: [u32; 3]) -> usize {
    let mixed = (x ^ y.rotate_left(11) ^ z.rotate_left(22)).wrapping_mul(0x9e37_79b1);
    (mixed >> (u32::BITS - (4 * POOL).ilog2())) as usize
}

/// The size of the pool that a block of these triangles should have, and where their corners are in it: 0 where a plain block is
/// smaller, or the pool would have more than `most` corners.
pub fn pool<T: Triangles>(ids: &[u32], triangles: &T, most: usize) -> (usize, Indices) {
    let none = (0, [[0; BLOCK]; 3]);
    if ids.is_empty() || ids.len() > BLOCK {
        return none;
    }
    match Pool::find(ids, triangles) {
        Some(found) if found.len <= most && words_of(ids.len(), found.len) < words_of(ids.len(), 0) => {
            (found.len, found.indices)
        }
        _ => none,
    }
}

/// Writes a block to `words`, which are as many as it takes; `pool` and `indices` are those of [`pool`].
pub fn write<T: Triangles>(words: &mut [u32], ids: &[u32], pool: usize, indices: &Indices, triangles: &T) {
    let n = ids.len();
    for (word, &id) in words[words_of(n, pool) - n..].iter_mut().zip(ids) {
        *word = triangles.number(id);
    }
    if pool == 0 {
        for (i, &id) in ids.iter().enumerate() {
            let coordinates = triangles.vertices(id).map(|v| v.to_array());
            for (k, x) in coordinates.as_flattened().iter().enumerate() {
                words[k * n + i] = x.to_bits();
            }
        }
        return;
    }
    for (i, &id) in ids.iter().enumerate() {
        for (corner, indices) in triangles.vertices(id).into_iter().zip(indices) {
            for (axis, x) in corner.to_array().into_iter().enumerate() {
                words[axis * pool + usize::from(indices[i])] = x.to_bits();
            }
        }
    }
    for (word, bytes) in words[3 * pool..].iter_mut().zip(indices.as_flattened().chunks_exact(4)) {
        *word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    struct Fan(usize);

    impl Triangles for Fan {
        fn len(&self) -> usize {
            self.0
        }

        fn vertices(&self, triangle: u32) -> [Vec3; 3] {
            let rim = |i: u32| Vec3::new(i as f32, (i * i) as f32, -(i as f32));
            [Vec3::ZERO, rim(triangle), rim(triangle + 1)]
        }
    }

    /// Pairs of triangles that share an edge.
    struct Squares;

    impl Triangles for Squares {
        fn len(&self) -> usize {
            100
        }

        fn vertices(&self, triangle: u32) -> [Vec3; 3] {
            let (x, z) = ((triangle / 2) as f32, triangle as f32 % 2.0);
            [Vec3::new(x, 1.0, 0.5), Vec3::new(x, 2.0, 0.5), Vec3::new(x, 3.0, z)]
        }
    }

    fn check(n: usize, triangles: &impl Triangles) {
        let ids: Vec<u32> = (0..n as u32).map(|i| i + 4).collect();
        for (pool, indices) in [(0, [[0; BLOCK]; 3]), pool(&ids, triangles, POOL)] {
            let mut words = vec![0; words_of(n, pool)];
            write(&mut words, &ids, pool, &indices, triangles);
            let block = Block { len: n, pool, words: &words };
            for (i, &id) in ids.iter().enumerate() {
                assert_eq!(block.triangle(i), id);
                assert_eq!(block.corners(i), triangles.vertices(id).map(|v| v.to_array()));
            }
        }
    }

    #[test]
    fn both_forms_give_back_what_was_written() {
        for n in 1..=16 {
            check(n, &Fan(30));
            check(n, &Squares);
        }
        let ids: Vec<u32> = (0..16).collect();
        assert_eq!(pool(&ids[..14], &Fan(30), POOL).0, 16, "14 triangles of a fan have 16 corners");
        assert_eq!(pool(&ids, &Squares, POOL).0, 32, "eight squares have 32");
        assert_eq!(pool(&ids, &Squares, 31).0, 0, "and no pool of fewer");
        let odd: Vec<u32> = ids.iter().map(|i| 2 * i).collect();
        assert_eq!(pool(&odd, &Squares, POOL).0, 0, "sixteen triangles that share nothing have too many");
    }
}
