//! Images of all kinds, whole and damaged.

use super::*;
use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn pixel(x: u32, y: u32) -> [u8; 4] {
    [10 + x as u8, 20 + y as u8, 30, 40 + x as u8]
}

fn picture() -> DynamicImage {
    ImageBuffer::from_fn(3, 2, |x, y| Rgba(pixel(x, y))).into()
}

#[test]
fn lossless_formats_give_their_bytes_row_by_row_from_the_top() {
    let want: Vec<u8> = (0..2).flat_map(|y| (0..3).flat_map(move |x| pixel(x, y))).collect();
    for format in [ImageFormat::Png, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::WebP, ImageFormat::Bmp] {
        let bytes = encode(&picture(), format);
        // The ending is a lie but for TGA, which has no signature.
        let name = if format == ImageFormat::Tga { "a.tga" } else { "a.jpg" };
        let image = decode(&bytes, name, 6).unwrap();
        assert_eq!((image.width, image.height, image.name.as_str()), (3, 2, name));
        let Pixels::Rgba8(got) = image.pixels else { panic!("{format:?}") };
        assert_eq!(got, want, "{format:?}");
        assert_eq!(dimensions(&bytes, name).unwrap(), (3, 2));
    }
}

#[test]
fn depth_and_missing_channels() {
    let grey = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([77_u8])));
    let Pixels::Rgba8(got) = decode(&encode(&grey, ImageFormat::Png), "", 1).unwrap().pixels else { panic!() };
    assert_eq!(got, [77, 77, 77, 255]);
    let deep = DynamicImage::from(ImageBuffer::from_pixel(1, 1, LumaA([1000_u16, 3])));
    let Pixels::Rgba16(got) = decode(&encode(&deep, ImageFormat::Png), "", 1).unwrap().pixels else { panic!() };
    assert_eq!(got, [1000, 1000, 1000, 3]);
    let float = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgb([0.5_f32, 4.0, f32::NAN])));
    let Pixels::RgbaF32(got) = decode(&encode(&float, ImageFormat::Tiff), "", 1).unwrap().pixels else { panic!() };
    assert_eq!(got, [0.5, 4.0, 0.0, 1.0]);
}

#[test]
fn windows_of_an_exr_file_are_not_believed() {
    let sound = encode(&ImageBuffer::from_pixel(4, 4, Rgb([0.5_f32, 4.0, 1.0])).into(), ImageFormat::OpenExr);
    let Pixels::RgbaF32(got) = decode(&sound, "", 16).unwrap().pixels else { panic!() };
    assert_eq!(got[..4], [0.5, 4.0, 1.0, 1.0]);
    for window in ["dataWindow", "displayWindow"] {
        let mut bytes = sound.clone();
        // The name, `box2i`, a size of four bytes; then x and y of the first texel, and of the last one.
        let name = [window.as_bytes(), b"\0box2i\0"].concat();
        let at = bytes.windows(name.len()).position(|w| w == name).expect("the attribute") + name.len() + 4;
        bytes[at + 8..at + 12].copy_from_slice(&30_000_i32.to_le_bytes());
        bytes[at + 12..at + 16].copy_from_slice(&30_000_i32.to_le_bytes());
        let error = decode(&bytes, "a.exr", 1 << 30).expect_err(window);
        assert!(matches!(error.code, ErrorCode::TooLarge | ErrorCode::Invalid), "{window}: {error}");
    }
}

#[test]
fn a_header_alone_allocates_nothing() {
    // A PNG of 1×1 whose header claims 65535 × 65535; the checksum of the header chunk is made right.
    let mut bytes = encode(&ImageBuffer::from_pixel(1, 1, Luma([0_u8])).into(), ImageFormat::Png);
    bytes[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
    let crc = bytes[12..29].iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    });
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    assert_eq!(dimensions(&bytes, "").unwrap(), (65535, 65535));
    assert_eq!(decode(&bytes, "big.png", 1 << 30).unwrap_err().code, ErrorCode::TooLarge);
    assert_eq!(decode(&encode(&picture(), ImageFormat::Png), "", 5).unwrap_err().code, ErrorCode::TooLarge);
}

#[test]
fn what_is_no_image_is_told_from_what_is_a_broken_one() {
    for bytes in [&b""[..], b"BLENDER", b"8BPS\0\x01 a Photoshop file"] {
        assert_eq!(decode(bytes, "a.png", 1 << 20).unwrap_err().code, ErrorCode::Unsupported);
    }
    let sound = encode(&picture(), ImageFormat::Png);
    for length in [9, 20, 40, sound.len() / 2] {
        let error = decode(&sound[..length], "a.png", 1 << 20).unwrap_err();
        assert_eq!((error.code, error.file.as_str()), (ErrorCode::Invalid, "a.png"), "{length}");
    }
}

#[test]
fn damaged_images_give_an_image_or_an_error() {
    let formats = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::Tga,
        ImageFormat::Tiff,
        ImageFormat::WebP,
        ImageFormat::Gif,
        ImageFormat::Bmp,
        ImageFormat::Pnm,
    ];
    let mut state = 12345_u32;
    let mut random = |n: usize| {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        (state >> 8) as usize % n
    };
    for format in formats {
        let rgb = DynamicImage::from(picture().into_rgb8());
        let sound = encode(&if format == ImageFormat::Jpeg { rgb } else { picture() }, format);
        for _ in 0..400 {
            let mut bytes = sound.clone();
            for _ in 0..1 + random(4) {
                let at = random(bytes.len());
                bytes[at] = random(256) as u8;
            }
            bytes.truncate(bytes.len() - random(2) * random(bytes.len()));
            if let Ok(image) = decode(&bytes, "a.tga", 1 << 20) {
                assert!(image.width > 0 && image.height > 0);
            }
        }
    }
}

#[test]
fn a_refused_allocation_is_known_from_other_panics() {
    let panic = |text: String| catch_unwind(move || std::panic::resume_unwind(Box::new(text))).expect_err("a panic");
    // As `image` unwraps it.
    let refused = Vec::<u8>::new().try_reserve_exact(isize::MAX as usize).expect_err("nobody has that");
    assert!(is_refused_allocation(&*panic(format!("input layout: {refused:?}"))), "{refused:?}");
    let overflow = Vec::<u32>::new().try_reserve_exact(usize::MAX).expect_err("more than can be said");
    assert!(!is_refused_allocation(&*panic(format!("{overflow:?}"))), "a file's fault: {overflow:?}");
    assert!(!is_refused_allocation(&*panic("index out of bounds".into())));
    assert!(can_be_had(1 << 16) && !can_be_had(isize::MAX as u64) && !can_be_had(u64::MAX));
}
