//! Pictures of the course tracers, and what their rules give by hand.

use crate::common::shared;
use crate::support::{code, folder, kiln, stderr};
use std::fs::File;
use std::path::Path;

const AS_THE_COURSE: [&str; 6] = ["--integrator", "whitted", "--tonemap", "course", "--spp", "1"];

/// The 8-bit colours of a picture, row by row from the top, and its width.
fn read_png(path: &Path) -> (usize, Vec<[u8; 3]>) {
    let decoder = png::Decoder::new(std::io::BufReader::new(File::open(path).expect("a picture")));
    let mut reader = decoder.read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG file");
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width as usize, bytes.as_chunks::<3>().0.to_vec())
}

fn render(input: &Path, size: &str, folder: &Path) -> (usize, Vec<[u8; 3]>) {
    let input = input.to_string_lossy();
    let arguments = ["render", &input, "-o", "a.png", "--width", size, "--height", size];
    let output = kiln(folder, &[&arguments[..], &AS_THE_COURSE].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    read_png(&folder.join("a.png"))
}

#[test]
fn the_course_solution_is_met_within_one_level() {
    let Some(shared) = shared("the course's reference picture") else { return };
    let folder = tempfile::tempdir().expect("temporary folder");
    let (_, ours) = render(&shared.join("scenes/ray/ut/reflection2.ray"), "512", folder.path());
    let (width, theirs) = read_png(&shared.join("scenes/ray/references/course-solution/reflection2_sol.png"));
    assert_eq!(ours.len(), theirs.len());
    let differ = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|c| a[c].abs_diff(b[c]) > 1);
    let wrong: Vec<_> = ours.iter().zip(&theirs).enumerate().filter(|(_, pair)| differ(*pair)).collect();
    let places: Vec<_> = wrong.iter().map(|(k, pair)| (k % width, k / width, pair)).take(9).collect();
    assert!(wrong.is_empty(), "{} of {} pixels differ by more than a level: {places:?}", wrong.len(), ours.len());
}

/// A wall under a light that shines straight at it, half of it behind a slab of glass.
const WALL: &str = "SBT-raytracer 1.0
camera { position = (0,0,10); viewdir = (0,0,-1); updir = (0,1,0); }
directional_light { direction = (0,0,-1); color = (1,.5,1) }
ambient_light { color = (.25,.25,.25) }
scale(40, square { material = { diffuse = (.5,.5,.5); ambient = (.2,.4,0); } })
translate(5,0,4, scale(8,20,2, box { material = { transmissive = (.5,1,.25); index = 1; } }))";

#[test]
fn walls_ambient_light_and_glass_are_as_the_rules_say() {
    let dir = folder(&[("wall.ray", WALL)]);
    let (width, pixels) = render(&dir.path().join("wall.ray"), "16", dir.path());
    let at = |x: usize| pixels[8 * width + x];
    // k_d · colour + k_a · I_a.
    let wall = [0.5 + 0.05, 0.25 + 0.1, 0.5];
    // Light loses k_t for each unit of glass: two straight on, and a little more on the slanting way to the eye.
    let slanting = 2.0 * (1.0_f64 + 0.3125 * 0.3125 + 0.0625 * 0.0625).sqrt();
    let seen = |k_t: f64, ambient: f64| (0.5 * k_t.powi(2) + ambient) * k_t.powf(slanting);
    let behind = [seen(0.5, 0.05), 0.35, seen(0.25, 0.0)];
    for (x, want) in [(3, wall), (13, behind)] {
        let near = (0..3).all(|c| (f64::from(at(x)[c]) + 0.5 - 255.0 * want[c]).abs() <= 1.0);
        assert!(near, "at {x}: {:?} for {want:?}", at(x));
    }
}

/// A mirror that leans by 45° shows a ball which glows, and a white lamp in the highlight of a ball.
const MIRROR: &str = "SBT-raytracer 1.0
camera { position = (0,0,10); viewdir = (0,0,-1); updir = (0,1,0); }
rotate(0,1,0,0.7853981633974483, scale(4, square { material = { reflective = (.5,.25,1) } }))
translate(20,0,0, scale(3, sphere { material = { emissive = (.5,.5,.5) } }))";

#[test]
fn mirrors_weigh_what_they_show_and_depth_ends() {
    let dir = folder(&[("mirror.ray", MIRROR)]);
    let (width, pixels) = render(&dir.path().join("mirror.ray"), "16", dir.path());
    let middle = pixels[8 * width + 8];
    assert!(
        [63.75, 31.875, 127.5].iter().zip(middle).all(|(w, g)| (f64::from(g) + 0.5 - w).abs() <= 1.0),
        "{middle:?}"
    );
    let arguments = ["render", "mirror.ray", "-o", "flat.png", "--width", "16", "--max-depth", "0"];
    assert_eq!(code(&kiln(dir.path(), &[&arguments[..], &AS_THE_COURSE].concat())), 0);
    assert_eq!(read_png(&dir.path().join("flat.png")).1[8 * width + 8], [0; 3]);
}

/// What both integrators make of a scene, as the pixels of a row through its middle.
fn rows(dir: &Path, scene: &str, more: &[&str]) -> [Vec<[u8; 3]>; 2] {
    ["whitted", "path"].map(|integrator| {
        let fixed = ["render", scene, "-o", "a.png", "--width", "16", "--tonemap", "course", "--spp", "4"];
        let output = kiln(dir, &[&fixed[..], &["--integrator", integrator], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let (width, pixels) = read_png(&dir.join("a.png"));
        pixels[8 * width..9 * width].to_vec()
    })
}

fn near(pixel: [u8; 3], want: [f64; 3]) -> bool {
    (0..3).all(|c| (f64::from(pixel[c]) + 0.5 - 255.0 * want[c]).abs() <= 1.0)
}

#[test]
fn glass_can_count_its_surfaces_instead_of_its_length() {
    let dir = folder(&[("wall.ray", &WALL.replace("ambient_light { color = (.25,.25,.25) }", ""))]);
    // Two surfaces on the way of the light, two on the way to the eye.
    let behind = [0.5 * 0.5_f64.powi(4), 0.25, 0.5 * 0.25_f64.powi(4)];
    for row in rows(dir.path(), "wall.ray", &["--ray-dialect", "hk"]) {
        assert!(near(row[3], [0.5, 0.25, 0.5]) && near(row[13], behind), "{row:?}");
    }
}

#[test]
fn bumps_turn_what_faces_the_light() {
    let scene = "SBT-raytracer 1.0
        camera { position = (0,0,10); viewdir = (0,0,-1); updir = (0,1,0); }
        directional_light { direction = (0,0,-1); color = (1,1,1) }
        scale(20, square { material = { diffuse = (.5,.25,1) } normal_map = \"leaning.png\" })";
    let dir = folder(&[("bumps.ray", scene)]);
    let file = File::create(dir.path().join("leaning.png")).expect("a file");
    let mut encoder = png::Encoder::new(file, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    // (0.6, 0, 0.8)
    encoder.write_header().and_then(|mut w| w.write_image_data(&[204, 128, 230])).expect("a picture");
    for row in rows(dir.path(), "bumps.ray", &[]) {
        assert!(near(row[8], [0.4, 0.2, 0.8]), "{row:?}");
    }
}
