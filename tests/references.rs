//! Bench scenes against converged pictures by two other renderers.
//!
//! Pictures and some scenes lie in the folder that `KILN_SHARED` names; without it these tests say so and pass, unless
//! `KILN_REQUIRE_SHARED` is set.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::shared;
use exr::prelude::read_first_rgba_layer_from_file;
use kiln::formats::{Control, ImportOptions, import};
use kiln::integrate::{Rendered, render};
use kiln::math::statistics;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{EnvironmentSettings, PrepareSettings, RenderSettings, ViewSettings};
use std::path::Path;

/// Side of the blocks whose means are compared.
const BLOCK: usize = 8;

struct Reference {
    /// Row by row from the top.
    pixels: Vec<[f64; 3]>,
    width: usize,
    /// Mean over pixels and channels of variance / (value² + ε), and ε.
    noise: f64,
    epsilon: f64,
}

fn read_reference(shared: &Path, name: &str) -> Reference {
    let path = shared.join(format!("references/{name}"));
    let facts: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path.with_extension("json")).expect("facts")).expect("JSON");
    let image = read_first_rgba_layer_from_file(
        &path,
        |size, _| (vec![[0f64; 3]; size.area()], size.width()),
        |(pixels, width), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * *width + at.x()] = [r, g, b].map(f64::from);
        },
    )
    .expect("a readable reference");
    let (pixels, width) = image.layer_data.channel_data.pixels;
    let number = |key: &str| facts[key].as_f64().expect("a number");
    Reference { pixels, width, noise: number("noise_relmse"), epsilon: number("relmse_eps") }
}

fn shoot(shared: &Path, name: &str, spp: u32) -> Rendered {
    let bench = shared.join("scenes/bench");
    let json = bench.join(format!("{name}.json"));
    let file = kiln::batch::ViewFile::read(&json).expect("a view file");
    let facts: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&json).expect("text")).expect("JSON");
    let asset = match std::env::var_os("KILN_LARGE_MESH") {
        Some(path) if name == "large_mesh" => path.into(),
        _ => bench.join(facts["file"].as_str().expect("a file name")),
    };
    let control = Control::default();
    let options = ImportOptions { root: Some(shared.to_path_buf()), ..ImportOptions::default() };
    let options = if name == "large_mesh" { ImportOptions::default() } else { options };
    let scene = import(&asset, &options, &control).expect("a readable scene").scene;
    let environment = match &file.environment {
        EnvironmentSettings::Constant(radiance) => EnvironmentSource::Constant(*radiance),
        EnvironmentSettings::File(f) => {
            let bytes = std::fs::read(&f.path).expect("an environment");
            let image = kiln::formats::images::decode(&bytes, "environment.hdr", 1 << 24).expect("a picture");
            EnvironmentSource::Image { image, rotation_y: 0.0, intensity: f.intensity as f32 }
        }
        _ => EnvironmentSource::None,
    };
    let (Some(width), Some(height)) = file.size else { panic!("a size") };
    let views = ViewSettings { width, height, fixed: Some(file.view), ..ViewSettings::default() };
    let view = kiln::batch::plan_views(&scene, &views, true).expect("a camera").remove(0);
    let prepared = prepare(scene, &environment, &PrepareSettings::default(), &control).expect("not stopped");
    let settings =
        RenderSettings { spp, seed: 11, max_depth: file.max_depth.expect("a depth"), ..RenderSettings::default() };
    render(&prepared, &view, &settings, &control).expect("not stopped")
}

/// Our mean and variance of the mean, of every pixel and channel.
fn estimates(rendered: &Rendered) -> Vec<[(f64, f64); 3]> {
    let pixel = |p: &kiln::film::PixelSums| {
        let (mean, variance) = (p.mean(), p.variance());
        std::array::from_fn(|c| (mean[c], variance[c]))
    };
    rendered.film.pixels.iter().map(pixel).collect()
}

/// What a comparison finds.
struct Comparison {
    /// Our mean radiance over the reference's, minus 1.
    mean_difference: f64,
    /// Standard error of that.
    mean_error: f64,
    /// The largest |z| of a block's mean, and the limit for it.
    worst_block: f64,
    limit: f64,
    /// relMSE against the reference, its noise subtracted.
    relmse: f64,
}

/// Sums over the pixels of a block.
#[derive(Clone, Copy, Default)]
struct BlockMean {
    difference: f64,
    variance: f64,
    /// Sum of the squares of the pixels' variances.
    squares: f64,
    level: f64,
    size: f64,
}

/// |z| of block `i / 3`, channel `i % 3`: that which is as improbable as the block's t.
///
/// Where rare paths carry much of the light (caustics), a block that happens to miss them has a mean that is too low
/// and, for the same reason, an estimate of its variance that is too low. So the variance is the larger one of the block's
/// own and the mean over the 5×5 blocks around it.
fn z_of(tests: &[BlockMean], i: usize, across: usize, down: usize) -> f64 {
    let (block, channel) = (i / 3, i % 3);
    let (x, y) = (block % across, block / across);
    let (mut pooled, mut squares, mut count) = (0.0, 0.0, 0.0);
    for v in y.saturating_sub(2)..(y + 3).min(down) {
        for u in x.saturating_sub(2)..(x + 3).min(across) {
            let near = &tests[3 * (v * across + u) + channel];
            pooled += near.variance;
            squares += near.squares;
            count += 1.0;
        }
    }
    let test = &tests[i];
    let size = f64::max(test.size, 1.0);
    // Where nothing varies (a lamp seen directly) both are exact to the precision of float pictures.
    let rounding = 1e-5 * test.level / size;
    let error = test.variance.max(pooled / count).sqrt() / size;
    let t = test.difference / size / error.max(rounding).max(1e-12);
    // Two replicates say as much of a pixel's variance as one number can (Satterthwaite 1946).
    let own = test.variance > pooled / count;
    let degrees = if own { test.variance.powi(2) / test.squares } else { pooled.powi(2) / squares };
    let degrees = if degrees.is_finite() { degrees } else { 1e5 };
    -statistics::normal_quantile(0.5 * statistics::student_t_two_sided(t, degrees))
}

/// `trim` leaves out that share of the pixels, those with the largest difference.
fn compare(ours: &Rendered, reference: &Reference, trim: f64) -> Comparison {
    let ours = estimates(ours);
    let (width, height) = (reference.width, reference.pixels.len() / reference.width);
    assert_eq!(ours.len(), reference.pixels.len());
    let relative = |p: usize, c: usize, x: f64| x / (reference.pixels[p][c].powi(2) + reference.epsilon);
    let n = (3 * ours.len()) as f64;
    let all = || (0..ours.len()).flat_map(|p| (0..3).map(move |c| (p, c)));
    let error = |p: usize, c: usize| relative(p, c, (ours[p][c].0 - reference.pixels[p][c]).powi(2));
    let own_noise: f64 = all().map(|(p, c)| relative(p, c, ours[p][c].1)).sum::<f64>() / n;
    let relmse = all().map(|(p, c)| error(p, c)).sum::<f64>() / n - reference.noise;
    // The reference's noise is known for the picture as a whole; it is taken to be distributed as ours.
    let variance_factor = 1.0 + reference.noise / own_noise.max(1e-12);
    let mut order: Vec<usize> = (0..ours.len()).collect();
    let pixel_error = |p: &usize| (0..3).map(|c| error(*p, c)).sum::<f64>();
    order.sort_by(|a, b| pixel_error(b).total_cmp(&pixel_error(a)));
    let mut kept = vec![true; ours.len()];
    order[..(trim * ours.len() as f64) as usize].iter().for_each(|p| kept[*p] = false);
    let across = width / BLOCK;
    let blocks = across * (height / BLOCK);
    let limit = statistics::normal_quantile(1.0 - statistics::sidak(1e-3, 3 * blocks) / 2.0);
    let tests: Vec<BlockMean> = (0..blocks)
        .flat_map(|block| (0..3).map(move |c| (block, c)))
        .map(|(block, c)| {
            let (x0, y0) = (block % across * BLOCK, block / across * BLOCK);
            let pixels = (0..BLOCK * BLOCK).map(|k| (y0 + k / BLOCK) * width + x0 + k % BLOCK).filter(|p| kept[*p]);
            let mut mean = BlockMean::default();
            for p in pixels {
                mean.difference += ours[p][c].0 - reference.pixels[p][c];
                mean.variance += ours[p][c].1 * variance_factor;
                mean.squares += (ours[p][c].1 * variance_factor).powi(2);
                mean.level += reference.pixels[p][c];
                mean.size += 1.0;
            }
            mean
        })
        .collect();
    let worst_block = (0..tests.len()).map(|i| z_of(&tests, i, across, blocks / across)).fold(0.0, f64::max);
    let reference_mean = all().map(|(p, c)| reference.pixels[p][c]).sum::<f64>() / n;
    let own_mean = all().map(|(p, c)| ours[p][c].0).sum::<f64>() / n;
    let mean_variance = all().map(|(p, c)| ours[p][c].1).sum::<f64>() * variance_factor / n / n;
    Comparison {
        mean_difference: own_mean / reference_mean - 1.0,
        mean_error: mean_variance.sqrt() / reference_mean,
        worst_block,
        limit,
        relmse,
    }
}

/// `offset`: by how much the mean is known to differ, relative, and how far it may be from that.
fn check(scene: &str, references: &[&str], spp: u32, (offset, bound): (f64, f64), blocks: bool, trim: f64) {
    let Some(shared) = shared(&format!("comparison of {scene}")) else { return };
    let rendered = shoot(&shared, scene, spp);
    assert_eq!(rendered.nonfinite, 0);
    for name in references {
        let c = compare(&rendered, &read_reference(&shared, name), trim);
        println!(
            "{scene} against {name}: mean {:+.3} % ± {:.3} %, worst block z {:.2} of {:.2}, relMSE {:.5}, {:.1} CPU s",
            100.0 * c.mean_difference,
            100.0 * c.mean_error,
            c.worst_block,
            c.limit,
            c.relmse,
            rendered.cpu_seconds
        );
        assert!(
            (c.mean_difference - offset).abs() < bound,
            "mean radiance differs from {name} by {}",
            c.mean_difference
        );
        assert!(!blocks || c.worst_block < c.limit, "a block differs from {name} by z = {}", c.worst_block);
    }
}

#[test]
fn cornell() {
    check("cornell", &["cornell.ref.exr"], 256, (0.0, 0.005), true, 0.0);
}

#[test]
fn soft_shadow() {
    check("soft_shadow", &["soft_shadow.ref.exr"], 64, (0.0, 0.005), true, 0.0);
}

#[test]
fn many_lights() {
    check("many_lights", &["many_lights.ref.exr"], 64, (0.0, 0.005), true, 0.0);
}

/// The peers' copper (α 0.16) loses the light that bounces among its microfacets more than once, 2 to 3 % of what it reflects; ours does
/// not, so that blocks that it fills differ by more than noise. The mean is 0.48 % higher for it: by 0.01 % the same with paths aimed at
/// casters, by BSDFs alone, and without roulette (six pictures of 512 samples).
#[test]
fn cornell_glossy() {
    check("cornell_glossy", &["cornell_glossy.ref.exr"], 128, (0.0048, 0.002), false, 0.001);
}

/// The mesh is too large to be stored: `KILN_LARGE_MESH` names what `scenes/bench/gen_large.py terrain1m` wrote.
#[test]
fn large_mesh() {
    if std::env::var_os("KILN_LARGE_MESH").is_none() {
        println!("skipped: KILN_LARGE_MESH is not set");
        assert!(std::env::var_os("KILN_REQUIRE_SHARED").is_none(), "KILN_LARGE_MESH is not set");
        return;
    }
    check("large_mesh", &["large_mesh.ref.exr"], 32, (0.0, 0.005), true, 0.0);
}

/// Both renderers on their own: they differ by 0.16 % in the mean and more around texels' edges.
#[test]
fn studio_lambert() {
    check("studio_lambert", &["studio_lambert.mitsuba.exr", "studio_lambert.cycles.exr"], 32, (0.0, 0.01), false, 0.0);
}

/// The two peers' material models differ by 1.4 % here.
#[test]
fn studio_knot() {
    check("studio_knot", &["studio_knot.mitsuba.exr", "studio_knot.cycles.exr"], 32, (0.0, 0.02), false, 0.0);
}

/// The two peers' material models differ by 0.6 % here.
#[test]
fn studio_helmet() {
    check("studio_helmet", &["studio_helmet.mitsuba.exr", "studio_helmet.cycles.exr"], 32, (0.0, 0.02), false, 0.0);
}

#[test]
fn furnace_is_one() {
    let Some(shared) = shared("the furnace") else { return };
    let rendered = shoot(&shared, "furnace", 16);
    for (i, pixel) in rendered.picture.pixels.iter().enumerate() {
        assert!(pixel[..3].iter().all(|c| (c - 1.0).abs() < 2e-4), "pixel {i}: {pixel:?}");
    }
}
