//! Operators by macro: what every tier writes the same way.

/// A binary operator of two vectors, and of a vector and a plain number.
macro_rules! operator {
    ($vector:ident, $scalar:ty, $operator:ident, $method:ident, |$a:ident, $b:ident| $result:expr) => {
        impl std::ops::$operator for $vector {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $result
            }
        }

        impl std::ops::$operator<$scalar> for $vector {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: $scalar) -> Self {
                std::ops::$operator::$method(self, self.fill(other))
            }
        }
    };
}

/// A binary operator of masks.
macro_rules! mask_operator {
    ($mask:ident, $operator:ident, $method:ident, |$a:ident, $b:ident| $result:expr) => {
        impl std::ops::$operator for $mask {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $result
            }
        }
    };
}

pub(super) use {mask_operator, operator};
