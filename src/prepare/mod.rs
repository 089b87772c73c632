//! From the scene IR to what rays meet: triangles in one frame, lights, kd-tree.

mod asks;
mod called;
mod casters;
mod instances;
pub mod kdtree;
mod parts;
mod physical;
mod questions;
mod rare_light;
mod unmet;

pub(crate) use crate::effects::Knowledge;
use crate::effects::{self, Rewrite};
use crate::geometry::{Geometry, Pyramids, WorldFrame, bleed, world_bounds};
use crate::lanes::AnyLanes;
use crate::lighting::casters::Casters;
use crate::lighting::{Environment, Lights};
pub use crate::lighting::{EnvironmentSource, SharedEnvironment};
use crate::math::simd::SimdTier;
use crate::settings::{EffectSet, PrepareSettings, SimdTier as AskedTier};
pub(crate) use asks::Asks;
use cpu_time::ThreadTime;
use glam::DVec3;
use kdtree::{BuildOptions, KdTree};
use kiln_formats::{Control, Scene, Stopped};
pub(crate) use parts::{PartWay, Way, bounds_body};
pub use questions::Asked;
pub(crate) use questions::Questions;
pub use rare_light::RareLight;
use std::time::Instant;
pub use unmet::Unmet;

/// Seconds that parts of the preparation took.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrepareTimes {
    /// Wall seconds of the kd-tree's build.
    pub kdtree: f64,
    /// CPU seconds of the kd-tree's build over all threads.
    pub kdtree_cpu: f64,
    /// The calling thread's part of them.
    pub kdtree_caller_cpu: f64,
}

/// What a traversal has to ask about a material's triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Filters {
    /// Coverage may be below 1.
    pub coverage: bool,
    /// Camera rays pass through the back.
    pub culled: bool,
    /// Shadow rays of `.ray` lights may pass and take on colour.
    pub tints: bool,
    /// A smooth wall without inside, which light goes through as it comes.
    pub walls: bool,
}

/// A scene ready to be rendered. Immutable and `Sync`.
#[derive(Debug)]
pub struct PreparedScene {
    /// World-space bounds (lower and upper corner) of everything drawn; `None` when nothing is.
    pub bounds: Option<(DVec3, DVec3)>,
    /// Triangles drawn, without degenerate ones.
    pub triangles: u64,
    /// Triangles left out because they have no area.
    pub degenerate_triangles: u64,
    /// Emitters: emissive triangles, punctual lights, environment.
    pub emitters: u64,
    /// Light that paths hardly find.
    pub rare_light: Option<RareLight>,
    /// What the file says that has no effect.
    pub rewrites: Vec<Rewrite>,
    /// Times.
    pub times: PrepareTimes,
    pub(crate) scene: Scene,
    pub(crate) frame: WorldFrame,
    pub(crate) geometry: Geometry,
    /// Smaller versions of the textures.
    pub(crate) pyramids: Pyramids,
    pub(crate) lights: Lights,
    /// Bodies that paths are aimed at.
    pub(crate) casters: Casters,
    pub(crate) tree: KdTree,
    pub(crate) filters: Vec<Filters>,
    /// What has to be asked at hits.
    pub(crate) asks: Asks,
    /// Whether there is a surface that is diffuse and nothing else.
    pub(crate) has_diffuse: bool,
    /// Whether all surfaces are flat and of one diffuse colour each.
    pub(crate) is_diffuse: bool,
    /// For each part of the geometry, how it is shaded.
    pub(crate) ways: Vec<PartWay>,
    /// Which triangles it has to be asked of.
    pub(crate) questions: Questions,
    /// The instructions that shading uses.
    pub(crate) lanes: AnyLanes,
}

impl PreparedScene {
    /// Changes what lights the scene beside its own lights.
    pub fn relight(&mut self, environment: &EnvironmentSource, settings: &PrepareSettings) {
        let environment = Environment::new(environment, self.scene.up);
        self.lights = Lights::new(&self.scene, &self.geometry, &self.frame, environment, settings);
        self.casters = casters::casters(&self.scene, &self.geometry, &self.frame, &self.lights);
        self.emitters = self.lights.count() as u64;
    }

    /// Of how many triangles rays ask whether they are stopped.
    pub fn asked(&self) -> Asked {
        self.questions.asked()
    }

    /// Figures of the kd-tree.
    pub fn kdtree_statistics(&self) -> kdtree::Statistics {
        self.tree.statistics()
    }
}

/// Whether the scene brings light of its own: lights, or surfaces whose emission has a factor above `least` (unlit ones do
/// not count). What is black, and materials that nothing drawn has, bring none.
pub fn has_own_light(scene: &Scene, least: f32) -> bool {
    let material = |mesh: u32| &scene.materials[scene.meshes[mesh as usize].material as usize];
    let emits = |mesh| material(mesh).emission.factor.iter().any(|e| *e > least);
    scene.lights.iter().any(|l| l.color != [0.0; 3]) || scene.instances.iter().any(|i| emits(i.mesh))
}

fn tier(asked: AskedTier) -> SimdTier {
    match asked {
        AskedTier::Auto => SimdTier::detect(),
        AskedTier::Scalar => SimdTier::Scalar,
        AskedTier::Avx2 => SimdTier::Avx2,
        AskedTier::Avx512 => SimdTier::Avx512,
    }
}

/// Prepares a scene. The kd-tree is built on the current rayon pool.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn prepare(
    scene: Scene,
    environment: &EnvironmentSource,
    settings: &PrepareSettings,
    control: &Control,
) -> Result<PreparedScene, Stopped> {
    let know = Knowledge { forced: settings.effects.forced, overlooked: EffectSet::default() };
    prepare_knowing(scene, environment, settings, know, control)
}

/// [`prepare`], by what is known of the effects.
pub(crate) fn prepare_knowing(
    mut scene: Scene,
    environment: &EnvironmentSource,
    settings: &PrepareSettings,
    know: Knowledge,
    control: &Control,
) -> Result<PreparedScene, Stopped> {
    control.check()?;
    effects::leave_out(&mut scene, settings.effects.without);
    let rewrites = if settings.effects.raw { Vec::new() } else { effects::normalise(&mut scene) };
    control.check()?;
    bleed(&mut scene, control)?;
    if settings.physical_lights {
        physical::replace_soft_lights(&mut scene, settings.point_lights);
    }
    let bounds = world_bounds(&scene);
    let frame = WorldFrame::new(&scene, bounds);
    control.check()?;
    let geometry = Geometry::sharing(&scene, &frame, &instances::sharing(settings.instances, settings.planned_rays));
    control.check()?;
    let environment = Environment::new(environment, scene.up);
    let lights = Lights::new(&scene, &geometry, &frame, environment, settings);
    control.check()?;
    let pyramids = Pyramids::new(&scene, control);
    control.check()?;
    let asks = Asks::new(&scene, &geometry, know);
    let filters: Vec<_> = scene.materials.iter().map(|material| asks.of(material)).collect();
    let ways = parts::ways(&scene, &geometry, know, &filters);
    let met = unmet::met(&scene, &geometry, &asks);
    let questions = Questions::new(&geometry, &ways, met.as_deref());
    let (start, clock) = (Instant::now(), ThreadTime::now());
    let options = BuildOptions {
        builder: settings.kdtree,
        seed: 0,
        simd: tier(settings.simd),
        planned_rays: settings.planned_rays,
    };
    let tree = instances::build(&geometry, met, &options, control)?;
    let times = PrepareTimes {
        kdtree: start.elapsed().as_secs_f64(),
        kdtree_cpu: tree.statistics().build_cpu_seconds,
        kdtree_caller_cpu: clock.elapsed().as_secs_f64(),
    };
    Ok(PreparedScene {
        bounds,
        triangles: geometry.len() as u64,
        degenerate_triangles: geometry.degenerate,
        emitters: lights.count() as u64,
        rare_light: RareLight::of(&scene),
        rewrites,
        times,
        casters: casters::casters(&scene, &geometry, &frame, &lights),
        asks,
        questions,
        has_diffuse: parts::has_diffuse(&scene),
        is_diffuse: ways.iter().all(|part| matches!(part.way, Way::Diffuse(_))),
        ways,
        lanes: AnyLanes::new(tier(settings.simd)),
        scene,
        frame,
        geometry,
        pyramids,
        lights,
        tree,
        filters,
    })
}
