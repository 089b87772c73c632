/// A logarithmic axis.
pub(super) struct Axis {
    /// Decimal logarithms of its ends.
    low: f64,
    high: f64,
    /// Where they are on the canvas.
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that covers all values, with a margin.
    pub fn covering(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for log in values.filter(|v| *v > 0.0 && v.is_finite()).map(libm::log10) {
            (low, high) = (low.min(log), high.max(log));
        }
        if low > high {
            (low, high) = (0.0, 0.0);
        }
        // At least half a decade, so that there is something to read.
        let margin = (0.05 * (high - low)).max(0.25 - 0.5 * (high - low)).max(0.02);
        Self { low: low - margin, high: high + margin, from, to }
    }

    pub fn place(&self, value: f64) -> f64 {
        self.from + (libm::log10(value) - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Values to draw a line at, with labels at some: 1, 2 and 5 of each decade where there is room.
    pub fn ticks(&self) -> Vec<(f64, Option<String>)> {
        let decades = self.high - self.low;
        let labelled: &[u32] = if decades < 1.6 {
            &[1, 2, 3, 5]
        } else if decades < 3.2 {
            &[1, 2, 5]
        } else {
            &[1]
        };
        let mut ticks = Vec::new();
        for decade in self.low.floor() as i32..=self.high.floor() as i32 {
            for digit in 1..10u32 {
                // 5e-3 read as text is the double next to it, unlike 5 · 10⁻³ computed.
                let value: f64 = format!("{digit}e{decade}").parse().unwrap_or(f64::NAN);
                let inside = (self.low..=self.high).contains(&libm::log10(value));
                if inside && (decades < 4.5 || digit == 1) {
                    ticks.push((value, labelled.contains(&digit).then(|| label(value))));
                }
            }
        }
        ticks
    }
}

fn label(value: f64) -> String {
    if (1e-4..1e6).contains(&value) { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        let axis = Axis::covering([0.03, 2.0].into_iter(), (0.0, 100.0));
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|t| t.1).collect();
        assert_eq!(labels, ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert!(axis.place(0.03) > 0.0 && axis.place(2.0) < 100.0 && axis.place(0.03) < axis.place(2.0));
        // Nothing to show, and a single value, still make an axis.
        for values in [vec![], vec![5.0], vec![0.0, f64::NAN]] {
            assert!(!Axis::covering(values.into_iter(), (0.0, 100.0)).ticks().is_empty());
        }
    }
}
