//! `kiln.toml`, and what belongs to a program that is installed.

use crate::support::{OBJ, code, files, folder, kiln, manifest, stderr};
use std::fs;
use std::process::Output;

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn flags_come_from_the_nearest_file_above() {
    let toml = "spp = 3\nwidth = 12\nquiet = true\n\n[batch]\nout = \"pictures\"\nformat = [\"png\"]\nspp = 2\nexclude = ['b*', 'c*']\n";
    let dir = folder(&[("kiln.toml", toml), ("deep/er/in/a.obj", OBJ), ("deep/er/in/b.obj", OBJ)]);
    let deep = dir.path().join("deep/er");
    let output = kiln(&deep, &["batch", "in"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    // Paths are relative to the file.
    let out = dir.path().join("pictures");
    assert_eq!(files(&out), ["a.obj.png", "index.html", "manifest.jsonl"]);
    let line = &manifest(&out)[0]["outputs"][0];
    assert_eq!(
        (line["width"].as_u64(), line["spp"].as_u64()),
        (Some(12), Some(2)),
        "the command's own table counts more"
    );
    // The command line counts most, and none of the file where it is not wanted.
    assert_eq!(code(&kiln(&deep, &["batch", "in", "--spp", "5", "--out", "mine"])), 0);
    assert_eq!(manifest(&deep.join("mine"))[0]["outputs"][0]["spp"], 5);
    assert_eq!(code(&kiln(&deep, &["batch", "in", "--no-config"])), 2, "there is no --out");
}

#[test]
fn what_a_flag_rules_out_in_the_file_gives_way() {
    let dir = folder(&[("kiln.toml", "camera = \"auto\"\nverbose = true\n"), ("a.obj", OBJ)]);
    let output = kiln(dir.path(), &["render", "a.obj", "--turntable", "2", "--quiet", "--width", "4", "--spp", "1"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

#[test]
fn mistakes_in_the_file_have_a_line() {
    let dir = folder(&[("a.obj", OBJ)]);
    for (text, want) in [
        ("\nwidht = 3\n", "kiln.toml:2: no command has a flag 'widht'"),
        ("[render]\n# note\njobs = 3\n", "kiln.toml:3: kiln render has no flag 'jobs'"),
        ("[rendr]\nwidth = 3\n", "kiln.toml:2: there is no command 'rendr'"),
        ("width = 3\nspp = \"many\"\n", "kiln.toml:2: invalid value 'many'"),
        ("width = 0\n", "kiln.toml:1: invalid value '0'"),
        ("width = { a = 1 }\n", "kiln.toml:1: there is no command 'width'"),
        ("width = 3\nspp = \n", "kiln.toml:2: "),
        ("asset = 'a'\n", "kiln.toml:1: no command has a flag 'asset'"),
    ] {
        fs::write(dir.path().join("kiln.toml"), text).expect("write");
        let output = kiln(dir.path(), &["render", "a.obj"]);
        assert_eq!(code(&output), 2, "{text}");
        assert!(stderr(&output).contains(want), "{text}: {}", stderr(&output));
    }
    let output = kiln(dir.path(), &["render", "a.obj", "--config", "none.toml"]);
    assert!(code(&output) == 2 && stderr(&output).contains("none.toml"), "{}", stderr(&output));
}

#[test]
fn what_counts_is_shown_with_where_it_comes_from() {
    let dir = folder(&[("own.toml", "spp = 7\n"), ("a.obj", OBJ)]);
    let output = kiln(dir.path(), &["render", "a.obj", "--config", "own.toml", "--width", "9", "--print-config"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for line in [
        "[render]",
        "spp = 7  # own.toml:1",
        "width = 9  # command line",
        "tonemap = \"neutral\"  # default",
        "quiet = false  # default",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}: {text}");
    }
    assert!(!dir.path().join("a.obj.png").exists(), "nothing is rendered");
    // What is shown can be taken as a file.
    fs::write(dir.path().join("again.toml"), &text).expect("write");
    let again = kiln(dir.path(), &["render", "a.obj", "--config", "again.toml", "--print-config"]);
    let flags = |text: &str| text.lines().map(|l| l.split("  #").next().map(str::to_owned)).collect::<Vec<_>>();
    assert_eq!(flags(&stdout(&again)), flags(&text), "{}", stderr(&again));
}

#[test]
fn every_shell_has_completions_and_every_command_a_page() {
    let dir = folder(&[]);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = kiln(dir.path(), &["completions", shell]);
        assert!(code(&output) == 0 && stdout(&output).contains("turntable"), "{shell}");
    }
    let page = stdout(&kiln(dir.path(), &["man", "batch"]));
    assert!(page.contains(".TH kiln-batch 1") && page.contains("turntable"), "{page}");
    assert_eq!(code(&kiln(dir.path(), &["man", "bake"])), 2);
    assert_eq!(code(&kiln(dir.path(), &["man", "--out", "pages"])), 0);
    let pages = files(&dir.path().join("pages"));
    assert!(pages.contains(&"kiln.1".to_owned()) && pages.contains(&"kiln-render.1".to_owned()), "{pages:?}");
}

#[test]
fn a_thumbnail_for_a_file_manager() {
    let dir = folder(&[("a chair.obj", OBJ), ("broken.glb", "glTF")]);
    let address = format!("file://{}/a%20chair.obj", dir.path().display());
    // File managers give a name without an ending.
    let output = kiln(dir.path(), &["thumbnail", "--size", "32", &address, "thumb.XYZ"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    let bytes = fs::read(dir.path().join("thumb.XYZ")).expect("a thumbnail");
    assert_eq!(bytes[..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(bytes[16..24], [0, 0, 0, 32, 0, 0, 0, 32], "width and height");
    let output = kiln(dir.path(), &["thumbnail", "broken.glb", "none.png"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("broken.glb") && !dir.path().join("none.png").exists(), "{}", stderr(&output));
}
