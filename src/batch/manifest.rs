use super::ledger::{Span, note_limits};
use super::{Job, Ledger, Outcome, Policy, Verdict};
use crate::write::atomic;
use kiln_formats::Control;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The record of a batch: `manifest.jsonl` in its output folder, one line an asset.
///
/// While the batch runs, lines are appended as assets are finished, after those of earlier runs; of two lines for one asset the
/// later one counts. So a run that is killed leaves what it and its forerunners did. At the end the file is replaced by one in
/// the order of the inputs.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    policy: Policy,
    ledger: Ledger,
    log: Mutex<Log>,
}

#[derive(Debug)]
struct Log {
    file: File,
    end: u64,
    /// By the asset's index.
    lines: Vec<Option<Span>>,
    error: Option<io::Error>,
}

/// The name of the record in the folder of a batch.
pub const MANIFEST: &str = "manifest.jsonl";

impl Manifest {
    /// Opens the manifest of a folder for a run over `count` assets. The folder is there, and ours.
    ///
    /// # Errors
    /// When it cannot be read or written to.
    pub fn open(folder: &Path, count: usize, policy: Policy) -> io::Result<Self> {
        let path = folder.join(MANIFEST);
        let ledger = Ledger::read(&path)?;
        let file = File::options().create(true).read(true).append(true).open(&path)?;
        if file.metadata()?.len() > ledger.end {
            // Half a line, from a run that was killed while it wrote.
            file.set_len(ledger.end)?;
        }
        let log = Log { file, end: ledger.end, lines: vec![None; count], error: None };
        Ok(Self { path, policy, ledger, log: Mutex::new(log) })
    }

    /// What the run asks for.
    pub fn policy(&self) -> &Policy {
        &self.policy
    }

    /// Whether the job of an index has to be done. Where it has not, its line is kept.
    pub fn keep(&self, index: usize, job: &Job, control: &Control) -> Verdict {
        let verdict = self.ledger.verdict(job, &self.policy, control);
        if matches!(verdict, Verdict::Current(_)) {
            self.log().lines[index] = self.ledger.span(&job.name);
        }
        verdict
    }

    /// Appends the line of the job of an index.
    ///
    /// # Errors
    /// Those of the file system; then nothing of the line is there.
    pub fn append(&self, index: usize, job: &Job, outcome: &mut Outcome) -> io::Result<()> {
        note_limits(outcome, job, &self.policy);
        let line = outcome.to_line()? + "\n";
        let mut log = self.log();
        let appended = log.append(index, &line);
        if let Err(error) = &appended {
            log.error.get_or_insert(io::Error::new(error.kind(), error.to_string()));
        }
        appended
    }

    /// Replaces the file by one with a line an asset in the order of their indices, whole or not at all. An asset without one keeps
    /// the line that it had, or gets the one that `skipped` makes.
    ///
    /// # Errors
    /// Those of the file system, of an earlier [`Self::append`] too; then what was appended stays.
    pub fn finish(self, name: &dyn Fn(usize) -> String, skipped: &dyn Fn(usize) -> Outcome) -> io::Result<()> {
        let mut log = self.log.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = log.error.take() {
            return Err(error);
        }
        for index in 0..log.lines.len() {
            if log.lines[index].is_none() {
                log.lines[index] = self.ledger.span(&name(index));
            }
            if log.lines[index].is_none() {
                log.append(index, &(skipped(index).to_line()? + "\n"))?;
            }
        }
        if log.is_in_order() {
            return log.file.sync_data();
        }
        let Log { mut file, lines, .. } = log;
        atomic::write_durably_with(&self.path, |target| {
            let mut target = io::BufWriter::with_capacity(1 << 18, target);
            let mut line = Vec::new();
            let mut place = u64::MAX;
            for span in lines.into_iter().flatten() {
                if place != span.at {
                    file.seek(SeekFrom::Start(span.at))?;
                }
                line.resize(usize::try_from(span.length).map_err(io::Error::other)?, 0);
                file.read_exact(&mut line)?;
                target.write_all(&line)?;
                place = span.at + span.length;
            }
            target.flush()
        })
    }

    fn log(&self) -> std::sync::MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Log {
    fn append(&mut self, index: usize, line: &str) -> io::Result<()> {
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            // A full disk takes half a line. Making a file shorter needs no room; should it fail, the next run does it.
            let _ = self.file.set_len(self.end);
            return Err(error);
        }
        let length = line.len() as u64;
        self.lines[index] = Some(Span { at: self.end, length });
        self.end += length;
        Ok(())
    }

    /// Whether the file has these lines in this order and no others.
    fn is_in_order(&self) -> bool {
        let mut end = 0;
        let follows = |span: &Option<Span>| {
            let follows = span.is_some_and(|span| span.at == end);
            end += span.map_or(0, |span| span.length);
            follows
        };
        self.lines.iter().all(follows) && end == self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn job(name: &str) -> Job {
        let output = super::super::Output { folder: "".into(), stem: name.into(), ending: None };
        let (limits, settings) = Default::default();
        Job { input: name.into(), name: name.into(), root: None, limits, output, settings }
    }

    fn inputs(folder: &Path) -> Vec<(String, u64)> {
        let text = fs::read_to_string(folder.join(MANIFEST)).expect("a manifest");
        let read = |line: &str| serde_json::from_str::<Outcome>(line).expect("a whole line");
        text.lines().map(read).map(|o| (o.input, o.seed)).collect()
    }

    /// Appends these assets (indices into a, b, c) with a seed and ends in order.
    fn write(folder: &Path, order: &[usize], seed: u64) {
        let names = ["a", "b", "c"];
        let manifest = Manifest::open(folder, 3, Policy::default()).expect("open");
        for index in order {
            let mut outcome = Outcome::skipped(names[*index], seed);
            manifest.append(*index, &job(names[*index]), &mut outcome).expect("append");
        }
        manifest.finish(&|i| names[i].into(), &|i| Outcome::skipped(names[i], 99)).expect("finish");
    }

    #[test]
    fn lines_are_ordered_and_older_ones_kept() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let expect = |seeds: [u64; 3]| {
            let want: Vec<_> = ["a", "b", "c"].iter().zip(seeds).map(|(n, s)| (n.to_string(), s)).collect();
            assert_eq!(inputs(folder.path()), want);
        };
        write(folder.path(), &[2, 0], 1);
        expect([1, 99, 1]);
        // What was not begun keeps its line.
        write(folder.path(), &[1], 2);
        expect([1, 2, 1]);
        write(folder.path(), &[0, 1, 2], 3);
        expect([3, 3, 3]);
        assert_eq!(folder.path().read_dir().expect("folder").count(), 1);
    }

    #[test]
    fn half_a_line_is_taken_away() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let manifest = Manifest::open(folder.path(), 3, Policy::default()).expect("open");
        manifest.append(1, &job("b"), &mut Outcome::skipped("b", 7)).expect("append");
        drop(manifest);
        let path = folder.path().join(MANIFEST);
        let mut file = File::options().append(true).open(&path).expect("open");
        file.write_all(b"{\"input\": \"a\", \"see").expect("write");
        write(folder.path(), &[2], 8);
        assert_eq!(inputs(folder.path()), [("a".into(), 99), ("b".into(), 7), ("c".into(), 8)]);
    }
}
