use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// A part of the assets of a batch, for one machine of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which of them, from 1.
    pub number: u32,
    /// How many there are, ≥ 1.
    pub of: u32,
}

/// Which part is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShardChoice {
    /// This one.
    Fixed(Shard),
    /// The one that the engine says which runs this as one of several; where it does not say how many there are, so many.
    Auto(Option<u32>),
}

/// Where an engine says which of several this is: its name, and the part.
pub type Engine = (&'static str, Shard);

impl Shard {
    /// Whether an asset of this name belongs to it. That depends on the name alone, so it stays so when others come and go.
    pub fn has(&self, name: &str) -> bool {
        let hash = blake3::hash(name.as_bytes());
        let head = hash.as_bytes().first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        head % u64::from(self.of.max(1)) == u64::from(self.number) - 1
    }

    fn checked(number: u32, of: u32) -> Option<Self> {
        (1..=of).contains(&number).then_some(Self { number, of })
    }

    /// The part that the engine says in its environment: a Slurm array, an AWS Batch array, or an indexed Job of Kubernetes, which
    /// does not say how many there are (`of`).
    ///
    /// # Errors
    /// A sentence, when there is such an engine and what it says makes no part.
    pub fn of_environment(of: Option<u32>, get: impl Fn(&str) -> Option<String>) -> Result<Option<Engine>, String> {
        let number = |name: &str| {
            get(name).map(|text| text.trim().parse::<u32>().map_err(|_| format!("{name}={text}: no number")))
        };
        let must = |name: &str| number(name).unwrap_or_else(|| Err(format!("{name} is not set")));
        let (engine, index, count) = if let Some(id) = number("SLURM_ARRAY_TASK_ID") {
            let (least, most, count) =
                (must("SLURM_ARRAY_TASK_MIN")?, must("SLURM_ARRAY_TASK_MAX")?, must("SLURM_ARRAY_TASK_COUNT")?);
            let step = number("SLURM_ARRAY_TASK_STEP").transpose()?.unwrap_or(1).max(1);
            let index = id?.checked_sub(least).filter(|i| i % step == 0).map(|i| i / step);
            let even = most.checked_sub(least).is_some_and(|span| span / step + 1 == count && span % step == 0);
            let index =
                index.filter(|_| even).ok_or("the tasks of the Slurm array are not evenly spaced: say --shard K/N")?;
            ("Slurm", index, Some(count))
        } else if let Some(index) = number("AWS_BATCH_JOB_ARRAY_INDEX") {
            ("AWS Batch", index?, Some(must("AWS_BATCH_JOB_ARRAY_SIZE")?))
        } else if let Some(index) = number("JOB_COMPLETION_INDEX") {
            ("Kubernetes", index?, of)
        } else {
            return Ok(None);
        };
        let count = count.ok_or_else(|| format!("{engine} does not say how many there are: say --shard auto/N"))?;
        if of.is_some_and(|of| of != count) {
            return Err(format!("{engine} runs {count} of them, and not {}", of.unwrap_or(0)));
        }
        let shard = index.checked_add(1).and_then(|number| Self::checked(number, count));
        shard.map(|shard| Some((engine, shard))).ok_or_else(|| format!("{engine} says {index} of {count}, from 0"))
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for ShardChoice {
    type Err = String;

    /// `K/N` with K from 1, `auto`, or `auto/N`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (left, right) = text.split_once('/').map_or((text, None), |(left, right)| (left, Some(right)));
        let number = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
        let choice = match (left, right) {
            ("auto", None) => Some(Self::Auto(None)),
            ("auto", Some(of)) => number(of).map(|of| Self::Auto(Some(of))),
            (k, Some(of)) => number(k).zip(number(of)).and_then(|(k, of)| Shard::checked(k, of)).map(Self::Fixed),
            _ => None,
        };
        choice.ok_or_else(|| format!("'{text}' is not K/N with K from 1 to N, auto, or auto/N"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn engine(of: Option<u32>, variables: &[(&str, &str)]) -> Result<Option<String>, String> {
        let get = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.to_string());
        Shard::of_environment(of, get).map(|found| found.map(|(engine, shard)| format!("{engine} {shard}")))
    }

    #[test]
    fn engines_are_known_by_their_variables() {
        let slurm = |id, least, most, count, step| {
            let names = ["ID", "MIN", "MAX", "COUNT", "STEP"].map(|n| format!("SLURM_ARRAY_TASK_{n}"));
            let values = [id, least, most, count, step];
            engine(None, &names.iter().map(String::as_str).zip(values).collect::<Vec<_>>())
        };
        assert_eq!(slurm("3", "1", "4", "4", "1"), Ok(Some("Slurm 3/4".into())));
        assert_eq!(slurm("0", "0", "6", "4", "2"), Ok(Some("Slurm 1/4".into())));
        assert_eq!(slurm("6", "0", "6", "4", "2"), Ok(Some("Slurm 4/4".into())));
        assert!(slurm("7", "1", "7", "3", "1").is_err(), "1, 2 and 7");
        assert!(slurm("x", "1", "7", "7", "1").is_err());
        let aws = [("AWS_BATCH_JOB_ARRAY_INDEX", "0"), ("AWS_BATCH_JOB_ARRAY_SIZE", "10")];
        assert_eq!(engine(None, &aws), Ok(Some("AWS Batch 1/10".into())));
        assert!(engine(Some(9), &aws).is_err());
        let kubernetes = [("JOB_COMPLETION_INDEX", "7")];
        assert_eq!(engine(Some(8), &kubernetes), Ok(Some("Kubernetes 8/8".into())));
        assert!(engine(None, &kubernetes).is_err() && engine(Some(7), &kubernetes).is_err());
        assert_eq!(engine(None, &[]), Ok(None));
    }

    #[test]
    fn parts_are_read_from_text() {
        assert_eq!("2/4".parse(), Ok(ShardChoice::Fixed(Shard { number: 2, of: 4 })));
        assert_eq!("auto".parse(), Ok(ShardChoice::Auto(None)));
        assert_eq!("auto/8".parse(), Ok(ShardChoice::Auto(Some(8))));
        for wrong in ["", "0/4", "5/4", "1/0", "2", "auto/0", "a/b", "1/2/3"] {
            assert!(wrong.parse::<ShardChoice>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_asset_is_in_one_part_and_the_parts_are_about_equal() {
        let shards: Vec<Shard> = (1..=5).map(|number| Shard { number, of: 5 }).collect();
        let mut sizes = [0; 5];
        for i in 0..5000 {
            let name = format!("chairs/{i}.glb");
            let owners: Vec<usize> = (0..5).filter(|k| shards[*k].has(&name)).collect();
            assert_eq!(owners.len(), 1);
            sizes[owners[0]] += 1;
        }
        // Six standard deviations of a fair draw.
        assert!(sizes.iter().all(|n| (830..=1170).contains(n)), "{sizes:?}");
        assert!(Shard { number: 1, of: 1 }.has("any"));
    }
}
