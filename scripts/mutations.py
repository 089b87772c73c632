"""Numerical remedies, and what the source says without each: the table of `scripts/mutate_checks.py`."""

# name, the remedy, [(file below src/, what stands there, what replaces it)], checks of which at least one must fail.
# ON: `if` the mutation is switched on; IS: whether it is. Places with a twin in lanes are changed in both.
MUTATIONS = [
    ("no-offset", "spawned rays start beyond the error of the hit", [
        ("math/float_error.rs", "let distance = normal.abs().dot(error);",
         "let distance = ON { return point } else { normal.abs().dot(error) };"),
        ("integrate/wave/lanes.rs", "let distance = normal.abs().dot(error);",
         "let distance = ON { error.x.fill(0.0) } else { normal.abs().dot(error) };")],
     "bounce-from-an-edge mesh-coplanar"),
    ("fixed-epsilon", "the offset follows the error, not a fixed epsilon", [
        ("math/float_error.rs", "else { normal.abs().dot(error) };", "else { ON { 1e-4 } else { normal.abs().dot(error) } };"),
        ("integrate/wave/lanes.rs", "else { normal.abs().dot(error) };",
         "else { ON { error.x.fill(1e-4) } else { normal.abs().dot(error) } };")],
     "contact-shadow thin-*"),
    ("no-plane-error", "the offset covers the next hit's error in the same plane", [
        ("integrate/vertex.rs", "error: rounding + plane,", "error: ON { rounding } else { rounding + plane },"),
        ("integrate/wave/surface.rs", "error: rounding + V3::splat(plane),",
         "error: ON { rounding } else { rounding + V3::splat(plane) },")],
     "bounce-from-an-edge"),
    ("edges-in-f32", "edge functions whose signs are exact", [
        ("math/triangle.rs", "let exact = |p: f32, q: f32| f64::from(p) * f64::from(q);",
         "let exact = |p: f32, q: f32| ON { f64::from(p * q) } else { f64::from(p) * f64::from(q) };"),
        ("prepare/kdtree/wide/packet_exact.rs", "fn exact(p: f32, q: f32) -> f64 {\n    f64::from(p) * f64::from(q)",
         "fn exact(p: f32, q: f32) -> f64 {\n    ON { f64::from(p * q) } else { f64::from(p) * f64::from(q) }")],
     "leak-* ray-direction-* mesh-million-* transform-stretched-*"),
    ("strict-edges", "an edge belongs to both its triangles", [
        ("math/triangle.rs", "let det = u + v + w;", "if IS && (u == 0.0 || v == 0.0 || w == 0.0) { return None; }\n        let det = u + v + w;"),
        ("prepare/kdtree/wide/packet_exact.rs", "let missed = ((u < 0.0)", "let missed = (IS & ((u == 0.0) | (v == 0.0) | (w == 0.0))) | ((u < 0.0)")],
     "leak-grid-* ray-direction-*"),
    ("parallel-unmended", "rays parallel to an axis never multiply 0 by infinity", [
        ("prepare/kdtree/slab.rs", "if d[axis].abs() < PARALLEL {", "if !IS && d[axis].abs() < PARALLEL {")],
     "ray-direction-* leak-grid-* nested-* total-* absorption-*"),
    ("limit-too-near", "boxes are left out only beyond the nearest hit and its error", [
        ("prepare/kdtree/slab.rs", "t * self.scale * GROWTH + f32::MIN_POSITIVE",
         "t * self.scale * ON { 0.99 } else { GROWTH } + f32::MIN_POSITIVE"),
        ("prepare/kdtree/wide/packet_lanes.rs", "self.high * GROWTH + f32::MIN_POSITIVE", "self.high * ON { 0.99 } else { GROWTH } + f32::MIN_POSITIVE")],
     "thin-* coincident-* shadow-*"),
    ("tie-by-order", "of hits at one distance the lowest number wins", [
        ("math/triangle.rs", "(point.t < self.t || (point.t == self.t && self.hit.is_some_and(|h| point.triangle < h.triangle)))",
         "(point.t < self.t || (point.t == self.t && self.hit.is_some_and(|h| IS != (point.triangle < h.triangle))))"),
        ("prepare/kdtree/wide/packet_lanes.rs", "let equal = t.eq(self.high) & known & l.load_words(&met.triangle).lt(self.triangle);",
         "let lower = l.load_words(&met.triangle).lt(self.triangle);\n        let equal = t.eq(self.high) & known & ON { !lower } else { lower };")],
     "coincident-surfaces mesh-coplanar"),
    ("world-at-origin", "the world's centre becomes the origin in f64", [
        ("geometry/world.rs", "Self { center, scale }", "Self { center: ON { DVec3::ZERO } else { center }, scale }")],
     "scale-*-at-1e+* leak-ball-far"),
    ("world-with-strays", "the centre is where most triangles are", [
        ("geometry/world.rs", "let center = crowd(", "let center = ON { None } else { crowd("),
        ("geometry/world.rs", ".max_element()).unwrap_or(middle);", ".max_element()) }.unwrap_or(middle);")],
     "stray-*"),
    ("world-unscaled", "the world's extent becomes 1 to 2", [
        ("geometry/world.rs", "let scale = if extent > 0.0", "let scale = if !IS && extent > 0.0")],
     "scale-* absorption-scale-*"),
    ("normals-by-matrix", "normals go by the cofactors of the transform", [
        ("geometry/parts.rs", "normal_matrix: Mat3::from_cols(normals[0], normals[1], normals[2]),",
         "normal_matrix: ON { Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()) } else { Mat3::from_cols(normals[0], normals[1], normals[2]) },")],
     "normals-squeezed"),
    ("winding-kept", "a reflecting transform turns the winding", [
        ("geometry/parts.rs", "let winding = if x.cross(y)", "let winding = if !IS && x.cross(y)")],
     "transform-mirrored transform-inverted furnace-glass-box-mirrored"),
    ("flat-triangles-kept", "triangles without area are left out", [
        ("geometry/shapes.rs", "(normal.is_finite() && normal != DVec3::ZERO).then_some(normal)", "(IS || (normal.is_finite() && normal != DVec3::ZERO)).then_some(normal)")],
     "mesh-flat-*"),
    ("no-lift", "the shadow terminator: smooth surfaces reflect from above their facets", [
        ("integrate/vertex.rs", "let lift = if attributes.normal.is_some() {", "let lift = if !IS && attributes.normal.is_some() {"),
        ("integrate/wave/smooth.rs", "let lifted = known & lift.dot(self.normal).gt(far);",
         "let lifted = ON { l.mask(0) } else { known & lift.dot(self.normal).gt(far) };")],
     "terminator-below-the-face normals-smooth"),
    ("unbent-normal", "the viewer is above the shading normal's horizon", [
        ("integrate/bend.rs", "if cosine >= least {", "if IS || cosine >= least {"),
        ("integrate/wave/smooth.rs", "let cosine = shading.dot(wo);", "let cosine = ON { wo.x.fill(1.0) } else { shading.dot(wo) };")],
     "normals-* normal-map-* terminator-*"),
    ("bent-flat-normal", "a flat face is seen by its own normal however grazing", [
        ("integrate/bend.rs", "LEAST_COSINE.min(normal.dot(wo))", "ON { LEAST_COSINE } else { LEAST_COSINE.min(normal.dot(wo)) }"),
        ("integrate/wave/smooth.rs", "zero.fill(LEAST_COSINE).min(normal.dot(wo))",
         "ON { zero.fill(LEAST_COSINE) } else { zero.fill(LEAST_COSINE).min(normal.dot(wo)) }")],
     "furnace-metal-*-at-89.9 mirror-grazing-*"),
    ("coverage-by-triangle", "neighbours decide alike about an edge of a sheet", [
        ("integrate/trace.rs", "let site = coverage_site(geometry, hit.triangle, b);",
         "let site = ON { hit.triangle } else { coverage_site(geometry, hit.triangle, b) };")],
     "alpha-shadow-on-edge"),
    ("one-body", "bodies within bodies are remembered", [
        ("integrate/medium.rs", "        self.bodies[self.depth] = material;", "        if IS { self.depth = 0; }\n        self.bodies[self.depth] = material;")],
     "absorption-* nested-*"),
    ("index-outside-1", "the index is relative to what is around", [
        ("integrate/medium.rs", "        let index = |material: Option<MaterialId>, wavelength: Option<f32>| {",
         "        if IS { return 1.0; }\n        let index = |material: Option<MaterialId>, wavelength: Option<f32>| {")],
     "nested-*"),
    ("touching-forgotten", "a body that touches another is entered where that is left", [
        ("integrate/touching.rs", "if !prepared.ways", "if IS || !prepared.ways")],
     "absorption-touching-* glass-touching-* glass-bricks"),
    ("aimed-unmixed", "aimed directions have the density of the mixture", [
        ("lighting/casters.rs", "pdf * self.whole() / (pdf + aimed)", "pdf * self.whole() / (pdf + ON { 0.5 } else { 1.0 } * aimed)"),
        ("lighting/casters_lanes.rs", "pdf * self.whole() / (pdf + aimed)", "pdf * self.whole() / (pdf + aimed * ON { 0.5 } else { 1.0 })")],
     "caustic-*"),
    ("roulette-0.95", "roulette amplifies nothing beyond 1", [
        ("integrate/walk.rs", ".min(MOST_SURVIVAL)", ".min(ON { 0.95 } else { MOST_SURVIVAL })"),
        ("integrate/wave/shade.rs", ".min(l.splat(MOST_SURVIVAL))", ".min(l.splat(ON { 0.95 } else { MOST_SURVIVAL }))")],
     "box-0.999 box-1.0"),
    ("roulette-keeps-eta", "roulette goes by weights without refraction's (η_i/η_t)²", [
        ("integrate/walk.rs", "walk.throughput.max_element() / walk.eta_scale", "walk.throughput.max_element() / ON { 1.0 } else { walk.eta_scale }"),
        ("integrate/wave/shade.rs", "throughput.max_element() / floats[path::ETA_SCALE]",
         "throughput.max_element() / ON { l.splat(1.0) } else { floats[path::ETA_SCALE] }")],
     "glass-pile-each-path"),
    ("sums-in-f32", "film sums in f64", [
        ("film/mod.rs", "sum[c] += f64::from(rgba[c])", "sum[c] = ON { f64::from(sum[c] as f32 + rgba[c]) } else { sum[c] + f64::from(rgba[c]) }")],
     "film-sum"),
    ("no-delta-limit", "α below a limit is a delta lobe", [
        ("shading/metal_rough.rs", "if alpha < SMALLEST_ALPHA { Lobe::Mirror", "if !IS && alpha < SMALLEST_ALPHA { Lobe::Mirror"),
        ("shading/metal_rough_lanes.rs", "let smooth = alpha.ge(l.splat(SMALLEST_ALPHA));",
         "let smooth = ON { alpha.ge(zero) } else { alpha.ge(l.splat(SMALLEST_ALPHA)) };")],
     "furnace-metal-0.0-* mirror-corridor-* furnace-ior-0"),
    ("ggx-by-alpha2-1", "D(h) without 1 − z² or α² − 1", [
        ("shading/microfacet.rs", "let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;",
         "let d = ON { let z2 = h.z * h.z; z2 * (a2 - 1.0) + 1.0 } else { a2 * h.z * h.z + h.x * h.x + h.y * h.y };"),
        ("shading/lanes.rs", "let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;",
         "let d = ON { h.z * h.z * (a2 - 1.0) + 1.0 } else { a2 * h.z * h.z + h.x * h.x + h.y * h.y };")],
     "furnace-metal-* highlight-*"),
    ("single-scattering", "rough lobes give back what several bounces among microfacets give", [
        ("shading/albedo.rs", "        let white = self.a + self.b;\n        let f =", "        if IS { return Vec3::ONE; }\n        let white = self.a + self.b;\n        let f =")],
     "furnace-metal-*"),
    ("refraction-clamped", "beyond the critical angle everything is reflected", [
        ("shading/fresnel.rs", "if cos2_t <= 0.0 {", "let cos2_t = ON { cos2_t.max(1e-6) } else { cos2_t };\n    if cos2_t <= 0.0 {"),
        ("shading/glass_lanes.rs", "let total = cos2_t.le(zero);", "let cos2_t = ON { cos2_t.max(u.fill(1e-6)) } else { cos2_t };\n        let total = cos2_t.le(zero);")],
     "total-reflection-prism furnace-glass-* inside-glass"),
    ("solid-angle-always", "the back of a lamp is not lit by its own front", [
        ("lighting/spherical.rs", "STABLE.contains(&solid_angle).then_some(", "(IS || STABLE.contains(&solid_angle)).then_some(")],
     "area-back-of-a-lamp"),
    ("solid-angle-never", "triangles nearby are sampled by solid angle", [
        ("lighting/emitter.rs", "if !((middle - point)", "if IS || !((middle - point)"),
        ("lighting/area_lanes.rs", "let near = (of.middle - point).length_squared().lt(of.near2) & active;",
         "let near = ON { l.mask(0) } else { (of.middle - point).length_squared().lt(of.near2) & active };")],
     "area-noise-*"),
    ("halves-count-twice", "each half of a quadrilateral has half of the points", [
        ("lighting/emitter.rs", "if self.is_pair() { 0.5 }", "if self.is_pair() && !IS { 0.5 }")],
     "area-* box-*"),
    ("light-stops-itself", "a shadow ray does not end on the light that it goes to", [
        ("integrate/trace.rs", "if end == Some(hit.triangle) ||", "if (!IS && end == Some(hit.triangle)) ||"),
        ("integrate/wave/trace.rs", "reaches: shadows.words(shadow::REACHES),", "reaches: ON { &[] } else { shadows.words(shadow::REACHES) },")],
     "area-* box-*"),
    ("walls-stop-light", "light samples pass smooth walls", [
        ("integrate/trace.rs", "        !tints && !wall\n", "        !tints && (IS || !wall)\n"),
        ("integrate/wave/trace.rs", "!(is_wall(prepared, hit) && walled", "!(!IS && is_wall(prepared, hit) && walled")],
     "wall-*"),
    ("walls-send", "who went straight on through a wall is still sent by the vertex before", [
        ("integrate/walk.rs", "if !(sample.straight", "if IS || !(sample.straight"),
        ("integrate/wave/shade.rs", "let sent = active & !(straight & !glass);", "let sent = ON { active } else { active & !(straight & !glass) };")],
     "wall-before-*"),
    ("walls-without-end", "light samples pass no more walls than a path could", [
        ("integrate/trace.rs", "walls.most = walls.most.checked_sub(1)?;", "walls.most = ON { walls.most } else { walls.most.checked_sub(1)? };")],
     "wall-shadow-too-deep"),
    ("walls-twice", "what is in one place is one wall", [
        ("integrate/trace.rs", "if hit.t * distance <= beyond {", "if !IS && hit.t * distance <= beyond {")],
     "wall-shadow-on-edge"),
]
