//! The families of the format, and the looks that can be asked for.

use super::{phong, read_as};
use kiln_formats::ray::{Basis, Dialect, RayOptions};
use kiln_formats::{Limits, Scene};

fn read(body: &str, options: RayOptions) -> Scene {
    let text = format!("SBT-raytracer 1.0 {body}");
    let read = read_as(&std::env::temp_dir(), text.as_bytes(), Limits::default(), options);
    read.unwrap_or_else(|e| panic!("{body}: {e}")).0
}

fn of(dialect: Dialect) -> RayOptions {
    RayOptions { dialect, ..RayOptions::default() }
}

#[test]
fn what_mirrors_shines_and_is_inherited_depends_on_the_dialect() {
    let body = "material = { diffuse = (1,0,0); specular = (0,.5,0); shininess = 0.5 }
        sphere { material = { ambient = (.1,.1,.1) } }
        box { material = { specular = (0,0,.25); reflective = (.125,0,0) } }";
    let seen = |dialect| {
        let scene = read(body, of(dialect));
        let each = |k: usize| {
            let p = phong(&scene.materials[scene.meshes[k].material as usize]);
            (p.diffuse.factor, p.mirror.factor, p.exponent.factor)
        };
        [each(0), each(1)]
    };
    let red = [1.0, 0.0, 0.0];
    assert_eq!(seen(Dialect::Ut), [(red, [0.0; 3], 0.5), (red, [0.125, 0.0, 0.0], 0.5)]);
    assert_eq!(seen(Dialect::Uw), [(red, [0.0, 0.5, 0.0], 0.5), (red, [0.125, 0.0, 0.0], 0.5)]);
    assert_eq!(seen(Dialect::Hk), [([0.0; 3], [0.0; 3], 0.0), ([0.0; 3], [0.125, 0.0, 0.0], 0.0)]);
    let hk = read("sphere { material = { specular = (0,.5,0); shininess = 0.5 } }", of(Dialect::Hk));
    assert_eq!(phong(&hk.materials[0]).exponent.factor, 64.0);
    assert_eq!(phong(&hk.materials[0]).mirror.factor, [0.0, 0.5, 0.0]);
}

#[test]
fn cameras_are_raw_normalised_or_orthonormal() {
    let body = "camera { viewdir = (0,0,-2); updir = (0,3,3); } box {}";
    let lengths = |options: RayOptions| {
        let camera = read(body, options).cameras.remove(0);
        let cosine = camera.up.normalize().dot(camera.forward.normalize());
        [camera.forward.length(), 2.0 * camera.right.length(), 2.0 * camera.up.length(), cosine.abs()]
    };
    let near = |got: [f64; 4], want: [f64; 4]| {
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-12), "{got:?} {want:?}");
    };
    let root = 0.5_f64.sqrt();
    near(lengths(of(Dialect::Ut)), [2.0, 6.0, 18.0_f64.sqrt(), root]);
    near(lengths(of(Dialect::Hk)), [1.0, root, 1.0, root]);
    let straight = RayOptions { basis: Basis::Orthonormal, ..RayOptions::default() };
    near(lengths(straight), [1.0, 1.0, 1.0, 0.0]);
}

#[test]
fn one_dialect_passes_over_what_it_does_not_know_and_counts_surfaces_of_glass() {
    let body = "camera { lens = bump(\"a\") ; fov = 30 } box { material = { glow = { a = (1,2); b } transmissive = (.5,.5,.5); fuzzy = 3 }
        shell = soft; } point_light { color = (1,1,1); position = (0,0,0); flicker = ((1,2),(3)) }";
    let text = format!("SBT-raytracer 1.0 {body}");
    let read = |text: &str, dialect| read_as(&std::env::temp_dir(), text.as_bytes(), Limits::default(), of(dialect));
    let (scene, warnings) = read(&text, Dialect::Hk).unwrap();
    assert_eq!(warnings.iter().filter(|w| w.code == "ignored-field").count(), 5, "{warnings:?}");
    assert!(phong(&scene.materials[0]).transmission_at_surfaces);
    assert_eq!(scene.lights.len(), 1);
    let error = read(&text, Dialect::Ut).unwrap_err();
    assert!(error.message.contains("`camera` has no field `lens`"), "{error}");
    let cut = read("SBT-raytracer 1.0 box { x = (1", Dialect::Hk);
    assert!(cut.unwrap_err().message.contains("end of file"));
}

#[test]
fn ambient_and_glass_can_be_taken_otherwise() {
    let body = "ambient_light { color = (.5,1,2) } point_light { position = (0,9,0); color = (1,1,1) }
        sphere { material = { ambient = (.5,.5,.5); emissive = (1,0,0) } }";
    let plain = read(body, RayOptions::default());
    assert_eq!((plain.materials[0].emission.factor, plain.lights[0].through_glass), ([1.0, 0.0, 0.0], true));
    let options = RayOptions { emit_ambient: true, opaque_glass: true, ..RayOptions::default() };
    let other = read(body, options);
    assert_eq!((other.materials[0].emission.factor, other.lights[0].through_glass), ([1.25, 0.5, 1.0], false));
}
