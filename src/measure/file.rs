//! Files of rays: the number of rays as u32, then for each the origin (x, y, z), where it begins, the direction (x, y, z) and
//! where it ends, all f32, everything little-endian. Ends are in units of the direction.

use crate::geometry::WorldFrame;
use crate::math::Ray;
use glam::DVec3;

/// Bytes of a ray.
const RAY: usize = 32;

/// A ray in the asset's own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileRay {
    /// Where it comes from.
    pub origin: [f32; 3],
    /// Where it begins, in units of its direction.
    pub near: f32,
    /// Where it goes; finite and not zero.
    pub dir: [f32; 3],
    /// Where it ends, in units of its direction; may be infinite.
    pub far: f32,
}

/// Why a file of rays cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RayFileError {
    /// The file ends before the number of rays.
    #[error("{0} bytes are no file of rays: it begins with their number, a u32")]
    TooShort(usize),
    /// The file is not as long as the number of rays says.
    #[error("{found} bytes instead of {expected} for {rays} rays")]
    Length {
        /// The number of rays that the file claims.
        rays: u32,
        /// Bytes that so many rays take.
        expected: u64,
        /// Bytes in the file.
        found: usize,
    },
    /// A ray that leads nowhere.
    #[error("ray {0} (counted from 0, byte {byte}): origin, beginning and direction must be finite, the direction not zero and the end a number", byte = 4 + RAY * .0)]
    Ray(usize),
}

/// Reads the bytes of a file.
///
/// # Errors
/// See [`RayFileError`].
pub fn parse(bytes: &[u8]) -> Result<Vec<FileRay>, RayFileError> {
    let (head, body) = bytes.split_first_chunk::<4>().ok_or(RayFileError::TooShort(bytes.len()))?;
    let rays = u32::from_le_bytes(*head);
    if body.len() as u64 != u64::from(rays) * RAY as u64 {
        return Err(RayFileError::Length { rays, expected: 4 + u64::from(rays) * RAY as u64, found: bytes.len() });
    }
    let ray = |(i, bytes): (usize, &[u8])| {
        let at = |k: usize| f32::from_le_bytes([bytes[4 * k], bytes[4 * k + 1], bytes[4 * k + 2], bytes[4 * k + 3]]);
        let ray = FileRay { origin: [at(0), at(1), at(2)], near: at(3), dir: [at(4), at(5), at(6)], far: at(7) };
        let finite = ray.origin.iter().chain(&ray.dir).chain([&ray.near]).all(|x| x.is_finite());
        let leads = finite && ray.dir != [0.0; 3] && !ray.far.is_nan();
        if leads { Ok(ray) } else { Err(RayFileError::Ray(i)) }
    };
    body.chunks_exact(RAY).enumerate().map(ray).collect()
}

impl FileRay {
    /// The part of the ray that counts, in the rays' frame. Distances stay in units of the file's direction, counted from where
    /// the ray begins.
    pub(super) fn placed(&self, frame: &WorldFrame) -> Ray {
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let begin = wide(self.origin) + wide(self.dir) * f64::from(self.near);
        Ray { origin: frame.point(begin), dir: frame.vector(wide(self.dir)), t_max: self.far - self.near }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(count: u32, rays: &[[f32; 8]]) -> Vec<u8> {
        let numbers = rays.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        count.to_le_bytes().into_iter().chain(numbers).collect()
    }

    #[test]
    fn rays_come_back_as_they_were_written() {
        let read = parse(&bytes(2, &[[1.0, 2.0, 3.0, 0.5, 0.0, -1.0, 0.0, 9.0], [0.0; 8].map(|_| 1.0)])).unwrap();
        let first = FileRay { origin: [1.0, 2.0, 3.0], near: 0.5, dir: [0.0, -1.0, 0.0], far: 9.0 };
        assert_eq!((read[0], read.len()), (first, 2));
        let placed = first.placed(&WorldFrame::new(&kiln_formats::Scene::default(), None));
        assert_eq!((placed.origin.to_array(), placed.t_max), ([1.0, 1.5, 3.0], 8.5));
        assert_eq!(parse(&bytes(0, &[])), Ok(vec![]));
    }

    #[test]
    fn what_is_no_file_of_rays_is_refused_at_its_place() {
        assert_eq!(parse(&[1, 2]), Err(RayFileError::TooShort(2)));
        let claims = parse(&bytes(u32::MAX, &[[1.0; 8]]));
        assert_eq!(claims, Err(RayFileError::Length { rays: u32::MAX, expected: 137_438_953_444, found: 36 }));
        let still = parse(&bytes(2, &[[1.0; 8], [1.0, 1.0, 1.0, 0.0, 0.0, -0.0, 0.0, 1.0]]));
        assert_eq!(still, Err(RayFileError::Ray(1)));
        assert!(still.unwrap_err().to_string().starts_with("ray 1 (counted from 0, byte 36)"));
        assert_eq!(parse(&bytes(1, &[[f32::NAN; 8]])), Err(RayFileError::Ray(0)));
    }
}
