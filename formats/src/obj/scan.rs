//! The reader in front of `tobj`: checks every statement with its line and passes on what is sound.

use super::log::Log;
use super::number::Words;
use super::pieces::Pieces;
use super::plain::Numbers;
use super::text::Lines;
use super::vertices::with_all_colors;
use crate::{Control, ErrorCode, ImportError, Place};
use std::collections::{BTreeMap, HashMap};

/// Faces that share a material and the kinds of attributes that they have. Becomes one mesh.
pub(super) struct Part {
    /// Index into [`Scan::materials`].
    pub(super) material: Option<u32>,
    /// The object or group of its first face, or empty.
    pub(super) name: String,
    /// Their smoothing groups, or empty: they have normals, or are flat.
    pub(super) groups: Vec<u32>,
}

/// A sound OBJ file, sorted: what `tobj` parses, and what it is not asked.
#[derive(Default)]
pub(super) struct Scan<'t> {
    /// The `v`, `vt` and `vn` statements: three numbers or six (when any vertex has a colour), two, and three.
    pub(super) vertices: Pieces<'t>,
    /// Whether vertices have colours.
    pub(super) has_colors: bool,
    /// Faces, sorted.
    pub(super) parts: Vec<Part>,
    /// The `f` statements of each part, sound and in the file's order.
    pub(super) faces: Vec<Pieces<'t>>,
    /// Names by `usemtl` with the lines of their first use.
    pub(super) materials: Vec<(u32, String)>,
    /// Operands of the `mtllib` statements with their lines.
    pub(super) libraries: Vec<(u32, String)>,
    /// What `tobj` would make of it, where all vertices and faces are plain.
    pub(super) numbers: Option<Numbers>,
}

impl Scan<'_> {
    /// What is left to know once the statements have been parsed.
    pub(super) fn without_text(self) -> Scan<'static> {
        Scan {
            vertices: Pieces::default(),
            faces: Vec::new(),
            parts: self.parts,
            has_colors: self.has_colors,
            materials: self.materials,
            libraries: self.libraries,
            numbers: None,
        }
    }
}

/// How many there are of each kind of vertex data.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) positions: u32,
    pub(super) texcoords: u32,
    pub(super) normals: u32,
}

/// The face statements that refer to vertices further down are looked at once all are known.
pub(super) struct Deferred {
    pub(super) line: u32,
    pub(super) corners: String,
    pub(super) counts: Counts,
    pub(super) material: Option<u32>,
    pub(super) name: String,
    pub(super) group: u32,
}

/// What faces of a part have in common: material, texture coordinates, normals, smoothing.
pub(super) type PartKey = (Option<u32>, bool, bool, bool);

#[derive(Default)]
pub(super) struct Scanner<'t> {
    pub(super) text: &'t str,
    pub(super) scan: Scan<'t>,
    pub(super) counts: Counts,
    /// Numbers (from 1, ascending) of vertex data that cannot be used.
    pub(super) bad_positions: Vec<u32>,
    pub(super) bad_texcoords: Vec<u32>,
    pub(super) bad_normals: Vec<u32>,
    pub(super) colored: u32,
    pub(super) material: Option<u32>,
    pub(super) name: String,
    /// The smoothing group in force, 0 for none.
    pub(super) group: u32,
    /// The part of the face before, by the same key as in `part_index`: most faces follow one of their kind.
    pub(super) last_part: Option<(PartKey, usize)>,
    pub(super) part_index: HashMap<PartKey, usize>,
    pub(super) deferred: Vec<Deferred>,
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) triangles: u64,
    pub(super) first_bad_face: Option<(u32, String)>,
    material_index: HashMap<String, u32>,
    /// First line and count of statements that are not drawn.
    skipped: BTreeMap<&'static str, (u32, u64)>,
    unknown: BTreeMap<String, u32>,
}

pub(crate) const FREE_FORM: [&str; 11] =
    ["curv", "curv2", "surf", "bzp", "bsp", "cdc", "cdp", "res", "con", "call", "csh"];

/// Statements that change nothing in a picture of polygons.
#[rustfmt::skip]
pub(crate) const HARMLESS: [&str; 23] = [
    "mg", "vp", "deg", "bmat", "step", "cstype", "parm", "trim", "hole", "scrv", "sp", "end", "bevel", "c_interp",
    "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech", "maplib", "usemap", "vw",
];

/// Reads the whole text.
///
/// # Errors
/// [`ErrorCode::Empty`] for a text without faces, [`ErrorCode::Invalid`] when none of them is sound,
/// [`ErrorCode::TooLarge`] beyond `max_triangles`, [`ErrorCode::Stopped`].
pub(super) fn scan<'t>(
    text: &'t str,
    max_triangles: u64,
    log: &mut Log,
    control: &Control,
) -> Result<Scan<'t>, ImportError> {
    let mut scanner = Scanner { text, ..Scanner::default() };
    scanner.scan.vertices = Pieces::of(text);
    scanner.scan.numbers = Some(Numbers::default());
    control.begin(text.len() as u64);
    let mut lines = Lines::new(text);
    let (mut statements, mut left) = (0_u32, text.len());
    loop {
        if let Some(length) = scanner.plain_statement(lines.rest()) {
            lines.skip_line(length);
        } else if let Some((line, statement)) = lines.next() {
            scanner.statement(line, statement, log);
        } else {
            break;
        }
        statements = statements.wrapping_add(1);
        if statements.is_multiple_of(8192) {
            control.check()?;
            control.advance((left - lines.rest().len()) as u64);
            left = lines.rest().len();
            scanner.check_limit(max_triangles)?;
        }
    }
    for deferred in std::mem::take(&mut scanner.deferred) {
        scanner.deferred_face(deferred, log);
    }
    scanner.check_limit(max_triangles)?;
    scanner.finish(log)
}

impl<'t> Scanner<'t> {
    fn check_limit(&self, max_triangles: u64) -> Result<(), ImportError> {
        if self.triangles > max_triangles {
            let message = format!("{} triangles or more exceed the limit of {max_triangles}", self.triangles);
            return Err(ImportError::new(ErrorCode::TooLarge, message));
        }
        Ok(())
    }

    fn statement(&mut self, line: u32, statement: &str, log: &mut Log) {
        let mut words = Words::new(statement);
        let Some(keyword) = words.next() else { return };
        let operands = statement.get(words.end()..).unwrap_or("");
        match keyword {
            b"v" => self.position(line, operands, log),
            b"vt" => self.texcoord(line, operands, log),
            b"vn" => self.normal(line, operands, log),
            b"f" | b"fo" => self.face(line, operands, log),
            b"l" => self.skip("lines", line),
            b"p" => self.skip("points", line),
            // Not longer than is of use: every face that waits keeps a copy.
            b"o" | b"g" => self.name = operands.trim().chars().take(200).collect(),
            b"s" => self.smoothing(line, words.next().unwrap_or_default(), log),
            b"usemtl" => self.use_material(line, operands.trim()),
            b"mtllib" => self.scan.libraries.push((line, operands.trim().to_owned())),
            _ => {
                let word = String::from_utf8_lossy(keyword);
                if FREE_FORM.contains(&word.as_ref()) {
                    self.skip("free-form elements", line);
                } else if !HARMLESS.contains(&word.as_ref()) && self.unknown.len() < 8 {
                    self.unknown.entry(word.chars().take(40).collect()).or_insert(line);
                }
            }
        }
    }

    fn skip(&mut self, what: &'static str, line: u32) {
        self.skipped.entry(what).or_insert((line, 0)).1 += 1;
    }

    fn smoothing(&mut self, line: u32, group: &[u8], log: &mut Log) {
        self.group = match std::str::from_utf8(group).unwrap_or_default() {
            "off" | "" => 0,
            "on" => 1,
            word => word.parse().unwrap_or_else(|_| {
                log.warn("bad-smoothing-group", line, || format!("'{}' is no smoothing group; none", short(word)));
                0
            }),
        };
    }

    fn use_material(&mut self, line: u32, name: &str) {
        if let Some(index) = self.material_index.get(name) {
            self.material = Some(*index);
            return;
        }
        let index = self.scan.materials.len() as u32;
        self.scan.materials.push((line, name.to_owned()));
        self.material_index.insert(name.to_owned(), index);
        self.material = Some(index);
    }

    /// Nothing yet, for another part.
    pub(super) fn no_pieces(&self) -> Pieces<'t> {
        Pieces::of(self.text)
    }

    fn finish(mut self, log: &mut Log) -> Result<Scan<'t>, ImportError> {
        for (what, (line, count)) in &self.skipped {
            let free_form = *what == "free-form elements";
            let code = if free_form { "unsupported-element" } else { "points-or-lines-not-drawn" };
            log.warn(code, line, || format!("{count} statements of {what} are not drawn"));
        }
        for (word, line) in &self.unknown {
            log.warn("unknown-statement", line, || format!("statement '{word}' is not known and ignored"));
        }
        if self.scan.parts.is_empty() {
            return Err(match self.first_bad_face.take() {
                None => ImportError::new(ErrorCode::Empty, "has no faces"),
                Some((line, why)) => ImportError::new(ErrorCode::Invalid, format!("no face is sound: {why}"))
                    .at(Place::Text { line, column: 0 }),
            });
        }
        self.scan.has_colors = self.colored > 0;
        if self.colored > 0 && self.colored < self.counts.positions {
            // tobj wants a colour for each position or for none.
            self.scan.vertices = with_all_colors(&self.scan.vertices);
        }
        Ok(self.scan)
    }
}

/// The beginning of a piece of the file, for messages.
pub(super) fn short(text: &str) -> String {
    let mut cut: String = text.trim_end().chars().take(60).collect();
    if cut.len() < text.trim_end().len() {
        cut.push('…');
    }
    cut
}
