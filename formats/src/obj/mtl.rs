//! The MTL parser: statements as they stand, no meaning yet.
//!
//! `tobj`'s own panics on legal statements (`Kd 0.5`, an empty `Ka`) and leaves texture options in the file names.

use super::log::Log;
use super::map::{Map, Origin};
use super::number::{Words, value};
use super::text::Lines;
use std::collections::BTreeSet;
use std::sync::Arc;

/// One `newmtl` with the values that the file gives.
#[derive(Clone, Debug, Default)]
pub(super) struct Mtl {
    pub(super) name: String,
    /// Where its `newmtl` stands.
    pub(super) place: Origin,
    pub(super) diffuse: Option<[f32; 3]>,
    pub(super) specular: Option<[f32; 3]>,
    pub(super) emission: Option<[f32; 3]>,
    pub(super) filter: Option<[f32; 3]>,
    pub(super) exponent: Option<f32>,
    pub(super) ior: Option<f32>,
    /// `d`: 1 is opaque.
    pub(super) dissolve: Option<f32>,
    /// `Tr`: 0 is opaque.
    pub(super) transparency: Option<f32>,
    pub(super) illumination: Option<u32>,
    pub(super) roughness: Option<f32>,
    pub(super) metallic: Option<f32>,
    /// `Ps`.
    pub(super) sheen: Option<f32>,
    /// `Pc`, called a thickness: the strength of the coat.
    pub(super) clearcoat: Option<f32>,
    /// `Pcr`.
    pub(super) clearcoat_roughness: Option<f32>,
    /// `aniso`.
    pub(super) anisotropy: Option<f32>,
    /// `anisor`, in turns.
    pub(super) anisotropy_rotation: Option<f32>,
    pub(super) diffuse_map: Option<Map>,
    pub(super) specular_map: Option<Map>,
    pub(super) emission_map: Option<Map>,
    pub(super) dissolve_map: Option<Map>,
    pub(super) roughness_map: Option<Map>,
    pub(super) metallic_map: Option<Map>,
    pub(super) sheen_map: Option<Map>,
    pub(super) clearcoat_map: Option<Map>,
    pub(super) clearcoat_roughness_map: Option<Map>,
    pub(super) normal_map: Option<Map>,
    pub(super) bump_map: Option<Map>,
}

impl Mtl {
    /// The textures that can matter.
    pub(super) fn maps(&self) -> impl Iterator<Item = &Map> {
        let all = [
            &self.diffuse_map,
            &self.specular_map,
            &self.emission_map,
            &self.dissolve_map,
            &self.roughness_map,
            &self.metallic_map,
            &self.sheen_map,
            &self.clearcoat_map,
            &self.clearcoat_roughness_map,
            &self.normal_map,
            &self.bump_map,
        ];
        all.into_iter().flatten()
    }
}

/// Statements that make the material, as the documentation lists them.
#[rustfmt::skip]
pub(crate) const READ: [&str; 29] = [
    "Kd", "Ks", "Ke", "Tf", "Ns", "Ni", "d", "Tr", "illum", "Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor", "map_Kd", "map_Ks",
    "map_Ke", "map_d", "map_Pr", "map_Pm", "map_Ps", "map_Pc", "map_Pcr", "norm", "map_Kn", "bump", "map_bump",
];

/// Statements that would change the picture and are named in a warning instead.
pub(crate) const NAMED: [&str; 8] = ["map_Ns", "map_aniso", "map_anisor", "map_Tr", "disp", "decal", "refl", "Pe"];

/// Statements that change nothing here: ambient terms (a path tracer has its own), hints to scan-line renderers.
const HARMLESS: [&str; 9] = ["ka", "map_ka", "km", "sharpness", "map_aat", "ctm", "acolor", "illum_type", "kt"];

/// Lobes that the scene cannot express; worth a warning only where they are on.
const LOBES: [&str; 4] = ["pe", "tf_thin", "ao", "fresnel"];

/// Parses the text of one MTL file. `file` is its name as the OBJ file gives it: texture names are relative to it.
pub(super) fn parse(text: &str, file: &str, log: &mut Log) -> Vec<Mtl> {
    let mut parser = Parser { library: file.into(), materials: Vec::new(), warned: BTreeSet::new(), log };
    let mut lines = Lines::new(text);
    while let Some((line, statement)) = lines.next() {
        let mut words = Words::new(statement);
        if let Some(keyword) = words.next() {
            let operands = statement.get(words.end()..).unwrap_or("");
            parser.statement(line, &String::from_utf8_lossy(keyword), operands);
        }
    }
    parser.materials
}

struct Parser<'b, 'c> {
    library: Arc<str>,
    materials: Vec<Mtl>,
    warned: BTreeSet<String>,
    log: &'b mut Log<'c>,
}

impl Parser<'_, '_> {
    fn statement(&mut self, line: u32, keyword: &str, operands: &str) {
        let word = keyword.to_ascii_lowercase();
        let place = Origin { library: self.library.clone(), line };
        if word == "newmtl" {
            let name = operands.trim().to_owned();
            self.materials.push(Mtl { name, place, ..Mtl::default() });
            return;
        }
        // What stands before the first `newmtl` belongs to none.
        let Some(m) = self.materials.last_mut() else { return };
        let map = || Map::parse(operands, &place);
        match word.as_str() {
            "kd" => set(&mut m.diffuse, color(operands)),
            "ks" => set(&mut m.specular, color(operands)),
            "ke" => set(&mut m.emission, color(operands)),
            "tf" => set(&mut m.filter, color(operands)),
            "ns" => set(&mut m.exponent, number(operands)),
            "ni" => set(&mut m.ior, number(operands)),
            "d" => set(&mut m.dissolve, number(operands.trim().trim_start_matches("-halo"))),
            "tr" => set(&mut m.transparency, number(operands)),
            "pr" => set(&mut m.roughness, number(operands)),
            "pm" => set(&mut m.metallic, number(operands)),
            "ps" => set(&mut m.sheen, number(operands)),
            "pc" => set(&mut m.clearcoat, number(operands)),
            "pcr" => set(&mut m.clearcoat_roughness, number(operands)),
            "aniso" => set(&mut m.anisotropy, number(operands)),
            "anisor" => set(&mut m.anisotropy_rotation, number(operands)),
            "illum" => set(&mut m.illumination, number(operands).map(|x| x as u32)),
            "map_kd" => set(&mut m.diffuse_map, map()),
            "map_ks" => set(&mut m.specular_map, map()),
            "map_ke" | "map_emissive" => set(&mut m.emission_map, map()),
            "map_d" | "map_opacity" => set(&mut m.dissolve_map, map()),
            "map_pr" => set(&mut m.roughness_map, map()),
            "map_pm" => set(&mut m.metallic_map, map()),
            "map_ps" => set(&mut m.sheen_map, map()),
            "map_pc" => set(&mut m.clearcoat_map, map()),
            "map_pcr" => set(&mut m.clearcoat_roughness_map, map()),
            "norm" | "map_norm" | "map_kn" => set(&mut m.normal_map, map()),
            "bump" | "map_bump" => set(&mut m.bump_map, map()),
            _ => self.other(&word, keyword, operands, &place),
        }
        let words = ["kd", "ks", "ke", "tf"];
        if words.contains(&word.as_str()) && ["spectral", "xyz"].iter().any(|w| operands.trim().starts_with(w)) {
            let message = || format!("'{keyword}' by spectrum or XYZ is not supported; its default is used");
            self.log.warn("unsupported-statement", &place, message);
        }
    }

    fn other(&mut self, word: &str, keyword: &str, operands: &str, place: &Origin) {
        let off = LOBES.contains(&word) && Words::new(operands).filter_map(value).all(|x| x == 0.0);
        if HARMLESS.contains(&word) || off || self.warned.len() >= 64 || !self.warned.insert(word.to_owned()) {
            return;
        }
        let shown: String = keyword.chars().take(40).collect();
        self.log.warn("unsupported-statement", place, || format!("'{shown}' is not supported and ignored"));
    }
}

/// A later statement without a value leaves the earlier value.
fn set<T>(slot: &mut Option<T>, value: Option<T>) {
    if value.is_some() {
        *slot = value;
    }
}

/// The first number, made non-negative.
fn number(operands: &str) -> Option<f32> {
    Words::new(operands).next().and_then(value).map(|x| x.max(0.0) as f32)
}

/// One to three numbers, made non-negative; the last stands for those that are missing.
fn color(operands: &str) -> Option<[f32; 3]> {
    let mut numbers = Words::new(operands).map_while(value).map(|x| x.max(0.0) as f32);
    let r = numbers.next()?;
    let g = numbers.next().unwrap_or(r);
    Some([r, g, numbers.next().unwrap_or(g)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_documentation_lists_is_read_or_named() {
        let warnings_of = |word: &str| {
            let mut warnings = Vec::new();
            let mut log = Log::new(&mut warnings);
            let parsed = parse(&format!("newmtl a\n{word} 1\n"), "a.mtl", &mut log);
            log.finish();
            assert_eq!(parsed.len(), 1);
            warnings.into_iter().map(|w| w.code.to_string()).collect::<Vec<_>>()
        };
        READ.iter().for_each(|word| assert!(warnings_of(word).is_empty(), "{word}"));
        NAMED.iter().for_each(|word| assert_eq!(warnings_of(word), ["unsupported-statement"], "{word}"));
    }
}
