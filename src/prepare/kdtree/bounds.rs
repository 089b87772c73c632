//! Boxes and references: what the builders push around.

/// An axis-aligned box as eight numbers: the lower corner, a free slot, the negated upper corner, a free slot. Merging
/// two boxes is one minimum over all eight. A [`Reference`] keeps its triangle's number in the first free slot and the
/// triangle's thickness (see `clip`) in the second.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bounds(pub [f32; 8]);

/// A box around what one cell sees of a triangle, or of a pair: two triangles with numbers that follow each other.
pub type Reference = Bounds;

/// Set in the number of a pair's first triangle.
const PAIR: u32 = 1 << 31;
/// Triangles that references can tell apart.
pub const MOST_TRIANGLES: u32 = PAIR;

impl Bounds {
    /// Holds nothing; the identity of [`Bounds::merge`].
    pub const EMPTY: Self = Self([f32::INFINITY; 8]);

    /// From corners.
    pub fn new(lo: [f32; 3], hi: [f32; 3]) -> Self {
        Self([lo[0], lo[1], lo[2], 0.0, -hi[0], -hi[1], -hi[2], 0.0])
    }

    /// The same box as a reference to a triangle of a thickness.
    pub fn of_triangle(self, triangle: u32, thickness: f32) -> Reference {
        let mut reference = self;
        reference.0[3] = f32::from_bits(triangle);
        reference.0[7] = thickness;
        reference
    }

    /// The same reference to a triangle and the one that follows it.
    pub fn of_pair(mut self) -> Reference {
        self.0[3] = f32::from_bits(self.0[3].to_bits() | PAIR);
        self
    }

    /// The thickness of the triangle, or of the thicker one, that a reference refers to.
    pub fn thickness(&self) -> f32 {
        self.0[7]
    }

    /// The box that holds all points that are at most so far from this one on each axis.
    pub fn widened(&self, by: f32) -> Self {
        let grown = |k: usize| (self.0[k] - by).next_down();
        Self([grown(0), grown(1), grown(2), 0.0, grown(4), grown(5), grown(6), 0.0])
    }

    /// The triangles that a reference refers to.
    #[inline(always)]
    pub fn triangles(&self) -> std::ops::Range<u32> {
        let first = self.0[3].to_bits() & !PAIR;
        first..first + self.weight()
    }

    /// How many they are: one or two.
    #[inline(always)]
    pub fn weight(&self) -> u32 {
        1 + (self.0[3].to_bits() >> 31)
    }

    /// Lower end on an axis.
    #[inline(always)]
    pub fn lo(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    /// Upper end on an axis.
    #[inline(always)]
    pub fn hi(&self, axis: usize) -> f32 {
        -self.0[4 + axis]
    }

    /// Sets the lower end on an axis.
    pub fn set_lo(&mut self, axis: usize, x: f32) {
        self.0[axis] = x;
    }

    /// Sets the upper end on an axis.
    pub fn set_hi(&mut self, axis: usize, x: f32) {
        self.0[4 + axis] = -x;
    }

    /// Grows to hold another box too. The free slots become meaningless.
    #[inline(always)]
    pub fn merge(&mut self, other: &Self) {
        // All eight are written back, whichever is less: one vector minimum instead of masked stores.
        self.0 = std::array::from_fn(|k| if other.0[k] < self.0[k] { other.0[k] } else { self.0[k] });
    }

    /// The box around several.
    pub fn around<'a>(boxes: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::EMPTY;
        for b in boxes {
            all.merge(b);
        }
        all
    }

    /// What two boxes share; it may be empty.
    #[inline(always)]
    pub fn intersection(&self, other: &Self) -> Self {
        let mut shared = *self;
        for (mine, theirs) in shared.0.iter_mut().zip(&other.0) {
            *mine = if *theirs > *mine { *theirs } else { *mine };
        }
        shared
    }

    /// Whether no point lies inside. A box without thickness is not empty.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.lo(axis) > self.hi(axis))
    }

    /// Whether another box lies inside, its border included.
    pub fn contains(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.lo(axis) <= other.lo(axis) && self.hi(axis) >= other.hi(axis))
    }

    /// Half the surface; 0 for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let x = (-self.0[4] - self.0[0]).max(0.0);
        let y = (-self.0[5] - self.0[1]).max(0.0);
        let z = (-self.0[6] - self.0[2]).max(0.0);
        x * y + y * z + z * x
    }

    /// The axis along which it is longest.
    pub fn longest_axis(&self) -> usize {
        let extent = |axis: usize| self.hi(axis) - self.lo(axis);
        let mut longest = 0;
        for axis in 1..3 {
            if extent(axis) > extent(longest) {
                longest = axis;
            }
        }
        longest
    }
}
