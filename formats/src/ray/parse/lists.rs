use super::{Parser, Result};
use crate::ray::lexer::{Token, TokenKind};
use crate::ray::tree::Faces;

/// Entries between two looks at the stop signal.
const POLL_EVERY: usize = 4096;

impl Parser<'_> {
    /// `= ( entry, entry, … )`: calls `entry` for each.
    pub(super) fn list(&mut self, name: &'static str, mut entry: impl FnMut(&mut Self) -> Result<()>) -> Result<()> {
        self.list = Some(name);
        self.expect(b'=')?;
        self.expect(b'(')?;
        if !self.accept(b')')? {
            for count in 0_usize.. {
                if count.is_multiple_of(POLL_EVERY) {
                    self.control.check()?;
                }
                entry(self)?;
                if !self.accept(b',')? {
                    break;
                }
            }
            if !self.accept(b')')? {
                return Err(self.unexpected("`,` or `)`"));
            }
        }
        self.list = None;
        Ok(())
    }

    /// Appends a list of vectors.
    pub(super) fn vectors<const N: usize>(&mut self, name: &'static str, out: &mut Vec<[f32; N]>) -> Result<()> {
        self.list(name, |p| {
            out.push(p.tuple(Self::single)?);
            Ok(())
        })
    }

    /// Appends a list of polygons, each with three indices or more.
    pub(super) fn faces(&mut self, faces: &mut Faces) -> Result<()> {
        self.list("faces", |p| {
            let at = p.token.start;
            let begin = faces.indices.len();
            p.expect(b'(')?;
            loop {
                let index = p.index()?;
                faces.indices.push(index);
                if !p.accept(b',')? {
                    break;
                }
            }
            p.expect(b')')?;
            if faces.indices.len() - begin < 3 {
                return Err(p.syntax(at, "a face needs three vertices or more"));
            }
            faces.ends.push((at, faces.indices.len()));
            Ok(())
        })
    }

    fn index(&mut self) -> Result<i64> {
        let Token { start, end, kind } = self.token;
        let TokenKind::Number(value) = kind else {
            return Err(self.unexpected("a number"));
        };
        let whole = value as i64;
        if whole as f64 != value || whole.unsigned_abs() > 1 << 53 {
            return Err(self.syntax(start, format!("`{}` is not a vertex index", self.source.excerpt(start, end))));
        }
        self.advance()?;
        Ok(whole)
    }
}
