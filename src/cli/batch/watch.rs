use kiln::Control;
use kiln::batch::{Discovered, Ledger};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// How often somebody who waits looks whether to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Size and time of change of files; `None` for one that is not there.
pub(super) type Sight = BTreeMap<PathBuf, Option<(u64, SystemTime)>>;

/// How the assets and all that they refer to look from outside.
pub(super) fn look(discovered: &Discovered, manifest: &Path) -> Sight {
    let ledger = Ledger::read(manifest).unwrap_or_default();
    let mut sight = Sight::new();
    let mut add = |path: PathBuf| {
        let metadata = path.metadata().ok();
        sight.insert(path, metadata.and_then(|m| Some((m.len(), m.modified().ok()?))));
    };
    for found in &discovered.found {
        let folder = found.path.parent().unwrap_or(Path::new(""));
        ledger.referred(&found.name()).into_iter().for_each(|file| add(folder.join(file)));
        add(found.path.clone());
    }
    sight
}

/// Waits until the sight has changed and then stays as it is for one interval, so that nothing half-written is taken up.
/// `false`: the control stopped.
pub(super) fn wait(interval: Duration, control: &Control, before: &Sight, look: impl Fn() -> Sight) -> bool {
    let mut last = before.clone();
    loop {
        let mut waited = Duration::ZERO;
        while waited < interval {
            if control.is_stopped() {
                return false;
            }
            std::thread::sleep(LOOK.min(interval));
            waited += LOOK;
        }
        let now = look();
        if now == last && now != *before {
            return true;
        }
        last = now;
    }
}
