//! Broken bytes: an error or a valid scene, never a panic, never a hang.

use super::read_in;
use kiln_formats::ray::RayOptions;
use kiln_formats::{Control, ErrorCode, Limits, Resources, ray};
use std::time::Instant;

const SEEDS: [&str; 3] = [
    "SBT-raytracer 1.0\ncamera { position=(0,0,4); viewdir=(0,0,-1); updir=(0,1,0); fov=45; aspectratio=1.5 }\n\
     point_light { position=(1,2,3); colour=(1,.5,.2) constant_attenuation_coeff=.25; }\n\
     area_light { position=(0,3,0); color=(1,1,1); light_radius=.5; }\n/* c */ ambient_light { color=(.1,.1,.1); }\n\
     material = { diffuse=(.5,.4,.3); name=\"m\"; }\ntranslate(1,0,-2, scale(2,1,1, rotate(0,1,0,1.5, box {})));\n\
     sphere { material = m; }",
    "SBT-raytracer 1.0\npolymesh { name=\"p\"; points=((0,0,0),(1,0,0),(1,1,0),(0,1,0)); faces=((0,1,2),(0,2,3),(0,1,2,3));\n\
     normals=((0,0,1),(0,0,1),(0,1,1),(0,0,1)); texture_uv=((0,0),(1,0),(1,1),(0,1)); gennormals;\n\
     materials=({diffuse=(1,0,0)},{specular=(0,1,0);shininess=20},{emissive=(1,1,1)},{}); }",
    "SBT-raytracer 1.0\n{ cone { height=2; bottom_radius=.5; top_radius=1e-1; capped=false; }\n\
     transform((1,0,0,1),(0,1,0,2),(0,0,-1,3),(0,0,0,1), { cylinder {} square { material={ index=1.5 \
     transmissive=(1,1,.9); shininess=128 } } }) } directional_light { direction=(0,-1,-1); color=(1,1,1); }",
];

/// Fragments that reach deeper than single bytes do.
const FRAGMENTS: [&str; 16] = [
    "{",
    "}",
    "(",
    ")",
    ",",
    ";",
    "=",
    "\"",
    "/*",
    "-",
    "1e38",
    "1e-320",
    "-1",
    "0",
    "material={diffuse=map(\"x\")}",
    "sphere{}",
];

/// xorshift64 (Marsaglia 2003), so that failures can be repeated.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n
    }
}

fn mutate(text: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(3) {
        let at = random.below(text.len().max(1)).min(text.len());
        let to = (at + random.below(24)).min(text.len());
        match random.below(16) {
            0 => text.truncate(at),
            1 => drop(text.drain(at..to)),
            2 => drop(text.splice(at..at, FRAGMENTS[random.below(FRAGMENTS.len())].bytes())),
            3 => {
                let piece = text[at..to].to_vec();
                let there = random.below(text.len() + 1);
                drop(text.splice(there..there, piece));
            }
            4 => text[at..to].iter_mut().take(1).for_each(|byte| *byte = random.below(256) as u8),
            // Another number often leaves the grammar intact.
            _ => {
                if let Some(digit) = text[at..].iter_mut().find(|byte| byte.is_ascii_digit()) {
                    *digit = b"0123456789.-e"[random.below(13)];
                }
            }
        }
    }
}

#[test]
fn mutated_scenes_give_an_error_or_a_valid_scene() {
    let folder = std::env::temp_dir();
    let mut random = Random(0x5EED);
    let (mut read, mut refused) = (0, 0);
    let begin = Instant::now();
    for seed in SEEDS {
        assert!(read_in(&folder, seed.as_bytes(), Limits::default()).is_ok(), "{seed}");
        for _ in 0..4000 {
            let mut text = seed.as_bytes().to_vec();
            mutate(&mut text, &mut random);
            // `read_in` validates what it gives.
            match read_in(&folder, &text, Limits::default()) {
                Ok(_) => read += 1,
                Err(error) => {
                    assert_ne!(error.code, ErrorCode::Internal, "{error}");
                    assert!(!error.message.is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(read > 500 && refused > 500, "{read} read, {refused} refused: the mutations are too tame or too wild");
    assert!(begin.elapsed().as_secs() < 60, "12000 small scenes took {:?}", begin.elapsed());
}

#[test]
fn every_cut_of_a_scene_is_refused_or_valid() {
    for seed in SEEDS {
        for length in 0..seed.len() {
            let _ = read_in(&std::env::temp_dir(), &seed.as_bytes()[..length], Limits::default());
        }
    }
}

#[test]
fn limits_hold_before_memory_is_spent() {
    let text = "SBT-raytracer 1.0 sphere {} sphere {} sphere { material={ diffuse=(1,1,1) } }";
    let limits = Limits { max_triangles: 50_000, ..Limits::default() };
    let error = read_in(&std::env::temp_dir(), text.as_bytes(), limits).expect_err("61440 triangles");
    assert_eq!(error.code, ErrorCode::TooLarge);
}

#[test]
fn a_stop_is_obeyed() {
    let control = Control::default();
    control.stop();
    let mut resources =
        Resources::new(&std::env::temp_dir().join("a.ray"), None, Limits::default()).expect("a temporary folder");
    let text = b"SBT-raytracer 1.0 sphere {}".to_vec();
    let error =
        ray::import(text, &mut resources, RayOptions::default(), &mut Vec::new(), &control).expect_err("stopped");
    assert_eq!(error.code, ErrorCode::Stopped);
}

#[test]
fn a_big_mesh_is_read_in_well_under_a_second() {
    let rows = 400;
    let mut text = String::from("SBT-raytracer 1.0 polymesh { points=(");
    let mut random = Random(7);
    for i in 0..rows * rows {
        let comma = if i == 0 { "" } else { "," };
        text +=
            &format!("{comma}( {}.{:06},{}.5,{:.7} )", i % rows, random.below(1_000_000), i / rows, i as f64 * 1e-5);
    }
    text += "); faces=(";
    for i in 0..rows * (rows - 1) - 1 {
        let comma = if i == 0 { "" } else { "," };
        let (right, below) = (i + 1, i + rows);
        text += &format!("{comma}({i},{right},{below}),({below},{right},{})", below + 1);
    }
    text += "); gennormals; }";
    assert!(text.len() > 10_000_000, "{}", text.len());
    let begin = Instant::now();
    let (scene, _) = read_in(&std::env::temp_dir(), text.as_bytes(), Limits::default()).expect("a mesh");
    println!("{} bytes in {:?}", text.len(), begin.elapsed());
    assert_eq!(scene.triangle_count(), 2 * (rows * (rows - 1) - 1) as u64);
    // Far above what it takes, for busy machines.
    assert!(begin.elapsed().as_secs_f64() < 2.0, "{:?}", begin.elapsed());
}
