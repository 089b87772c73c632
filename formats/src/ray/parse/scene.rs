use super::object::primitive;
use super::{Parser, Result};
use crate::ErrorCode;
use crate::ray::lexer::{Lexer, Token, TokenKind};
use crate::ray::source::{At, Offset, Source};
use crate::ray::tree::{LightWord, Node, TransformBlock};
use glam::{DAffine3, DMat3, DVec3};

const NEWEST_VERSION: f64 = 1.1;

/// Reads `SBT-raytracer 1.0` and gives the token behind it.
pub(super) fn read_header(source: Source<'_>, lexer: &mut Lexer<'_>) -> Result<Token> {
    let magic = lexer.next().ok();
    let word = magic.filter(|token| token.kind == TokenKind::Word);
    if word.and_then(|token| source.bytes.get(token.start..token.end)) != Some(b"SBT-raytracer") {
        let message = "is not an SBT-raytracer file: it does not begin with `SBT-raytracer`";
        return Err(source.error(ErrorCode::UnknownFormat, magic.map_or(0, |t| t.start), message));
    }
    let version = lexer.next()?;
    let text = source.excerpt(version.start, version.end);
    match version.kind {
        TokenKind::Number(number) if number <= NEWEST_VERSION => lexer.next(),
        TokenKind::Number(_) => {
            let message = format!("format version {text} is newer than the newest supported ({NEWEST_VERSION})");
            Err(source.error(ErrorCode::UnknownFormat, version.start, message))
        }
        _ => {
            let message = "the version number of the format was expected behind `SBT-raytracer`";
            Err(source.error(ErrorCode::Syntax, version.start, message))
        }
    }
}

/// What an element may stand in.
#[derive(Clone, Copy, PartialEq)]
enum Level {
    /// Takes one element and `)`.
    Transform,
    /// Takes any number of elements and `}`.
    Group,
}

impl Parser<'_> {
    /// Everything behind the header. Nesting is kept on a stack of our own.
    pub(super) fn scene(&mut self) -> Result<()> {
        let mut levels: Vec<Level> = Vec::new();
        loop {
            self.control.check()?;
            let at = self.token.start;
            let in_transform = levels.last() == Some(&Level::Transform);
            match (self.token.kind, self.word()) {
                (TokenKind::End, _) if levels.is_empty() => return Ok(()),
                (TokenKind::Punct(b';'), _) if levels.is_empty() => {
                    self.advance()?;
                }
                (TokenKind::Punct(b'}'), _) if levels.last() == Some(&Level::Group) => {
                    self.advance()?;
                    self.close(&mut levels);
                    self.close_transforms(&mut levels)?;
                }
                (TokenKind::Punct(b'{'), _) => {
                    self.advance()?;
                    self.open(&mut levels, Level::Group, "group", at)?;
                    self.nodes.push(Node::Group);
                }
                (_, Some("camera")) if levels.is_empty() => {
                    self.advance()?;
                    self.camera(at)?;
                }
                (_, Some("material")) if !in_transform => {
                    self.advance()?;
                    let material = self.assigned_material()?;
                    self.nodes.push(Node::Material(material));
                    if !levels.is_empty() {
                        self.accept(b';')?;
                    }
                }
                (_, Some(word)) => {
                    if let Some(light) = LightWord::of(word).filter(|_| levels.is_empty()) {
                        self.advance()?;
                        self.light(light, at)?;
                    } else if let Some(keyword) = primitive(word) {
                        self.advance()?;
                        self.object(keyword, at)?;
                        self.close_transforms(&mut levels)?;
                    } else {
                        let (keyword, value) = self.transform(word, at, levels.is_empty())?;
                        self.open(&mut levels, Level::Transform, keyword, at)?;
                        self.nodes.push(Node::Transform(At { at, value }));
                    }
                }
                _ if in_transform => return Err(self.unexpected("an object, a transform or a group")),
                _ if levels.is_empty() => return Err(self.unexpected("a camera, light, material, object or transform")),
                _ => return Err(self.unexpected("an object, a transform or `}`")),
            }
        }
    }

    fn open(&mut self, levels: &mut Vec<Level>, level: Level, name: &'static str, at: Offset) -> Result<()> {
        if levels.len() as u64 >= u64::from(self.max_nesting) {
            let message = format!("transforms and groups are nested deeper than {}", self.max_nesting);
            return Err(self.source.error(ErrorCode::TooLarge, at, message));
        }
        levels.push(level);
        self.blocks.push((name, at));
        Ok(())
    }

    fn close(&mut self, levels: &mut Vec<Level>) {
        levels.pop();
        self.blocks.pop();
        self.nodes.push(Node::Close);
    }

    /// Behind an element: the `)` of each transform that it completes, each with an optional `;`.
    fn close_transforms(&mut self, levels: &mut Vec<Level>) -> Result<()> {
        while levels.last() == Some(&Level::Transform) {
            self.expect(b')')?;
            self.accept(b';')?;
            self.close(levels);
        }
        Ok(())
    }

    /// `translate( x, y, z,` and its kin up to the comma before the element, from the keyword on.
    fn transform(&mut self, word: &str, at: Offset, top_level: bool) -> Result<(&'static str, TransformBlock)> {
        let keyword = match word {
            "translate" => "translate",
            "rotate" => "rotate",
            "scale" => "scale",
            "transform" => "transform",
            _ => return Err(self.unknown_element(word, at, top_level)),
        };
        self.blocks.push((keyword, at));
        self.advance()?;
        self.expect(b'(')?;
        let mut projective = false;
        let (matrix, complaint) = match keyword {
            "translate" => (DAffine3::from_translation(self.three_arguments()?), "translation"),
            "rotate" => {
                let axis = self.three_arguments()?;
                let angle = self.argument()?;
                (DAffine3::from_mat3(rotation(axis, angle)), "rotation about an axis of length 0")
            }
            "scale" => {
                let x = self.argument()?;
                let uniform = !matches!(self.token.kind, TokenKind::Number(_));
                let factors = if uniform { DVec3::splat(x) } else { DVec3::new(x, self.argument()?, self.argument()?) };
                (DAffine3::from_scale(factors), "scale by 0")
            }
            _ => {
                let (matrix, last_row) = self.matrix()?;
                projective = last_row != [0.0, 0.0, 0.0, 1.0];
                (matrix, "this matrix")
            }
        };
        self.blocks.pop();
        match matrix.matrix3.determinant() {
            d if d == 0.0 || d.is_nan() => {
                Err(self.source.error(ErrorCode::Invalid, at, format!("{complaint} gives a singular transform")))
            }
            d if d.is_infinite() => {
                Err(self.source.error(ErrorCode::Invalid, at, format!("`{keyword}` leaves the range of numbers")))
            }
            _ => Ok((keyword, TransformBlock { matrix, projective })),
        }
    }

    /// A number and the comma behind it.
    fn argument(&mut self) -> Result<f64> {
        let value = self.number()?;
        self.expect(b',')?;
        Ok(value)
    }

    fn three_arguments(&mut self) -> Result<DVec3> {
        Ok(DVec3::new(self.argument()?, self.argument()?, self.argument()?))
    }

    /// Four rows of a matrix for column vectors: the affine map of the first three, and the last.
    fn matrix(&mut self) -> Result<(DAffine3, [f64; 4])> {
        let mut rows = [[0.0; 4]; 4];
        for row in &mut rows {
            *row = self.tuple(Self::number)?;
            self.expect(b',')?;
        }
        let [x, y, z, last] = rows;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        Ok((DAffine3 { matrix3, translation: column(3) }, last))
    }

    fn unknown_element(&self, word: &str, at: Offset, top_level: bool) -> crate::ImportError {
        const FOREIGN: &[&str] =
            &["csg", "metaball", "quadric", "skybox", "spot_light", "torus", "torus_knot", "warn_light"];
        if FOREIGN.contains(&word) {
            let message = format!("`{word}` belongs to another dialect of .ray and is not supported");
            return self.source.error(ErrorCode::Unsupported, at, message);
        }
        if !top_level && (word == "camera" || LightWord::of(word).is_some()) {
            return self.syntax(at, format!("`{word}` cannot stand inside a transform or group"));
        }
        if top_level {
            self.unexpected("a camera, light, material, object or transform")
        } else {
            self.unexpected("an object, a transform or a group")
        }
    }
}

/// Right-handed rotation about an axis of any length, angle in radians (Rodrigues' formula). NaN for a zero axis.
fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    // `DVec3::normalize` would overflow for axes longer than about 1e154.
    let axis = (axis / axis.abs().max_element()).normalize();
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos)
}
