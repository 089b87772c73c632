//! A `.ray` scene against the picture that a course's GPU path tracer made of it.

use crate::common::shared;
use kiln::formats::{Control, ImportOptions, import};
use kiln::integrate::render;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{PrepareSettings, RenderSettings, ViewSettings};
use std::fs::File;
use std::path::Path;

/// Side of our picture; the reference's is a multiple.
const SIZE: usize = 128;
/// Patches along a side.
const PATCHES: usize = 16;

/// Means of square patches, of 8-bit levels as the reference has them: linear, clamped, cut to integers. Row by row
/// from the top.
fn patches(size: usize, level: impl Fn(usize, usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let side = size / PATCHES;
    let mean = |k: usize| {
        let (x0, y0) = (k % PATCHES * side, k / PATCHES * side);
        let mut sum = [0.0; 3];
        for i in 0..side * side {
            let rgb = level(x0 + i % side, y0 + i / side);
            (0..3).for_each(|c| sum[c] += rgb[c] / (side * side) as f64);
        }
        sum
    };
    (0..PATCHES * PATCHES).map(mean).collect()
}

fn reference(path: &Path) -> Vec<[f64; 3]> {
    let decoder = png::Decoder::new(std::io::BufReader::new(File::open(path).expect("a picture")));
    let mut reader = decoder.read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG file");
    assert_eq!((info.width, info.height, info.color_type), (512, 512, png::ColorType::Rgb));
    patches(512, |x, y| std::array::from_fn(|c| f64::from(bytes[3 * (y * 512 + x) + c])))
}

fn ours(shared: &Path, bounces: u32) -> Vec<[f64; 3]> {
    let control = Control::default();
    let path = shared.join("scenes/ray/pathtrace/cornell-box.ray");
    let scene = import(&path, &ImportOptions::default(), &control).expect("a readable scene").scene;
    let views = ViewSettings { width: SIZE as u32, height: SIZE as u32, ..ViewSettings::default() };
    let view = kiln::batch::plan_views(&scene, &views, true).expect("a camera").remove(0);
    let prepared =
        prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &control).expect("not stopped");
    let settings = RenderSettings { spp: 64, seed: 3, max_depth: bounces, ..RenderSettings::default() };
    let rendered = render(&prepared, &view, &settings, &control).expect("not stopped");
    assert_eq!(rendered.nonfinite, 0);
    let pixels = rendered.picture.pixels;
    // Truncation takes half a level on average.
    patches(SIZE, |x, y| {
        std::array::from_fn(|c| (f64::from(pixels[y * SIZE + x][c]).clamp(0.0, 1.0) * 255.0 - 0.5).max(0.0))
    })
}

/// Our mean over the reference's in each channel, and the share of patches within `tolerance` of it or two levels.
fn compare(shared: &Path, name: &str, bounces: u32, tolerance: f64) -> ([f64; 3], f64) {
    let theirs = reference(&shared.join(format!("scenes/ray/references/pathtrace/{name}")));
    let ours = ours(shared, bounces);
    let sum = |p: &[[f64; 3]], c: usize| p.iter().map(|p| p[c]).sum::<f64>();
    let close = |(a, b): &(&[f64; 3], &[f64; 3])| (0..3).all(|c| (a[c] - b[c]).abs() < (tolerance * b[c]).max(2.0));
    let share = ours.iter().zip(&theirs).filter(close).count() as f64 / ours.len() as f64;
    let means = std::array::from_fn(|c| sum(&ours, c) / sum(&theirs, c));
    println!("{name} with {bounces} bounces: means {means:.4?} of theirs, {:.1} % of the patches close", 100.0 * share);
    (means, share)
}

#[test]
fn pathtrace_cornell_box_is_that_of_another_renderer() {
    let Some(shared) = shared("the pathtrace Cornell box") else { return };
    for (name, bounces) in [("cornell-box.ray_3_3072_gpu.png", 3), ("cornell-box.ray_5_3072_gpu.png", 5)] {
        let (means, share) = compare(&shared, name, bounces, 0.05);
        assert!(means.iter().all(|m| (m - 1.0).abs() < 0.03), "{name}: {means:?}");
        assert!(share > 0.9, "{name}: {share}");
        // One bounce more or less is told apart.
        let (means, _) = compare(&shared, name, bounces - 1, 0.05);
        assert!(means.iter().any(|m| (m - 1.0).abs() > 0.03), "{name}: {means:?}");
    }
}
