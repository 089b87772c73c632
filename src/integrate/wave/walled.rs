//! The smooth walls that light samples have met on their way.

use crate::math::Hit;

/// No further wall.
const NONE: u32 = u32::MAX;

/// For each light sample of a batch the walls that it has met, each of them once.
#[derive(Default)]
pub(super) struct Walled {
    /// The last wall of each light sample, and how many it has.
    last: Vec<(u32, u32)>,
    /// Walls, and which of the same light sample came before.
    walls: Vec<(Hit, u32)>,
    /// Room for those of one light sample.
    own: Vec<Hit>,
}

impl Walled {
    /// Forgets all, for a batch of so many.
    pub fn begin(&mut self, samples: usize) {
        self.walls.clear();
        self.last.clear();
        self.last.resize(samples, (NONE, 0));
    }

    /// Takes a wall that light sample number `i` has met, perhaps not for the first time: a triangle in several cells is met in each of
    /// them. False: these are more than `most`.
    pub fn meet(&mut self, i: usize, hit: &Hit, most: usize) -> bool {
        let (last, count) = self.last[i];
        let mut at = last;
        while let Some((known, before)) = self.walls.get(at as usize) {
            if known.triangle == hit.triangle {
                return true;
            }
            at = *before;
        }
        if count as usize >= most {
            return false;
        }
        self.walls.push((*hit, last));
        self.last[i] = (self.walls.len() as u32 - 1, count + 1);
        true
    }

    /// The walls that light sample number `i` has met, in no order.
    pub fn of(&mut self, i: usize) -> &mut [Hit] {
        self.own.clear();
        let mut at = self.last.get(i).map_or(NONE, |(last, _)| *last);
        while let Some((hit, before)) = self.walls.get(at as usize) {
            self.own.push(*hit);
            at = *before;
        }
        &mut self.own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_light_sample_has_its_walls_once_and_no_more_than_told() {
        let mut walled = Walled::default();
        walled.begin(3);
        let hit = |triangle| Hit { t: triangle as f32, triangle, b1: 0.0, b2: 0.0 };
        for (i, triangle, fits) in
            [(0, 7, true), (2, 7, true), (0, 8, true), (0, 7, true), (2, 9, true), (0, 9, false), (0, 8, true)]
        {
            assert_eq!(walled.meet(i, &hit(triangle), 2), fits, "{i} {triangle}");
        }
        let mut own = |i| walled.of(i).iter().map(|hit| hit.triangle).collect::<Vec<_>>();
        assert_eq!([own(0), own(1), own(2)], [vec![8, 7], vec![], vec![9, 7]]);
        walled.begin(1);
        assert!(walled.of(0).is_empty() && walled.of(5).is_empty());
    }
}
