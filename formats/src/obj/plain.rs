//! Statements as nearly all files have them, read while they are checked.
//!
//! `tobj` reads a number a second time, and asks a hash table for every corner of a face. Where all vertices and faces of a file are plain,
//! neither is needed: [`Numbers`] gives the models that `tobj` would give, bit for bit.

use super::number::{Plain, plain_corners, plain_decimals};
use super::scan::{Counts, Scanner};
use crate::{Control, ImportError};
use std::collections::HashMap;

/// The vertices and faces of a file that has had only plain ones so far.
#[derive(Default)]
pub(super) struct Numbers {
    positions: Vec<[f64; 3]>,
    /// One for each position, or none at all.
    colors: Vec<[f64; 3]>,
    texcoords: Vec<[f64; 2]>,
    normals: Vec<[f64; 3]>,
    /// Of each part.
    faces: Vec<Faces>,
}

/// The faces of one part.
#[derive(Default)]
struct Faces {
    /// Position, texture coordinate and normal, from 1; 0 for what the part has none of.
    corners: Vec<[u32; 3]>,
    arities: Vec<u32>,
}

impl Numbers {
    fn position(&mut self, plain: &Plain) {
        let [x, y, z, r, g, b] = plain.values;
        if plain.count == 6 {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            self.colors.push([r, g, b]);
        } else if !self.colors.is_empty() {
            self.colors.push([1.0; 3]);
        }
        self.positions.push([x, y, z]);
    }

    fn face(&mut self, part: usize, corners: &[[u32; 3]]) {
        if self.faces.len() <= part {
            self.faces.resize_with(part + 1, Faces::default);
        }
        if let Some(faces) = self.faces.get_mut(part) {
            faces.corners.extend_from_slice(corners);
            faces.arities.push(corners.len() as u32);
        }
    }

    /// A model for each part, with a vertex for each combination of indices, in the order in which faces name them.
    ///
    /// # Errors
    /// [`crate::ErrorCode::Stopped`].
    pub(super) fn into_models(mut self, control: &Control) -> Result<Vec<tobj::Model>, ImportError> {
        let mut corners = Corners { first: vec![(0, 0); self.positions.len() + 1], ..Corners::default() };
        let mut models = Vec::with_capacity(self.faces.len());
        for faces in std::mem::take(&mut self.faces) {
            corners.next_part();
            let mut mesh = tobj::Mesh::default();
            mesh.indices.reserve_exact(faces.corners.len());
            for some in faces.corners.chunks(1 << 16) {
                control.check()?;
                mesh.indices.extend(some.iter().map(|corner| corners.vertex(*corner)));
            }
            let named =
                |k: usize| corners.known.iter().filter_map(move |known| (known.corner[k] as usize).checked_sub(1));
            mesh.positions = gather(&self.positions, named(0));
            mesh.vertex_color = gather(&self.colors, named(0));
            mesh.texcoords = gather(&self.texcoords, named(1));
            mesh.normals = gather(&self.normals, named(2));
            if faces.arities.iter().any(|arity| *arity != 3) {
                mesh.face_arities = faces.arities;
            }
            models.push(tobj::Model::new(mesh, String::new()));
        }
        Ok(models)
    }
}

fn gather<const N: usize>(values: &[[f64; N]], indices: impl Iterator<Item = usize>) -> Vec<f64> {
    let mut gathered: Vec<[f64; N]> = Vec::new();
    if !values.is_empty() {
        gathered.extend(indices.filter_map(|i| values.get(i)));
    }
    gathered.into_flattened()
}

/// Vertices of a position that are looked through one by one.
const CHAIN: usize = 8;

/// Numbers the combinations of indices of a part.
#[derive(Default)]
struct Corners {
    /// For each position the last part that has named it, and its first vertex there.
    first: Vec<(u32, u32)>,
    part: u32,
    known: Vec<Known>,
    /// Those beyond [`CHAIN`] others of their position.
    far: HashMap<[u32; 3], u32>,
}

struct Known {
    corner: [u32; 3],
    /// The next vertex of the same position, or 0.
    next: u32,
}

impl Corners {
    fn next_part(&mut self) {
        self.part += 1;
        self.known.clear();
        self.far.clear();
    }

    #[inline]
    fn vertex(&mut self, corner: [u32; 3]) -> u32 {
        let new = self.known.len() as u32;
        let Some((part, first)) = self.first.get_mut(corner[0] as usize) else { return 0 };
        if *part != self.part {
            (*part, *first) = (self.part, new);
            self.known.push(Known { corner, next: 0 });
            return new;
        }
        let mut at = *first;
        for left in (0..CHAIN).rev() {
            let Some(known) = self.known.get_mut(at as usize) else { break };
            if known.corner == corner {
                return at;
            }
            if known.next == 0 && left > 0 {
                known.next = new;
                self.known.push(Known { corner, next: 0 });
                return new;
            }
            at = known.next;
        }
        let known = &mut self.known;
        *self.far.entry(corner).or_insert_with(|| {
            known.push(Known { corner, next: 0 });
            new
        })
    }
}

impl<'t> Scanner<'t> {
    /// Takes the statement that `rest` of the text begins with if it is a plain one of a vertex or a face, and gives its length, the end of its
    /// line included.
    #[inline]
    pub(super) fn plain_statement(&mut self, rest: &'t str) -> Option<usize> {
        let bytes = rest.as_bytes();
        let length = match bytes {
            [b'v', b' ' | b'\t', ..] => {
                let (plain, length) = plain_decimals(bytes, 1).filter(|(plain, _)| matches!(plain.count, 3 | 6))?;
                self.counts.positions += 1;
                self.colored += u32::from(plain.count == 6);
                if let Some(numbers) = &mut self.scan.numbers {
                    numbers.position(&plain);
                }
                length
            }
            [b'v', b't', b' ' | b'\t', ..] => {
                let (plain, length) = plain_decimals(bytes, 2).filter(|(plain, _)| matches!(plain.count, 2 | 3))?;
                self.counts.texcoords += 1;
                if let Some(numbers) = &mut self.scan.numbers {
                    numbers.texcoords.push([plain.values[0], plain.values[1]]);
                }
                length
            }
            [b'v', b'n', b' ' | b'\t', ..] => {
                let (plain, length) = plain_decimals(bytes, 2).filter(|(plain, _)| plain.count == 3)?;
                let [x, y, z, ..] = plain.values;
                if [x, y, z] == [0.0; 3] {
                    return None;
                }
                self.counts.normals += 1;
                if let Some(numbers) = &mut self.scan.numbers {
                    numbers.normals.push([x, y, z]);
                }
                length
            }
            [b'f', b' ' | b'\t', ..] => return self.plain_face(rest),
            _ => return None,
        };
        let start = self.text.len() - rest.len();
        self.scan.vertices.borrow(start..start + length);
        Some(length)
    }

    /// Takes a face whose corners are plain, sound and alike.
    #[inline]
    fn plain_face(&mut self, rest: &str) -> Option<usize> {
        let Counts { positions, texcoords, normals } = self.counts;
        let bad = [&self.bad_positions, &self.bad_texcoords, &self.bad_normals];
        if bad.iter().any(|list| !list.is_empty()) {
            return None;
        }
        self.corners.clear();
        let list = &mut self.corners;
        let mut first = None;
        let length = plain_corners(rest.as_bytes(), 1, |[v, vt, vn]| {
            let kind = (vt != 0, vn != 0);
            list.push([v, vt, vn]);
            v <= positions && vt <= texcoords && vn <= normals && *first.get_or_insert(kind) == kind
        })?;
        let (uvs, normals) = first.filter(|_| list.len() >= 3)?;
        let part = self.part(uvs, normals);
        if let Some(numbers) = &mut self.scan.numbers {
            numbers.face(part, &self.corners);
        }
        let start = self.text.len() - rest.len();
        self.scan.faces.get_mut(part)?.borrow(start..start + length);
        Some(length)
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::parse;
    use super::super::log::Log;
    use super::super::scan::scan;
    use super::*;

    /// The models of a text by its numbers, and by `tobj`.
    fn both_ways(text: &str) -> [Vec<tobj::Model>; 2] {
        [true, false].map(|by_numbers| {
            let (mut warnings, control) = (Vec::new(), Control::default());
            let mut scan = scan(text, 1000, &mut Log::new(&mut warnings), &control).unwrap();
            assert!(scan.numbers.is_some(), "plain: {text}");
            scan.numbers = scan.numbers.filter(|_| by_numbers);
            parse(&mut scan, &control).unwrap()
        })
    }

    fn assert_same(text: &str) -> Vec<tobj::Model> {
        let [ours, theirs] = both_ways(text);
        assert_eq!(ours.len(), theirs.len(), "{text}");
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for (a, b) in ours.iter().zip(&theirs) {
            let (a, b) = (&a.mesh, &b.mesh);
            assert_eq!((&a.indices, &a.face_arities), (&b.indices, &b.face_arities), "{text}");
            for [a, b] in [
                [&a.positions, &b.positions],
                [&a.normals, &b.normals],
                [&a.texcoords, &b.texcoords],
                [&a.vertex_color, &b.vertex_color],
            ] {
                assert_eq!(bits(a), bits(b), "{text}");
            }
        }
        ours
    }

    #[test]
    fn numbers_give_what_tobj_gives() {
        let data = "v 0 0 -0.0\nv 1.1 0.30000000000000004 0\nv 0 1e-3 0\nv 123456789.123456789 1 1\nvt 0.1 0.9\nvt 1 1 0\nvn 0 0 1\nvn 0 1 0\n";
        let faces = [
            "f 1 2 3\n",
            "f 1/1 2/2 3/1\nf 1/2 2/2 3/1\n",
            "f 1//1 2//1 3//2\nf 1//2 2//1 3//1\n",
            "f 1/1/1 2/1/1 3/2/2\nf 3/1/1 2/1/1 4/2/2\n",
            "f 1 2 3 4\nf 1 2 3\n",
            "f 1 2 3\nusemtl a\nf 2 3 4\nf 1/1 2/2 3/1\nusemtl b\nf 1 2 3\nusemtl a\nf 4 3 2\n",
            "s 1\nf 1 2 3\ns 2\nf 2 3 4\n",
            "f 4 4 4\r\nf 4 3 4\r\n",
        ];
        for face in faces {
            assert_same(&format!("{data}{face}"));
        }
        let colored = "v 0 0 0\nv 1 0 0 0.5 0.25 1\nv 0 1 0 1 0 0\nv 1 1 0\nf 1 2 3 4\n";
        let [ours] = assert_same(colored).try_into().unwrap();
        assert_eq!(ours.mesh.vertex_color[..6], [1.0, 1.0, 1.0, 0.5, 0.25, 1.0]);
    }

    #[test]
    fn a_position_may_have_any_number_of_vertices() {
        let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        (0..60).for_each(|i| text += &format!("vt {i} 0\n"));
        for (a, b) in (0..60).flat_map(|a| [(a, 59 - a), (a, a * 7 % 60)]) {
            text += &format!("f 1/{} 2/{} 3/{}\n", a + 1, b + 1, a % 3 + 1);
        }
        let [ours] = assert_same(&text).try_into().unwrap();
        assert_eq!(ours.mesh.positions.len(), 3 * (60 + 60 + 3));
    }
}
