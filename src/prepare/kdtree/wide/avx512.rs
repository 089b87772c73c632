//! The kernel in AVX-512: sixteen lanes.
#![allow(unsafe_code)]

use super::super::block::Block;
use super::super::slab::SlabRay;
use super::WideTree;
use super::kernel::{Enters, Kernel};
use super::node::{WIDTH, WideNode};
use super::traverse;
use crate::math::simd::SimdTier;
use crate::math::triangle::ShearedRay;
use crate::math::{Hit, Ray};
use std::arch::x86_64::*;

/// Proof that the machine has AVX-512 F, BW, DQ and VL.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

/// A ray in registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Ray {
    enter_add: [__m512; 3],
    enter_inv: [__m512; 3],
    leave_add: [__m512; 3],
    leave_inv: [__m512; 3],
    /// Where in a node the rows of planes begin at which boxes are entered and left; below `6 · WIDTH`.
    first: [usize; 3],
    last: [usize; 3],
    /// The node's order for this octant: where among the words of all orders, which of its halves comes first (both below
    /// 8 in sum), and the shifts to its nibbles.
    order: usize,
    halves: [usize; 2],
    shifts: __m512i,
}

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

// Everything in vectors is in functions with the features, closures included; else nothing would be inlined.
impl Kernel for Avx512 {
    type Ray = Avx512Ray;

    #[inline(always)]
    fn prepare(self, slab: &SlabRay) -> Avx512Ray {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { prepare(slab) }
    }

    #[inline(always)]
    fn enter(self, ray: &Avx512Ray, node: &WideNode, limit: f32, enters: &mut Enters) -> u32 {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { enter(ray, node, limit, enters) }
    }

    #[inline(always)]
    fn candidates(self, ray: &ShearedRay, block: &Block) -> u32 {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { candidates(ray, block) }
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn prepare(slab: &SlabRay) -> Avx512Ray {
    let octant = slab.octant;
    let reversed = octant >= 4;
    let row = |axis: usize, first: bool| if slab.is_negative(axis) == first { axis + 3 } else { axis };
    {
        let spread = |x: [f32; 3]| x.map(|x| _mm512_set1_ps(x));
        let forwards = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28);
        let backwards = _mm512_setr_epi32(28, 24, 20, 16, 12, 8, 4, 0, 28, 24, 20, 16, 12, 8, 4, 0);
        Avx512Ray {
            enter_add: spread(slab.enter_add),
            enter_inv: spread(slab.enter_inv),
            leave_add: spread(slab.leave_add),
            leave_inv: spread(slab.leave_inv),
            first: [0, 1, 2].map(|axis| WIDTH * row(axis, true)),
            last: [0, 1, 2].map(|axis| WIDTH * row(axis, false)),
            order: 2 * if reversed { 7 - octant } else { octant },
            halves: if reversed { [1, 0] } else { [0, 1] },
            shifts: if reversed { backwards } else { forwards },
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn enter(ray: &Avx512Ray, node: &WideNode, limit: f32, enters: &mut Enters) -> u32 {
    // SAFETY: `prepare` makes offsets of whole rows of 16 within the planes and of words within the orders; rows and
    // `enters` are aligned to 64 bytes.
    unsafe {
        let planes = node.planes.as_ptr().cast::<f32>();
        let row = |at: usize| _mm512_load_ps(planes.add(at));
        let enter = |a: usize| _mm512_fmadd_ps(row(ray.first[a]), ray.enter_inv[a], ray.enter_add[a]);
        let leave = |a: usize| _mm512_fmadd_ps(row(ray.last[a]), ray.leave_inv[a], ray.leave_add[a]);
        let entered = _mm512_max_ps(_mm512_max_ps(enter(0), enter(1)), _mm512_max_ps(enter(2), _mm512_setzero_ps()));
        let left = _mm512_min_ps(_mm512_min_ps(leave(0), leave(1)), _mm512_min_ps(leave(2), _mm512_set1_ps(limit)));
        let order = node.orders.as_ptr().cast::<i32>().add(ray.order);
        let low = _mm512_set1_epi32(*order.add(ray.halves[0]));
        let both = _mm512_mask_set1_epi32(low, 0xff00, *order.add(ray.halves[1]));
        let slots = _mm512_srlv_epi32(both, ray.shifts);
        let entered = _mm512_permutexvar_ps(slots, entered);
        let left = _mm512_permutexvar_ps(slots, left);
        _mm512_store_ps(enters.0.as_mut_ptr(), entered);
        u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(entered, left))
    }
}

/// Edge functions in f32: rounding is monotone, so a sign other than zero is right, and a triangle with edges of both
/// signs is not met.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn candidates(ray: &ShearedRay, block: &Block) -> u32 {
    let (len, pool) = (block.len, block.pool);
    assert!(block.words.len() >= if pool == 0 { 9 * len + 16 } else { 3 * pool + 16 });
    let base = block.words.as_ptr().cast::<f32>();
    let [x, y, z] = ray.axes;
    let origin = |axis: usize| _mm512_set1_ps(ray.origin[axis]);
    let (origin_x, origin_y, origin_z) = (origin(x), origin(y), origin(z));
    let (shear_x, shear_y) = (_mm512_set1_ps(ray.shear_x), _mm512_set1_ps(ray.shear_y));
    let mut sheared = [(_mm512_setzero_ps(), _mm512_setzero_ps()); 3];
    // SAFETY: plain loads begin at 8·len at most, pooled ones at 2·pool and indices at 3·pool + 8; each reads 16 words, or
    // 4 for indices, which the assertion allows.
    unsafe {
        let shear = |at_x: usize, at_y: usize, at_z: usize| {
            let along = _mm512_sub_ps(_mm512_loadu_ps(base.add(at_z)), origin_z);
            let across_x = _mm512_sub_ps(_mm512_loadu_ps(base.add(at_x)), origin_x);
            let across_y = _mm512_sub_ps(_mm512_loadu_ps(base.add(at_y)), origin_y);
            (
                _mm512_sub_ps(across_x, _mm512_mul_ps(shear_x, along)),
                _mm512_sub_ps(across_y, _mm512_mul_ps(shear_y, along)),
            )
        };
        if pool == 0 {
            for (k, corner) in sheared.iter_mut().enumerate() {
                *corner = shear((3 * k + x) * len, (3 * k + y) * len, (3 * k + z) * len);
            }
        } else {
            let (points_x, points_y) = shear(x * pool, y * pool, z * pool);
            for (k, corner) in sheared.iter_mut().enumerate() {
                let indices = _mm512_cvtepu8_epi32(_mm_loadu_si128(base.add(3 * pool + 4 * k).cast()));
                *corner = (_mm512_permutexvar_ps(indices, points_x), _mm512_permutexvar_ps(indices, points_y));
            }
        }
    }
    let [(ax, ay), (bx, by), (cx, cy)] = sheared;
    let edge = |px, py, qx, qy| _mm512_sub_ps(_mm512_mul_ps(px, qy), _mm512_mul_ps(py, qx));
    let zero = _mm512_setzero_ps();
    let (mut negative, mut positive) = (0, 0);
    for side in [edge(cx, cy, bx, by), edge(ax, ay, cx, cy), edge(bx, by, ax, ay)] {
        negative |= _mm512_cmp_ps_mask::<_CMP_LT_OQ>(side, zero);
        positive |= _mm512_cmp_ps_mask::<_CMP_GT_OQ>(side, zero);
    }
    u32::from(!(negative & positive)) & ((1 << len) - 1)
}
