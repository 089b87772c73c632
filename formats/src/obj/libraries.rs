//! Finds, reads and parses the MTL files.

use super::log::Log;
use super::mtl::{self, Mtl};
use super::text;
use crate::{Control, ErrorCode, ImportError, Resources};
use std::collections::{BTreeSet, HashMap};

/// Statements and names that are looked at.
const MOST: usize = 1000;

/// All materials of the libraries, by name; of two with one name the later counts.
#[derive(Default)]
pub(super) struct Libraries {
    pub(super) by_name: HashMap<String, Mtl>,
    /// The names by their lower-case forms; `None` where several have the same.
    by_lower: HashMap<String, Option<String>>,
    /// Whether every library could be read.
    pub(super) complete: bool,
}

impl Libraries {
    /// Reads what the `mtllib` statements (line, operands) name; what fails becomes a warning.
    ///
    /// # Errors
    /// [`ErrorCode::TooLarge`], [`ErrorCode::Stopped`].
    pub(super) fn load(
        statements: &[(u32, String)],
        resources: &mut Resources,
        log: &mut Log,
        control: &Control,
    ) -> Result<Self, ImportError> {
        let mut libraries = Self { complete: true, ..Self::default() };
        // Some exporters repeat the statement for every object.
        let mut seen: BTreeSet<String> = BTreeSet::new();
        for (line, operands) in statements {
            control.check()?;
            if seen.contains(operands) || seen.len() > MOST {
                continue;
            }
            let names = names(operands, resources);
            seen.insert(operands.clone());
            for name in names {
                if name != *operands && !seen.insert(name.clone()) || seen.len() > MOST {
                    continue;
                }
                match read(&name, resources) {
                    Ok((file, bytes)) => libraries.add(&file, bytes, log),
                    Err(error) if error.code == ErrorCode::TooLarge => return Err(error),
                    Err(error) => libraries.instead(&error, *line, resources, log)?,
                }
            }
        }
        Ok(libraries)
    }

    /// Takes the library that has the name of the OBJ file for one that is missing: files get renamed together.
    fn instead(
        &mut self,
        error: &ImportError,
        line: u32,
        resources: &mut Resources,
        log: &mut Log,
    ) -> Result<(), ImportError> {
        let name = resources.asset_name().map(|name| format!("{name}.mtl"));
        match name.as_deref().map(|name| read(name, resources)) {
            Some(Ok((file, bytes))) => {
                log.warn("missing-material-library", line, || format!("{error}; {file} is read instead"));
                self.add(&file, bytes, log);
            }
            Some(Err(error)) if error.code == ErrorCode::TooLarge => return Err(error),
            _ => {
                self.complete = false;
                log.warn("missing-material-library", line, || format!("{error}; its materials are shown in grey"));
            }
        }
        Ok(())
    }

    fn add(&mut self, file: &str, bytes: Vec<u8>, log: &mut Log) {
        match text::decode(bytes) {
            Ok(text) => {
                for material in mtl::parse(&text, file, log) {
                    let only =
                        self.by_lower.entry(material.name.to_ascii_lowercase()).or_insert(Some(material.name.clone()));
                    if only.as_ref().is_some_and(|name| *name != material.name) {
                        *only = None;
                    }
                    self.by_name.insert(material.name.clone(), material);
                }
            }
            Err(_) => {
                self.complete = false;
                log.warn("missing-material-library", file, || "is binary data, not an MTL file".into());
            }
        }
    }

    /// The material of that name, of the name without a comment behind it, or the only one whose name differs in case alone.
    pub(super) fn get(&self, name: &str) -> Option<&Mtl> {
        let uncommented = || name.split(" #").next().map(str::trim_end);
        let alike = || self.by_name.get(self.by_lower.get(&name.to_ascii_lowercase())?.as_ref()?);
        self.by_name.get(name).or_else(|| self.by_name.get(uncommented()?)).or_else(alike)
    }
}

/// The names in a statement: the whole of it if there is such a file, else each up to a word that ends in `.mtl`.
fn names(operands: &str, resources: &Resources) -> Vec<String> {
    let whole = operands.trim().trim_matches('"');
    if locate(whole, resources).is_ok() {
        return vec![whole.to_owned()];
    }
    let (mut names, mut name) = (Vec::new(), String::new());
    for word in operands.split_whitespace() {
        if !name.is_empty() {
            name.push(' ');
        }
        // Some write `my\ name.mtl`.
        name.push_str(word.strip_suffix('\\').unwrap_or(word));
        if word.to_ascii_lowercase().ends_with(".mtl") {
            names.push(std::mem::take(&mut name));
        }
    }
    // What follows the last is another name or a comment.
    if names.is_empty() && !name.is_empty() {
        names.push(name);
    }
    names
}

/// The reference that resolves: the name as it stands, or else its last part beside the OBJ file.
fn locate(name: &str, resources: &Resources) -> Result<String, ImportError> {
    let as_it_stands = resources.resolve(name);
    let base = name.rsplit(['/', '\\']).next().unwrap_or_default();
    match as_it_stands {
        Ok(path) if path.is_file() => Ok(name.to_owned()),
        Ok(_) => Err(ImportError::new(ErrorCode::Io, "is not a file").in_file(name)),
        Err(error) => match resources.resolve(base) {
            Ok(path) if path.is_file() => Ok(base.to_owned()),
            _ => Err(error),
        },
    }
}

fn read(name: &str, resources: &mut Resources) -> Result<(String, Vec<u8>), ImportError> {
    let reference = locate(name, resources)?;
    let bytes = resources.read(&reference)?;
    Ok((reference, bytes))
}
