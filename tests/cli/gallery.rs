//! The gallery of a batch, as far as the program goes; how it looks and works in a browser is in tests/browser.

use crate::support::{OBJ, code, command, files, folder, kiln, stderr};
use serde_json::Value;
use std::fs;
use std::path::Path;

const TINY: [&str; 6] = ["--width", "8", "--spp", "1", "--format", "png"];

fn batch(dir: &Path, arguments: &[&str]) -> std::process::Output {
    kiln(dir, &[&["batch", "in", "--quiet"], &TINY[..], arguments].concat())
}

/// What the page of a folder holds.
fn data(folder: &Path) -> Value {
    let page = fs::read_to_string(folder.join("index.html")).expect("a page");
    let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next());
    serde_json::from_str(data.expect("data in the page")).expect("JSON")
}

fn changes(folder: &Path) -> Vec<(String, String)> {
    let text = |v: &Value| v.as_str().unwrap_or("-").to_owned();
    let data = data(folder);
    data["assets"]
        .as_array()
        .expect("assets")
        .iter()
        .map(|a| (text(&a["input"]), text(&a["before"]["change"])))
        .collect()
}

#[test]
fn a_run_is_compared_with_an_earlier_one() {
    let bigger = OBJ.replace("0.5", "0.7");
    let dir =
        folder(&[("in/same.obj", OBJ), ("in/other.obj", OBJ), ("in/gone.obj", OBJ), ("in/mended.obj", "f 1 2 3\n")]);
    assert_eq!(code(&batch(dir.path(), &["--out", "was"])), 3);
    for (name, text) in [("other", bigger.as_str()), ("mended", OBJ), ("novel", OBJ)] {
        fs::write(dir.path().join(format!("in/{name}.obj")), text).expect("write");
    }
    fs::remove_file(dir.path().join("in/gone.obj")).expect("remove");
    let output = batch(dir.path(), &["--out", "is", "--against", "was"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let want = [("mended", "fixed"), ("novel", "-"), ("other", "changed"), ("same", "same"), ("gone", "gone")];
    let want = want.map(|(name, change)| (format!("{name}.obj"), change.to_owned()));
    assert_eq!(changes(&dir.path().join("is")), want);
    let data = data(&dir.path().join("is"));
    assert!(data["assets"][2]["before"]["levels"].as_f64().expect("measured") > 1.0);
    assert_eq!(data["assets"][2]["before"]["png"][0], "../was/other.obj.png");
    // Without --against it is written anew without a comparison.
    let output = kiln(dir.path(), &["gallery", "is"]);
    assert_eq!((code(&output), stderr(&output).contains("4 assets")), (0, true), "{}", stderr(&output));
    assert!(changes(&dir.path().join("is")).iter().all(|(_, change)| change == "-"));
}

#[test]
fn turntables_become_animations() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/chairs/é.obj", OBJ), ("in/broken.obj", "f 1 2 3\n")]);
    assert_eq!(code(&batch(dir.path(), &["--out", "out", "--turntable", "3"])), 3);
    let output = kiln(dir.path(), &["animate", "out", "--fps", "5"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for name in ["a.obj", "chairs/é.obj"] {
        let bytes = fs::read(dir.path().join(format!("out/{name}.apng"))).expect(name);
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG file");
        assert_eq!(reader.info().animation_control().expect("animated").num_frames, 3);
        let mut last = vec![0; 8 * 8 * 4];
        for _ in 0..3 {
            reader.next_frame(&mut last).expect("a frame");
        }
        let still = fs::read(dir.path().join(format!("out/{name}.002.png"))).expect("the frame's own file");
        let mut reader = png::Decoder::new(std::io::Cursor::new(still)).read_info().expect("a PNG file");
        let mut pixels = vec![0; 8 * 8 * 4];
        reader.next_frame(&mut pixels).expect("whole");
        assert!(last == pixels, "{name}");
    }
    let output = kiln(dir.path(), &["animate", "out", "--format", "webp,apng", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let webp = fs::read(dir.path().join("out/chairs/é.obj.webp")).expect("a film");
    let decoder = image_webp::WebPDecoder::new(std::io::Cursor::new(webp)).expect("a WebP file");
    assert_eq!((decoder.num_frames(), decoder.dimensions(), decoder.has_alpha()), (3, (8, 8), true));
    let mut alone = command(dir.path(), &["animate", "out", "--format", "mp4"]);
    let output = alone.env("PATH", "").output().expect("the program runs");
    assert!(code(&output) == 1 && stderr(&output).contains("ffmpeg"), "{}", stderr(&output));
    // A frame that has gone is told, and costs that turntable alone.
    fs::remove_file(dir.path().join("out/a.obj.001.png")).expect("remove");
    let output = kiln(dir.path(), &["animate", "out"]);
    assert!(code(&output) == 3 && stderr(&output).contains("a.obj.001.png"), "{}", stderr(&output));
    assert_eq!(code(&batch(dir.path(), &["--out", "still"])), 3);
    assert_eq!(code(&kiln(dir.path(), &["animate", "still"])), 1, "no turntables");
}

#[test]
fn a_gallery_that_cannot_be_written_is_told() {
    let dir = folder(&[("in/a.obj", OBJ), ("out/index.html/taken", "")]);
    let output = batch(dir.path(), &["--out", "out"]);
    assert_eq!(code(&output), 3, "the pictures are there, the page is not");
    assert!(stderr(&output).contains("index.html"), "{}", stderr(&output));
    assert_eq!(files(&dir.path().join("out")), ["a.obj.png", "index.html/taken", "manifest.jsonl"]);
    let output = kiln(dir.path(), &["gallery", "in"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("manifest.jsonl"), "{}", stderr(&output));
    // What cannot be compared with is no reason to have no gallery.
    let output = batch(dir.path(), &["--out", "new", "--against", "nowhere"]);
    assert_eq!((code(&output), stderr(&output).contains("nowhere")), (3, true), "{}", stderr(&output));
    assert_eq!(changes(&dir.path().join("new")), [("a.obj".to_owned(), "-".to_owned())]);
}
