//! OpenEXR files: linear Rec. 709 radiance, 32-bit float, premultiplied by the coverage in A.

use super::Metadata;
use super::layers::{self, Layers};
use crate::film::{Noise, Picture, Surfaces};
use crate::settings;
use ::exr::error::Error;
use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::*;
use std::io::Cursor;

/// Encodes a picture as one scan-line part with channels A, B, G, R, compressed without loss (ZIP, 16 lines).
/// The bytes depend on the arguments alone, and not on names or threads.
///
/// # Errors
/// When the picture is too large for the format.
pub fn encode(picture: &Picture, metadata: &Metadata) -> std::result::Result<Vec<u8>, Error> {
    encode_channels(picture, Layers::from(beauty(picture)), metadata)
}

/// As [`encode`], with the layers `variance` (R, G, B, float: of the linear premultiplied pixel; left out where it is not
/// known) and `samples` (one channel, unsigned integers) beside the beauty.
///
/// # Errors
/// As [`encode`].
pub fn encode_with_noise(picture: &Picture, noise: &Noise, metadata: &Metadata) -> std::result::Result<Vec<u8>, Error> {
    encode_with_layers(picture, noise, None, &Surfaces::default(), &[], metadata)
}

/// As [`encode_with_noise`], with the picture without its noise as the layer `denoised` (R, G, B, of the same size and as
/// premultiplied), and with the layers of `wanted` from `surfaces`: `albedo` (R, G, B), `normal` (X, Y, Z), `depth` (Z), and
/// Cryptomattes of objects and materials.
///
/// # Errors
/// As [`encode`].
pub fn encode_with_layers(
    picture: &Picture,
    noise: &Noise,
    denoised: Option<&Picture>,
    surfaces: &Surfaces,
    wanted: &[settings::Layer],
    metadata: &Metadata,
) -> std::result::Result<Vec<u8>, Error> {
    let mut channels = beauty(picture);
    if let Some(variance) = &noise.variance {
        for (c, name) in ["variance.R", "variance.G", "variance.B"].into_iter().enumerate() {
            let values = variance.iter().map(|v| v[c]).collect();
            channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
        }
    }
    for (c, name) in ["denoised.R", "denoised.G", "denoised.B"].into_iter().enumerate() {
        let values = |picture: &Picture| picture.pixels.iter().map(|p| p[c]).collect();
        channels.extend(denoised.map(|picture| AnyChannel::new(name, FlatSamples::F32(values(picture)))));
    }
    // Numbers, not light: nothing is to be applied to them.
    let mut samples = AnyChannel::new("samples", FlatSamples::U32(noise.samples.clone()));
    samples.quantize_linearly = true;
    channels.push(samples);
    let mut all = Layers::from(channels);
    wanted.iter().for_each(|layer| all.add(*layer, surfaces));
    encode_channels(picture, all, metadata)
}

fn beauty(picture: &Picture) -> layers::Channels {
    let channel = |(c, name): (usize, &str)| {
        AnyChannel::new(name, FlatSamples::F32(picture.pixels.iter().map(|p| p[c]).collect()))
    };
    ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect()
}

fn encode_channels(picture: &Picture, layers: Layers, metadata: &Metadata) -> std::result::Result<Vec<u8>, Error> {
    let size = (picture.width as usize, picture.height as usize);
    let attributes = LayerAttributes {
        software_name: Text::new_or_none(&metadata.software),
        // One JSON text: the crate writes a map of attributes in random order, which would vary the bytes.
        comments: serde_json::to_string(metadata).ok().as_deref().and_then(Text::new_or_none),
        other: layers.attributes,
        ..LayerAttributes::default()
    };
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(layers.channels));
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(REC_709);
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes)?;
    Ok(layers::with_sorted_attributes(bytes.into_inner()))
}

/// Primaries and white point (D65) of Rec. 709.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Reads the first layer with R, G and B, and A where there is one, as linear RGBA, row by row from the top.
///
/// # Errors
/// A sentence, when the file is no sound EXR of this kind or claims more than `max_texels` (before they are
/// allocated).
pub fn decode(bytes: &[u8], max_texels: u64) -> std::result::Result<Picture, String> {
    let unsound = |e: Error| format!("is not a sound EXR file: {e}");
    let metadata = MetaData::read_from_buffered(bytes, false).map_err(unsound)?;
    for header in &metadata.headers {
        let texels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        if texels > max_texels {
            return Err(format!("claims {texels} texels, more than the limit of {max_texels}"));
        }
    }
    let create = |size: Vec2<usize>, _: &RgbaChannels| Picture {
        width: u32::try_from(size.width()).unwrap_or(0),
        height: u32::try_from(size.height()).unwrap_or(0),
        pixels: vec![[0.0, 0.0, 0.0, 1.0]; size.area()],
    };
    let set = |picture: &mut Picture, at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
        if let Some(pixel) = picture.pixels.get_mut(at.y() * picture.width as usize + at.x()) {
            *pixel = [r, g, b, a];
        }
    };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(create, set)
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(unsound)?;
    Ok(image.layer_data.channel_data.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metadata(source: &str) -> Metadata {
        Metadata {
            software: Metadata::software(),
            source: source.into(),
            content: "blake3:00".into(),
            settings: "blake3:11".into(),
            seed: 7,
            spp: 64,
            view: 3,
            stated: None,
            denoised: None,
        }
    }

    fn picture() -> Picture {
        let pixel = |i: u32| [i as f32 * 0.37, 1e-8 * i as f32, 1e8 / (1.0 + i as f32), (i % 5) as f32 / 4.0];
        Picture { width: 37, height: 29, pixels: (0..37 * 29).map(pixel).collect() }
    }

    #[test]
    fn every_float_survives_the_round_trip() {
        let bytes = encode(&picture(), &metadata("a.glb")).expect("a small picture");
        assert_eq!(decode(&bytes, 1 << 20).expect("our own file"), picture());
        assert!(decode(&bytes, 37 * 29 - 1).expect_err("too large").contains("limit"));
    }

    #[test]
    fn bytes_repeat_and_do_not_know_the_assets_name() {
        let bytes = encode(&picture(), &metadata("a.glb")).expect("a small picture");
        for name in ["a.glb", "b.glb", "é椅"] {
            assert_eq!(bytes, encode(&picture(), &metadata(name)).expect("again"));
        }
    }

    #[test]
    fn the_metadata_is_there() {
        let bytes = encode(&picture(), &metadata("a.glb")).expect("a small picture");
        let header = &MetaData::read_from_buffered(&bytes[..], false).expect("our own file").headers[0];
        assert_eq!(header.shared_attributes.chromaticities, Some(REC_709));
        let comments = header.own_attributes.comments.as_ref().expect("comments").to_string();
        let json: serde_json::Value = serde_json::from_str(&comments).expect("JSON");
        assert_eq!((json["spp"].as_u64(), json["view"].as_u64()), (Some(64), Some(3)));
    }

    #[test]
    fn noise_has_layers_of_its_own() {
        let n = 37 * 29;
        let variance: Vec<[f32; 3]> = (0..n).map(|i| [i as f32, 1e-9 * i as f32, 0.5]).collect();
        let noise = Noise { variance: Some(variance.clone()), samples: vec![48; n] };
        let bytes = encode_with_noise(&picture(), &noise, &metadata("a.glb")).expect("a small picture");
        assert_eq!(bytes, encode_with_noise(&picture(), &noise, &metadata("b.glb")).expect("again"));
        assert_eq!(decode(&bytes, 1 << 20).expect("our own file"), picture(), "the beauty is found among the layers");
        let image = read_first_flat_layer_from_buffered(&bytes);
        let channel = |name: &str| {
            let found = image.list.iter().find(|c| c.name.to_string() == name);
            found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.clone()
        };
        assert_eq!(channel("samples"), FlatSamples::U32(noise.samples));
        assert_eq!(channel("variance.G"), FlatSamples::F32(variance.iter().map(|v| v[1]).collect()));
        let unknown = Noise { variance: None, samples: vec![1; n] };
        let bytes = encode_with_noise(&picture(), &unknown, &metadata("a.glb")).expect("a small picture");
        assert_eq!(read_first_flat_layer_from_buffered(&bytes).list.len(), 5);
    }

    fn read_first_flat_layer_from_buffered(bytes: &[u8]) -> AnyChannels<FlatSamples> {
        let reader =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        reader.from_buffered(Cursor::new(bytes)).expect("our own file").layer_data.channel_data
    }

    #[test]
    fn broken_files_are_errors() {
        let bytes = encode(&picture(), &metadata("a.glb")).expect("a small picture");
        for end in [0, 4, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(decode(&bytes[..end], 1 << 20).is_err(), "cut at {end}");
        }
    }
}
