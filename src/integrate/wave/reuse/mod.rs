//! Pixels that use each other's paths (Bekaert, Sbert & Halton 2002, "Accelerating Path Tracing by Re-using Paths").
//!
//! A diffuse surface sends the same light to all who see it. So what a path gathers from its second vertex y on is worth something to
//! all sixteen pixels of a group ([`crate::film::group_in_square`]): their first vertices x are joined to y by a ray each. Pixel i
//! gets from the path of pixel j
//!
//!   f_i(x_i → y) G(x_i, y) V(x_i, y) L(y) / Σ_k p_k(x_k → y) G(x_k, y) V(x_k, y),
//!
//! the balance heuristic over all first vertices that could have sent their path to y, themselves included: unbiased, and without a
//! pole where G has one, since the same G stands below the line.
//!
//! What takes part is decided by what all techniques agree on, so that the weights of a place add up to one:
//! - First vertices shaded in lanes that scatter otherwise than by delta distributions; a part of the scattering that is one stays the
//!   path's own.
//! - Second vertices that are diffuse and nothing else, on the side that the path sees, from where their shading normal is not bent to
//!   the viewer. Other second vertices, and paths that find none, stay the path's own.
//! - What y looks like is read once, with the width of the ray that found it: weights of textured places are those of one technique.
//! - Light that is emitted at y or comes from beyond the scene stays the path's own, with its weight against light samples: L is what y
//!   scatters.
//! - Where surfaces are cut out, a ray from x_k is stopped by the same random numbers as the path of pixel k: it meets the scene that this
//!   path could have met. How much of y is there all techniques find alike, so nobody asks.
//!
//! Samples of one number only are joined, so the replicates stay independent.

mod first;
mod join;
mod second;

use super::rows::Rows;
use super::{PATHS, Slot};
use crate::film::{GROUPS, group_in_square};
use crate::integrate::tile::SIDE;
use crate::lanes::LANES;
use glam::Vec3;
pub(super) use join::Join;

/// Rays between paths that wait to be traced.
const PAIRS: usize = 2048;

/// What paths leave behind for others.
pub(super) struct Shared {
    /// First vertices, at the places of the slots.
    first: Rows<{ first::FLOATS }, { first::WORDS }>,
    /// Second vertices that others can use, in the order of the slots.
    second: Rows<{ second::FLOATS }, { second::WORDS }>,
    /// What the paths of [`Self::second`] have brought their own pixels alone; later what others may use.
    light: Vec<Vec3>,
    /// Rays from first to second vertices.
    pairs: Rows<{ pair::FLOATS }, { pair::WORDS }>,
    blocked: Vec<bool>,
    /// Where rays to points end.
    ones: Vec<f32>,
    /// The paths that the rays belong to.
    joined: Vec<Joined>,
}

/// Rows of a ray between paths.
mod pair {
    pub const ORIGIN: usize = 0;
    pub const DIR: usize = 3;
    /// What it brings its first vertex's pixel, but for the common divisor, if nothing is in the way.
    pub const LIGHT: usize = 6;
    /// The density with which the first vertex would have sent its path there, per area.
    pub const DENSITY: usize = 9;
    pub const FLOATS: usize = 10;
    /// Of the first vertex.
    pub const SLOT: usize = 0;
    pub const REACHES: usize = 1;
    pub const WORDS: usize = 2;
}

/// A second vertex, joined.
struct Joined {
    /// Of the path that found it.
    slot: u32,
    /// The same as [`pair::LIGHT`] and [`pair::DENSITY`], for that path.
    light: Vec3,
    density: f32,
    /// Where the rays to it end; they begin where those of the one before end.
    end: usize,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            first: Rows::new(PATHS),
            second: Rows::new(PATHS),
            light: Vec::with_capacity(PATHS),
            pairs: Rows::new(PAIRS),
            blocked: vec![false; PAIRS],
            ones: vec![1.0; PAIRS],
            joined: Vec::with_capacity(PATHS),
        }
    }
}

/// The pixels of a tile, group after group of those that use each other's paths.
pub(super) fn in_groups(width: u32, height: u32) -> Vec<[u32; 2]> {
    let group = |k: u32| (0..SIDE * SIDE).map(|i| [i % SIDE, i / SIDE]).filter(move |at| group_in_square(*at) == k);
    (0..GROUPS).flat_map(group).filter(|[x, y]| *x < width && *y < height).collect()
}

impl Shared {
    /// Before so many paths as there are slots.
    pub fn begin(&mut self, paths: usize) {
        self.second.len = 0;
        self.light.clear();
        for slot in 0..paths.next_multiple_of(LANES) {
            self.first.set_word(first::FLAGS, slot, 0);
        }
    }

    /// Gives each slot what its path brought its own pixel, and keeps what others may use.
    fn part(&mut self, slots: &mut [Slot]) {
        for (i, light) in self.light.iter_mut().enumerate() {
            let slot = self.second.word(second::SLOT, i) as usize;
            std::mem::swap(light, &mut slots[slot].radiance);
        }
    }
}
