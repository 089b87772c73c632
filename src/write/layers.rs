//! Channels and attributes of an EXR file beside the picture's own.

use super::cryptomatte::mattes;
use crate::film::Surfaces;
use crate::settings::Layer;
use ::exr::meta::attribute::AttributeValue;
use ::exr::prelude::{AnyChannel, FlatSamples, SmallVec, Text};
use std::collections::HashMap;

/// Channels of one part.
pub(super) type Channels = SmallVec<[AnyChannel<FlatSamples>; 4]>;

/// What one part of a file holds.
pub(super) struct Layers {
    pub channels: Channels,
    pub attributes: HashMap<Text, AttributeValue>,
}

impl From<Channels> for Layers {
    fn from(channels: Channels) -> Self {
        Self { channels, attributes: HashMap::new() }
    }
}

impl Layers {
    /// Adds a layer. All are 32-bit floats, which identifiers have to be.
    pub fn add(&mut self, layer: Layer, surfaces: &Surfaces) {
        match layer {
            Layer::Albedo => self.add_three(["albedo.R", "albedo.G", "albedo.B"], &surfaces.albedo),
            Layer::Normal => self.add_three(["normal.X", "normal.Y", "normal.Z"], &surfaces.normal),
            Layer::Depth => self.add_one("depth.Z", surfaces.depth.clone(), true),
            Layer::Object => self.add_mattes("CryptoObject", &surfaces.objects),
            Layer::Material => self.add_mattes("CryptoMaterial", &surfaces.materials),
        }
    }

    /// `linear`: numbers, to which nothing that is meant for light is to be applied.
    fn add_one(&mut self, name: &str, values: Vec<f32>, linear: bool) {
        let mut channel = AnyChannel::new(name, FlatSamples::F32(values));
        channel.quantize_linearly = linear;
        self.channels.push(channel);
    }

    fn add_three(&mut self, names: [&str; 3], values: &[[f32; 3]]) {
        let linear = !names[0].ends_with('R');
        for (c, name) in names.into_iter().enumerate() {
            self.add_one(name, values.iter().map(|v| v[c]).collect(), linear);
        }
    }

    fn add_mattes(&mut self, set: &str, things: &crate::film::Identity) {
        let mattes = mattes(set, things);
        for (name, values) in mattes.channels {
            self.add_one(&name, values, true);
        }
        for (name, text) in mattes.attributes {
            // A text of EXR holds any bytes: UTF-8 as the specification of Cryptomatte asks.
            let text = Text::from_bytes_unchecked(text.into_bytes().into());
            if let Some(name) = Text::new_or_none(name) {
                self.attributes.insert(name, AttributeValue::Text(text));
            }
        }
    }
}

/// Bytes of magic number and version before the first attribute.
const BEFORE_ATTRIBUTES: usize = 8;

/// The same single-part file with the attributes of its header in the order of their names: the crate writes a map in random
/// order, which would vary the bytes. Nothing moves but within the header.
pub(super) fn with_sorted_attributes(mut file: Vec<u8>) -> Vec<u8> {
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = file.get(BEFORE_ATTRIBUTES..).unwrap_or_default();
    let end = |bytes: &[u8], from: usize| bytes.get(from..)?.iter().position(|b| *b == 0).map(|at| from + at + 1);
    while rest.first().is_some_and(|byte| *byte != 0) {
        let length = || {
            let kind = end(rest, 0)?;
            let size = end(rest, kind)?;
            let bytes = rest.get(size..size + 4)?.try_into().ok()?;
            (size + 4).checked_add(u32::from_le_bytes(bytes) as usize).filter(|n| *n <= rest.len())
        };
        let Some(length) = length() else { return file };
        let (attribute, after) = rest.split_at(length);
        attributes.push(attribute);
        rest = after;
    }
    // Names come first in each and end in zero.
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[BEFORE_ATTRIBUTES..BEFORE_ATTRIBUTES + sorted.len()].copy_from_slice(&sorted);
    file
}
