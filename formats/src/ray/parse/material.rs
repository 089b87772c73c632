use super::{Parser, Result};
use crate::ray::lexer::TokenKind;
use crate::ray::source::At;
use crate::ray::tree::{FieldName, FieldValue, MaterialBlock, MaterialExpr, MaterialField};

impl FieldName {
    fn of(word: &str) -> Option<Self> {
        match word {
            "emissive" => Some(Self::Emissive),
            "ambient" => Some(Self::Ambient),
            "diffuse" => Some(Self::Diffuse),
            "specular" => Some(Self::Specular),
            "reflective" => Some(Self::Reflective),
            "transmissive" => Some(Self::Transmissive),
            "shininess" => Some(Self::Shininess),
            "index" => Some(Self::Index),
            "bump_mapping" => Some(Self::BumpMapping),
            _ => None,
        }
    }
}

impl Parser<'_> {
    /// What stands behind the word `material`: `= { … }`, `= name`, or `{ … }`.
    pub(super) fn assigned_material(&mut self) -> Result<MaterialExpr> {
        if !self.at_punct(b'{') {
            self.expect(b'=')?;
        }
        self.material()
    }

    /// `{ … }` or a name.
    pub(super) fn material(&mut self) -> Result<MaterialExpr> {
        if matches!(self.token.kind, TokenKind::Word | TokenKind::Text) {
            return Ok(MaterialExpr::Named(self.string()?));
        }
        let opened = self.token.start;
        if !self.at_punct(b'{') {
            return Err(self.unexpected("a material in `{ }` or the name of one"));
        }
        let mut material = MaterialBlock::default();
        self.block("material", opened, |p, word, at| {
            if word == "name" {
                // The course's grammar has no `=` here; everybody writes one.
                p.accept(b'=')?;
                material.name = Some(p.string()?);
                return Ok(());
            }
            let Some(name) = FieldName::of(word) else {
                return p.unknown_field("material", word, at);
            };
            let value = p.assigned(|p| p.field_value(name))?.value;
            material.fields.push(MaterialField { at, name, value });
            Ok(())
        })?;
        Ok(MaterialExpr::Block(At { at: opened, value: material }))
    }

    fn field_value(&mut self, name: FieldName) -> Result<FieldValue> {
        let is_number = matches!(name, FieldName::Shininess | FieldName::Index);
        let (function, expected) = match name {
            FieldName::BumpMapping => ("bump", "`bump(\"file\")`"),
            _ if is_number => ("map", "a number or `map(\"file\")`"),
            _ => ("map", "a colour `(r,g,b)` or `map(\"file\")`"),
        };
        match self.token.kind {
            TokenKind::Word if self.word() == Some(function) => {
                self.advance()?;
                self.expect(b'(')?;
                let file = self.string()?.value;
                self.expect(b')')?;
                Ok(FieldValue::Map(file))
            }
            TokenKind::Number(_) if is_number => Ok(FieldValue::Number(self.single()?)),
            // Grey, which all known parsers refuse.
            TokenKind::Number(_) if name != FieldName::BumpMapping => Ok(FieldValue::Color([self.single()?; 3])),
            TokenKind::Punct(b'(') if !is_number && name != FieldName::BumpMapping => {
                Ok(FieldValue::Color(self.tuple(Self::single)?))
            }
            _ => Err(self.unexpected(expected)),
        }
    }
}
