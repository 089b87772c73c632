//! glTF 2.0, `.gltf` and `.glb`.
//!
//! Bytes become JSON ([`container`]), JSON becomes the `gltf` crate's typed model ([`document`]), and its parts become
//! the scene; compressed views ([`meshopt`]) and primitives ([`draco`]) are decoded into plain ones before that, so that
//! nothing behind them knows of compression. Nothing in the file is trusted: every index and range is checked where it
//! is used, geometry that does not fit is an error at its JSON pointer, and anything else that is wrong is left out with
//! a warning.

mod accessor;
mod animation;
mod basisu;
mod buffers;
mod cameras;
mod container;
mod contents;
mod document;
mod draco;
pub(crate) mod extensions;
mod glossiness;
mod habits;
mod instancing;
mod layers;
mod layout;
mod lights;
mod materials;
mod mend;
mod meshopt;
mod nodes;
mod pictures;
mod pose;
mod primitive;
mod prune;
mod references;
mod report;
mod textures;
mod triangles;
mod uri;
mod uv_sets;
mod variants;

use crate::scene::{Instance, Mesh, Scene, UpAxis};
use crate::{Contents, Control, ErrorCode, ImportError, Place, Resources, Show, Warning, parallel};
use accessor::Accessors;
use buffers::Buffers;
use glam::DAffine3;
use gltf::json;
use gltf::json::validation::Checked;
use materials::Materials;
use nodes::Hierarchy;
use pictures::{Encoded, Files};
use pose::Pose;
use primitive::{Reader, Tangents};
use report::{Report, Seen};
use std::collections::BTreeMap;

/// Reads a `.gltf` or `.glb` file (told by its first bytes) and what it refers to.
///
/// `show` names the moment of an animation and the variant; without them it is the rest pose in the materials that the
/// primitives name. What the document says of itself goes to `contents`. The progress counts primitives and images.
///
/// # Errors
/// [`ImportError`] with a JSON pointer, or a byte offset or a line where it is no glTF yet:
/// [`ErrorCode::Syntax`] for what is no JSON or GLB, [`ErrorCode::Unsupported`] for other versions than 2 and required
/// extensions that are not known, [`ErrorCode::Invalid`] for wrong indices, ranges and hierarchies,
/// [`ErrorCode::Io`] and [`ErrorCode::Refused`] for buffers, [`ErrorCode::TooLarge`] by the limits of `resources`,
/// [`ErrorCode::Empty`] when there is no triangle, and [`ErrorCode::Stopped`].
pub fn import(
    bytes: Vec<u8>,
    resources: &mut Resources,
    show: &Show,
    contents: &mut Contents,
    warnings: &mut Vec<Warning>,
    control: &Control,
) -> Result<Scene, ImportError> {
    open(bytes, resources, show, contents, warnings, control)?.finish(resources, warnings, control)
}

/// A document of which all files and the geometry have been read. Images are encoded still, and meshes lack the tangents that they do not bring.
pub(crate) struct Opened {
    root: json::Root,
    buffers: Buffers,
    scene: Scene,
    materials: Materials,
    without_tangents: Vec<Tangents>,
    files: Files,
    seen: Seen,
}

/// Does of an import what does not depend on pixels. The warnings are complete after [`Opened::finish`].
///
/// # Errors
/// As [`import`].
pub(crate) fn open(
    bytes: Vec<u8>,
    resources: &mut Resources,
    show: &Show,
    contents: &mut Contents,
    warnings: &mut Vec<Warning>,
    control: &Control,
) -> Result<Opened, ImportError> {
    let mut report = Report::new(warnings);
    match read(bytes, resources, show, contents, &mut report, control) {
        Ok(opened) => Ok(Opened { seen: report.interrupt(), ..opened }),
        Err(error) => {
            report.finish();
            Err(error)
        }
    }
}

impl Opened {
    /// Gives the meshes their tangents and decodes the images.
    ///
    /// # Errors
    /// [`ErrorCode::TooLarge`] when there are too many texels, and [`ErrorCode::Stopped`].
    pub(crate) fn finish(
        mut self,
        resources: &mut Resources,
        warnings: &mut Vec<Warning>,
        control: &Control,
    ) -> Result<Scene, ImportError> {
        let mut report = Report::go_on(warnings, std::mem::take(&mut self.seen));
        let result = self.complete(resources, &mut report, control);
        report.finish();
        result
    }

    fn complete(self, resources: &mut Resources, report: &mut Report, control: &Control) -> Result<Scene, ImportError> {
        let Self { root, buffers, mut scene, mut materials, without_tangents, files, .. } = self;
        complete_tangents(without_tangents, &mut materials, &mut scene, report, control)?;
        scene.materials = materials.list;
        let encoded = Encoded { root: &root, buffers: &buffers, files };
        materials.textures.load(encoded, resources, &mut scene, report, control)?;
        Ok(scene)
    }
}

fn read(
    bytes: Vec<u8>,
    resources: &mut Resources,
    show: &Show,
    contents: &mut Contents,
    report: &mut Report,
    control: &Control,
) -> Result<Opened, ImportError> {
    let container::Container { mut json, bytes, bin } = container::split(bytes)?;
    document::check_version(&json)?;
    extensions::check(&json, report)?;
    *contents = contents::of(&json);
    document::normalize(&mut json);
    habits::mend(&mut json, report);
    if let Some(variant) = &show.variant {
        variants::apply(&mut json, variant)?;
    }
    let unresolved = references::first_unresolved(&json);
    let storage = document::storage(&mut json)?;
    let mut buffers = Buffers::load(&storage, bytes, bin, resources, control)?;
    buffers.set_decoded(meshopt::decode_views(&storage, &buffers, resources.limits(), report, control)?);
    if show.is_animated() {
        animation::pose(&mut json, &Accessors { root: &storage, buffers: &buffers }, show, report)?;
    } else if !contents.animations.is_empty() {
        let message = "animations are not played: the rest pose is shown, for no moment is asked for (--time-code)";
        report.once("animation-ignored", "/animations", message);
    }
    let local = nodes::local_transforms(&json, report);
    let materials = Materials::reading(uv_sets::of_materials(&json));
    pose::warn_about_other_targets(&json, report);
    let mut root = document::read(&mut json, storage, report)?;
    drop(json);
    let hierarchy = nodes::compose(&root, &local, resources.limits().max_nesting)?;
    draco::expand(&mut root, &mut buffers, &hierarchy.shown, resources.limits(), report, control)?;
    let accessors = Accessors { root: &root, buffers: &buffers };
    accessors.check_all()?;
    control.begin((root.meshes.iter().map(|m| m.primitives.len()).sum::<usize>() + root.images.len()) as u64);

    let mut scene = Scene { up: UpAxis::Y, ..Scene::default() };
    let drawn = geometry(accessors, &hierarchy, materials, resources, &mut scene, report, control);
    let (materials, without_tangents) = drawn.map_err(|error| match (error.code, unresolved) {
        (ErrorCode::Empty, Some(why)) if error.place == Place::File => why,
        _ => error,
    })?;
    for node in &hierarchy.shown {
        let world = hierarchy.world.get(*node).copied().unwrap_or(DAffine3::IDENTITY);
        scene.cameras.extend(cameras::at_node(&root, *node, &world, report));
        scene.lights.extend(lights::at_node(&root, *node, &world, report));
    }
    let files = pictures::read_files(&root, &materials.textures.wanted(), resources, control)?;
    Ok(Opened { root, buffers, scene, materials, without_tangents, files, seen: Seen::new() })
}

/// What distinguishes two poses of one mesh: the mesh, its skin, and the bits of its morph weights.
type PoseKey = (usize, Option<usize>, Vec<u32>);

/// A primitive in the scene: its mesh, and the transform that takes the place of the node's where it is skinned.
type Placed = (u32, Option<DAffine3>);

/// Puts the meshes and instances of the nodes shown into the scene; each mesh is read once for each of its poses.
fn geometry(
    accessors: Accessors,
    hierarchy: &Hierarchy,
    mut materials: Materials,
    resources: &Resources,
    scene: &mut Scene,
    report: &mut Report,
    control: &Control,
) -> Result<(Materials, Vec<Tangents>), ImportError> {
    let root = accessors.root;
    check_size(&accessors, &hierarchy.shown, resources.limits().max_triangles)?;
    let mut poses: BTreeMap<PoseKey, Vec<Placed>> = BTreeMap::new();
    let mut reader = Reader {
        accessors,
        report,
        control,
        survey: resources.is_survey(),
        points_or_lines: 0,
        first_points_or_lines: String::new(),
        first_nothing: None,
        without_tangents: Vec::new(),
    };
    for index in &hierarchy.shown {
        let Some(node) = root.nodes.get(*index) else { continue };
        let Some(mesh) = node.mesh.map(|m| m.value()) else { continue };
        let Some(source) = root.meshes.get(mesh) else {
            let message = format!("mesh {mesh} of {}", root.meshes.len());
            return Err(document::invalid(format!("/nodes/{index}/mesh"), message));
        };
        let weights = node.weights.as_ref().or(source.weights.as_ref()).cloned().unwrap_or_default();
        let skin = node.skin.map(|s| s.value());
        let key = (mesh, skin, weights.iter().map(|w| w.to_bits()).collect());
        if !poses.contains_key(&key) {
            let mut pose = Pose { weights, ..Pose::default() };
            if let Some(skin) = skin
                && let Some((joints, origin)) = pose::joints(&accessors, skin, &hierarchy.world, reader.report)?
            {
                (pose.joints, pose.origin) = (joints, origin);
            }
            let placed = read_mesh(&mut reader, source, mesh, &pose, &mut materials, scene)?;
            poses.insert(key.clone(), placed);
        }
        let world = hierarchy.world.get(*index).copied().unwrap_or(DAffine3::IDENTITY);
        let instances = match instancing::of_node(&accessors, node, *index)? {
            Some(instances) => instances.transforms(&accessors)?,
            None => vec![DAffine3::IDENTITY],
        };
        for (mesh, own) in poses.get(&key).into_iter().flatten() {
            for instance in &instances {
                let transform = own.unwrap_or(world * *instance);
                if !transform.is_finite() {
                    let message = "is not finite; the mesh is left out";
                    reader.report.warn("bad-transform", format!("/nodes/{index}"), message);
                    continue;
                }
                scene.instances.push(Instance { name: node.name.clone().unwrap_or_default(), mesh: *mesh, transform });
                // Joints alone place a skinned mesh.
                if own.is_some() {
                    break;
                }
            }
        }
    }
    if reader.points_or_lines > 0 {
        let message = format!("{} primitives of points or lines are not drawn", reader.points_or_lines);
        let place = reader.first_points_or_lines.clone();
        reader.report.once("points-or-lines-not-drawn", place, message);
    }
    if scene.instances.is_empty() {
        return Err(nothing(&reader));
    }
    Ok((materials, reader.without_tangents))
}

fn nothing(reader: &Reader) -> ImportError {
    let empty = |why: &str| ImportError::new(ErrorCode::Empty, format!("has no triangle to draw{why}"));
    match &reader.first_nothing {
        Some((place, why)) => empty(&format!(": {why}")).at(Place::Json(place.clone())),
        None if reader.points_or_lines > 0 => {
            empty(", only points or lines").at(Place::Json(reader.first_points_or_lines.clone()))
        }
        None => empty(""),
    }
}

fn read_mesh(
    reader: &mut Reader,
    source: &json::Mesh,
    index: usize,
    pose: &Pose,
    materials: &mut Materials,
    scene: &mut Scene,
) -> Result<Vec<Placed>, ImportError> {
    let root = reader.accessors.root;
    let mut placed = Vec::new();
    for (p, primitive) in source.primitives.iter().enumerate() {
        let place = format!("/meshes/{index}/primitives/{p}");
        let wanted = primitive.material.map(|m| m.value());
        let known = wanted.filter(|m| *m < root.materials.len());
        if known != wanted {
            let message = "there is no such material; the default one is used";
            reader.report.warn("missing-material", format!("{place}/material"), message);
        }
        let tangents = known.and_then(|m| root.materials.get(m)).is_some_and(layers::may_need_tangents);
        let sets = materials.uv_sets(known);
        let posed = reader.read(primitive, &place, pose, tangents, sets)?;
        reader.control.advance(1);
        let Some(mut posed) = posed else { continue };
        let material = materials.id(root, known, reader.report);
        match materials.tangent_source(material).filter(|_| !reader.survey) {
            Some(source) => {
                let mesh = scene.meshes.len();
                reader.without_tangents.push(Tangents { mesh, place, source, material: known });
            }
            None => posed.mesh.tangents = Vec::new(),
        }
        let own = posed.skinned.then(|| DAffine3::from_translation(pose.origin));
        let name = source.name.clone().unwrap_or_default();
        scene.meshes.push(Mesh { name, material, ..posed.mesh });
        placed.push(((scene.meshes.len() - 1) as u32, own));
    }
    Ok(placed)
}

/// Gives the meshes their tangents, several at a time. Those that can have none get their material without what needs them.
fn complete_tangents(
    wanted: Vec<Tangents>,
    materials: &mut Materials,
    scene: &mut Scene,
    report: &mut Report,
    control: &Control,
) -> Result<(), ImportError> {
    let taken = |wanted: Tangents| {
        let mesh = scene.meshes.get_mut(wanted.mesh).map(std::mem::take).unwrap_or_default();
        (wanted, mesh)
    };
    let mut meshes: Vec<(Tangents, Mesh)> = wanted.into_iter().map(taken).collect();
    let made = parallel::map_mut(&mut meshes, control, |(wanted, mesh)| {
        control.check()?;
        Ok::<_, ImportError>(primitive::complete_tangents(mesh, &wanted.source))
    });
    for ((wanted, mut mesh), made) in meshes.into_iter().zip(made) {
        if let Err(why) = made? {
            let message = format!("{why}: the normal map (and anisotropy) is left out");
            report.warn("normal-map-ignored", wanted.place, message);
            mesh.material = materials.without_tangents(wanted.material, mesh.material);
        }
        if let Some(slot) = scene.meshes.get_mut(wanted.mesh) {
            *slot = mesh;
        }
    }
    Ok(())
}

/// Refuses, before anything is allocated for it, an asset that would draw more triangles than the limit.
fn check_size(accessors: &Accessors, shown: &[usize], max_triangles: u64) -> Result<(), ImportError> {
    let root = accessors.root;
    let mut sizes = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        let mut size = 0u64;
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let Checked::Valid(mode) = primitive.mode else { continue };
            let positions = primitive.attributes.get(&Checked::Valid(json::mesh::Semantic::Positions));
            let (counted, name) = match (primitive.indices, positions) {
                (Some(indices), _) => (indices, "indices"),
                (None, Some(positions)) => (*positions, "attributes/POSITION"),
                (None, None) => continue,
            };
            let count = accessors.count(counted.value(), &|| format!("/meshes/{m}/primitives/{p}/{name}"))?;
            size = size.saturating_add(triangles::upper_bound(mode, count));
        }
        sizes.push(size);
    }
    let mut total = 0u64;
    for index in shown {
        let Some(node) = root.nodes.get(*index) else { continue };
        let Some(size) = node.mesh.and_then(|m| sizes.get(m.value())) else { continue };
        let instances = instancing::of_node(accessors, node, *index)?.map_or(1, |i| i.count as u64);
        total = total.saturating_add(size.saturating_mul(instances));
    }
    if total > max_triangles {
        let message = format!("{total} triangles exceed the limit of {max_triangles}");
        return Err(ImportError::new(ErrorCode::TooLarge, message));
    }
    Ok(())
}
