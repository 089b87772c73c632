//! Small files with random damage: whatever happens, it is no panic and no invalid scene.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use kiln_formats::{Control, Limits, Resources, obj};
use std::path::Path;
use std::time::Instant;

const OBJ: &str = "\
# a little of everything
mtllib a.mtl
o first
v 0 0 0 1 0.5 0
v 1 0 0 0 1 0
v 1.5e0 1 0 0 0 1
v 0 1 0.25 1 1 1
v 0.5 0.25 0
v 2 2 2 2
vt 0 0
vt 1 0 0
vt 0.5 1
vn 0 0 1
vn 0 0.6 0.8
g left
usemtl red
s 1
f 1/1/1 2/2/1 3/3/2 5/1/1 4/2/2
f 1//1 2//1 -1//-1
usemtl glass
f 1/1 \\
  2/2 3/3
f 6 5 4 3 2 1
l 1 2
p 1
usemtl none
f 2 3 7
v 9 9 9
";

const MTL: &str = "\
newmtl red
Ka 1 0 0
Kd 0.8 0.1 0.1
Ks 0.5 0.5 0.5
Ns 32
illum 2
map_Kd -s 2 2 1 -o 0.5 0 -clamp on a b.png
bump -bm 0.5 a b.png
Ke 0.5 0 0
newmtl glass
Kd 0.01 0.01 0.01
Tf 0.9 0.9 0.8
Ni 1.5
d 0.5
Tr 0.5
illum 7
Pr 0.1
Pm 0.9
map_d -imfchan m a b.png
norm a b.png
";

struct Random(u64);

impl Random {
    /// xorshift64* (Vigna 2016), to a number below `n`.
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n
    }
}

/// Writes a new file: ext4 waits for the disk when an old one is cut and written anew.
fn write(path: &Path, bytes: &[u8]) {
    std::fs::remove_file(path).ok();
    std::fs::write(path, bytes).unwrap();
}

fn damage(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(6) {
        if bytes.len() < 2 {
            break;
        }
        let (at, other) = (random.below(bytes.len()), random.below(bytes.len()));
        match random.below(8) {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes.insert(at, b"0123456789-+.e/ \\#\n\r\t"[random.below(21)]),
            3 => drop(bytes.remove(at)),
            4 => bytes.truncate(at.max(1)),
            5 => bytes.swap(at, other),
            6 => {
                let piece: Vec<u8> = bytes.iter().skip(other).take(1 + random.below(20)).copied().collect();
                drop(bytes.splice(at..at, piece));
            }
            _ => {
                let words: [&[u8]; 6] = [b"1e38", b"-99999999999999999999", b"nan", b"1e-45", b"0", b"4294967295"];
                drop(bytes.splice(at..at, words[random.below(6)].iter().copied()));
            }
        }
    }
    bytes
}

#[test]
fn damaged_files_never_break_the_importer() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("a b.png");
    image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([x as u8 * 60, y as u8 * 60, 200, 100])).save(&png).unwrap();
    let png_bytes = std::fs::read(&png).unwrap();
    let mtl = folder.path().join("a.mtl");
    std::fs::write(&mtl, MTL).unwrap();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut sound, mut unsound) = (0, 0);
    let mut mtl_bytes = MTL.as_bytes().to_vec();
    for round in 0..6000 {
        // One in three has a sound OBJ file, so that the MTL file gets its turn.
        let obj_bytes = if round % 3 == 1 { OBJ.as_bytes().to_vec() } else { damage(OBJ.as_bytes(), &mut random) };
        if round % 3 == 1 {
            mtl_bytes = damage(MTL.as_bytes(), &mut random);
            write(&mtl, &mtl_bytes);
        }
        if round % 12 == 0 {
            write(&png, &damage(&png_bytes, &mut random));
        }
        let start = Instant::now();
        let mut resources = Resources::new(&folder.path().join("a.obj"), None, Limits::default()).unwrap();
        let mut warnings = Vec::new();
        let result = obj::import(obj_bytes.clone(), &mut resources, &mut warnings, &Control::default());
        let shown = || format!("{}\n---\n{}", String::from_utf8_lossy(&obj_bytes), String::from_utf8_lossy(&mtl_bytes));
        assert!(start.elapsed().as_secs_f64() < 5.0, "{}", shown());
        match result {
            Ok(scene) => {
                scene.validate().unwrap_or_else(|e| panic!("{e}\n{}", shown()));
                sound += 1;
            }
            Err(_) => unsound += 1,
        }
    }
    println!("{sound} imported, {unsound} refused");
    assert!(sound > 3000 && unsound > 10, "{sound} {unsound}: the damage is too great or too small");
}
