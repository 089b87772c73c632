use super::{Lower, Result};
use crate::ErrorCode;
use crate::ray::source::Offset;
use crate::ray::tree::Faces;

impl Lower<'_, '_> {
    /// `objfile = "f.obj"` of one fork: the points and faces of a Wavefront file, and nothing else of it.
    pub(super) fn objfile(&mut self, file: &str, at: Offset) -> Result<(Vec<[f32; 3]>, Faces)> {
        let fail = |code, message: String| self.source.error(code, at, format!("mesh `{file}`: {message}"));
        let bytes = self.resources.read(file).map_err(|error| fail(error.code, error.message))?;
        let mut points = Vec::new();
        let mut faces = Faces::default();
        for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
            if number.is_multiple_of(4096) {
                self.control.check()?;
            }
            let line = String::from_utf8_lossy(line);
            let mut words = line.split_ascii_whitespace();
            let broken = |what: &str| fail(ErrorCode::Syntax, format!("line {}: {what}", number + 1));
            match words.next() {
                Some("v") => {
                    let mut coordinate = || words.next()?.parse().ok().filter(|x: &f32| x.is_finite());
                    let (Some(x), Some(y), Some(z)) = (coordinate(), coordinate(), coordinate()) else {
                        return Err(broken("a vertex needs three numbers"));
                    };
                    points.push([x, y, z]);
                }
                Some("f") => {
                    let begin = faces.indices.len();
                    for word in words {
                        // Only the first of `v/vt/vn` matters.
                        let index = word.split('/').next().and_then(|i| i.parse::<i64>().ok());
                        faces.indices.push(match index {
                            Some(index) if index > 0 => index - 1,
                            Some(index) if index < 0 => (points.len() as i64).saturating_add(index),
                            _ => return Err(broken("a face has an index that is no number from 1")),
                        });
                    }
                    if faces.indices.len() - begin < 3 {
                        return Err(broken("a face needs three vertices or more"));
                    }
                    faces.ends.push((at, faces.indices.len()));
                }
                _ => {}
            }
        }
        Ok((points, faces))
    }
}
