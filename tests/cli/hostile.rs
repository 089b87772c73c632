//! A folder of everything that ends other batches, among a hundred good assets.

use crate::support::{OBJ, code, manifest, stderr};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names of good assets: every script, both directions of writing, and what shells, addresses and terminals obey.
const NAMES: [&str; 26] = [
    "стул",
    "καρέκλα",
    "كرسي",
    "כיסא",
    "कुर्सी",
    "เก้าอี้",
    "椅子",
    "いす",
    "의자",
    "աթոռ",
    "სკამი",
    "ወንበር",
    "ಕುರ್ಚಿ",
    "é",
    "e\u{301}",
    "🪑👨‍👩‍👧",
    "-rf",
    "a b'\"$(x)`y`",
    "100%25",
    "a#?&;b",
    "<b>&amp;",
    "new\nline",
    "\u{1b}[31mred",
    "back\\slash",
    "..",
    "CON",
];

/// The whole chunk of a PNG file.
fn chunk(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let mut checked = [&name[..], content].concat();
    // The checksum of ISO 3309, bit by bit.
    let crc = !checked.iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    });
    checked.extend(crc.to_be_bytes());
    [&(content.len() as u32).to_be_bytes()[..], &checked].concat()
}

/// A sound PNG file of 16384 × 16384 black texels, a gigabyte once it is decoded.
fn large_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1 << 14, 1 << 14);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&vec![0; (1 << 14) * (1 << 11)]).expect("a picture");
    writer.finish().expect("an end");
    bytes
}

/// A PNG file whose header claims as many texels as the format can say.
fn boasting_png() -> Vec<u8> {
    let header = [&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff][..], &[8, 6, 0, 0, 0]].concat();
    [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &header), &chunk(b"IEND", &[])].concat()
}

/// An OBJ file with a texture, and its material library.
fn textured(folder: &Path, name: &str, png: &[u8]) {
    let put = |ending: &str, text: &[u8]| fs::write(folder.join(format!("{name}.{ending}")), text).expect("write");
    put("png", png);
    put("mtl", format!("newmtl m\nmap_Kd {name}.png\n").as_bytes());
    put(
        "obj",
        format!("mtllib {name}.mtl\nusemtl m\nvt 0 0\n{}", OBJ.replace("f 1 2 3 4", "f 1/1 2/1 3/1 4/1")).as_bytes(),
    );
}

/// `kiln` such that permissions bind it, even when root runs the tests; `None`: that cannot be done here.
fn bound_by_permissions(locked: &Path) -> Option<Command> {
    if fs::read(locked).is_err() {
        return Some(Command::new(env!("CARGO_BIN_EXE_kiln")));
    }
    let lesser = || {
        let mut command = Command::new("setpriv");
        command.arg("--bounding-set=-dac_override,-dac_read_search");
        command
    };
    let read = lesser().arg("cat").arg(locked).output();
    let bound = read.is_ok_and(|output| !output.status.success() && output.stdout.is_empty());
    bound.then(|| {
        let mut command = lesser();
        command.arg(env!("CARGO_BIN_EXE_kiln"));
        command
    })
}

#[test]
fn a_hostile_folder_among_good_assets() {
    let Some(shared) = std::env::var_os("KILN_SHARED").map(PathBuf::from) else {
        eprintln!("skipped: KILN_SHARED is not set");
        return;
    };
    let dir = tempfile::tempdir().expect("temporary folder");
    let inside = dir.path().join("in");
    let good = inside.join("good");
    fs::create_dir_all(&good).expect("folder");
    let write = |path: PathBuf, text: &str| fs::write(path, text).expect("write");
    NAMES.iter().for_each(|name| write(good.join(format!("{name}.obj")), OBJ));
    // A name that is no text, and one that leaves just room for the picture's ending.
    write(good.join(OsStr::from_bytes(b"caf\xe9.obj")), OBJ);
    write(good.join(format!("{}.obj", "x".repeat(247))), OBJ);
    (NAMES.len() + 2..100).for_each(|i| write(good.join(format!("{i:03}.obj")), OBJ));
    ["abort", "overflow", "loop", "allocate"].iter().for_each(|kind| write(inside.join(format!("{kind}.obj")), OBJ));
    write(inside.join(format!("{}.obj", "y".repeat(251))), OBJ);
    write(inside.join("deep.gltf"), &format!("{}{}", "{\"a\":".repeat(100_000), "}".repeat(100_000)));
    textured(&inside, "large", &large_png());
    textured(&inside, "boasting", &boasting_png());
    for (to, from) in [("..", "good/up"), ("loop.glb", "loop.glb"), ("/dev/zero", "zero.glb"), ("nowhere", "lost.glb")]
    {
        symlink(to, inside.join(from)).expect("link");
    }
    write(inside.join("locked.obj"), OBJ);
    fs::create_dir(inside.join("shut")).expect("folder");
    let permit =
        |name: &str, mode: u32| fs::set_permissions(inside.join(name), Permissions::from_mode(mode)).expect("chmod");
    permit("locked.obj", 0);
    permit("shut", 0);
    let bound = bound_by_permissions(&inside.join("locked.obj"));
    let permissions_bind = bound.is_some();
    let mut command = bound.unwrap_or_else(|| {
        eprintln!("unreadable files are left out: nothing here binds root");
        Command::new(env!("CARGO_BIN_EXE_kiln"))
    });
    let malformed = fs::canonicalize(shared.join("assets/malformed")).expect("shared assets");
    command.current_dir(dir.path()).args(["batch", "in"]).arg(malformed).env_remove("RUST_BACKTRACE");
    command.args([
        "--out",
        "out",
        "--memory",
        "600M",
        "--timeout",
        "5",
        "--width",
        "16",
        "--spp",
        "1",
        "--format",
        "png",
    ]);
    let faults = ["abort", "overflow", "loop", "allocate"].map(|kind| format!("{kind}.obj={kind}")).join(",");
    let output = command.env("KILN_FAULT", faults).output().expect("the program runs");
    permit("shut", 0o755);
    let said = stderr(&output);
    assert_eq!(code(&output), 3, "{said}");
    assert!(!said.contains('\u{1b}') && !said.contains("\nline"), "names command nothing");
    let lines = manifest(&dir.path().join("out"));
    let of = |line: &Value, key: &str| line[key].as_str().unwrap_or_default().to_owned();
    let good = lines.iter().filter(|l| of(l, "input").starts_with("in/good/"));
    let bad: Vec<_> = good.clone().filter(|l| of(l, "status") != "ok").collect();
    assert_eq!((good.count(), bad.len()), (100, 0), "{bad:?}");
    let failed: Vec<(String, String)> = lines
        .iter()
        .filter(|l| of(l, "status") == "failed")
        .map(|l| {
            assert!(!of(l, "error_message").is_empty(), "{l}");
            assert!(l["peak_bytes"].as_u64().is_none_or(|peak| peak < 900 << 20), "{l}");
            (of(l, "input"), of(l, "error_code"))
        })
        .collect();
    let named = |name: &str| said.contains(&name.replace(char::is_control, "\u{fffd}"));
    assert!(failed.iter().all(|(input, _)| named(input)), "every one is named: {said}");
    let code_of =
        |name: &str| failed.iter().find(|(input, _)| *input == format!("in/{name}")).map(|(_, code)| code.as_str());
    let long = format!("{}.obj", "y".repeat(251));
    let mut want = vec![
        ("abort.obj", "crashed"),
        ("overflow.obj", "stack-overflow"),
        ("loop.obj", "timeout"),
        ("allocate.obj", "out-of-memory"),
        ("large.obj", "out-of-memory"),
        ("boasting.obj", "too-large"),
        ("deep.gltf", "syntax"),
        ("loop.glb", "io"),
        ("lost.glb", "io"),
        (long.as_str(), "unwritable"),
    ];
    if permissions_bind {
        want.push(("locked.obj", "io"));
        assert!(said.contains("in/shut cannot be searched"), "{said}");
    }
    for (name, code) in want {
        assert_eq!(code_of(name), Some(code), "{name}: {said}");
    }
    assert!(code_of("zero.glb").is_some(), "{said}");
    // Of all others none is our fault.
    for (input, code) in failed.iter().filter(|(input, _)| !input.starts_with("in/")) {
        assert!(
            !["internal", "crashed", "stack-overflow", "no-worker", "timeout"].contains(&code.as_str()),
            "{input}: {code}"
        );
    }
    assert!(lines.len() > 400, "{} lines", lines.len());
}
