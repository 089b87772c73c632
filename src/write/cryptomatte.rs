//! Cryptomatte, version 1.2 (Friedman & Jones, 2018; Psyop): mattes of things by name in channels that compositors know.

use crate::film::{Identity, RANKS};
use serde_json::{Map, Value};

/// The channels and header attributes of one set of mattes.
pub struct Mattes {
    /// Channel names with their values: for two ranks each red, green, blue, alpha: identifier, coverage, identifier, coverage.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Attribute names with their texts.
    pub attributes: Vec<(String, String)>,
}

/// The mattes of a set such as `CryptoObject`.
pub fn mattes(set: &str, things: &Identity) -> Mattes {
    let ids: Vec<f32> = things.names.iter().map(|name| f32::from_bits(identifier(name))).collect();
    let id = |(thing, coverage): (u32, f32)| if coverage > 0.0 { ids[thing as usize] } else { 0.0 };
    let mut channels = Vec::new();
    for rank in 0..RANKS {
        let names = if rank % 2 == 0 { ["R", "G"] } else { ["B", "A"] };
        let [identifier, coverage] = names.map(|channel| format!("{set}{:02}.{channel}", rank / 2));
        channels.push((identifier, things.ranks.iter().map(|ranks| id(ranks[rank])).collect()));
        channels.push((coverage, things.ranks.iter().map(|ranks| ranks[rank].1).collect()));
    }
    let hex = |name: &str| Value::String(format!("{:08x}", identifier(name)));
    let manifest: Map<String, Value> = things.names.iter().map(|name| (name.clone(), hex(name))).collect();
    // The set's key: the first seven digits of its name's hash.
    let key = &format!("{:08x}", murmur3(set.as_bytes()))[..7];
    let attribute = |name: &str, value: &str| (format!("cryptomatte/{key}/{name}"), value.to_owned());
    let attributes = vec![
        attribute("name", set),
        attribute("hash", "MurmurHash3_32"),
        attribute("conversion", "uint32_to_float32"),
        attribute("manifest", &Value::Object(manifest).to_string()),
    ];
    Mattes { channels, attributes }
}

/// The hash of a name, with an exponent that makes it a finite, normal float.
fn identifier(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    if matches!(hash >> 23 & 255, 0 | 255) { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3_x86_32 (Appleby 2011) with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0u32, |hash, block| {
        (hash ^ scramble(u32::from_le_bytes(*block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let last = tail.iter().rev().fold(0u32, |word, byte| word << 8 | u32::from(*byte));
    hash ^= scramble(last);
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_reference() {
        // smhasher's MurmurHash3_x86_32 with seed 0.
        let known: [(&str, u32); 5] = [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
            ("19 Jan 2038 at 3:14:07 AM", 0xe31e_8a70),
        ];
        for (text, hash) in known {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn identifiers_are_normal_floats() {
        assert!((0..5000).all(|k| f32::from_bits(identifier(&format!("thing {k}"))).is_normal()));
    }

    #[test]
    fn ranks_go_into_pairs_of_channels() {
        let mut things = Identity::new("object", ["bunny", "floor"].into_iter(), 1);
        things.ranks[0][..2].copy_from_slice(&[(1, 0.75), (0, 0.25)]);
        let mattes = mattes("CryptoObject", &things);
        let value = |name: &str| mattes.channels.iter().find(|(n, _)| n == name).expect(name).1[0];
        assert_eq!(value("CryptoObject00.R").to_bits(), identifier("floor"));
        assert_eq!((value("CryptoObject00.G"), value("CryptoObject00.A")), (0.75, 0.25));
        assert_eq!(value("CryptoObject00.B").to_bits(), identifier("bunny"));
        assert_eq!((value("CryptoObject01.R"), value("CryptoObject02.A")), (0.0, 0.0));
        let manifest: Value = serde_json::from_str(&mattes.attributes[3].1).expect("JSON");
        assert_eq!(manifest["bunny"], format!("{:08x}", identifier("bunny")));
    }
}
