//! First vertices, from where pixels look at each other's paths.

use super::super::Wave;
use super::super::lanes::FrameLanes;
use super::super::surface::{Outgoing, Surface};
use crate::integrate::walk::{MOST_SURVIVAL, SURVIVAL};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::shading::RoughLanes;

pub const POINT: usize = 0;
pub const PLACE: usize = 3;
pub const ERROR: usize = 6;
pub const NORMAL: usize = 9;
/// The frame's third axis: the other two follow.
pub const SHADING: usize = 12;
pub const WO: usize = 15;
/// What the path brings there.
pub const THROUGHPUT: usize = 18;
const ALBEDO: usize = 21;
const F0: usize = 24;
const F90: usize = 27;
const TINT: usize = 30;
const SHARES: usize = 33;
const ALPHA: usize = 36;
pub const FLOATS: usize = 37;

pub const FLAGS: usize = 0;
pub const WORDS: usize = 1;

/// It takes part.
pub const TAKES_PART: u32 = 1;
const LIFTED: u32 = 2;
const ROUGH: u32 = 4;

/// Sixteen first vertices.
pub struct First<L: Lanes> {
    pub surface: Surface<L>,
    lobes: RoughLanes<L::F>,
    throughput: V3<L::F>,
    pub takes_part: L::M,
}

/// What sixteen first vertices have to do with a point.
pub struct Seen<L: Lanes> {
    /// Towards it, of unit length.
    pub dir: V3<L::F>,
    pub distance2: L::F,
    /// Scattered towards it or from there, with the path's throughput: f·|cos θ|.
    pub value: V3<L::F>,
    /// The density over solid angle with which paths are sent there.
    pub pdf: L::F,
    /// The probability that they go on.
    pub survival: L::F,
    pub out: Outgoing<L>,
}

impl Wave<'_, '_> {
    /// Keeps the first vertices of the paths from `at` on, of which those where `lit` take part.
    #[inline(always)]
    pub(in super::super) fn keep_first<L: Lanes>(
        &mut self,
        l: L,
        at: usize,
        lit: L::M,
        surface: &Surface<L>,
        lobes: &RoughLanes<L::F>,
        throughput: V3<L::F>,
    ) {
        let Some(shared) = &mut self.memory.reuse else { return };
        let mut floats = [l.splat(0.0); FLOATS];
        for (row, v) in [
            (POINT, surface.point),
            (PLACE, surface.place),
            (ERROR, surface.error),
            (NORMAL, surface.normal),
            (SHADING, surface.frame.z),
            (WO, surface.wo),
            (THROUGHPUT, throughput),
            (ALBEDO, lobes.albedo),
            (F0, lobes.f0),
            (F90, lobes.f90),
            (TINT, lobes.tint),
            (SHARES, V3::new(lobes.shares[0], lobes.shares[1], lobes.shares[2])),
        ] {
            floats[row..row + 3].copy_from_slice(&v.components());
        }
        floats[ALPHA] = lobes.alpha;
        let flag = |there: L::M, flag: u32| L::U::select(there, l.word(flag), l.word(0));
        let flags = flag(lit, TAKES_PART) | flag(surface.lifted, LIFTED) | flag(lobes.rough, ROUGH);
        // At the first hits, paths still are at the places of their slots.
        shared.first.store::<L>(at, l.first(LANES), floats, [flags]);
    }
}

/// Where a flag is set.
#[inline(always)]
fn has<L: Lanes>(l: L, flags: L::U, flag: u32) -> L::M {
    !(flags & flag).eq(l.word(0))
}

impl<L: Lanes> First<L> {
    /// Those of `count` slots from `at` on.
    #[inline(always)]
    pub fn load(l: L, rows: &super::Rows<FLOATS, WORDS>, at: usize, count: usize) -> Self {
        let (floats, [flags]) = rows.load_all(l, at);
        let vector = |row: usize| V3::new(floats[row], floats[row + 1], floats[row + 2]);
        let takes_part = has(l, flags, TAKES_PART) & l.first(count);
        let surface = Surface {
            point: vector(POINT),
            place: vector(PLACE),
            error: vector(ERROR),
            normal: vector(NORMAL),
            lifted: has(l, flags, LIFTED),
            steady: takes_part,
            frame: FrameLanes::from_normal(vector(SHADING)),
            wo: vector(WO),
        };
        let shares = [floats[SHARES], floats[SHARES + 1], floats[SHARES + 2]];
        let any = |share: L::F| (takes_part & share.gt(l.splat(0.0))).any();
        let lobes = RoughLanes {
            albedo: vector(ALBEDO),
            alpha: floats[ALPHA],
            f0: vector(F0),
            f90: vector(F90),
            tint: vector(TINT),
            shares,
            rough: has(l, flags, ROUGH),
            reflects: any(shares[1]),
            transmits: any(shares[2]),
            // Delta distributions stay the path's own.
            peaks: false,
            coat: None,
        };
        Self { surface, lobes, throughput: vector(THROUGHPUT), takes_part }
    }

    /// How they scatter towards a point; `roulette`: whether their paths must survive it.
    #[inline(always)]
    pub fn see(&self, l: L, point: V3<L::F>, roulette: bool) -> Seen<L> {
        let to = point - self.surface.point;
        let distance2 = to.length_squared();
        let dir = to * (l.splat(1.0) / distance2.sqrt());
        let local = self.surface.frame.to_local(dir);
        let out = self.surface.outgoing(dir, local.z);
        let (value, pdf) = self.lobes.eval(self.surface.wo, local);
        let value = self.throughput.times(value);
        let most = l.splat(MOST_SURVIVAL);
        let survival = if roulette { (value.max_element() / pdf * SURVIVAL).min(most) } else { l.splat(1.0) };
        Seen { dir, distance2, value, pdf, survival, out }
    }
}
