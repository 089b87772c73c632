//! What is read and what is not, as a table for the documentation: made of the lists that the importers go by.

use crate::gltf::extensions;
use crate::obj::{mtl, scan};
use std::fmt::Write;

/// What a reader should know of an extension beyond its name.
fn note(extension: &str) -> &'static str {
    match extension {
        "EXT_mesh_gpu_instancing" => "TRANSLATION, ROTATION, SCALE",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "all modes and filters",
        "EXT_texture_webp" => "first choice where a texture has several sources",
        "KHR_animation_pointer" => {
            "with `--time-code` or `--animation`: nodes, morph weights, visibility, materials with their extensions, \
             texture transforms, lights, cameras"
        }
        "KHR_draco_mesh_compression" => "all attributes that are read at all",
        "KHR_lights_punctual" => "range and spot cones included; candela and lux are taken as W/sr and W/m²",
        "KHR_materials_dispersion" => "paths go on with one wavelength each, bent by Cauchy's formula",
        "KHR_materials_variants" => "`--variant NAME`, or `all` for pictures of each",
        "KHR_texture_basisu" => "KTX2 with ETC1S or UASTC, Zstandard included",
        "MSFT_texture_dds" => "BC1 to BC7 and uncompressed; used where a texture has no other source",
        _ => "",
    }
}

/// The table in Markdown, as `docs/formats.md` has it.
pub fn markdown() -> String {
    let mut text = String::from(
        "# What Kiln reads\n\n\
         Made of the importers' own lists; a test keeps it so. What an asset uses and does not get is named in a warning with\n\
         its place, and `kiln inspect` shows it. A glTF extension that is not listed here gives the warning\n\
         `unsupported-extension`, or the error `unsupported` where the file requires it.\n\n\
         ## glTF 2.0 (`.gltf`, `.glb`)\n\n\
         Triangles, strips and fans; sparse, normalised and quantised accessors; data URIs; skins and morph targets in the\n\
         rest pose or at a moment of an animation (STEP, LINEAR, CUBICSPLINE); any two sets of texture coordinates a\n\
         material; perspective and orthographic cameras. Points and lines are counted and not drawn.\n\n\
         | extension | | |\n|---|---|---|\n",
    );
    for name in extensions::SUPPORTED {
        let _ = writeln!(text, "| {name} | honoured | {} |", note(name));
    }
    for (name, missing) in extensions::SHOWN_WITHOUT {
        let _ = writeln!(text, "| {name} | named in a warning | {missing} |");
    }
    for name in extensions::WITHOUT_EFFECT {
        let _ = writeln!(text, "| {name} | no effect on pictures | |");
    }
    text.push_str(
        "\n## OBJ with MTL (`.obj`)\n\n\
         UTF-8, UTF-16 and Latin-1; any line ends; continued lines; polygons, concave ones included;\n\
         smoothing groups (`s`) where faces have no normals; vertex colours. One bad statement costs itself.\n\n\
         | statement | |\n|---|---|\n\
         | `v` `vt` `vn` `f` `fo` `o` `g` `s` `usemtl` `mtllib` | read |\n\
         | `p` `l` | counted and not drawn |\n",
    );
    let list = |words: &[&str]| words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" ");
    let _ = writeln!(text, "| {} | free-form surfaces: counted and not drawn |", list(&scan::FREE_FORM));
    let _ = writeln!(text, "| {} | no effect on pictures of polygons |", list(&scan::HARMLESS));
    let _ = writeln!(text, "| MTL: {} | read, with the options of textures |", list(&mtl::READ));
    let _ = writeln!(text, "| MTL: {} | named in a warning, and without effect |", list(&mtl::NAMED));
    text.push_str(
        "\n## SBT-raytracer scenes (`.ray`)\n\n\
         The language of the ray tracing courses of UT Austin, Washington and HKUST (`--ray-dialect ut|uw|hk`), with the\n\
         `area_light`s of its forks (`light_radius`, `bottom_radius`, `area`, `u` and `v`), meshes with texture coordinates and\n\
         `objfile`, bumps (`bump_mapping`; `bump_map`, `normal_map`, `diffuse_map` and `specular_map` of objects) on shapes that have\n\
         texture coordinates, `emission` of objects and `sphere_light`. k_t counts lengths, and surfaces in the dialect `hk`, which\n\
         also passes over fields that are not known. `spot_light`, `quadric`, `torus`, `csg` and other words of single forks are\n\
         errors that say so.\n\n\
         | look | |\n|---|---|\n\
         | `--integrator whitted` | the course tracers' shading: mirrors, glass with straight coloured shadows, no indirect light |\n\
         | `--tonemap course` | 8 bits of linear light, cut off, as their files have |\n\
         | `--ray-camera raw\\|orthonormal` | the camera's axes as written, or straightened |\n\
         | `--ray-ambient` | path tracing with the ambient term as emission |\n\
         | `--ray-opaque-glass` | glass blocks the light of lamps |\n\n\
         ## Images\n\n\
         PNG, JPEG, WebP, TIFF, TGA, BMP, GIF (its first frame), PPM and its kin, Radiance HDR and EXR, with 8 or 16 bits or as\n\
         floats; DDS with BC1 to BC7 or uncompressed (the largest picture); KTX2 as above. AVIF is not decoded (no decoder without C\n\
         code has been proven on hostile files yet): textures fall back on their other source.\n",
    );
    text
}
