use super::{Ledger, MANIFEST, Outcome, Shard, Status, Tally};
use crate::write::atomic;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

/// The note in the output folder of a part of a batch that says which part it is.
pub const SHARD_NOTE: &str = ".kiln.shard";

/// What joining the outputs of several runs gave.
#[derive(Debug, Default)]
pub struct Merged {
    /// What became of the assets.
    pub tally: Tally,
    /// What is not as it should be, in sentences.
    pub problems: Vec<String>,
}

/// Writes down which part of a batch a folder holds; without a part, takes the note away.
///
/// # Errors
/// Those of the file system.
pub fn note_shard(folder: &Path, shard: Option<Shard>) -> io::Result<()> {
    let note = folder.join(SHARD_NOTE);
    match shard {
        Some(shard) => atomic::write(&note, format!("{shard}\n").as_bytes()),
        None if note.exists() => fs::remove_file(note),
        None => Ok(()),
    }
}

/// Joins the output folders of several runs into one: each picture once, and one manifest, in the order of the names.
///
/// Pictures are linked where the file system can and copied elsewhere; the folders stay as they are. Where several have an asset, the
/// one with more of it counts, of equals the one named later. The folder is ours, and may be one of those that are joined.
///
/// # Errors
/// When a manifest cannot be read, or nothing can be written.
pub fn merge(folders: &[PathBuf], out: &Path) -> io::Result<Merged> {
    let mut merged = Merged { problems: missing_parts(folders), ..Merged::default() };
    let mut owners: BTreeMap<PathBuf, (usize, Outcome)> = BTreeMap::new();
    for (index, folder) in folders.iter().enumerate() {
        let path = folder.join(MANIFEST);
        let named = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", path.display()));
        path.metadata().map_err(named)?;
        let ledger = Ledger::read(&path).map_err(named)?;
        for outcome in ledger.outcomes() {
            let key = PathBuf::from(&outcome.input);
            let known = owners.get(&key);
            if let Some((_, known)) = known.filter(|(_, known)| known.status.is_done() && outcome.status.is_done())
                && (&known.content, &known.settings) != (&outcome.content, &outcome.settings)
            {
                merged
                    .problems
                    .push(format!("{} was done from other bytes or with other settings elsewhere", outcome.input));
            }
            if known.is_none_or(|(_, known)| rank(known.status) <= rank(outcome.status)) {
                owners.insert(key, (index, outcome));
            }
        }
    }
    let mut text = Vec::new();
    for (owner, mut outcome) in owners.into_values() {
        if let Err(error) = take_over(&outcome, &folders[owner], out) {
            if error.kind() == io::ErrorKind::StorageFull {
                return Err(error);
            }
            outcome.status = Status::Failed;
            outcome.error_code = Some("io".into());
            outcome.error_message = Some(error.to_string());
            outcome.outputs.clear();
            merged.problems.push(format!("{}: {error}", outcome.input));
        }
        merged.tally.add(&outcome, false);
        writeln!(text, "{}", outcome.to_line()?)?;
    }
    atomic::write_durably(&out.join(MANIFEST), &text)?;
    Ok(merged)
}

/// How much there is of an asset.
fn rank(status: Status) -> u32 {
    match status {
        Status::Ok | Status::Warned => 3,
        Status::Partial => 2,
        Status::Failed => 1,
        Status::Skipped => 0,
    }
}

/// Parts of a batch that are not among the folders.
fn missing_parts(folders: &[PathBuf]) -> Vec<String> {
    let mut parts: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for folder in folders {
        let note = fs::read_to_string(folder.join(SHARD_NOTE)).unwrap_or_default();
        if let Some((number, of)) = note.trim().split_once('/')
            && let (Ok(number), Ok(of)) = (number.parse(), of.parse())
        {
            parts.entry(of).or_default().insert(number);
        }
    }
    let missing = |(of, there): (&u32, &BTreeSet<u32>)| {
        let missing: Vec<String> = (1..=*of).filter(|k| !there.contains(k)).map(|k| format!("{k}/{of}")).collect();
        (!missing.is_empty()).then(|| format!("shards are missing: {}", missing.join(", ")))
    };
    parts.iter().filter_map(missing).collect()
}

/// Brings the pictures of an asset from one folder to another.
fn take_over(outcome: &Outcome, from: &Path, to: &Path) -> io::Result<()> {
    for output in &outcome.outputs {
        let path = Path::new(&output.path);
        // A manifest may come from anywhere.
        if !path.components().all(|c| matches!(c, Component::Normal(_))) {
            return Err(io::Error::other(format!("{} leads out of the folder", output.path)));
        }
        let (source, target) = (from.join(path), to.join(path));
        let explain = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", source.display()));
        let length = source.metadata().map_err(explain)?.len();
        if length != output.bytes {
            return Err(io::Error::other(format!(
                "{} has {length} bytes instead of {}",
                source.display(),
                output.bytes
            )));
        }
        atomic::link_or_copy(&source, &target).map_err(explain)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::OutputRecord;
    use super::*;
    use crate::settings::PictureFormat;

    fn line(input: &str, status: Status, seed: u64) -> Outcome {
        let path = format!("{input}.png");
        let output = OutputRecord {
            path,
            format: PictureFormat::Png,
            bytes: 1,
            view: 0,
            width: 1,
            height: 1,
            spp: 1,
            samples: 1,
            exposure: 0.0,
            error: None,
            error_bound: None,
            relmse: None,
            relmse_bound: None,
            target_met: None,
            bias: Vec::new(),
            reuse: false,
            denoised: None,
        };
        let outputs = if status.is_done() { vec![output] } else { Vec::new() };
        Outcome { status, outputs, ..Outcome::skipped(input, seed) }
    }

    fn folder(top: &Path, name: &str, lines: &[Outcome]) -> PathBuf {
        let folder = top.join(name);
        fs::create_dir_all(&folder).expect("folder");
        let text: String = lines.iter().map(|l| l.to_line().expect("finite") + "\n").collect();
        fs::write(folder.join(MANIFEST), text).expect("write");
        for output in lines.iter().flat_map(|l| &l.outputs) {
            fs::write(folder.join(&output.path), name).expect("write");
        }
        folder
    }

    #[test]
    fn the_best_of_each_asset_is_taken_in_order() {
        use Status::{Failed, Ok, Skipped};
        let top = tempfile::tempdir().expect("temporary folder");
        let x = folder(top.path(), "x", &[line("b", Ok, 1), line("a", Failed, 1), line("c", Skipped, 1)]);
        let y = folder(top.path(), "y", &[line("d", Ok, 2), line("a", Ok, 2), line("b", Failed, 2)]);
        note_shard(&x, Some(Shard { number: 1, of: 3 })).expect("write");
        note_shard(&y, Some(Shard { number: 3, of: 3 })).expect("write");
        let out = top.path().join("out");
        fs::create_dir(&out).expect("folder");
        // A name that comes again is replaced.
        fs::write(out.join("a.png"), "old").expect("write");
        let merged = merge(&[x, y.clone()], &out).expect("merged");
        assert_eq!(merged.problems, ["shards are missing: 2/3"]);
        let lines: Vec<(String, u64)> =
            Ledger::read(&out.join(MANIFEST)).expect("read").outcomes().map(|o| (o.input, o.seed)).collect();
        let want = [("a", 2), ("b", 1), ("c", 1), ("d", 2)].map(|(n, s)| (n.to_owned(), s));
        assert_eq!(lines, want);
        assert_eq!(fs::read_to_string(out.join("a.png")).expect("read"), "y");
        assert_eq!(fs::read_to_string(out.join("b.png")).expect("read"), "x");
        // Merging into a part of it is no copying onto itself.
        let merged = merge(&[out.clone(), y], &out).expect("merged");
        assert_eq!((merged.tally.done(), fs::read_to_string(out.join("d.png")).expect("read")), (3, "y".to_owned()));
    }

    #[test]
    fn pictures_that_are_not_whole_are_told() {
        let top = tempfile::tempdir().expect("temporary folder");
        let mut bad = line("evil", Status::Ok, 0);
        bad.outputs[0].path = "../evil.png".into();
        let x = folder(top.path(), "x", &[line("a", Status::Ok, 0), line("b", Status::Ok, 0), bad]);
        fs::write(x.join("a.png"), "too long").expect("write");
        let out = top.path().join("out");
        fs::create_dir(&out).expect("folder");
        let merged = merge(&[x], &out).expect("merged");
        assert_eq!((merged.tally.done(), merged.tally.count(Status::Failed), merged.problems.len()), (1, 2, 2));
        assert!(!out.join("a.png").exists() && out.join("b.png").exists());
        assert!(merge(&[top.path().join("nowhere")], &out).is_err());
    }
}
