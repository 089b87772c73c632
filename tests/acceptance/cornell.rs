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

/// Whether a patch lies at the lamp or beside it on the ceiling. The lamp hangs a hundredth below the ceiling and lights
/// it through that gap; the other renderer shows nothing of that.
fn is_near_lamp(patch: usize) -> bool {
    (5..=10).contains(&(patch % PATCHES)) && (1..=2).contains(&(patch / PATCHES))
}

/// Away from the lamp: our mean over the reference's in each channel, and the share of the patches that are within 5 %
/// or two levels.
fn compare(theirs: &[[f64; 3]], ours: &[[f64; 3]]) -> ([f64; 3], f64) {
    let kept: Vec<_> = (0..theirs.len()).filter(|k| !is_near_lamp(*k)).collect();
    let sum = |p: &[[f64; 3]], c: usize| kept.iter().map(|k| p[*k][c]).sum::<f64>();
    let close = |k: &&usize| (0..3).all(|c| (ours[**k][c] - theirs[**k][c]).abs() < (0.05 * theirs[**k][c]).max(2.0));
    let share = kept.iter().filter(close).count() as f64 / kept.len() as f64;
    (std::array::from_fn(|c| sum(ours, c) / sum(theirs, c)), share)
}

#[test]
fn pathtrace_cornell_box_is_that_of_another_renderer() {
    let Some(shared) = shared("the pathtrace Cornell box") else { return };
    let compare = |name: &str, bounces: u32| {
        let theirs = reference(&shared.join(format!("scenes/ray/references/pathtrace/{name}")));
        let (means, share) = compare(&theirs, &ours(&shared, bounces));
        println!("{name} with {bounces} bounces: {means:.4?} of its means, {:.1} % of the patches", 100.0 * share);
        (means, share)
    };
    let three = "cornell-box.ray_3_3072_gpu.png";
    // That the second picture has five bounces is known from its name alone.
    for (name, bounces) in [(three, 3), ("cornell-box.ray_5_3072_gpu.png", 5)] {
        let (means, share) = compare(name, bounces);
        assert!(means.iter().all(|m| (m - 1.0).abs() < 0.03), "{name}: {means:?}");
        assert!(share > 0.9, "{name}: {share}");
    }
    // One bounce more or less is another picture.
    for bounces in [2, 4] {
        let (means, share) = compare(three, bounces);
        assert!(means.iter().any(|m| (m - 1.0).abs() > 0.04) && share < 0.6, "{bounces} bounces: {means:?} {share}");
    }
}
