//! The operands of texture statements: options and a file name that may hold blanks.

use super::number::value;
use crate::scene::{Channel, UvTransform};
use std::fmt;
use std::sync::Arc;

/// A line of an MTL file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Origin {
    /// The file, as the OBJ file refers to it.
    pub(super) library: Arc<str>,
    pub(super) line: u32,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.library, self.line)
    }
}

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The file name as it stands.
    pub(super) file: String,
    /// Where it stands; the folder of the MTL file is where names are looked for first.
    pub(super) place: Origin,
    /// `-o`.
    pub(super) offset: [f32; 2],
    /// `-s`.
    pub(super) scale: [f32; 2],
    /// `-bm`.
    pub(super) strength: f32,
    /// `-clamp on`.
    pub(super) clamp: bool,
    /// `-imfchan`.
    pub(super) channel: Option<Channel>,
    /// `-mm`: base and gain.
    pub(super) range: [f32; 2],
}

/// How many operands options take: (name, at least, at most); those of varying number are numbers.
const OPTIONS: [(&str, usize, usize); 14] = [
    ("-blendu", 1, 1),
    ("-blendv", 1, 1),
    ("-boost", 1, 1),
    ("-mm", 0, 2),
    ("-o", 0, 3),
    ("-s", 0, 3),
    ("-t", 0, 3),
    ("-texres", 1, 1),
    ("-clamp", 1, 1),
    ("-bm", 0, 1),
    ("-imfchan", 1, 1),
    ("-type", 1, 1),
    ("-cc", 1, 1),
    ("-colorspace", 1, 1),
];

fn option(word: &str) -> Option<(&'static str, usize, usize)> {
    OPTIONS.into_iter().find(|(name, _, _)| word.eq_ignore_ascii_case(name))
}

/// Splits the first word off.
fn split_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

impl Map {
    /// `None` when no file is named.
    pub(super) fn parse(operands: &str, place: &Origin) -> Option<Self> {
        let mut map = Self {
            file: String::new(),
            place: place.clone(),
            offset: [0.0; 2],
            scale: [1.0; 2],
            strength: 1.0,
            clamp: false,
            channel: None,
            range: [0.0, 1.0],
        };
        let mut rest = map.options(operands);
        // The name runs to the end, or to options behind it.
        let mut at = 0;
        while let Some((word, _)) = rest.get(at..).and_then(split_word) {
            let start = rest.get(at..)?.find(word)? + at;
            if start > 0 && option(word).is_some() {
                let (name, options) = rest.split_at(start);
                map.options(options);
                rest = name;
                break;
            }
            at = start + word.len();
        }
        map.file = rest.trim().trim_matches('"').to_owned();
        (!map.file.is_empty()).then_some(map)
    }

    /// Reads the options in front of `text` and gives what follows them.
    fn options<'a>(&mut self, mut text: &'a str) -> &'a str {
        while let Some((word, mut rest)) = split_word(text) {
            let Some((name, least, most)) = option(word) else { break };
            let mut operands: Vec<&str> = Vec::new();
            while operands.len() < most
                && let Some((operand, after)) = split_word(rest)
                && (operands.len() < least || value(operand.as_bytes()).is_some())
            {
                operands.push(operand);
                rest = after;
            }
            self.apply(name, &operands);
            text = rest;
        }
        text
    }

    fn apply(&mut self, name: &str, operands: &[&str]) {
        let number = |i: usize| operands.get(i).and_then(|o| value(o.as_bytes())).map(|x| x as f32);
        match name {
            "-o" => self.offset = [number(0).unwrap_or(0.0), number(1).unwrap_or(0.0)],
            "-s" => self.scale = [number(0).unwrap_or(1.0), number(1).unwrap_or(1.0)],
            "-bm" => self.strength = number(0).unwrap_or(1.0),
            "-mm" => self.range = [number(0).unwrap_or(0.0), number(1).unwrap_or(1.0)],
            "-clamp" => self.clamp = operands.first().is_some_and(|o| o.eq_ignore_ascii_case("on")),
            "-imfchan" => {
                self.channel = match operands.first().map(|o| o.to_ascii_lowercase()).as_deref() {
                    Some("r" | "l") => Some(Channel::R),
                    Some("g") => Some(Channel::G),
                    Some("b") => Some(Channel::B),
                    Some("m") => Some(Channel::A),
                    _ => None,
                }
            }
            _ => {}
        }
    }

    /// `-o` and `-s` for coordinates with v downwards.
    ///
    /// MTL means `t' = s·t + o` with v upwards; with v = 1 − t that is `v' = s·v + (1 − s − o)`.
    pub(super) fn transform(&self) -> UvTransform {
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        if (su, sv, ou, ov) == (1.0, 1.0, 0.0, 0.0) {
            return UvTransform::IDENTITY;
        }
        UvTransform { linear: [[su, 0.0], [0.0, sv]], offset: [ou, 1.0 - sv - ov] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(operands: &str) -> Map {
        Map::parse(operands, &Origin::default()).unwrap()
    }

    #[test]
    fn names_are_found_among_options() {
        let cases = [
            (" a.png", "a.png"),
            ("\tmy  file 01.png \r", "my  file 01.png"),
            ("-s 1 2 3 -o 0.1 my file.png", "my file.png"),
            ("-s 0.5 file.png", "file.png"),
            ("-bm 0.2 \"quoted name.png\"", "quoted name.png"),
            ("-imfchan r bump map.jpg -bm 1.5", "bump map.jpg"),
            ("-blendu on -blendv off -mm 0.1 0.3 -type cube_top -texres 64 x.jpg", "x.jpg"),
            ("-clamp on C:\\a b\\c.png", "C:\\a b\\c.png"),
            ("wood -old.png", "wood -old.png"),
        ];
        for (operands, file) in cases {
            assert_eq!(parse(operands).file, file, "{operands}");
        }
        assert_eq!(Map::parse("-s 1 1 1", &Origin::default()), None);
        assert_eq!(Map::parse("  ", &Origin::default()), None);
        let map = parse("-imfchan g bump map.jpg -bm 1.5 -clamp on");
        assert_eq!((map.channel, map.strength, map.clamp), (Some(Channel::G), 1.5, true));
    }

    #[test]
    fn the_transform_is_that_of_mtl_turned_upside_down() {
        let map = parse("-s 2 3 1 -o 0.25 0.125 x.png");
        for [u, t] in [[0.0_f32, 0.0_f32], [0.5, 0.75], [1.0, 2.0]] {
            let want = [2.0 * u + 0.25, 1.0 - (3.0 * t + 0.125)];
            let got = map.transform().apply([u, 1.0 - t]);
            assert!((got[0] - want[0]).abs() < 1e-6 && (got[1] - want[1]).abs() < 1e-6, "{got:?} {want:?}");
        }
        assert_eq!(parse("x.png").transform(), UvTransform::IDENTITY);
    }
}
