//! The `.ray` importer: scenes of the course ray tracers that call themselves `SBT-raytracer 1.0`.
//!
//! The dialect is the one of UT Austin's CS354 with the `area_light` of its forks; harmless words of other dialects
//! are understood too. The text goes through a lexer and a parser to a plain tree, and from there to the [`Scene`]:
//! materials inherit from their context, lights are multiplied by π (the course tracers shade `k_d · color · cos`
//! without 1/π), the camera keeps its raw, possibly sheared basis, and round shapes become fine meshes that instances
//! share.

mod lexer;
mod lower;
mod notes;
mod options;
mod parse;
mod shapes;
mod source;
mod tree;

pub use options::{Basis, Dialect, RayOptions};

use crate::{Control, ImportError, Resources, Scene, Warning};

/// Reads the bytes of a `.ray` file and the textures and meshes that it refers to.
///
/// # Errors
/// [`ImportError`] with line and column for the first thing that is wrong: text that breaks the grammar, unknown or
/// foreign words, indices out of range, singular transforms, textures that cannot be read, limits exceeded.
pub fn import(
    bytes: Vec<u8>,
    resources: &mut Resources,
    options: RayOptions,
    warnings: &mut Vec<Warning>,
    control: &Control,
) -> Result<Scene, ImportError> {
    let source = source::Source { bytes: &bytes };
    let lenient = options.dialect == Dialect::Hk;
    let nodes = parse::parse(source, resources.limits().max_nesting, lenient, control)?;
    let mut notes = notes::Notes::new(source, warnings);
    let scene = lower::lower(nodes, source, resources, options, &mut notes, control)?;
    notes.finish();
    Ok(scene)
}
