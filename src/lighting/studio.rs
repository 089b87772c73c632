use kiln_formats::scene::{Image, Pixels};

/// A soft light box: centre (azimuth and elevation in degrees; azimuth 0 is +Z, 90 is +X), half widths, radiance.
struct SoftBox {
    azimuth: f32,
    elevation: f32,
    half_width: f32,
    half_height: f32,
    radiance: [f32; 3],
}

/// Key from the front left above, fill from the right, rim from behind. The default camera looks from the front right.
const BOXES: [SoftBox; 4] = [
    SoftBox { azimuth: -38.0, elevation: 46.0, half_width: 26.0, half_height: 20.0, radiance: [6.2, 5.95, 5.6] },
    SoftBox { azimuth: 78.0, elevation: 22.0, half_width: 20.0, half_height: 26.0, radiance: [1.5, 1.6, 1.8] },
    SoftBox { azimuth: -158.0, elevation: 34.0, half_width: 34.0, half_height: 10.0, radiance: [4.2, 4.3, 4.6] },
    SoftBox { azimuth: 152.0, elevation: 58.0, half_width: 16.0, half_height: 10.0, radiance: [3.0, 3.0, 3.0] },
];

fn smoothstep(lo: f32, hi: f32, x: f32) -> f32 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The default studio as an equirectangular picture (u = 0.5 + atan2(z, x)/2π, v from the zenith).
pub(super) fn picture() -> Image {
    let (width, height) = (256u32, 128u32);
    let mut pixels = Vec::with_capacity(4 * (width * height) as usize);
    for y in 0..height {
        let elevation = 90.0 - (y as f32 + 0.5) / height as f32 * 180.0;
        for x in 0..width {
            let phi = ((x as f32 + 0.5) / width as f32 - 0.5) * 360.0;
            let azimuth = 90.0 - phi;
            let sky = smoothstep(-50.0, 80.0, elevation);
            let mut c = [0.30 + 0.42 * sky, 0.31 + 0.43 * sky, 0.33 + 0.46 * sky];
            for b in &BOXES {
                let turn = (azimuth - b.azimuth + 540.0).rem_euclid(360.0) - 180.0;
                let dx = turn.abs() * libm::cosf(b.elevation.to_radians()) / b.half_width;
                let dy = (elevation - b.elevation).abs() / b.half_height;
                let inside = (1.0 - smoothstep(0.75, 1.0, dx)) * (1.0 - smoothstep(0.75, 1.0, dy));
                (0..3).for_each(|k| c[k] += inside * b.radiance[k]);
            }
            pixels.extend([c[0], c[1], c[2], 1.0]);
        }
    }
    Image { name: "studio".into(), width, height, pixels: Pixels::RgbaF32(pixels) }
}
