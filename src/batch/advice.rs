//! What each warning means and what can be done about it: the list behind `docs/warnings.md` and the summary of a batch.

/// A kind of warning.
#[derive(Clone, Copy, Debug)]
pub struct Advice {
    /// The stable word.
    pub code: &'static str,
    /// What it says.
    pub meaning: &'static str,
    /// What can be done.
    pub remedy: &'static str,
}

const fn advice(code: &'static str, meaning: &'static str, remedy: &'static str) -> Advice {
    Advice { code, meaning, remedy }
}

/// What is known of a kind of warning.
pub fn of(code: &str) -> Option<&'static Advice> {
    ALL.iter().find(|advice| advice.code == code)
}

/// All kinds, by their words.
pub const ALL: &[Advice] = &[
    advice(
        "ambient-ignored",
        "Only ambient light would show an object, and there is none in light transport",
        "`--ray-ambient`, or `--integrator whitted`",
    ),
    advice("ambiguous-transparency", "`d` and `Tr` of a material disagree", "write one of them"),
    advice(
        "animation-ignored",
        "An animation, or a part of it, is not played; the rest pose is shown",
        "`--time-code T` shows a moment, `--turntable N --play` all; or export it again",
    ),
    advice("attribute-ignored", "A vertex attribute is not used", "nothing, unless the picture lacks something"),
    advice("bad-face", "A face is broken and left out", "mend the line"),
    advice("bad-index", "An index leads nowhere; what uses it is left out", "export the mesh again"),
    advice(
        "bad-normals",
        "Normals are no unit vectors or are missing in places; they were made anew",
        "export normals, or none",
    ),
    advice("bad-smoothing-group", "A smoothing group is no number", "mend the line"),
    advice("bad-tangents", "Tangents cannot be right; they were made anew", "export tangents, or none"),
    advice(
        "bad-transform",
        "A transform is degenerate or not finite; what it places is left out or shown without",
        "mend the node",
    ),
    advice("bad-vertex", "A vertex is no position", "mend the line"),
    advice("bad-vertex-color", "A vertex colour is no colour", "mend the line"),
    advice(
        "black-picture",
        "What is in the picture is black",
        "is it meant to be lit? Try `--env studio`, or `--exposure auto`",
    ),
    advice(
        "blank-picture",
        "Nothing of the asset is in the picture",
        "try `--camera auto`: the asset's own camera may look elsewhere",
    ),
    advice("broken-texture", "An image cannot be decoded; the material is shown without", "convert the image anew"),
    advice(
        "clipped-highlights",
        "More than a twentieth of what is in the picture is white",
        "try `--exposure auto`, or a lower EV",
    ),
    advice(
        "cropped",
        "The asset goes on beyond the picture's edge",
        "try `--camera auto`, or move the camera of `--view`",
    ),
    advice("empty-mesh", "A mesh has no faces", "nothing, unless the picture lacks something"),
    advice("empty-shape", "A shape has no extent", "mend its size"),
    advice(
        "error-not-met",
        "All samples were taken, and the error may still be above the one asked for",
        "more `--spp`, a larger `--error`, or `--time`, if there is some to spare",
    ),
    advice(
        "energy-scaled",
        "A material would reflect more light than falls on it; its colours are scaled down",
        "choose colours that add up to 1 at most",
    ),
    advice("factor-out-of-range", "A factor of a material is beyond its bounds and was limited", "mend the factor"),
    advice(
        "fallback-used",
        "Compressed geometry cannot be read; the plain one beside it is shown",
        "nothing, or compress anew",
    ),
    advice("ignored-field", "A statement is not used", "nothing, unless the picture lacks something"),
    advice("incomplete-triangle", "Vertices are left over that make no triangle", "export the mesh again"),
    advice(
        "index-out-of-range",
        "An index leads beyond the vertices; its triangle is left out",
        "export the mesh again",
    ),
    advice("invalid-camera", "A camera makes no picture and is left out", "mend the camera, or use `--camera auto`"),
    advice("invalid-ior", "An index of refraction cannot be", "mend the material"),
    advice("invalid-light", "A light is broken and left out", "mend the light"),
    advice("invalid-object", "An object of the file is broken and left out", "mend the place that is named"),
    advice(
        "missing-material",
        "A material is referred to and not there; a plain one is shown",
        "bring the material, or its library",
    ),
    advice(
        "missing-material-library",
        "A material library is not there; plain materials are shown",
        "bring the `.mtl` file, with the name that the file says",
    ),
    advice(
        "missing-texture",
        "An image is not there; the material is shown without",
        "bring the file to where the asset looks for it; `--root` where it lies outside the folder",
    ),
    advice("missing-uvs", "A texture lies on a mesh without coordinates", "export texture coordinates"),
    advice("morph-ignored", "A morph target is not used", "export it again"),
    advice("negative-value", "A colour or light is negative", "mend the value"),
    advice(
        "nonfinite-samples",
        "Samples were not finite and do not count",
        "please report it; `--replay` shows where (`nonfinite_first` in the manifest)",
    ),
    advice("normal-map-ignored", "A normal map cannot be used on this mesh", "export texture coordinates and tangents"),
    advice("not-finite", "A vertex is not finite; its triangles are left out", "export the mesh again"),
    advice(
        "nothing-to-draw",
        "A part of the asset has nothing that can be drawn",
        "nothing, unless the picture lacks something",
    ),
    advice(
        "nothing-to-reuse",
        "`--reuse on` does nothing for this asset",
        "leave it off; `docs/path-reuse.md` says what it is for",
    ),
    advice("occlusion-ignored", "Occlusion textures are not used: light transport knows what is occluded", "nothing"),
    advice("out-of-range", "A value of a material is beyond its bounds and was limited", "mend the value"),
    advice(
        "own-light-too-dark",
        "The asset's own light leaves the picture black; the studio lights it as well",
        "nothing, or `--env none`",
    ),
    advice("points-or-lines-not-drawn", "Points and lines have no surface and are left out", "make surfaces of them"),
    advice(
        "shininess-dialect",
        "A shininess is read as the course tracers of another dialect do",
        "choose the `--ray-dialect`",
    ),
    advice("skin-ignored", "A skin is broken; the mesh is shown unbent", "export the skin again"),
    advice("texcoord-ignored", "A set of texture coordinates is not used", "use the first or second set"),
    advice(
        "texture-fallback",
        "An image cannot be shown; another one that the texture names is",
        "nothing, or convert the image anew",
    ),
    advice(
        "time-cut",
        "The time was over before the picture was as good as asked for",
        "more `--time`, or a larger `--error`",
    ),
    advice("time-past-end", "The moment is after the animation's end; the end is shown", "an earlier `--time-code`"),
    advice("unknown-statement", "A statement is not known and ignored", "nothing, unless the picture lacks something"),
    advice(
        "unsampled-caustics",
        "Light without extent shines on a smooth mirror or through a smooth body: what these cast is missing or comes as specks, and the stated error hardly knows of it",
        "a lamp with a surface, or `--env`, instead; a rougher surface; `--clamp` against specks",
    ),
    advice("unsupported-element", "An element is not drawn", "make polygons of it"),
    advice(
        "unsupported-extension",
        "An extension is not supported; the asset is shown without",
        "see what it does in `docs/formats.md`; export without it",
    ),
    advice(
        "unsupported-statement",
        "A statement is not supported and ignored",
        "nothing, unless the picture lacks something",
    ),
    advice(
        "unsupported-texture",
        "An image format or option is not supported; the material is shown without",
        "convert the image to PNG or JPEG",
    ),
    advice("vertex-emission", "Emission of vertices is not shown, only the mesh's own", "give the mesh its emission"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    /// The literals that are the first argument of what makes warnings, in the sources below a folder but their tests.
    fn told(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).expect("sources") {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                told(&path, found);
                continue;
            }
            let text = fs::read_to_string(&path).unwrap_or_default();
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            for maker in ["warn(", "once(", "Warning::new("] {
                for (at, _) in text.match_indices(maker) {
                    let argument = text[at + maker.len()..].trim_start();
                    if let Some(code) = argument.strip_prefix('"').and_then(|rest| rest.split('"').next()) {
                        found.push(code.to_owned());
                    }
                }
            }
        }
    }

    #[test]
    fn every_warning_is_explained_here_and_in_the_documentation() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut codes = Vec::new();
        told(&root.join("formats/src"), &mut codes);
        told(&root.join("src/batch"), &mut codes);
        assert!(codes.len() > 60, "the search finds next to nothing: {codes:?}");
        let unexplained: Vec<_> = codes.iter().filter(|code| of(code).is_none()).collect();
        assert!(unexplained.is_empty(), "add to ALL: {unexplained:?}");
        let page = fs::read_to_string(root.join("docs/warnings.md")).expect("docs/warnings.md");
        let rows: Vec<&str> = page.lines().filter(|l| l.starts_with("| `")).collect();
        let want: Vec<String> =
            ALL.iter().map(|a| format!("| `{}` | {} | {} |", a.code, a.meaning, a.remedy)).collect();
        assert_eq!(rows, want, "docs/warnings.md is made of this list");
    }
}
