//! The reader in front of `tobj`: checks every statement with its line and passes on what is sound.

use super::log::Log;
use super::number::{Decimal, Words, decimal, value};
use super::text::Lines;
use crate::{Control, ErrorCode, ImportError, Place};
use std::collections::{BTreeMap, HashMap};

/// Faces that share a material and the kinds of attributes that they have. Becomes one mesh.
pub(super) struct Part {
    /// Index into [`Scan::materials`].
    pub(super) material: Option<u32>,
    /// The object or group of its first face, or empty.
    pub(super) name: String,
    /// The `f` statements, sound and in the file's order.
    pub(super) faces: Vec<u8>,
}

/// A sound OBJ file, sorted: what `tobj` parses, and what it is not asked.
#[derive(Default)]
pub(super) struct Scan {
    /// The `v`, `vt` and `vn` statements: three numbers or six (when any vertex has a colour), two, and three.
    pub(super) vertices: Vec<u8>,
    /// Whether vertices have colours.
    pub(super) has_colors: bool,
    /// Faces, sorted.
    pub(super) parts: Vec<Part>,
    /// Names by `usemtl` with the lines of their first use.
    pub(super) materials: Vec<(u32, String)>,
    /// Operands of the `mtllib` statements with their lines.
    pub(super) libraries: Vec<(u32, String)>,
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
}

#[derive(Default)]
pub(super) struct Scanner {
    pub(super) scan: Scan,
    pub(super) counts: Counts,
    /// Numbers (from 1, ascending) of vertex data that cannot be used.
    pub(super) bad_positions: Vec<u32>,
    pub(super) bad_texcoords: Vec<u32>,
    pub(super) bad_normals: Vec<u32>,
    pub(super) colored: u32,
    pub(super) material: Option<u32>,
    pub(super) name: String,
    pub(super) part_index: HashMap<(Option<u32>, bool, bool), usize>,
    pub(super) deferred: Vec<Deferred>,
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) triangles: u64,
    pub(super) first_bad_face: Option<(u32, String)>,
    material_index: HashMap<String, u32>,
    /// First line and count of statements that are not drawn.
    skipped: BTreeMap<&'static str, (u32, u64)>,
    unknown: BTreeMap<String, u32>,
}

const FREE_FORM: [&str; 11] = ["curv", "curv2", "surf", "bzp", "bsp", "cdc", "cdp", "res", "con", "call", "csh"];

/// Statements that change nothing in a picture of polygons.
const HARMLESS: [&str; 26] = [
    "s",
    "mg",
    "vp",
    "deg",
    "bmat",
    "step",
    "cstype",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "maplib",
    "usemap",
    "vw",
    "g",
    "o",
];

/// Reads the whole text.
///
/// # Errors
/// [`ErrorCode::Empty`] for a text without faces, [`ErrorCode::Invalid`] when none of them is sound,
/// [`ErrorCode::TooLarge`] beyond `max_triangles`, [`ErrorCode::Stopped`].
pub(super) fn scan(text: &str, max_triangles: u64, log: &mut Log, control: &Control) -> Result<Scan, ImportError> {
    let mut scanner = Scanner::default();
    scanner.scan.vertices.reserve(text.len() / 2);
    control.begin(text.len() as u64);
    let mut lines = Lines::new(text);
    let (mut statements, mut left) = (0_u32, text.len());
    while let Some((line, statement)) = lines.next() {
        scanner.statement(line, statement, log);
        statements = statements.wrapping_add(1);
        if statements.is_multiple_of(8192) {
            control.check()?;
            control.advance((left - lines.bytes_left()) as u64);
            left = lines.bytes_left();
            scanner.check_limit(max_triangles)?;
        }
    }
    for deferred in std::mem::take(&mut scanner.deferred) {
        scanner.deferred_face(deferred, log);
    }
    scanner.check_limit(max_triangles)?;
    scanner.finish(log)
}

impl Scanner {
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
            b"o" | b"g" => self.name = operands.trim().to_owned(),
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

    fn position(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.positions += 1;
        let mut words = Words::new(operands);
        let sound = (0..3).all(|_| words.next().is_some_and(|w| decimal(w).is_some()));
        let end = words.end();
        let out = &mut self.scan.vertices;
        out.extend_from_slice(b"v");
        if !sound {
            out.extend_from_slice(b" 0 0 0\n");
            self.bad_positions.push(self.counts.positions);
            let text =
                || format!("'v{}' is no position of three finite numbers; its faces are left out", short(operands));
            return log.warn("bad-vertex", line, text);
        }
        let Some(fourth) = words.next() else {
            out.extend_from_slice(operands.get(..end).unwrap_or("").as_bytes());
            return out.push(b'\n');
        };
        let rest = [Some(fourth), words.next(), words.next()];
        let weight = rest[1].is_none().then(|| value(fourth)).flatten().filter(|w| *w != 0.0 && *w != 1.0);
        if let Some(weight) = weight {
            // Homogeneous coordinates.
            for word in Words::new(operands).take(3) {
                let quotient = value(word).unwrap_or(0.0) / weight;
                let kept = if quotient.abs() <= super::number::LARGEST { quotient } else { 0.0 };
                out.extend_from_slice(format!(" {kept}").as_bytes());
            }
            return out.push(b'\n');
        }
        out.extend_from_slice(operands.get(..end).unwrap_or("").as_bytes());
        if let [Some(r), Some(g), Some(b)] = rest {
            let sound = [r, g, b].iter().all(|w| decimal(w).is_some());
            let color = if sound { [r, g, b] } else { [b"1".as_slice(); 3] };
            for word in color {
                out.push(b' ');
                out.extend_from_slice(word);
            }
            self.colored += 1;
            if !sound {
                log.warn("bad-vertex-color", line, || "a vertex colour is not a number; taken as white".into());
            }
        }
        out.push(b'\n');
    }

    fn texcoord(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.texcoords += 1;
        let mut words = Words::new(operands);
        let (u, v) = (words.next(), words.next().unwrap_or(b"0"));
        let out = &mut self.scan.vertices;
        match u {
            Some(u) if decimal(u).is_some() && decimal(v).is_some() => {
                out.extend_from_slice(b"vt ");
                out.extend_from_slice(u);
                out.push(b' ');
                out.extend_from_slice(v);
                out.push(b'\n');
            }
            _ => {
                out.extend_from_slice(b"vt 0 0\n");
                self.bad_texcoords.push(self.counts.texcoords);
                log.warn("bad-vertex", line, || format!("'vt{}' is no texture coordinate; not used", short(operands)));
            }
        }
    }

    fn normal(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.normals += 1;
        let mut words = Words::new(operands);
        let mut number = || words.next().and_then(decimal);
        let kinds = [number(), number(), number()];
        let end = words.end();
        let out = &mut self.scan.vertices;
        out.extend_from_slice(b"vn");
        if kinds.iter().all(Option::is_some) && kinds.contains(&Some(Decimal::NotZero)) {
            out.extend_from_slice(operands.get(..end).unwrap_or("").as_bytes());
            return out.push(b'\n');
        }
        // Some tools write zeros where they know no normal: no cause for a warning.
        out.extend_from_slice(b" 0 0 1\n");
        self.bad_normals.push(self.counts.normals);
        if kinds.contains(&None) {
            log.warn("bad-vertex", line, || format!("'vn{}' is no normal of three numbers; not used", short(operands)));
        }
    }

    fn finish(mut self, log: &mut Log) -> Result<Scan, ImportError> {
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

fn with_all_colors(vertices: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(vertices.len() + vertices.len() / 4);
    for line in vertices.split(|b| *b == b'\n').filter(|l| !l.is_empty()) {
        out.extend_from_slice(line);
        if line.first_chunk() == Some(b"v ") || line.first_chunk() == Some(b"v\t") {
            let plain = std::str::from_utf8(line).is_ok_and(|l| Words::new(l).count() == 4);
            out.extend_from_slice(if plain { b" 1 1 1" } else { b"" });
        }
        out.push(b'\n');
    }
    out
}

/// The beginning of a piece of the file, for messages.
pub(super) fn short(text: &str) -> String {
    let mut cut: String = text.trim_end().chars().take(60).collect();
    if cut.len() < text.trim_end().len() {
        cut.push('…');
    }
    cut
}
