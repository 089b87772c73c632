//! From tokens to the tree.

mod camera;
mod light;
mod lists;
mod material;
mod object;
mod scene;

use super::lexer::{Lexer, Token, TokenKind};
use super::source::{At, Offset, Source};
use super::tree::Node;
use crate::{Control, ErrorCode, ImportError};
use glam::DVec3;

type Result<T> = std::result::Result<T, ImportError>;

/// Parses a whole file. `max_nesting` bounds the levels of transforms and groups; `lenient` passes over fields that are not known.
///
/// # Errors
/// The first mistake in the text, with its place.
pub(super) fn parse(source: Source<'_>, max_nesting: u32, lenient: bool, control: &Control) -> Result<Vec<Node>> {
    let mut lexer = Lexer::new(source);
    let token = scene::read_header(source, &mut lexer)?;
    let mut parser = Parser {
        source,
        lexer,
        token,
        control,
        max_nesting,
        lenient,
        blocks: Vec::new(),
        list: None,
        nodes: Vec::new(),
    };
    parser.scene()?;
    Ok(parser.nodes)
}

/// A recursive-descent parser with one token of look-ahead; only [`Parser::scene`], which can nest without bound,
/// keeps a stack of its own.
struct Parser<'a> {
    source: Source<'a>,
    lexer: Lexer<'a>,
    /// The token to be consumed next.
    token: Token,
    control: &'a Control,
    max_nesting: u32,
    lenient: bool,
    /// What is open, with its keyword's place: for messages about a file that is cut off.
    blocks: Vec<(&'static str, Offset)>,
    /// The list of the innermost block that is open.
    list: Option<&'static str>,
    nodes: Vec<Node>,
}

impl<'a> Parser<'a> {
    /// Consumes a token and gives it.
    fn advance(&mut self) -> Result<Token> {
        let next = self.lexer.next()?;
        Ok(std::mem::replace(&mut self.token, next))
    }

    fn at_punct(&self, punct: u8) -> bool {
        self.token.kind == TokenKind::Punct(punct)
    }

    /// Consumes the punctuation mark if it comes next.
    fn accept(&mut self, punct: u8) -> Result<bool> {
        let found = self.at_punct(punct);
        if found {
            self.advance()?;
        }
        Ok(found)
    }

    fn expect(&mut self, punct: u8) -> Result<()> {
        if self.accept(punct)? { Ok(()) } else { Err(self.unexpected(&format!("`{}`", char::from(punct)))) }
    }

    /// The text of a token.
    fn text(&self, token: Token) -> &'a [u8] {
        self.source.bytes.get(token.start..token.end).unwrap_or_default()
    }

    /// The word that comes next, not consumed.
    fn word(&self) -> Option<&'a str> {
        let is_word = self.token.kind == TokenKind::Word;
        std::str::from_utf8(self.text(self.token)).ok().filter(|_| is_word)
    }

    fn syntax(&self, at: Offset, message: impl Into<String>) -> ImportError {
        self.source.error(ErrorCode::Syntax, at, message)
    }

    /// The error "`expected` was expected, found …" at the next token.
    fn unexpected(&self, expected: &str) -> ImportError {
        let at = self.token.start;
        if self.token.kind != TokenKind::End {
            let found = self.source.excerpt(at, self.token.end);
            return self.syntax(at, format!("{expected} was expected, found `{found}`"));
        }
        let list = self.list.map_or_else(String::new, |list| format!("`{list}` list of "));
        let inside = match self.blocks.last() {
            Some((block, opened)) => format!(" inside {list}`{block}` opened at line {}", self.source.line(*opened)),
            None => String::new(),
        };
        self.syntax(at, format!("end of file{inside}; {expected} was expected"))
    }

    fn number(&mut self) -> Result<f64> {
        match self.token.kind {
            TokenKind::Number(value) => {
                self.advance()?;
                Ok(value)
            }
            _ => Err(self.unexpected("a number")),
        }
    }

    /// A number that fits single precision.
    fn single(&mut self) -> Result<f32> {
        let Token { start, end, .. } = self.token;
        let value = self.number()? as f32;
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.syntax(start, format!("`{}` is too large a number", self.source.excerpt(start, end))))
    }

    /// `(a, b, …)` with as many numbers as asked for.
    fn tuple<T: Copy + Default, const N: usize>(&mut self, read: impl Fn(&mut Self) -> Result<T>) -> Result<[T; N]> {
        self.expect(b'(')?;
        let mut values = [T::default(); N];
        for (i, value) in values.iter_mut().enumerate() {
            if i > 0 {
                self.expect(b',')?;
            }
            *value = read(self)?;
        }
        self.expect(b')')?;
        Ok(values)
    }

    fn vec3(&mut self) -> Result<DVec3> {
        Ok(DVec3::from_array(self.tuple(Self::number)?))
    }

    /// A string; a bare word serves as well.
    fn string(&mut self) -> Result<At<String>> {
        match self.token.kind {
            TokenKind::Text | TokenKind::Word => {
                let token = self.advance()?;
                Ok(At { at: token.start, value: String::from_utf8_lossy(self.text(token)).into_owned() })
            }
            _ => Err(self.unexpected("a string")),
        }
    }

    fn boolean(&mut self) -> Result<bool> {
        let value = match self.word() {
            Some("true") => true,
            Some("false") => false,
            _ => return Err(self.unexpected("`true` or `false`")),
        };
        self.advance()?;
        Ok(value)
    }

    /// `= …` with the place of the value.
    fn assigned<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T>) -> Result<At<T>> {
        self.expect(b'=')?;
        let at = self.token.start;
        Ok(At { at, value: read(self)? })
    }

    /// `{ field … }`: calls `field` with each word and its place; a `;` behind a field is optional.
    fn block(
        &mut self,
        name: &'static str,
        opened: Offset,
        mut field: impl FnMut(&mut Self, &'a str, Offset) -> Result<()>,
    ) -> Result<()> {
        self.blocks.push((name, opened));
        let list = self.list.take();
        self.expect(b'{')?;
        while !self.at_punct(b'}') {
            let Some(word) = self.word() else {
                return Err(self.unexpected(&format!("a field of `{name}` or `}}`")));
            };
            let at = self.advance()?.start;
            field(self, word, at)?;
            self.accept(b';')?;
        }
        self.blocks.pop();
        self.list = list;
        self.advance()?;
        Ok(())
    }

    /// A word that is no field of the block: an error, with a hint when it is another dialect's, or passed over with its value.
    fn unknown_field(&mut self, block: &str, word: &str, at: Offset) -> Result<()> {
        const FOREIGN: &[&str] = &[
            "absorb",
            "albedo",
            "cone_angle",
            "cutoff",
            "glossiness",
            "metallic",
            "penumbra",
            "roughness",
            "translucency",
            "type",
        ];
        if self.lenient {
            self.skip_value()?;
            self.nodes.push(Node::Ignored(At { at, value: format!("`{word}` in `{block}`") }));
            return Ok(());
        }
        if FOREIGN.contains(&word) {
            let message = format!(
                "`{word}` in `{block}` belongs to another dialect of .ray and is not supported; `--ray-dialect hk` passes over it"
            );
            return Err(self.source.error(ErrorCode::Unsupported, at, message));
        }
        Err(self.syntax(at, format!("`{block}` has no field `{word}`")))
    }

    /// Passes over `= value`, where the value is a word, number or string, or anything in brackets.
    fn skip_value(&mut self) -> Result<()> {
        if !self.accept(b'=')? && !self.at_punct(b'(') && !self.at_punct(b'{') {
            return Ok(());
        }
        let mut depth = 0_u32;
        loop {
            self.control.check()?;
            match self.token.kind {
                TokenKind::End => return Err(self.unexpected("the end of a value")),
                TokenKind::Punct(b'(' | b'{') => depth += 1,
                TokenKind::Punct(b')' | b'}') if depth == 0 => return Err(self.unexpected("a value")),
                TokenKind::Punct(b')' | b'}') => depth -= 1,
                _ => {}
            }
            self.advance()?;
            // `bump("file")` and its like: a word with brackets behind it.
            if depth == 0 && !self.at_punct(b'(') {
                return Ok(());
            }
        }
    }
}
