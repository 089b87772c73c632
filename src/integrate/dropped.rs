//! Samples that were not finite: how many, why, and where to look.

use super::Cause;

/// Places that are kept.
const KEPT: usize = 8;

/// Address of a sample, and why it was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct DroppedSample {
    /// Column and row from the upper left.
    pub pixel: [u32; 2],
    /// Number of the sample.
    pub sample: u32,
    /// Why.
    pub cause: Cause,
}

/// Samples that were dropped because they were not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    counts: [u64; Cause::ALL.len()],
    first: [Option<DroppedSample>; KEPT],
}

impl Dropped {
    /// Counts a sample.
    pub fn add(&mut self, sample: DroppedSample) {
        self.counts[sample.cause as usize] += 1;
        self.keep(sample);
    }

    fn keep(&mut self, sample: DroppedSample) {
        if let Some(slot) = self.first.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(sample);
        }
    }

    /// All of them.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// How many by which cause, those without any left out.
    pub fn by_cause(&self) -> impl Iterator<Item = (Cause, u64)> + '_ {
        Cause::ALL.into_iter().zip(self.counts).filter(|(_, count)| *count > 0)
    }

    /// The first of them, by the order of tiles.
    pub fn first(&self) -> impl Iterator<Item = DroppedSample> + '_ {
        self.first.iter().flatten().copied()
    }
}

impl std::ops::AddAssign for Dropped {
    fn add_assign(&mut self, other: Self) {
        self.counts.iter_mut().zip(other.counts).for_each(|(own, more)| *own += more);
        other.first().for_each(|sample| self.keep(sample));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_the_first_places_are_kept() {
        let sample = |k: u32, cause| DroppedSample { pixel: [k, 2 * k], sample: k, cause };
        let (mut all, mut more) = (Dropped::default(), Dropped::default());
        (0..6).for_each(|k| all.add(sample(k, Cause::Scattering)));
        (6..20).for_each(|k| more.add(sample(k, Cause::Emission)));
        all += more;
        assert_eq!(all.count(), 20);
        assert_eq!(all.by_cause().collect::<Vec<_>>(), [(Cause::Emission, 14), (Cause::Scattering, 6)]);
        assert_eq!(all.first().map(|s| s.sample).collect::<Vec<_>>(), (0..8).collect::<Vec<_>>());
    }
}
