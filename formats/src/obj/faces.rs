//! Checks of `f` statements.

use super::log::Log;
use super::number::{Words, index};
use super::scan::{Counts, Deferred, Part, Scanner, short};

/// What becomes of one index of a corner.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Index {
    /// Counted from 1.
    Sound(u32),
    Absent,
    /// Refers to what the file has not shown yet.
    Ahead,
    Bad,
}

fn resolve(word: &[u8], count: u32) -> Index {
    if word.is_empty() {
        return Index::Absent;
    }
    match index(word) {
        Some(i) if i < 0 && i >= -i64::from(count) => Index::Sound((i64::from(count) + 1 + i) as u32),
        Some(i) if i > i64::from(count) => Index::Ahead,
        Some(i) if i > 0 => Index::Sound(i as u32),
        _ => Index::Bad,
    }
}

/// How a face statement ended.
enum Verdict {
    Sound {
        uvs: bool,
        normals: bool,
        verbatim: bool,
        note: Option<&'static str>,
    },
    Later,
    /// Warning code and reason.
    Bad(&'static str, &'static str),
}

impl Scanner<'_> {
    /// Takes a face statement.
    pub(super) fn face(&mut self, line: u32, corners: &str, log: &mut Log) {
        self.scan.numbers = None;
        match self.check(corners, self.counts, false) {
            Verdict::Later => self.deferred.push(Deferred {
                line,
                corners: corners.to_owned(),
                counts: self.counts,
                material: self.material,
                name: self.name.clone(),
                group: self.group,
            }),
            verdict => self.settle(verdict, line, corners, log),
        }
    }

    /// Takes a face statement that waited for the end of the file.
    pub(super) fn deferred_face(&mut self, face: Deferred, log: &mut Log) {
        (self.material, self.name, self.group) = (face.material, face.name, face.group);
        let verdict = self.check(&face.corners, face.counts, true);
        self.settle(verdict, face.line, &face.corners, log);
    }

    /// Reads the corners into `self.corners`, with 0 for what a corner lacks. `counts` is what the file had shown
    /// before the statement.
    fn check(&mut self, corners: &str, counts: Counts, last: bool) -> Verdict {
        self.corners.clear();
        let (mut uvs, mut normals, mut verbatim, mut note) = (true, true, true, None);
        let total = self.counts;
        let look_ahead = |word: &[u8], count: u32, total: u32| match resolve(word, count) {
            Index::Ahead if last => match resolve(word, total) {
                Index::Ahead => Index::Bad,
                index => index,
            },
            index => index,
        };
        for corner in Words::new(corners) {
            let mut parts = corner.split(|b| *b == b'/');
            let mut part = || parts.next().unwrap_or_default();
            let v = look_ahead(part(), counts.positions, total.positions);
            let vt = look_ahead(part(), counts.texcoords, total.texcoords);
            let vn = look_ahead(part(), counts.normals, total.normals);
            if parts.next().is_some() {
                return Verdict::Bad("bad-face", "has a corner of more than three indices");
            }
            if [v, vt, vn].contains(&Index::Ahead) {
                return Verdict::Later;
            }
            let Index::Sound(v) = v else { return Verdict::Bad("bad-index", "refers to a vertex that does not exist") };
            if self.bad_positions.binary_search(&v).is_ok() {
                return Verdict::Bad("bad-index", "refers to a bad vertex");
            }
            if vt == Index::Bad || vn == Index::Bad {
                note = Some("refers to a texture coordinate or normal that does not exist; drawn without");
            }
            let vt = known(vt, &self.bad_texcoords);
            let vn = known(vn, &self.bad_normals);
            (uvs, normals) = (uvs && vt != 0, normals && vn != 0);
            verbatim = verbatim && !corner.contains(&b'-');
            self.corners.push([v, vt, vn]);
        }
        if self.corners.len() < 3 {
            return Verdict::Bad("bad-face", "has fewer than three corners");
        }
        // What only some of the corners have cannot be used.
        let stripped = |on: bool, k: usize| !on && self.corners.iter().any(|c| c[k] != 0);
        verbatim = verbatim && note.is_none() && !stripped(uvs, 1) && !stripped(normals, 2);
        // A corner may name bad data, which is stripped like data that it lacks.
        verbatim = verbatim && (uvs || self.bad_texcoords.is_empty()) && (normals || self.bad_normals.is_empty());
        Verdict::Sound { uvs, normals, verbatim, note }
    }

    fn settle(&mut self, verdict: Verdict, line: u32, corners: &str, log: &mut Log) {
        let (uvs, normals, verbatim, note) = match verdict {
            Verdict::Sound { uvs, normals, verbatim, note } => (uvs, normals, verbatim, note),
            Verdict::Later => return,
            Verdict::Bad(code, why) => {
                // Deferred faces come last, but may stand first.
                if self.first_bad_face.as_ref().is_none_or(|(first, _)| line < *first) {
                    self.first_bad_face = Some((line, format!("'f{}' {why}", short(corners))));
                }
                return log.warn(code, line, || format!("'f{}' {why}; left out", short(corners)));
            }
        };
        if let Some(note) = note {
            log.warn("bad-index", line, || format!("'f{}' {note}", short(corners)));
        }
        let part = self.part(uvs, normals);
        let Some(faces) = self.scan.faces.get_mut(part) else { return };
        let out = faces.own();
        out.push(b'f');
        if verbatim {
            let mut words = Words::new(corners);
            words.by_ref().for_each(drop);
            out.extend_from_slice(corners.get(..words.end()).unwrap_or("").as_bytes());
        } else {
            for [v, vt, vn] in &self.corners {
                let text = match (uvs, normals) {
                    (true, true) => format!(" {v}/{vt}/{vn}"),
                    (true, false) => format!(" {v}/{vt}"),
                    (false, true) => format!(" {v}//{vn}"),
                    (false, false) => format!(" {v}"),
                };
                out.extend_from_slice(text.as_bytes());
            }
        }
        out.push(b'\n');
    }
}

impl Scanner<'_> {
    /// The part of the face in `self.corners`, which is counted.
    pub(super) fn part(&mut self, uvs: bool, normals: bool) -> usize {
        self.triangles += self.corners.len() as u64 - 2;
        let smooth = !normals && self.group != 0;
        let next = self.scan.parts.len();
        let key = (self.material, uvs, normals, smooth);
        let index = match self.last_part {
            Some((last, part)) if last == key => part,
            _ => *self.part_index.entry(key).or_insert(next),
        };
        self.last_part = Some((key, index));
        if index == next {
            let name = self.name.clone();
            self.scan.parts.push(Part { material: self.material, name, groups: Vec::new() });
            self.scan.faces.push(self.no_pieces());
        }
        if smooth && let Some(part) = self.scan.parts.get_mut(index) {
            part.groups.push(self.group);
        }
        index
    }
}

fn known(index: Index, bad: &[u32]) -> u32 {
    match index {
        Index::Sound(i) if bad.binary_search(&i).is_err() => i,
        _ => 0,
    }
}
