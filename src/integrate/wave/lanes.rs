//! Small geometry in lanes, each the twin of a function on one vector.

pub(super) use crate::lanes::FrameLanes;
use crate::lanes::{Floats, V3, Words};

/// See [`crate::math::float_error::offset_point`].
#[inline(always)]
pub(super) fn offset_point<F: Floats>(point: V3<F>, error: V3<F>, normal: V3<F>, towards: V3<F>) -> V3<F> {
    let distance = normal.abs().dot(error);
    let side = F::select(towards.dot(normal).lt(distance.fill(0.0)), -distance, distance);
    V3::new(moved_by(point.x, normal.x * side), moved_by(point.y, normal.y * side), moved_by(point.z, normal.z * side))
}

/// Moved, and to the next number in the same direction: away from zero is one more, towards it one less, and beyond zero
/// begins the other sign.
#[inline(always)]
fn moved_by<F: Floats>(x: F, offset: F) -> F {
    let zero = x.fill(0.0);
    let moved = x + offset;
    let bits = moved.to_bits();
    let (negative, none) = (moved.lt(zero), moved.eq(zero));
    let (more, less) = (bits + 1, bits - 1);
    let up = F::Words::select(none, bits.fill(1), F::Words::select(negative, less, more));
    let down = F::Words::select(none, bits.fill(0x8000_0001), F::Words::select(negative, more, less));
    let moved = F::select(offset.gt(zero), up.from_bits(), moved);
    F::select(offset.lt(zero), down.from_bits(), moved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, LANES, Lanes, Work};
    use crate::math::simd::SimdTier;
    use crate::math::{Frame, float_error};
    use glam::Vec3;

    struct Both(Vec3, Vec3, Vec3, Vec3);

    impl Work for Both {
        type Output = [[f32; 3]; 3];

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let splat = |v: Vec3| V3::new(l.splat(v.x), l.splat(v.y), l.splat(v.z));
            let frame = FrameLanes::from_normal(splat(self.2));
            let there = frame.to_local(splat(self.0));
            let moved = offset_point(splat(self.0), splat(self.1), splat(self.2), splat(self.3));
            [there.lane(LANES - 1), frame.to_world(there).lane(3), moved.lane(0)]
        }
    }

    #[test]
    fn lanes_are_twins_of_single_vectors() {
        for i in 0..200i32 {
            let x = |k: i32| ((i * 7 + k * 13) % 41 - 20) as f32 * 0.37;
            let point = Vec3::new(x(1), x(2), if i % 5 == 0 { 0.0 } else { x(3) });
            let normal = Vec3::new(x(4), if i % 3 == 0 { 0.0 } else { x(5) }, x(6) + 0.1).normalize();
            let towards = Vec3::new(x(7), x(8), x(9));
            let error = point.abs() * 1e-6;
            let [local, world, moved] = AnyLanes::new(SimdTier::detect()).run(Both(point, error, normal, towards));
            let frame = Frame::from_normal(normal);
            assert_eq!(Vec3::from(local), frame.to_local(point));
            assert_eq!(Vec3::from(world), frame.to_world(frame.to_local(point)));
            assert_eq!(Vec3::from(moved), float_error::offset_point(point, error, normal, towards));
        }
    }
}
