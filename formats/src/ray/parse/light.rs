use super::{Parser, Result};
use crate::ray::source::{At, Offset};
use crate::ray::tree::{LightBlock, LightWord, Node};
use glam::DVec3;

impl LightWord {
    pub(super) fn of(word: &str) -> Option<Self> {
        match word {
            "point_light" => Some(Self::Point),
            "directional_light" => Some(Self::Directional),
            "ambient_light" => Some(Self::Ambient),
            "area_light" => Some(Self::Area),
            _ => None,
        }
    }

    fn keyword(self) -> &'static str {
        match self {
            Self::Point => "point_light",
            Self::Directional => "directional_light",
            Self::Ambient => "ambient_light",
            Self::Area => "area_light",
        }
    }
}

impl Parser<'_> {
    /// `point_light { … }` and its kin, behind the keyword.
    pub(super) fn light(&mut self, word: LightWord, opened: Offset) -> Result<()> {
        let keyword = word.keyword();
        let default = |value| At { at: opened, value };
        let mut light = LightBlock {
            word,
            name: String::new(),
            color: None,
            position: None,
            direction: None,
            attenuation: [default(0.0), default(0.0), default(1.0)],
            radius: None,
            side: None,
            u: None,
            v: None,
        };
        let has_position = matches!(word, LightWord::Point | LightWord::Area);
        let is_area = word == LightWord::Area;
        self.block(keyword, opened, |p, field, at| {
            match field {
                "color" | "colour" => p.once(&mut light.color, keyword, field, at)?,
                "name" => light.name = p.assigned(Self::string)?.value.value,
                "position" if has_position => p.once(&mut light.position, keyword, field, at)?,
                "direction" if word == LightWord::Directional => p.once(&mut light.direction, keyword, field, at)?,
                "constant_attenuation_coeff" if has_position => light.attenuation[0] = p.assigned(Self::number)?,
                "linear_attenuation_coeff" if has_position => light.attenuation[1] = p.assigned(Self::number)?,
                "quadratic_attenuation_coeff" if has_position => light.attenuation[2] = p.assigned(Self::number)?,
                "light_radius" | "bottom_radius" if is_area => light.radius = Some(p.assigned(Self::number)?),
                "area" if is_area => light.side = Some(p.assigned(Self::number)?),
                "u" if is_area => light.u = Some(p.assigned(Self::vec3)?),
                "v" if is_area => light.v = Some(p.assigned(Self::vec3)?),
                _ => p.unknown_field(keyword, field, at)?,
            }
            Ok(())
        })?;
        let missing = if light.color.is_none() {
            Some("color")
        } else if has_position && light.position.is_none() {
            Some("position")
        } else if word == LightWord::Directional && light.direction.is_none() {
            Some("direction")
        } else if light.u.is_some() != light.v.is_some() {
            Some(if light.u.is_some() { "v" } else { "u" })
        } else {
            None
        };
        if let Some(field) = missing {
            return Err(self.syntax(opened, format!("`{keyword}` has no `{field}`")));
        }
        self.nodes.push(Node::Light(At { at: opened, value: light }));
        Ok(())
    }

    /// A vector field that may be given only once.
    fn once(&mut self, slot: &mut Option<At<DVec3>>, block: &str, field: &str, at: Offset) -> Result<()> {
        if slot.is_some() {
            return Err(self.syntax(at, format!("`{field}` is given twice in `{block}`")));
        }
        *slot = Some(self.assigned(Self::vec3)?);
        Ok(())
    }
}
