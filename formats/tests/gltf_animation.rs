//! Animations and variants of imported glTF.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod gltf_common;

use gltf_common::{Builder, triangle, warned};
use kiln_formats::scene::{LightKind, Surface};
use kiln_formats::{ErrorCode, Place, Scene, Show};
use serde_json::{Value, json};

fn at(time: f64) -> Show {
    Show { time: Some(time), ..Show::default() }
}

/// Adds an animation of one channel.
fn animate(b: &mut Builder, target: Value, interpolation: &str, times: &[f32], output: usize) {
    let input = b.floats("SCALAR", times);
    let clip = json!({
        "name": format!("clip {interpolation}"),
        "channels": [{"sampler": 0, "target": target}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
    });
    match b.doc.get_mut("animations").and_then(Value::as_array_mut) {
        Some(list) => list.push(clip),
        None => b.doc["animations"] = json!([clip]),
    }
}

fn node(path: &str) -> Value {
    json!({"node": 0, "path": path})
}

fn pointer(pointer: &str) -> Value {
    json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}})
}

fn place(scene: &Scene) -> [f64; 3] {
    scene.instances[0].transform.translation.to_array()
}

#[test]
fn nodes_move_by_every_interpolation() {
    let values = [0.0, 0.0, 0.0, 4.0, 0.0, 0.0];
    for (interpolation, quarter) in [("STEP", 0.0), ("LINEAR", 1.0)] {
        let mut b = triangle();
        let output = b.floats("VEC3", &values);
        animate(&mut b, node("translation"), interpolation, &[1.0, 3.0], output);
        for (time, x) in [(0.0, 0.0), (1.5, quarter), (3.0, 4.0), (7.0, 4.0)] {
            let (scene, warnings) = b.import_showing(&at(time)).unwrap();
            assert_eq!(place(&scene), [x, 0.0, 0.0], "{interpolation} at {time}");
            assert_eq!(warned(&warnings, "time-past-end"), time > 3.0);
        }
        let (scene, warnings) = b.import().unwrap();
        assert_eq!(place(&scene), [0.0; 3]);
        assert!(warned(&warnings, "animation-ignored"), "the rest pose says so");
    }
    // x = t² over 2 seconds from slopes 0 and 4: a parabola is its own spline.
    let mut b = triangle();
    let [zero, end] = [[0.0; 3], [4.0, 0.0, 0.0]];
    let output = b.floats("VEC3", &[zero, zero, zero, [4.0, 0.0, 0.0], end, zero].concat());
    animate(&mut b, node("translation"), "CUBICSPLINE", &[0.0, 2.0], output);
    for time in [0.0, 0.5, 1.5, 2.0] {
        let (scene, warnings) = b.import_showing(&at(time)).unwrap();
        assert!((place(&scene)[0] - time * time).abs() < 1e-12);
        assert_eq!(warnings, []);
    }
}

#[test]
fn quantised_rotations_take_the_shorter_arc() {
    let mut b = triangle();
    // Identity, and minus the quaternion of a quarter turn about z.
    let half = (std::f32::consts::FRAC_1_SQRT_2 * 32767.0).round() as i16;
    let bytes: Vec<u8> = [0, 0, 0, 32767, 0, 0, -half, -half].iter().flat_map(|x: &i16| x.to_le_bytes()).collect();
    let accessor = json!({"type": "VEC4", "componentType": 5122, "normalized": true, "count": 2});
    let output = b.accessor(accessor, &bytes);
    animate(&mut b, node("rotation"), "LINEAR", &[0.0, 3.0], output);
    let (scene, warnings) = b.import_showing(&at(1.0)).unwrap();
    assert_eq!(warnings, []);
    let x = scene.instances[0].transform.matrix3.x_axis;
    let angle = x.y.atan2(x.x).to_degrees();
    assert!((angle - 30.0).abs() < 0.01, "{angle}");
}

#[test]
fn morph_weights_are_several_values_a_key() {
    let mut b = triangle();
    let lift = b.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let push = b.floats("VEC3", &[0.0, 1.0, 0.0].repeat(3));
    b.doc["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}, {"POSITION": push}]);
    let output = b.floats("SCALAR", &[0.0, 1.0, 1.0, 3.0]);
    animate(&mut b, node("weights"), "LINEAR", &[0.0, 1.0], output);
    let (scene, warnings) = b.import_showing(&at(0.5)).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(scene.meshes[0].positions[0], [0.0, 2.0, 0.5]);
}

#[test]
fn clips_are_chosen_by_name_index_or_all() {
    let mut b = triangle();
    let output = b.floats("VEC3", &[1.0, 0.0, 0.0]);
    animate(&mut b, node("translation"), "STEP", &[0.0], output);
    let output = b.floats("VEC3", &[2.0, 2.0, 2.0]);
    animate(&mut b, node("scale"), "LINEAR", &[0.0], output);
    let clip = |name: &str| Show { animation: Some(name.into()), ..Show::default() };
    for (choice, x, scale) in [("clip STEP", 1.0, 1.0), ("clip LINEAR", 0.0, 2.0), ("1", 0.0, 2.0), ("all", 1.0, 2.0)] {
        let (scene, _) = b.import_showing(&clip(choice)).unwrap();
        let transform = scene.instances[0].transform;
        assert_eq!((transform.translation.x, transform.matrix3.x_axis.x), (x, scale), "{choice}");
    }
    let error = b.import_showing(&clip("walk")).unwrap_err();
    assert_eq!((error.code, error.place.clone()), (ErrorCode::Invalid, Place::Json("/animations".into())));
    assert!(error.message.contains("'clip STEP', 'clip LINEAR'"), "{error}");
    // An asset without animations is the same at every moment.
    assert_eq!(triangle().import_showing(&clip("walk")).unwrap().1, []);
}

#[test]
fn pointers_move_materials_lights_cameras_and_visibility() {
    let mut b = triangle();
    b.doc["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}, "intensity": 9}]}});
    b.doc["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1}}]);
    b.doc["materials"] = json!([{}]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    b.doc["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "translation": [5, 0, 0]},
    ]);
    b.doc["extensionsUsed"] = json!(["KHR_animation_pointer", "KHR_lights_punctual", "KHR_node_visibility"]);
    b.doc["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let two = |b: &mut Builder, values: [f32; 2]| b.floats("SCALAR", &values);
    let output = b.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0]);
    let base_color = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    animate(&mut b, pointer(base_color), "LINEAR", &[0.0, 1.0], output);
    for (at, values) in [
        ("/extensions/KHR_lights_punctual/lights/0/intensity", [0.0, 8.0]),
        ("/cameras/0/perspective/yfov", [0.5, 1.5]),
        ("/nodes/2/extensions/KHR_node_visibility/visible", [0.0, 1.0]),
    ] {
        let output = two(&mut b, values);
        let kind = if at.ends_with("visible") { "STEP" } else { "LINEAR" };
        animate(&mut b, pointer(at), kind, &[0.0, 1.0], output);
    }
    let all = |time| Show { animation: Some("all".into()), time: Some(time), ..Show::default() };
    let (scene, warnings) = b.import_showing(&all(0.5)).unwrap();
    assert_eq!(warnings, []);
    let Surface::MetalRough(surface) = &scene.materials[0].surface else { panic!("{:?}", scene.materials[0]) };
    assert_eq!(surface.base_color.factor, [0.5, 0.25, 0.0]);
    assert_eq!(scene.lights[0].color, [4.0; 3]);
    assert!(matches!(scene.lights[0].kind, LightKind::Spot { .. }));
    let camera = &scene.cameras[0];
    assert!((camera.up.length() / camera.forward.length() - 0.5_f64.tan()).abs() < 1e-9);
    assert_eq!(scene.instances.len(), 1, "the third node is hidden before 1 s");
    assert_eq!(b.import_showing(&all(1.0)).unwrap().0.instances.len(), 2);
}

#[test]
fn unsound_channels_cost_themselves_only() {
    let sound = || {
        let mut b = triangle();
        let output = b.floats("VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        animate(&mut b, node("translation"), "LINEAR", &[0.0, 1.0], output);
        b
    };
    type Spoil = (&'static str, fn(&mut Builder));
    let spoil: [Spoil; 7] = [
        ("/animations/0/channels/0/sampler", |b| b.doc["animations"][0]["channels"][0]["sampler"] = json!(9)),
        ("/animations/0/channels/0/target", |b| b.doc["animations"][0]["channels"][0]["target"]["node"] = json!(9)),
        ("/animations/0/samplers/0/interpolation", |b| {
            b.doc["animations"][0]["samplers"][0]["interpolation"] = json!("SMOOTH");
        }),
        ("/animations/0/samplers/0/output", |b| {
            let output = b.floats("VEC3", &[0.0; 9]);
            b.doc["animations"][0]["samplers"][0]["output"] = json!(output);
        }),
        ("/animations/0/samplers/0/output", |b| {
            let output = b.floats("VEC3", &[f32::NAN; 6]);
            b.doc["animations"][0]["samplers"][0]["output"] = json!(output);
        }),
        ("/animations/0/samplers/0/input", |b| {
            let input = b.floats("SCALAR", &[1.0, 0.0]);
            b.doc["animations"][0]["samplers"][0]["input"] = json!(input);
        }),
        ("/accessors/2/count", |b| {
            // A billion keys that are nowhere.
            let input = b.raw(json!({"type": "SCALAR", "componentType": 5126, "count": 1_000_000_000}));
            b.doc["animations"][0]["samplers"][0]["input"] = json!(input);
            b.doc["accessors"].as_array_mut().unwrap().swap(2, 3);
            b.doc["animations"][0]["samplers"][0]["input"] = json!(2);
        }),
    ];
    assert_eq!(place(&sound().import_showing(&at(0.5)).unwrap().0)[0], 1.5);
    for (where_, spoil) in spoil {
        let mut b = sound();
        spoil(&mut b);
        let (scene, warnings) = b.import_showing(&at(0.5)).unwrap();
        assert_eq!(place(&scene)[0], 0.0);
        let found = warnings.iter().find(|w| w.code == "animation-ignored").unwrap_or_else(|| panic!("{where_}"));
        assert_eq!(found.place, where_, "{found:?}");
    }
}

#[test]
fn variants_change_materials_of_the_primitives_that_map_them() {
    let mut b = triangle();
    b.doc["extensionsRequired"] = json!(["KHR_materials_variants"]);
    b.doc["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "beach"}, {"name": "street"}]}});
    b.doc["materials"] = json!([{"name": "plain"}, {"name": "sand"}, {"name": "asphalt"}]);
    let mut primitive = b.doc["meshes"][0]["primitives"][0].clone();
    primitive["material"] = json!(0);
    let fixed = primitive.clone();
    let mappings = json!([{"material": 1, "variants": [0]}, {"material": 2, "variants": [1, 7]}]);
    primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": mappings}});
    b.doc["meshes"][0]["primitives"] = json!([primitive, fixed]);
    let shown = |b: &mut Builder, variant: Option<&str>| {
        let show = Show { variant: variant.map(str::to_owned), ..Show::default() };
        b.import_showing(&show).map(|(scene, warnings)| {
            assert_eq!(warnings, []);
            scene.meshes.iter().map(|m| scene.materials[m.material as usize].name.clone()).collect::<Vec<_>>()
        })
    };
    assert_eq!(shown(&mut b, None).unwrap(), ["plain", "plain"]);
    assert_eq!(shown(&mut b, Some("beach")).unwrap(), ["sand", "plain"]);
    assert_eq!(shown(&mut b, Some("1")).unwrap(), ["asphalt", "plain"]);
    let error = shown(&mut b, Some("moon")).unwrap_err();
    assert_eq!(error.place, Place::Json("/extensions/KHR_materials_variants/variants".into()));
    assert_eq!(shown(&mut triangle(), Some("moon")).unwrap(), [""], "no variants: the same in each");
}
