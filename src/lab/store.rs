use super::Cell;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The folder of a study: cells are appended as they are measured, so that a study that dies loses one at most.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    file: File,
    cells: Vec<Cell>,
}

impl Store {
    /// Opens a folder, which is made when it is missing, with the cells that are in it. Lines that cannot be read (the
    /// last one of a study that was killed) are left out.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn open(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let path = folder.join("cells.jsonl");
        let text = fs::read_to_string(&path).unwrap_or_default();
        let cells = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        if !text.is_empty() && !text.ends_with('\n') {
            file.write_all(b"\n")?;
        }
        Ok(Self { folder: folder.to_path_buf(), file, cells })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The cells of a run, in the order of their samples.
    pub fn of_run(&self, run: &str) -> Vec<Cell> {
        let mut cells: Vec<Cell> = self.cells.iter().filter(|c| c.run == run).cloned().collect();
        cells.sort_by_key(|c| c.spp);
        cells.dedup_by_key(|c| c.spp);
        cells
    }

    /// Keeps a cell.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn append(&mut self, cell: &Cell) -> io::Result<()> {
        let line = serde_json::to_string(cell)? + "\n";
        self.file.write_all(line.as_bytes())?;
        self.cells.push(cell.clone());
        Ok(())
    }
}

/// A path with an ending, whatever dots are in its name.
pub(super) fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.file_name().unwrap_or_default().to_os_string();
    name.push(ending);
    stem.with_file_name(name)
}
