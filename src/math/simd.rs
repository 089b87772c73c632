//! Which vector instructions the kernels use. The answer never depends on it, only the time that it takes.

use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// A tier of vector instructions; each contains the ones before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SimdTier {
    /// Plain code, as far as the compiler vectorises it for the baseline.
    Scalar,
    /// AVX2 with FMA and BMI: eight lanes.
    Avx2,
    /// AVX-512 F, BW, DQ and VL: sixteen lanes.
    Avx512,
}

impl SimdTier {
    /// Every tier, from the plainest.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// The best tier of this machine.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("popcnt")
                && is_x86_feature_detected!("lzcnt");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl");
            if avx2 && avx512 {
                return Self::Avx512;
            }
            if avx2 {
                return Self::Avx2;
            }
        }
        Self::Scalar
    }

    /// This tier, or the machine's best where that is less: what can safely be run.
    pub fn available(self) -> Self {
        self.min(Self::detect())
    }

    /// The stable word: `scalar`, `avx2` or `avx512`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl Default for SimdTier {
    fn default() -> Self {
        Self::detect()
    }
}

impl std::fmt::Display for SimdTier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for SimdTier {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|tier| tier.as_str() == word)
            .ok_or_else(|| format!("unknown SIMD tier '{word}': scalar, avx2 or avx512"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_round_trip_and_the_available_tier_is_never_above_the_machines() {
        for tier in SimdTier::ALL {
            assert_eq!(tier.as_str().parse::<SimdTier>(), Ok(tier));
            assert_eq!(serde_json::to_string(&tier).unwrap(), format!("\"{tier}\""));
            assert!(tier.available() <= SimdTier::detect());
        }
        assert!("sse9".parse::<SimdTier>().is_err());
    }
}
