//! Tokens, punctuation and the header.

use super::{assert_fails, diffuse_of_instances, read_body, read_in, scene};
use kiln_formats::ErrorCode::{Empty, Syntax, UnknownFormat, Unsupported};
use kiln_formats::{Limits, Place};

fn translation(number: &str) -> f64 {
    scene(&format!("translate({number},0,0,sphere{{}})")).instances[0].transform.translation.x
}

#[test]
fn numbers_of_the_usual_float_grammar_are_read() {
    let cases = [
        ("1", 1.0),
        ("+1", 1.0),
        ("-1.5", -1.5),
        (".5", 0.5),
        ("-.5", -0.5),
        ("5.", 5.0),
        ("1E5", 1e5),
        ("1e+5", 1e5),
        ("25e-2", 0.25),
        ("007", 7.0),
    ];
    for (text, value) in cases {
        assert_eq!(translation(text), value, "{text}");
    }
}

#[test]
fn garbage_for_numbers_is_refused_at_its_place() {
    for text in ["1.2.3", "-4-2", "1.0f", "-", ".", "+-1", "1e", "0x10", "-inf", "+nan", "-nan"] {
        let words = format!("`{text}` is not a number");
        assert_fails(&format!("translate( 0,\n  {text}, 0, sphere {{}})"), Syntax, 3, 3, &words);
    }
    assert_fails("translate(1e999,0,0,sphere{})", Syntax, 2, 11, "`1e999` is too large a number");
    // Shapes and colours are single precision.
    assert_fails("polymesh { points = ((1e39,0,0)); }", Syntax, 2, 23, "`1e39` is too large a number");
}

#[test]
fn comments_stand_anywhere_and_hold_any_bytes() {
    let text = b"// Gr\xFC\xDFe\r\nSBT-raytracer/* * / **/1.0 sphere // {\n{ /* \xFF\n{ */ } // the end";
    assert_eq!(read_in(&std::env::temp_dir(), text, Limits::default()).expect("a sphere").0.instances.len(), 1);
    assert_fails("sphere {}\n  /* begun", Syntax, 3, 3, "never closed");
}

#[test]
fn strings_end_on_their_line() {
    assert_eq!(scene("sphere { name = \"a b;{\" }").instances[0].name, "a b;{");
    assert_eq!(scene("sphere { name = \"\" }").instances[0].name, "");
    assert_eq!(scene("sphere { name = ball; }").instances[0].name, "ball");
    assert_fails("sphere { name = \"ball; }\n\"", Syntax, 2, 17, "not closed");
}

#[test]
fn columns_count_characters() {
    assert_fails("sphere { name = \"Größe\" ? }", Syntax, 2, 25, "unexpected character `?`");
    assert_fails("sphere { é }", Syntax, 2, 10, "unexpected character `é`");
}

#[test]
fn the_header_comes_first_and_is_of_a_known_version() {
    let read = |text: &str| read_in(&std::env::temp_dir(), text.as_bytes(), Limits::default());
    for good in ["SBT-raytracer 1.0 sphere{}", "\u{FEFF}SBT-raytracer 1.1\nbox{}", "SBT-raytracer 0.9 box{}"] {
        assert!(read(good).is_ok(), "{good}");
    }
    for bad in ["", "sphere{}", "#camera 1 2 3", "raytracer 1.0", "SBT-raytracer-1.0", "\"SBT-raytracer\" 1.0"] {
        assert_eq!(read(bad).expect_err(bad).code, UnknownFormat, "{bad}");
    }
    let newer = read("\nSBT-raytracer 1.2 sphere{}").expect_err("too new");
    assert_eq!((newer.code, &newer.place), (UnknownFormat, &Place::Text { line: 2, column: 15 }));
    assert!(newer.message.contains("format version 1.2 is newer"), "{newer}");
    assert_eq!(read("SBT-raytracer sphere{}").expect_err("no version").code, Syntax);
}

#[test]
fn semicolons_are_optional_behind_fields_and_stray_at_top_level_only() {
    assert_eq!(diffuse_of_instances(&scene(";; sphere { material = { diffuse = (1,0,0) } } ;")), [[1.0, 0.0, 0.0]]);
    assert_eq!(scene("scale(2, sphere{});").instances.len(), 1);
    assert_fails("scale(2, sphere{};)", Syntax, 2, 18, "`)` was expected, found `;`");
    assert_fails("{ sphere{}; }", Syntax, 2, 11, "an object, a transform or `}` was expected");
    assert_fails("sphere { ; }", Syntax, 2, 10, "a field of `sphere` or `}` was expected");
}

#[test]
fn unknown_words_are_errors_that_name_them() {
    assert_fails("sphere { radius = 2; }", Syntax, 2, 10, "`sphere` has no field `radius`");
    assert_fails("camera { zoom = 2; }", Syntax, 2, 10, "`camera` has no field `zoom`");
    assert_fails("sphere { material = { color = (1,1,1); } }", Syntax, 2, 23, "`material` has no field `color`");
    assert_fails("point_light { intensity = 1; }", Syntax, 2, 15, "`point_light` has no field `intensity`");
    assert_fails("pyramid {}", Syntax, 2, 1, "found `pyramid`");
    assert_fails("Sphere {}", Syntax, 2, 1, "found `Sphere`");
    assert_fails("sphere {} }", Syntax, 2, 11, "found `}`");
}

#[test]
fn words_of_other_dialects_are_refused_by_name() {
    assert_fails("trimesh { albedo = (1,1,1); }", Unsupported, 2, 11, "`albedo` in `trimesh`");
    assert_fails("torus {}", Unsupported, 2, 1, "`torus`");
    assert_fails("spot_light { cone_angle = 3; }", Unsupported, 2, 1, "`spot_light`");
}

#[test]
fn a_file_that_is_cut_off_says_what_is_open() {
    let unfinished = "end of file inside `translate` opened at line 2; `)` was expected";
    assert_fails("translate(0,0,0,\n sphere{}", Syntax, 3, 10, unfinished);
    let unfinished = "end of file inside `sphere` opened at line 2; a field of `sphere` or `}` was expected";
    assert_fails("sphere {", Syntax, 2, 9, unfinished);
    let unfinished = "end of file inside `points` list of `polymesh` opened at line 2; `,` or `)` was expected";
    assert_fails("polymesh { points = ( (0,0,0)", Syntax, 2, 30, unfinished);
    let unfinished = "end of file inside `group` opened at line 3; an object, a transform or `}` was expected";
    assert_fails("sphere {}\n{ sphere {}", Syntax, 3, 12, unfinished);
}

#[test]
fn a_scene_without_geometry_is_empty() {
    assert_eq!(read_body("camera {}").expect_err("nothing").code, Empty);
    assert_eq!(read_body("polymesh { points = (); faces = (); }").expect_err("nothing").code, Empty);
}
