use crate::batch::StageSeconds;

/// What an asset still has to do, CPU seconds: first alone on one core, then on all, then alone again.
#[derive(Clone, Copy, Debug)]
struct Work {
    asset: usize,
    parts: [f64; 3],
    at: usize,
}

/// How a batch went when it was played through.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Played {
    /// Seconds from beginning to end.
    pub seconds: f64,
    /// Assets that were worked on at the same time, whenever these changed.
    pub together: Vec<Vec<usize>>,
}

/// Plays a batch through as a fluid: `workers` assets at a time share `cores` fairly; importing, preparing and writing use one
/// core at most, the kd-tree and rendering as many as there are.
pub(super) fn play(assets: &[StageSeconds], workers: usize, cores: f64) -> Played {
    let mut waiting = assets.iter().enumerate().map(|(asset, s)| Work {
        asset,
        parts: [s.import + s.prepare, s.kdtree + s.render, s.write],
        at: 0,
    });
    let mut active: Vec<Work> = waiting.by_ref().take(workers.max(1)).collect();
    let mut played = Played::default();
    while !active.is_empty() {
        played.together.push(active.iter().map(|w| w.asset).collect());
        let speeds = speeds(&active, cores);
        let left = |w: &Work| w.parts[w.at];
        let step = active.iter().zip(&speeds).map(|(w, s)| left(w) / s).fold(f64::INFINITY, f64::min);
        played.seconds += step;
        for (work, speed) in active.iter_mut().zip(&speeds) {
            work.parts[work.at] -= step * speed;
            // What is left of the one that ends here is rounding.
            while work.at < 3 && work.parts[work.at] <= 1e-9 {
                work.at += 1;
            }
        }
        active.retain(|w| w.at < 3);
        while active.len() < workers.max(1) {
            let Some(next) = waiting.next() else { break };
            active.push(next);
        }
    }
    played
}

/// Cores that each one gets: equal shares, and what those that need but one leave goes to the others.
fn speeds(active: &[Work], cores: f64) -> Vec<f64> {
    let alone = active.iter().filter(|w| w.at != 1).count() as f64;
    let share = cores / active.len() as f64;
    let single = share.min(1.0);
    let wide = (active.len() as f64 - alone).max(1.0);
    let rest = (cores - alone * single) / wide;
    active.iter().map(|w| if w.at == 1 { rest } else { single }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asset(import: f64, render: f64) -> StageSeconds {
        StageSeconds { import, render, ..StageSeconds::default() }
    }

    #[test]
    fn alone_it_takes_the_serial_part_and_a_share_of_the_rest() {
        let played = play(&[asset(1.0, 8.0)], 1, 4.0);
        assert!((played.seconds - 3.0).abs() < 1e-9, "{}", played.seconds);
        assert_eq!(play(&[], 2, 4.0).seconds, 0.0);
    }

    #[test]
    fn several_fill_the_cores() {
        let many: Vec<_> = (0..40).map(|i| asset(0.5, 1.0 + f64::from(i % 3))).collect();
        let cpu: f64 = many.iter().map(|a| a.import + a.render).sum();
        let played = play(&many, 4, 4.0);
        assert!(
            played.seconds >= cpu / 4.0 - 1e-6 && played.seconds < 1.05 * cpu / 4.0,
            "{} for {cpu}",
            played.seconds
        );
        assert!(played.together.iter().all(|t| t.len() <= 4));
        // One at a time leaves cores idle during the imports.
        assert!((play(&many, 1, 4.0).seconds - (20.0 + (cpu - 20.0) / 4.0)).abs() < 1e-6);
    }
}
