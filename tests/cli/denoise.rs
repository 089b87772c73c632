//! Pictures without noise, as far as the program goes: the denoiser here is a script. The real one is in tests/denoise.

use crate::support::{OBJ, code, files, folder, kiln, manifest, stderr};
use exr::prelude::*;
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Gives back the picture, or the colours of its surfaces, or fails, as its name says.
const SCRIPT: &str = r#"#!/bin/sh
[ "$1" = -h ] && { echo "Open Image Denoise"; exit 1; }
while [ $# -gt 0 ]; do
    case $1 in -hdr) color=$2;; -alb) albedo=$2;; -o) result=$2;; esac
    shift
done
case $0 in
    *colors.sh) cp "$albedo" "$result";;
    *broken.sh) echo "no such weights" >&2; exit 3;;
    *) cp "$color" "$result";;
esac
echo "  device=CPU, version=9.8.7, msec=1"
"#;

fn denoiser(dir: &Path, name: &str) -> String {
    let path = dir.join(format!("{name}.sh"));
    fs::write(&path, SCRIPT).expect("write");
    fs::set_permissions(&path, Permissions::from_mode(0o755)).expect("chmod");
    format!("--denoise={}", path.display())
}

const SMALL: [&str; 4] = ["--width", "16", "--spp", "2"];

fn pixels(path: &Path) -> Vec<u8> {
    let mut reader =
        png::Decoder::new(fs::File::open(path).map(std::io::BufReader::new).expect("a file")).read_info().expect("PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
    reader.next_frame(&mut pixels).expect("whole");
    pixels
}

#[test]
fn a_picture_without_noise_stands_beside_the_rendered_one() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let batch = |out: &str, more: &[&str]| {
        let output = kiln(dir.path(), &[&["batch", "in", "--out", out], &SMALL[..], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    };
    batch("plain", &[]);
    batch("same", &[&denoiser(dir.path(), "same")]);
    batch("colors", &[&denoiser(dir.path(), "colors")]);
    let read = |path: &str| fs::read(dir.path().join(path)).expect("a file");
    let want = ["a.obj.denoised.png", "a.obj.exr", "a.obj.png", "index.html", "manifest.jsonl"];
    assert_eq!(files(&dir.path().join("same")), want);
    let picture = |path: &str| pixels(&dir.path().join(path));
    assert!(picture("plain/a.obj.png") == picture("same/a.obj.png"), "what was rendered is kept");
    assert!(picture("same/a.obj.denoised.png") == picture("same/a.obj.png"), "the right way up");
    assert!(picture("colors/a.obj.denoised.png") != picture("same/a.obj.png"));
    let lines = manifest(&dir.path().join("same"));
    let [png, denoised, exr] = &lines[0]["outputs"].as_array().expect("outputs")[..] else { panic!("{}", lines[0]) };
    assert!(png["error"].as_f64().is_some() && png.get("denoised").is_none(), "{png}");
    assert_eq!(denoised["denoised"], "Open Image Denoise 9.8.7");
    assert!(denoised["error"].is_null() && denoised["error_bound"].is_null(), "{denoised}");
    assert!(denoised["bias"].to_string().contains("its error is not known"), "{denoised}");
    assert!(exr["error"].as_f64().is_some() && exr["denoised"] == denoised["denoised"], "{exr}");
    let text = read("same/a.obj.denoised.png");
    let says = |what: &[u8]| text.windows(what.len()).any(|w| w == what);
    assert!(says(b"kiln:denoised") && !says(b"kiln:error"));
    // The layer is the picture here, bit for bit.
    let image = read_first_flat_layer_from_file(dir.path().join("same/a.obj.exr")).expect("our own file");
    let channel = |name: &str| {
        let list = &image.layer_data.channel_data.list;
        list.iter().find(|c| c.name.to_string() == name).expect(name).sample_data.values_as_f32().collect::<Vec<_>>()
    };
    assert_eq!(channel("denoised.G"), channel("G"));
    // A second run knows; what was not asked for before is made.
    let again = kiln(
        dir.path(),
        &[&["batch", "in", "--out", "plain", "--dry-run"], &SMALL[..], &[&denoiser(dir.path(), "same")]].concat(),
    );
    assert!(stderr(&again).contains("1 asset to render"), "{}", stderr(&again));
    let again = kiln(
        dir.path(),
        &[&["batch", "in", "--out", "same", "--dry-run"], &SMALL[..], &[&denoiser(dir.path(), "same")]].concat(),
    );
    assert!(stderr(&again).contains("1 up to date"), "{}", stderr(&again));
    let page = String::from_utf8(read("same/index.html")).expect("text");
    assert!(page.contains("\"denoised\":[\"a.obj.denoised.png\"]"));
}

#[test]
fn a_denoiser_that_is_missing_or_fails_is_an_error() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let output = kiln(dir.path(), &["batch", "in", "--out", "out", "--denoise=/there/is/none"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("/there/is/none") && !dir.path().join("out").exists(), "{}", stderr(&output));
    let broken = denoiser(dir.path(), "broken");
    let output = kiln(dir.path(), &[&["batch", "in", "--out", "out", broken.as_str()], &SMALL[..]].concat());
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    assert_eq!(lines[0]["error_code"], "denoiser");
    let want = ["a.obj.exr", "a.obj.png", "index.html", "manifest.jsonl"];
    assert_eq!(files(&dir.path().join("out")), want, "what was rendered is kept");
    assert!(lines[0]["error_message"].to_string().contains("no such weights"), "{}", lines[0]);
    assert_eq!(code(&kiln(dir.path(), &["render", "in/a.obj", "-o", "-", broken.as_str()])), 2);
}
