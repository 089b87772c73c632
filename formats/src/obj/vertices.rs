//! Checks of `v`, `vt` and `vn` statements.

use super::log::Log;
use super::number::{Decimal, LARGEST, Words, decimal, value};
use super::pieces::Pieces;
use super::scan::{Scanner, short};

impl Scanner<'_> {
    pub(super) fn position(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.positions += 1;
        self.scan.numbers = None;
        let mut words = Words::new(operands);
        let sound = (0..3).all(|_| words.next().is_some_and(|w| decimal(w).is_some()));
        let end = words.end();
        let out = self.scan.vertices.own();
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
                let kept = if quotient.abs() <= LARGEST { quotient } else { 0.0 };
                out.extend_from_slice(format!(" {kept:e}").as_bytes());
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

    pub(super) fn texcoord(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.texcoords += 1;
        self.scan.numbers = None;
        let mut words = Words::new(operands);
        let (u, v) = (words.next(), words.next().unwrap_or(b"0"));
        let out = self.scan.vertices.own();
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

    pub(super) fn normal(&mut self, line: u32, operands: &str, log: &mut Log) {
        self.counts.normals += 1;
        self.scan.numbers = None;
        let mut words = Words::new(operands);
        let mut number = || words.next().and_then(decimal);
        let kinds = [number(), number(), number()];
        let end = words.end();
        let out = self.scan.vertices.own();
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
}

/// Appends white to the positions without a colour.
pub(super) fn with_all_colors<'t>(vertices: &Pieces<'t>) -> Pieces<'t> {
    let mut all = Pieces::default();
    let out = all.own();
    for line in vertices.iter().flat_map(|run| run.split(|b| *b == b'\n')).filter(|l| !l.is_empty()) {
        out.extend_from_slice(line);
        if line.first_chunk() == Some(b"v ") || line.first_chunk() == Some(b"v\t") {
            let plain = std::str::from_utf8(line).is_ok_and(|l| Words::new(l).count() == 4);
            out.extend_from_slice(if plain { b" 1 1 1" } else { b"" });
        }
        out.push(b'\n');
    }
    all
}
