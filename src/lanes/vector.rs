use super::Floats;
use super::LANES;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A vector or colour in each lane.
#[derive(Clone, Copy, Debug)]
pub struct V3<F> {
    /// First component.
    pub x: F,
    /// Second component.
    pub y: F,
    /// Third component.
    pub z: F,
}

impl<F: Floats> V3<F> {
    /// From its components.
    #[inline(always)]
    pub fn new(x: F, y: F, z: F) -> Self {
        Self { x, y, z }
    }

    /// The same number in every component.
    #[inline(always)]
    pub fn splat(x: F) -> Self {
        Self { x, y: x, z: x }
    }

    /// The lanes, component by component.
    #[inline(always)]
    pub fn arrays(self) -> [[f32; LANES]; 3] {
        [self.x.array(), self.y.array(), self.z.array()]
    }

    /// As an array.
    #[inline(always)]
    pub fn components(self) -> [F; 3] {
        [self.x, self.y, self.z]
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> F {
        self.dot(self)
    }

    /// With length 1; not numbers where it is zero.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        self * (self.x.fill(1.0) / self.length_squared().sqrt())
    }

    /// The components' magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Component by component.
    #[inline(always)]
    pub fn times(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// The largest component.
    #[inline(always)]
    pub fn max_element(self) -> F {
        self.x.max(self.y).max(self.z)
    }

    /// Lane by lane `yes` where the mask is true, else `no`.
    #[inline(always)]
    pub fn select(mask: F::Mask, yes: Self, no: Self) -> Self {
        Self { x: F::select(mask, yes.x, no.x), y: F::select(mask, yes.y, no.y), z: F::select(mask, yes.z, no.z) }
    }

    /// The vector where the mask is true, else zero.
    #[inline(always)]
    pub fn only(self, mask: F::Mask) -> Self {
        Self { x: self.x.only(mask), y: self.y.only(mask), z: self.z.only(mask) }
    }

    /// Where all components are finite.
    #[inline(always)]
    pub fn is_finite(self) -> F::Mask {
        self.x.is_finite() & self.y.is_finite() & self.z.is_finite()
    }

    /// Where any component is not zero (or not a number).
    #[inline(always)]
    pub fn is_not_zero(self) -> F::Mask {
        let zero = self.x.fill(0.0);
        !(self.x.eq(zero) & self.y.eq(zero) & self.z.eq(zero))
    }

    /// One lane.
    #[inline(always)]
    pub fn lane(self, i: usize) -> [f32; 3] {
        [self.x.array()[i], self.y.array()[i], self.z.array()[i]]
    }
}

impl<F: Floats> Add for V3<F> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<F: Floats> Sub for V3<F> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<F: Floats> Mul<F> for V3<F> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: F) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<F: Floats> Div<F> for V3<F> {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: F) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

impl<F: Floats> Neg for V3<F> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
