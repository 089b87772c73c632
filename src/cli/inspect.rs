use super::console::print_line;
use super::effects;
use super::exit::{Exit, Fatal};
use super::looks::LookOptions;
use super::progress::warning;
use super::rays::RayOptions;
use super::summary::plural;
use clap::Args;
use kiln::Control;
use kiln::batch::{AssetFacts, MaterialFacts, TextureFacts, lights_itself};
use kiln::formats::scene::Projection;
use kiln::formats::{Contents, ErrorCode, Format, ImportError, ImportOptions, Imported, import, survey};
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{Instances, KdTreeBuilder, PrepareSettings, SimdTier};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  kiln inspect chair.glb
  kiln inspect chair.glb --json | jq .textures
  kiln inspect chair.glb --quick
  kiln inspect chair.glb --effects --measure
  kiln inspect fox.glb --time-code 0.5
  kiln inspect chair.glb --rays
  kiln inspect chair.glb --rays bounce.rays --stream --threads 2 --json";

/// Lists longer than this are cut for people.
const LISTED: usize = 24;

/// `kiln inspect`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectCommand {
    /// A .gltf, .glb, .obj or .ray file
    asset: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Tell what the files say and no more: images of glTF files are known by their headers, not decoded, and neither tangents nor a kd-tree are
    /// made
    #[arg(long, conflicts_with_all = ["effects", "rays"])]
    quick: bool,
    /// Show which effects the scene calls for and why, and what is left away because it has none
    #[arg(long)]
    effects: bool,
    /// With --effects: render both as the scene calls for it and with every effect reckoned with at every hit, and tell what that
    /// saves
    #[arg(long, requires = "effects")]
    measure: bool,
    /// Files that the asset refers to must lie below this folder [default: the parent of the asset's folder]
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// How the kd-tree is built
    #[arg(long, value_enum, default_value_t, value_name = "BUILDER")]
    kdtree: KdTreeBuilder,
    /// Whether triangles that several nodes draw are kept once
    #[arg(long, value_enum, default_value_t)]
    instances: Instances,
    /// The instructions that tracing may use
    #[arg(long, value_enum, default_value_t, value_name = "TIER")]
    simd: SimdTier,
    #[command(flatten)]
    looks: LookOptions,
    #[command(flatten)]
    rays: RayOptions,
}

impl InspectCommand {
    /// Does it.
    ///
    /// # Errors
    /// When the asset cannot be read.
    pub fn run(self) -> Result<Exit, Fatal> {
        let name = self.asset.display().to_string();
        let control = Control::default();
        let look = self.looks.settings();
        let (root, show, ray) = (self.root.clone(), look.show, look.ray);
        let options = ImportOptions { root, show, ray, ..ImportOptions::default() };
        let failed = |e: ImportError| Fatal::failed(format!("{name}: {}: {e}", e.code.as_str()));
        if self.quick {
            let survey = survey(&self.asset, &options, &control).map_err(failed)?;
            return self.tell_quickly(&name, survey.found());
        }
        let imported = import(&self.asset, &options, &control).map_err(failed)?;
        let format = Format::of(&self.asset);
        let own_light = lights_itself(&imported.scene, format);
        let facts = AssetFacts::of(format, &imported);
        let environment = if own_light { EnvironmentSource::None } else { EnvironmentSource::Studio };
        let settings = PrepareSettings {
            kdtree: self.kdtree,
            instances: self.instances,
            simd: self.simd,
            ..PrepareSettings::default()
        };
        let prepared = prepare(imported.scene, &environment, &settings, &control)
            .map_err(|_| Fatal::failed(format!("{name}: {}", ErrorCode::Stopped.as_str())))?;
        let tree = prepared.kdtree_statistics();
        let rays = self.rays.measure(&prepared)?;
        let saved = match self.measure {
            true => Some(effects::measure(&self.asset, self.root.as_ref(), &settings)?),
            false => None,
        };
        if self.json {
            let mut object = described(&name, &facts, own_light)?;
            object.insert("degenerate_triangles".into(), prepared.degenerate_triangles.into());
            object.insert("emitters".into(), prepared.emitters.into());
            object.insert("kdtree".into(), json!(tree));
            object.insert("effects".into(), json!(prepared.effects()));
            object.insert("rewrites".into(), json!(prepared.rewrites));
            object.insert("attribute_bytes".into(), json!(prepared.attribute_bytes()));
            if self.effects {
                object.insert("asked".into(), json!(prepared.asked()));
                object.insert("never_met".into(), json!(prepared.unmet()));
            }
            if let Some(saved) = &saved {
                object.insert("measured".into(), json!(saved));
            }
            if let Some(rays) = &rays {
                self.rays.tell_json(rays, tree.build_seconds, &mut object);
            }
            print_line(&Value::Object(object).to_string());
        } else {
            print_line(&text(&name, &facts, own_light));
            let left_out = match prepared.degenerate_triangles {
                0 => String::new(),
                n => format!("; {n} triangles without area are left out"),
            };
            let shared = match tree.instances {
                0 => String::new(),
                n => format!(", {n} instances share trees"),
            };
            print_line(&format!(
                "kd-tree    {} nodes, {} leaves, depth {}, {} references to {} triangles, {:.1} MB in {:.3} s{shared}{left_out}",
                tree.nodes,
                tree.leaves,
                tree.depth,
                tree.references,
                tree.triangles,
                tree.bytes as f64 / 1e6,
                prepared.times.kdtree
            ));
            if self.effects {
                effects::lines(&prepared).iter().for_each(|line| print_line(line));
                saved.iter().for_each(|saved| print_line(&effects::measured(saved)));
            }
            if let Some(rays) = &rays {
                print_line(&format!(
                    "           built by {} planes: {:.1} references a triangle, {:.1} bytes a triangle, SAH cost {:.2}",
                    builder(self.kdtree),
                    tree.references as f64 / tree.triangles.max(1) as f64,
                    tree.bytes as f64 / tree.triangles.max(1) as f64,
                    tree.sah_cost
                ));
                self.rays.tell(rays).iter().for_each(|line| print_line(line));
            }
        }
        Ok(Exit::Done)
    }

    /// What importing alone tells.
    fn tell_quickly(&self, name: &str, imported: &Imported) -> Result<Exit, Fatal> {
        let format = Format::of(&self.asset);
        let own_light = lights_itself(&imported.scene, format);
        let facts = AssetFacts::of(format, imported);
        if self.json {
            print_line(&Value::Object(described(name, &facts, own_light)?).to_string());
        } else {
            print_line(&text(name, &facts, own_light));
        }
        Ok(Exit::Done)
    }
}

/// The facts as JSON, with the file's name and what lights it.
fn described(name: &str, facts: &AssetFacts, own_light: bool) -> Result<Map<String, Value>, Fatal> {
    let value = serde_json::to_value(facts).map_err(|e| Fatal::failed(e.to_string()))?;
    let Value::Object(mut object) = value else { return Err(Fatal::failed(format!("{name}: facts are no object"))) };
    object.insert("input".into(), name.into());
    object.insert("light".into(), if own_light { "own" } else { "studio" }.into());
    Ok(object)
}

fn builder(builder: KdTreeBuilder) -> &'static str {
    match builder {
        KdTreeBuilder::Median => "median",
        KdTreeBuilder::Sampled => "sampled",
        KdTreeBuilder::Auto | KdTreeBuilder::Sah => "SAH",
    }
}

fn text(name: &str, facts: &AssetFacts, own_light: bool) -> String {
    let format = match facts.format {
        Some(Format::Gltf) => "glTF",
        Some(Format::Obj) => "OBJ",
        Some(Format::Ray) => "ray",
        None => "unknown",
    };
    let mut lines = vec![
        format!("{name}: {format}, {}", plural(facts.files as usize, "file")),
        format!(
            "geometry   {} triangles, {} vertices; meshes: {}, instances: {}",
            facts.triangles, facts.vertices, facts.meshes, facts.instances
        ),
    ];
    if let Some([low, high]) = facts.bounds {
        let corner = |p: [f64; 3]| p.map(|x| format!("{x:.4}")).join(" ");
        lines.push(format!("bounds     {} … {}, {:?} up", corner(low), corner(high), facts.up));
    }
    list(&mut lines, "material", &facts.materials, material);
    list(&mut lines, "texture", &facts.textures, texture);
    list(&mut lines, "light", &facts.lights, |l| format!("{:11} {}", l.kind, quoted(&l.name)));
    lines.push(format!("lit by     {}", if own_light { "its own light" } else { "the studio: it brings no lights" }));
    list(&mut lines, "camera", &facts.cameras, |c| {
        let fov = c.vertical_fov_deg.map_or(String::new(), |f| format!(", {f:.1}° high"));
        let aspect = c.aspect.map_or(String::new(), |a| format!(", aspect {a:.3}"));
        let kind = match c.projection {
            Projection::Perspective => "perspective",
            Projection::Orthographic => "orthographic",
        };
        format!("{kind:12} {}{fov}{aspect}", quoted(&c.name))
    });
    of_file(&mut lines, &facts.contents);
    list(&mut lines, "warning", &facts.warnings, warning);
    lines.join("\n")
}

/// What the file says about itself.
fn of_file(lines: &mut Vec<String>, contents: &Contents) {
    list(lines, "animation", &contents.animations, |clip| {
        let seconds = clip.seconds.map_or(String::new(), |s| format!(", {s:.2} s"));
        format!("{}{seconds}, {}", quoted(&clip.name), plural(clip.channels as usize, "channel"))
    });
    list(lines, "variant", &contents.variants, |name| quoted(name));
    list(lines, "extension", &contents.extensions_used, |name| {
        let required = contents.extensions_required.contains(name);
        let on = contents.materials.iter().filter(|m| m.extensions.contains(name)).count();
        let on = if on > 0 { format!(", on {}", plural(on, "material")) } else { String::new() };
        format!("{name}{}{on}", if required { ", required" } else { "" })
    });
    if !contents.generator.is_empty() {
        lines.push(format!("made by    {}", contents.generator));
    }
}

fn material(m: &MaterialFacts) -> String {
    let mut words = vec![format!("{:11} {}", m.kind, quoted(&m.name))];
    if m.alpha != "opaque" {
        words.push(format!("alpha {}", m.alpha));
    }
    if m.emits {
        words.push("emits".into());
    }
    if !m.double_sided {
        words.push("single-sided".into());
    }
    if !m.textures.is_empty() {
        let indices: Vec<String> = m.textures.iter().map(ToString::to_string).collect();
        words.push(format!("textures {}", indices.join(" ")));
    }
    words.join(", ")
}

fn texture(t: &TextureFacts) -> String {
    let [u, v] = t.wrap;
    let wrap = if u == v { u.to_owned() } else { format!("{u}/{v}") };
    let nearest = if t.filter == "nearest" { ", nearest" } else { "" };
    format!("{}×{}, {} bit {}, {wrap}{nearest}, {}", t.width, t.height, t.bits, t.color_space, quoted(&t.name))
}

fn quoted(name: &str) -> String {
    if name.is_empty() { "(no name)".into() } else { format!("'{name}'") }
}

fn list<T>(lines: &mut Vec<String>, word: &str, items: &[T], tell: impl Fn(&T) -> String) {
    if items.is_empty() {
        return;
    }
    lines.push(plural(items.len(), word));
    lines.extend(items.iter().take(LISTED).enumerate().map(|(i, item)| format!("  {i:3}  {}", tell(item))));
    if items.len() > LISTED {
        lines.push(format!("  … and {} more (--json lists all)", items.len() - LISTED));
    }
}
