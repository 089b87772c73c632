//! The kernel in AVX-512: sixteen lanes.
#![allow(unsafe_code)]

use super::super::batch::RayBatch;
use super::super::block::{Block, words_of};
use super::super::slab::GROWTH;
use super::WideTree;
use super::kernel::{BEHIND_ERROR, BEHIND_UNDERFLOW, BEYOND_UNDERFLOW, BoxRay, Job, Kernel, UPPER, reach};
use super::node::{WIDTH, WideNode};
use super::stack::Stack;
use super::{stream, traverse};
use crate::lanes::AnyLanes;
use crate::math::simd::SimdTier;
use crate::math::triangle::ShearedRay;
use crate::math::{Hit, Placement, Ray};
use std::arch::x86_64::*;

/// Proof that the machine has AVX-512 F, BW, DQ and VL.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

/// Shifts to the nibbles of half an order, forwards and backwards; for each half.
static SHIFTS: Shifts = Shifts([
    [0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28],
    [28, 24, 20, 16, 12, 8, 4, 0, 28, 24, 20, 16, 12, 8, 4, 0],
]);

#[repr(align(64))]
struct Shifts([[u32; WIDTH]; 2]);

impl Avx512 {
    /// The proof, on a machine that has it.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        (SimdTier::detect() == SimdTier::Avx512).then_some(Self(()))
    }

    /// See [`traverse::nearest`].
    #[inline(always)]
    pub fn nearest<const ANY: bool>(self, tree: WideTree, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        // SAFETY: `self` exists only on machines with these features.
        unsafe { nearest_with_features::<ANY>(self, tree, ray, accept) }
    }

    /// See [`stream::trace`].
    #[inline(always)]
    pub fn trace<const ANY: bool>(
        self,
        lanes: AnyLanes,
        tree: WideTree,
        rays: &RayBatch,
        stops: impl FnMut(usize, &Hit) -> bool,
        found: impl FnMut(usize, Option<Hit>),
    ) {
        // SAFETY: `self` exists only on machines with these features.
        unsafe { trace_with_features::<ANY>(self, lanes, tree, rays, stops, found) }
    }

    /// Does a job with these features.
    #[inline(always)]
    pub fn run<J: Job>(self, job: J) -> J::Output {
        // SAFETY: `self` exists only on machines with these features.
        unsafe { run_with_features(self, job) }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_with_features<J: Job>(kernel: Avx512, job: J) -> J::Output {
    job.run(kernel)
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn trace_with_features<const ANY: bool>(
    kernel: Avx512,
    lanes: AnyLanes,
    tree: WideTree,
    rays: &RayBatch,
    stops: impl FnMut(usize, &Hit) -> bool,
    found: impl FnMut(usize, Option<Hit>),
) {
    stream::trace::<ANY, _>(kernel, lanes, tree, rays, stops, found);
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn nearest_with_features<const ANY: bool>(
    kernel: Avx512,
    tree: WideTree,
    ray: &Ray,
    accept: impl FnMut(&Hit) -> bool,
) -> Option<Hit> {
    traverse::nearest::<ANY, _>(kernel, tree, ray, accept)
}

// What is inlined for certain has no features of its own: it gets those of `nearest_with_features`. Closures in it are not
// inlined for certain; there are none.
impl Kernel for Avx512 {
    #[inline(always)]
    fn open(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) {
        // SAFETY: `self` is the proof that the machine has the features, and all that are met were written.
        unsafe {
            let met = open(ray, node, limit, stack);
            stack.grow(met.count_ones() as usize);
        }
    }

    #[inline(always)]
    fn open_first(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> Option<u32> {
        // SAFETY: `self` is the proof that the machine has the features, and all that are met were written.
        unsafe {
            let met = open(ray, node, limit, stack);
            if met == 0 {
                return None;
            }
            // The first that the ray passes is the last in the order; by its slot it is known sooner than by way of the stack.
            stack.grow(met.count_ones() as usize - 1);
            Some(node.last_of(ray, met))
        }
    }

    #[inline(always)]
    fn open_any(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> Option<u32> {
        // SAFETY: `self` is the proof that the machine has the features, and all that are met but one were written.
        unsafe {
            let met = open_unordered(ray, node, limit, stack);
            if met == 0 {
                return None;
            }
            stack.grow(met.count_ones() as usize - 1);
            Some(node.children[met.trailing_zeros() as usize & 15])
        }
    }

    #[inline(always)]
    fn candidates(self, ray: &ShearedRay, block: &Block, barred: u32, end: f32) -> u32 {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { candidates(ray, block, barred, end) }
    }

    #[inline(always)]
    fn place(self, placement: &Placement, from: &[u32], stride: usize, to: &mut [u32; 3 * WIDTH]) {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { place(placement, from, stride, to) }
    }
}

/// Writes those children to the stack's room that the ray enters up to `limit`, and says by their places in its order which they are.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn open(ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> u32 {
    let (enters, children_to, leaf_bases) = stack.room();
    let backwards = (ray.backwards & 1) as usize;
    let order = (ray.order & 6) as usize;
    // SAFETY: offsets are those of words within the orders. The stack has room for sixteen of each kind, all of which are written
    // before it grows.
    unsafe {
        let [entered, left] = intervals(ray, node, limit);
        let words = node.orders.as_ptr().cast::<i32>().add(order);
        let first = _mm512_set1_epi32(*words.add(backwards));
        let both = _mm512_mask_set1_epi32(first, 0xff00, *words.add(1 - backwards));
        let shifts = _mm512_load_si512(SHIFTS.0[backwards].as_ptr().cast());
        let slots = _mm512_srlv_epi32(both, shifts);
        let entered = _mm512_permutexvar_ps(slots, entered);
        let left = _mm512_permutexvar_ps(slots, left);
        let children = _mm512_permutexvar_epi32(slots, _mm512_load_si512(node.children.as_ptr().cast()));
        let met = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(entered, left);
        _mm512_storeu_ps(enters, _mm512_maskz_compress_ps(met, entered));
        _mm512_storeu_si512(children_to.cast(), _mm512_maskz_compress_epi32(met, children));
        _mm512_storeu_si512(leaf_bases.cast(), _mm512_set1_epi32(node.leaf_base as i32));
        met.into()
    }
}

/// The same in no order: a bit for the slot of each. All are entered at 0, it is said.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn open_unordered(ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> u32 {
    let (enters, children_to, leaf_bases) = stack.room();
    // SAFETY: the stack has room for sixteen of each kind, all of which are written before it grows.
    unsafe {
        let [entered, left] = intervals(ray, node, limit);
        let met = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(entered, left);
        let others = met & met.wrapping_sub(1);
        let children = _mm512_load_si512(node.children.as_ptr().cast());
        _mm512_storeu_ps(enters, _mm512_setzero_ps());
        _mm512_storeu_si512(children_to.cast(), _mm512_maskz_compress_epi32(others, children));
        _mm512_storeu_si512(leaf_bases.cast(), _mm512_set1_epi32(node.leaf_base as i32));
        met.into()
    }
}

/// Where a ray enters the boxes of a node's children and leaves them, or ends at `limit`.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn intervals(ray: &BoxRay, node: &WideNode, limit: f32) -> [__m512; 2] {
    let planes = node.planes.as_ptr().cast::<f32>();
    let [ux, uy, uz] = ray.upper.map(|upper| upper.min(UPPER) as usize);
    let far = UPPER as usize;
    // SAFETY: offsets are those of whole rows of 16 within the planes; rows are aligned to 64 bytes.
    unsafe {
        let near_x = _mm512_load_ps(planes.add(ux));
        let near_y = _mm512_load_ps(planes.add(WIDTH + uy));
        let near_z = _mm512_load_ps(planes.add(2 * WIDTH + uz));
        let far_x = _mm512_load_ps(planes.add(far - ux));
        let far_y = _mm512_load_ps(planes.add(WIDTH + far - uy));
        let far_z = _mm512_load_ps(planes.add(2 * WIDTH + far - uz));
        let inv = [_mm512_set1_ps(ray.inv[0]), _mm512_set1_ps(ray.inv[1]), _mm512_set1_ps(ray.inv[2])];
        let enter_x = _mm512_mul_ps(_mm512_sub_ps(near_x, _mm512_set1_ps(ray.enter_from[0])), inv[0]);
        let enter_y = _mm512_mul_ps(_mm512_sub_ps(near_y, _mm512_set1_ps(ray.enter_from[1])), inv[1]);
        let enter_z = _mm512_mul_ps(_mm512_sub_ps(near_z, _mm512_set1_ps(ray.enter_from[2])), inv[2]);
        let leave_x = _mm512_mul_ps(_mm512_sub_ps(far_x, _mm512_set1_ps(ray.leave_from[0])), inv[0]);
        let leave_y = _mm512_mul_ps(_mm512_sub_ps(far_y, _mm512_set1_ps(ray.leave_from[1])), inv[1]);
        let leave_z = _mm512_mul_ps(_mm512_sub_ps(far_z, _mm512_set1_ps(ray.leave_from[2])), inv[2]);
        let entered = _mm512_max_ps(_mm512_max_ps(enter_x, enter_y), _mm512_max_ps(enter_z, _mm512_setzero_ps()));
        let left = _mm512_min_ps(_mm512_min_ps(leave_x, leave_y), leave_z);
        let left = _mm512_min_ps(_mm512_mul_ps(left, _mm512_set1_ps(GROWTH)), _mm512_set1_ps(limit));
        [entered, left]
    }
}

/// Corners at `base`, whose x, y, z begin at `at`: sheared x and y, and the distance along z.
///
/// # Safety
/// For machines with the features; sixteen words follow each place.
#[inline(always)]
unsafe fn shear(base: *const f32, at: [usize; 3], origin: [__m512; 3], shear: [__m512; 2]) -> [__m512; 3] {
    // SAFETY: as promised.
    unsafe {
        let along = _mm512_sub_ps(_mm512_loadu_ps(base.add(at[2])), origin[2]);
        let across_x = _mm512_sub_ps(_mm512_loadu_ps(base.add(at[0])), origin[0]);
        let across_y = _mm512_sub_ps(_mm512_loadu_ps(base.add(at[1])), origin[1]);
        [
            _mm512_sub_ps(across_x, _mm512_mul_ps(shear[0], along)),
            _mm512_sub_ps(across_y, _mm512_mul_ps(shear[1], along)),
            along,
        ]
    }
}

/// An edge function, and the sum of its two products' magnitudes.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn edge(p: [__m512; 3], q: [__m512; 3]) -> [__m512; 2] {
    // SAFETY: as promised.
    unsafe {
        let (one, other) = (_mm512_mul_ps(p[0], q[1]), _mm512_mul_ps(p[1], q[0]));
        [_mm512_sub_ps(one, other), _mm512_add_ps(_mm512_abs_ps(one), _mm512_abs_ps(other))]
    }
}

/// Edge functions in f32: rounding is monotone, so a sign other than zero is right, and a triangle with edges of both
/// signs is not met.
///
/// With u = 2⁻²⁴, an edge function of products p and q is off by 2u·(|p| + |q|) at most, and the numerator of the distance,
/// which is their sum weighted by the corners' z, by 5u times the like sum of magnitudes. With 8u instead ([`BEHIND_ERROR`]), and a
/// little for what underflow takes away, a triangle is left out that certainly lies behind the ray's origin. (Where the denominator's sign is
/// wrong, exact edges have both signs.) The denominator is off by 4u times the magnitudes in it, so that 8u of them are more than that and
/// what rounding does here: so a triangle is left out, too, that certainly lies beyond the ray's end.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn candidates(ray: &ShearedRay, block: &Block, barred: u32, end: f32) -> u32 {
    let (len, pool) = (block.len, block.pool);
    assert!(block.words.len() >= words_of(len, pool) + WIDTH);
    let base = block.words.as_ptr().cast::<f32>();
    let [x, y, z] = ray.axes;
    // SAFETY: plain loads begin at 8·len at most, pooled ones at 2·pool and indices at 3·pool + 8; numbers
    // `len` before the end; each reads 16 words, or 4 for indices, which the assertion allows.
    unsafe {
        let origin = [_mm512_set1_ps(ray.origin[0]), _mm512_set1_ps(ray.origin[1]), _mm512_set1_ps(ray.origin[2])];
        let shears = [_mm512_set1_ps(ray.shear_x), _mm512_set1_ps(ray.shear_y)];
        let (a, b, c);
        if pool == 0 {
            a = shear(base, [x * len, y * len, z * len], origin, shears);
            b = shear(base.add(3 * len), [x * len, y * len, z * len], origin, shears);
            c = shear(base.add(6 * len), [x * len, y * len, z * len], origin, shears);
        } else if pool > WIDTH {
            let low = shear(base, [x * pool, y * pool, z * pool], origin, shears);
            let high = shear(base.add(WIDTH), [x * pool, y * pool, z * pool], origin, shears);
            let indices = base.add(3 * pool);
            let i = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.cast()));
            let j = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.add(4).cast()));
            let k = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.add(8).cast()));
            a = pick(low, high, i);
            b = pick(low, high, j);
            c = pick(low, high, k);
        } else {
            let [px, py, pz] = shear(base, [x * pool, y * pool, z * pool], origin, shears);
            let indices = base.add(3 * pool);
            let i = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.cast()));
            let j = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.add(4).cast()));
            let k = _mm512_cvtepu8_epi32(_mm_loadu_si128(indices.add(8).cast()));
            a = [_mm512_permutexvar_ps(i, px), _mm512_permutexvar_ps(i, py), _mm512_permutexvar_ps(i, pz)];
            b = [_mm512_permutexvar_ps(j, px), _mm512_permutexvar_ps(j, py), _mm512_permutexvar_ps(j, pz)];
            c = [_mm512_permutexvar_ps(k, px), _mm512_permutexvar_ps(k, py), _mm512_permutexvar_ps(k, pz)];
        }
        let ([u, u_size], [v, v_size], [w, w_size]) = (edge(c, b), edge(a, c), edge(b, a));
        let zero = _mm512_setzero_ps();
        let negative = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_min_ps(_mm512_min_ps(u, v), w), zero);
        let positive = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(_mm512_max_ps(_mm512_max_ps(u, v), w), zero);
        let met = u32::from(!(negative & positive)) & ((1 << len) - 1);
        if met == 0 {
            return 0;
        }
        let (az, bz, cz) = (a[2], b[2], c[2]);
        let along = _mm512_fmadd_ps(u, az, _mm512_fmadd_ps(v, bz, _mm512_mul_ps(w, cz)));
        let size = _mm512_mul_ps(w_size, _mm512_abs_ps(cz));
        let size = _mm512_fmadd_ps(v_size, _mm512_abs_ps(bz), size);
        let size = _mm512_fmadd_ps(u_size, _mm512_abs_ps(az), size);
        let det = _mm512_add_ps(_mm512_add_ps(u, v), w);
        // The distance's sign: that of z along the ray, of the numerator and of the denominator.
        let sign = _mm512_set1_epi32(i32::MIN);
        let turn = _mm512_xor_si512(_mm512_castps_si512(det), _mm512_castps_si512(_mm512_set1_ps(ray.dir_z)));
        let turn = _mm512_and_si512(turn, sign);
        let forward = _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(along), turn));
        let error = _mm512_set1_ps(BEHIND_ERROR);
        let underflow = _mm512_set1_ps(BEHIND_UNDERFLOW);
        let most = _mm512_fmadd_ps(size, error, _mm512_add_ps(forward, underflow));
        let behind = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(most, zero);
        let least = _mm512_fnmadd_ps(size, error, _mm512_sub_ps(forward, underflow));
        let sizes = _mm512_add_ps(_mm512_add_ps(u_size, v_size), w_size);
        let det = _mm512_add_ps(_mm512_abs_ps(det), _mm512_set1_ps(BEYOND_UNDERFLOW));
        let reach = _mm512_set1_ps(reach(ray, end));
        let beyond = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(least, _mm512_mul_ps(reach, _mm512_fmadd_ps(sizes, error, det)));
        let ids = _mm512_loadu_si512(base.add(words_of(len, pool) - len).cast());
        let out = _mm512_cmpeq_epi32_mask(ids, _mm512_set1_epi32(barred as i32));
        met & !u32::from(behind | beyond | out)
    }
}

/// Points of a pool of 32, the first sixteen and the others, by their numbers.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn pick(low: [__m512; 3], high: [__m512; 3], at: __m512i) -> [__m512; 3] {
    // SAFETY: as promised.
    unsafe {
        [
            _mm512_permutex2var_ps(low[0], at, high[0]),
            _mm512_permutex2var_ps(low[1], at, high[1]),
            _mm512_permutex2var_ps(low[2], at, high[2]),
        ]
    }
}

/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn place(placement: &Placement, from: &[u32], stride: usize, to: &mut [u32; 3 * WIDTH]) {
    assert!(from.len() >= 2 * stride + WIDTH);
    let from = from.as_ptr().cast::<f32>();
    let to = to.as_mut_ptr().cast::<f32>();
    // SAFETY: rows of 16 words begin at 0, `stride` and twice that, which the assertion allows, and at 0, 16 and 32.
    unsafe {
        let (x, y, z) =
            (_mm512_loadu_ps(from), _mm512_loadu_ps(from.add(stride)), _mm512_loadu_ps(from.add(2 * stride)));
        let (x_low, y_low, z_low) = (low(x), low(y), low(z));
        let (x_high, y_high, z_high) = (high(x), high(y), high(z));
        for (axis, row) in placement.rows.iter().enumerate() {
            let (first, second) = (coordinate(row, x_low, y_low, z_low), coordinate(row, x_high, y_high, z_high));
            let both = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(first), second);
            _mm512_storeu_ps(to.add(axis * WIDTH), both);
        }
    }
}

/// The first eight of sixteen numbers, in double precision.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn low(x: __m512) -> __m512d {
    // SAFETY: as promised.
    unsafe { _mm512_cvtps_pd(_mm512_castps512_ps256(x)) }
}

/// The last eight of sixteen numbers, in double precision.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn high(x: __m512) -> __m512d {
    // SAFETY: as promised.
    unsafe { _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(x)) }
}

/// [`Placement::coordinate`] of eight points: the same operations, none of them fused.
///
/// # Safety
/// For machines with the features.
#[inline(always)]
unsafe fn coordinate(row: &[f64; 4], x: __m512d, y: __m512d, z: __m512d) -> __m256 {
    // SAFETY: as promised.
    unsafe {
        let sum = _mm512_add_pd(_mm512_mul_pd(_mm512_set1_pd(row[0]), x), _mm512_mul_pd(_mm512_set1_pd(row[1]), y));
        let sum = _mm512_add_pd(sum, _mm512_mul_pd(_mm512_set1_pd(row[2]), z));
        _mm512_cvtpd_ps(_mm512_add_pd(sum, _mm512_set1_pd(row[3])))
    }
}
