//! The kernel in AVX2: two times eight lanes.
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

/// Proof that the machine has AVX2 and FMA.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, on a machine that has it.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        (SimdTier::detect() >= SimdTier::Avx2).then_some(Self(()))
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

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_with_features<J: Job>(kernel: Avx2, job: J) -> J::Output {
    job.run(kernel)
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn trace_with_features<const ANY: bool>(
    kernel: Avx2,
    lanes: AnyLanes,
    tree: WideTree,
    rays: &RayBatch,
    stops: impl FnMut(usize, &Hit) -> bool,
    found: impl FnMut(usize, Option<Hit>),
) {
    stream::trace::<ANY, _>(kernel, lanes, tree, rays, stops, found);
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn nearest_with_features<const ANY: bool>(
    kernel: Avx2,
    tree: WideTree,
    ray: &Ray,
    accept: impl FnMut(&Hit) -> bool,
) -> Option<Hit> {
    traverse::nearest::<ANY, _>(kernel, tree, ray, accept)
}

// Everything in vectors is in functions with the features, closures included; else nothing would be inlined.
impl Kernel for Avx2 {
    #[inline(always)]
    fn open(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { open(ray, node, limit, stack) };
    }

    #[inline(always)]
    fn open_first(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> Option<u32> {
        // SAFETY: `self` is the proof that the machine has the features.
        let met = unsafe { open(ray, node, limit, stack) };
        if met == 0 {
            return None;
        }
        stack.pop();
        Some(node.last_of(ray, met))
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

/// Puts those children of a node on the stack that the ray enters up to `limit`, and says by their places in its order which they are.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn open(ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> u32 {
    let planes = node.planes.as_ptr().cast::<f32>();
    let (mut entered, mut left) = ([_mm256_setzero_ps(); 2], [_mm256_set1_ps(f32::INFINITY); 2]);
    for axis in 0..3 {
        let (enter_from, leave_from) = (_mm256_set1_ps(ray.enter_from[axis]), _mm256_set1_ps(ray.leave_from[axis]));
        let inv = _mm256_set1_ps(ray.inv[axis]);
        let upper = ray.upper[axis].min(UPPER) as usize;
        for half in 0..2 {
            // SAFETY: offsets are those of whole rows of 16 within the planes; halves of rows are aligned to 32 bytes.
            let (near, far) = unsafe {
                let row = planes.add(WIDTH * axis + 8 * half);
                (_mm256_load_ps(row.add(upper)), _mm256_load_ps(row.add(UPPER as usize - upper)))
            };
            entered[half] = _mm256_max_ps(entered[half], _mm256_mul_ps(_mm256_sub_ps(near, enter_from), inv));
            left[half] = _mm256_min_ps(left[half], _mm256_mul_ps(_mm256_sub_ps(far, leave_from), inv));
        }
    }
    let longer = _mm256_set1_ps(GROWTH);
    let left = left.map(|left| _mm256_min_ps(_mm256_mul_ps(left, longer), _mm256_set1_ps(limit)));
    let order = node.orders[(ray.order / 2) as usize & 3];
    let forwards = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
    let backwards = _mm256_setr_epi32(28, 24, 20, 16, 12, 8, 4, 0);
    let (halves, shifts) = if ray.backwards == 1 { ([32, 0], backwards) } else { ([0, 32], forwards) };
    // SAFETY: two halves of a row, aligned to 32 bytes.
    let children = [0, 1].map(|half| unsafe { _mm256_load_ps(node.children.as_ptr().cast::<f32>().add(8 * half)) });
    let mut met = 0;
    for (half, shift) in halves.into_iter().enumerate() {
        let slots = _mm256_srlv_epi32(_mm256_set1_epi32((order >> shift) as i32), shifts);
        // Bit 3 of a slot selects the half; blending looks at the sign bit.
        let upper = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(slots));
        let pick = |[low, high]: [__m256; 2]| {
            let (a, b) = (_mm256_permutevar8x32_ps(low, slots), _mm256_permutevar8x32_ps(high, slots));
            _mm256_blendv_ps(a, b, upper)
        };
        let (entered, left) = (pick(entered), pick(left));
        let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entered, left)) as u32;
        // The lanes that are met move to the front: their numbers are picked out of all numbers.
        let lanes = _pext_u64(0x0706_0504_0302_0100, _pdep_u64(mask.into(), 0x0101_0101_0101_0101) * 0xff);
        let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(lanes as i64));
        let children = pick(children);
        let (enters, words, leaf_bases) = stack.room();
        // SAFETY: the stack has room for sixteen of each kind, of which the first eight are written before it grows by at
        // most as many.
        unsafe {
            _mm256_storeu_ps(enters, _mm256_permutevar8x32_ps(entered, lanes));
            _mm256_storeu_ps(words.cast(), _mm256_permutevar8x32_ps(children, lanes));
            _mm256_storeu_si256(leaf_bases.cast(), _mm256_set1_epi32(node.leaf_base as i32));
            stack.grow(mask.count_ones() as usize);
        }
        met |= mask << (8 * half);
    }
    met
}

/// As in [`super::avx512`], where the reasons are, eight triangles at a time.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn candidates(ray: &ShearedRay, block: &Block, barred: u32, end: f32) -> u32 {
    let (len, pool) = (block.len, block.pool);
    assert!(block.words.len() >= words_of(len, pool) + 16);
    let base = block.words.as_ptr().cast::<f32>();
    let [x, y, z] = ray.axes;
    let origin = ray.origin.map(|x| _mm256_set1_ps(x));
    let shears = [_mm256_set1_ps(ray.shear_x), _mm256_set1_ps(ray.shear_y)];
    let dir_z = _mm256_set1_ps(ray.dir_z);
    let mut points = [[_mm256_setzero_ps(); 3]; 4];
    for (k, points) in points.iter_mut().enumerate().take(pool.div_ceil(8)) {
        // SAFETY: begins at 2·pool + 8·k at most, where 8·k is less than the pool, and reads 8 words.
        *points = unsafe { shear(base.add(8 * k), [x * pool, y * pool, z * pool], origin, shears) };
    }
    let mut all = 0;
    for begin in (0..len).step_by(8) {
        let mut sheared = [[_mm256_setzero_ps(); 3]; 3];
        let mut indices = [_mm256_setzero_si256(); 3];
        for k in 0..3 {
            if pool == 0 {
                // SAFETY: begins at 8·len + 8 at most and reads 8 words, which the assertion allows.
                sheared[k] =
                    unsafe { shear(base.add(3 * k * len + begin), [x * len, y * len, z * len], origin, shears) };
            } else {
                // SAFETY: eight of the 48 bytes of indices, which begin at 3·pool words.
                indices[k] =
                    unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(base.add(3 * pool + 4 * k + begin / 4).cast())) };
                sheared[k][0] = pick(&points, 0, indices[k], pool > 16);
                sheared[k][1] = pick(&points, 1, indices[k], pool > 16);
            }
        }
        let [a, b, c] = sheared;
        let ([u, u_size], [v, v_size], [w, w_size]) = (edge(c, b), edge(a, c), edge(b, a));
        let zero = _mm256_setzero_ps();
        let negative = _mm256_cmp_ps::<_CMP_LT_OQ>(_mm256_min_ps(_mm256_min_ps(u, v), w), zero);
        let positive = _mm256_cmp_ps::<_CMP_GT_OQ>(_mm256_max_ps(_mm256_max_ps(u, v), w), zero);
        let real = (1u32 << (len - begin).min(8)) - 1;
        let met = !(_mm256_movemask_ps(_mm256_and_ps(negative, positive)) as u32) & real;
        if met == 0 {
            continue;
        }
        let mut along_z = [a[2], b[2], c[2]];
        if pool > 0 {
            along_z = indices.map(|at| pick(&points, 2, at, pool > 16));
        }
        let [az, bz, cz] = along_z;
        let along = _mm256_fmadd_ps(u, az, _mm256_fmadd_ps(v, bz, _mm256_mul_ps(w, cz)));
        let size = _mm256_mul_ps(w_size, abs(cz));
        let size = _mm256_fmadd_ps(u_size, abs(az), _mm256_fmadd_ps(v_size, abs(bz), size));
        let det = _mm256_add_ps(_mm256_add_ps(u, v), w);
        let turn = _mm256_and_ps(_mm256_xor_ps(det, dir_z), _mm256_set1_ps(-0.0));
        let forward = _mm256_xor_ps(along, turn);
        let (error, underflow) = (_mm256_set1_ps(BEHIND_ERROR), _mm256_set1_ps(BEHIND_UNDERFLOW));
        let most = _mm256_fmadd_ps(size, error, _mm256_add_ps(forward, underflow));
        let behind = _mm256_cmp_ps::<_CMP_LT_OQ>(most, zero);
        let least = _mm256_fnmadd_ps(size, error, _mm256_sub_ps(forward, underflow));
        let sizes = _mm256_add_ps(_mm256_add_ps(u_size, v_size), w_size);
        let det = _mm256_add_ps(abs(det), _mm256_set1_ps(BEYOND_UNDERFLOW));
        let reach = _mm256_set1_ps(reach(ray, end));
        let beyond = _mm256_cmp_ps::<_CMP_GT_OQ>(least, _mm256_mul_ps(reach, _mm256_fmadd_ps(sizes, error, det)));
        // SAFETY: eight of the triangles' numbers, or what follows them, which the assertion allows.
        let ids = unsafe { _mm256_loadu_si256(base.add(words_of(len, pool) - len + begin).cast()) };
        let out = _mm256_castsi256_ps(_mm256_cmpeq_epi32(ids, _mm256_set1_epi32(barred as i32)));
        all |= (met & !(_mm256_movemask_ps(_mm256_or_ps(_mm256_or_ps(behind, beyond), out)) as u32)) << begin;
    }
    all
}

/// Eight corners from `base` on, whose x, y, z begin at `at`: sheared x and y, and the distance along z.
///
/// # Safety
/// Eight words follow each place.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn shear(base: *const f32, at: [usize; 3], origin: [__m256; 3], shears: [__m256; 2]) -> [__m256; 3] {
    // SAFETY: as promised.
    let [x, y, z] = unsafe {
        [_mm256_loadu_ps(base.add(at[0])), _mm256_loadu_ps(base.add(at[1])), _mm256_loadu_ps(base.add(at[2]))]
    };
    let along = _mm256_sub_ps(z, origin[2]);
    let (across_x, across_y) = (_mm256_sub_ps(x, origin[0]), _mm256_sub_ps(y, origin[1]));
    [
        _mm256_sub_ps(across_x, _mm256_mul_ps(shears[0], along)),
        _mm256_sub_ps(across_y, _mm256_mul_ps(shears[1], along)),
        along,
    ]
}

/// A coordinate of points of a pool by their numbers; of the first sixteen unless there are `more`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn pick(points: &[[__m256; 3]; 4], axis: usize, at: __m256i, more: bool) -> __m256 {
    // Bits 3 and 4 of a number select the eighth and the half; blending looks at the sign bit.
    let eighth = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(at));
    let low = _mm256_permutevar8x32_ps(points[0][axis], at);
    let first = _mm256_blendv_ps(low, _mm256_permutevar8x32_ps(points[1][axis], at), eighth);
    if !more {
        return first;
    }
    let low = _mm256_permutevar8x32_ps(points[2][axis], at);
    let second = _mm256_blendv_ps(low, _mm256_permutevar8x32_ps(points[3][axis], at), eighth);
    _mm256_blendv_ps(first, second, _mm256_castsi256_ps(_mm256_slli_epi32::<27>(at)))
}

/// An edge function of two corners, and the sum of its products' magnitudes.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn edge(p: [__m256; 3], q: [__m256; 3]) -> [__m256; 2] {
    let (one, other) = (_mm256_mul_ps(p[0], q[1]), _mm256_mul_ps(p[1], q[0]));
    [_mm256_sub_ps(one, other), _mm256_add_ps(abs(one), abs(other))]
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn abs(x: __m256) -> __m256 {
    _mm256_andnot_ps(_mm256_set1_ps(-0.0), x)
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn place(placement: &Placement, from: &[u32], stride: usize, to: &mut [u32; 3 * WIDTH]) {
    assert!(from.len() >= 2 * stride + WIDTH);
    let (from, to) = (from.as_ptr().cast::<f32>(), to.as_mut_ptr().cast::<f32>());
    for begin in (0..WIDTH).step_by(4) {
        // SAFETY: four of the 16 words of a row, which begin at 0, `stride` and twice that: the assertion allows them.
        let [x, y, z] = unsafe {
            let row = |axis: usize| _mm256_cvtps_pd(_mm_loadu_ps(from.add(axis * stride + begin)));
            [row(0), row(1), row(2)]
        };
        for (axis, [a, b, c, d]) in placement.rows.iter().enumerate() {
            let [a, b, c, d] = [a, b, c, d].map(|x| _mm256_set1_pd(*x));
            let sum = _mm256_add_pd(_mm256_mul_pd(a, x), _mm256_mul_pd(b, y));
            let sum = _mm256_add_pd(_mm256_add_pd(sum, _mm256_mul_pd(c, z)), d);
            // SAFETY: four words of one of three rows.
            unsafe { _mm_storeu_ps(to.add(axis * WIDTH + begin), _mm256_cvtpd_ps(sum)) };
        }
    }
}
