use crate::settings::Goal;

/// The passes of a render: how many samples per pixel there are at the end of each. Fixed by the settings alone.
///
/// Where nothing is to be decided on the way, the first pass is [`AT_ONCE`] samples, and few pictures need another: after each
/// pass one may stop with a picture. With a deadline the first pass is one sample; with an
/// error asked for, the first is [`FIRST_LOOK`], since fewer samples say little about what they have not seen. Then passes
/// double up to 4 samples, take 4 more up to 16, and from there on divide each octave in four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    most: u32,
    first: u32,
}

/// The fewest samples per pixel after which the error is judged.
pub const FIRST_LOOK: u32 = 16;

/// Samples per pixel that are taken before anybody may stop with a picture.
const AT_ONCE: u32 = 64;

impl Schedule {
    /// For a goal and at most `spp` samples per pixel.
    pub fn new(goal: &Goal, spp: u32) -> Self {
        let first = match (goal.time, goal.error) {
            (Some(_), _) => 1,
            (None, Some(_)) => FIRST_LOOK,
            (None, None) => AT_ONCE,
        };
        Self { most: spp.max(1), first }
    }

    /// Samples per pixel at the end of the pass that begins with `spp` of them; `None` when there are no more passes.
    pub fn after(&self, spp: u32) -> Option<u32> {
        if spp >= self.most {
            return None;
        }
        let next = match spp {
            0 => self.first,
            // Whoever took fewer, to see where the noise is, takes the rest of them.
            _ if spp < self.first => self.first,
            1..4 => spp.saturating_mul(2),
            4..FIRST_LOOK => spp + 4,
            // The largest power of two that is not above it, over four: 16 → 4, 20 → 4, 32 → 8.
            _ => spp.saturating_add((1 << spp.ilog2()) / 4),
        };
        Some(next.min(self.most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::REPLICATES;

    fn ends(goal: Goal, spp: u32) -> Vec<u32> {
        let schedule = Schedule::new(&goal, spp);
        std::iter::successors(schedule.after(0), |n| schedule.after(*n)).collect()
    }

    #[test]
    fn passes_grow_by_quarters_of_an_octave_in_whole_replicates() {
        assert_eq!(ends(Goal::default(), 64), [64]);
        assert_eq!(Schedule::new(&Goal::default(), 100).after(16), Some(64));
        assert_eq!(Schedule::new(&Goal::default(), 40).after(16), Some(40));
        assert_eq!(ends(Goal::default(), 150), [64, 80, 96, 112, 128, 150]);
        let timed = Goal { time: Some(1.0), error: None };
        assert_eq!(ends(timed, 50), [1, 2, 4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 50]);
        let accurate = Goal { error: Some(2.0), time: None };
        assert_eq!(ends(accurate, 28), [16, 20, 24, 28]);
        assert_eq!(ends(accurate, 5), [5]);
        assert!(ends(accurate, 65_536).iter().all(|n| n % REPLICATES == 0));
        assert_eq!(ends(timed, u32::MAX).last(), Some(&u32::MAX));
    }
}
