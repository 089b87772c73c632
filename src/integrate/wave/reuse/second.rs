//! Second vertices, whose light others can use.

use super::super::surface::Surface;
use super::super::{Wave, hit, path};
use super::first;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::shading::RoughLanes;
use glam::Vec3;

/// On the triangle.
pub const PLACE: usize = 0;
pub const ERROR: usize = 3;
/// Geometric and shading normal on the side that the path sees.
pub const NORMAL: usize = 6;
pub const SHADING: usize = 9;
/// What the path brings there.
pub const THROUGHPUT: usize = 12;
/// Density of its direction over solid angle.
pub const PDF: usize = 15;
pub const FLOATS: usize = 16;

pub const SLOT: usize = 0;
pub const TRIANGLE: usize = 1;
pub const WORDS: usize = 2;

impl Wave<'_, '_> {
    /// Keeps those of the second vertices of the paths from `at` on, among those where `lit`, that others can use. From there on, their
    /// paths gather light of which nobody knows yet who gets how much, so they carry a throughput of one: that is given.
    #[inline(always)]
    pub(in super::super) fn keep_second<L: Lanes>(
        &mut self,
        l: L,
        at: usize,
        lit: L::M,
        surface: &Surface<L>,
        lobes: &RoughLanes<L::F>,
        throughput: V3<L::F>,
    ) -> V3<L::F> {
        let memory = &mut *self.memory;
        let Some(shared) = &mut memory.reuse else { return throughput };
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let pdf = memory.paths.load(l, path::PDF, at) * self.course.light_samples(0) as f32;
        let [diffuse, reflection, wall] = lobes.shares;
        let only_diffuse = diffuse.gt(zero) & reflection.eq(zero) & wall.eq(zero) & !lobes.coated();
        let fits = lit & surface.steady & only_diffuse & pdf.gt(zero);
        if fits.none() {
            return throughput;
        }
        let slot = memory.paths.load_words(l, path::SLOT, at);
        let (slots, mut bits) = (slot.array(), fits.bits());
        for lane in (0..LANES).filter(|lane| fits.bits() >> lane & 1 != 0) {
            let slot = slots[lane] as usize;
            if shared.first.word(first::FLAGS, slot) & first::TAKES_PART == 0 {
                bits &= !(1 << lane);
                continue;
            }
            shared.light.push(std::mem::replace(&mut memory.slots[slot].radiance, Vec3::ZERO));
        }
        let fits = l.mask(bits);
        let mut floats = [zero; FLOATS];
        for (row, v) in [
            (PLACE, surface.place),
            (ERROR, surface.error),
            (NORMAL, surface.normal),
            (SHADING, surface.frame.z),
            (THROUGHPUT, throughput),
        ] {
            floats[row..row + 3].copy_from_slice(&v.components());
        }
        floats[PDF] = pdf;
        let triangle = memory.hits.load_words(l, hit::TRIANGLE, at);
        shared.second.store::<L>(shared.second.len, fits, floats, [slot, triangle]);
        shared.second.len += fits.count();
        V3::select(fits, V3::splat(one), throughput)
    }
}
