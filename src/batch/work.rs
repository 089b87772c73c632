use super::asset::Desk;
use super::budget::Budget;
use super::by_deadline::by_deadline;
use super::environment::{self, LoadedEnvironment};
use super::failure::{Failure, guarded};
use super::read::{Read, note, read};
use super::stages::StageClock;
use super::{Job, Outcome, SceneFacts, Stage, digest, exposure};
use crate::integrate::{PassTally, View, shares_paths};
use crate::prepare::{EnvironmentSource, PreparedScene, RareLight, prepare};
use crate::settings::{CameraChoice, EnvironmentSettings, Exposure, Integrator, PictureFormat, PrepareSettings};
use kiln_formats::{Control, ErrorCode, Format, Scene, Warning};
use std::sync::Arc;

/// Rays that a path takes, about: what is planned for does not have to be exact.
const RAYS_PER_PATH: u64 = 6;

/// How many rays pictures of so many pixels in all are taken to need, before anything of them is known.
pub(crate) fn planned_rays(pixels: u64, spp: u32) -> u64 {
    pixels.saturating_mul(u64::from(spp) * RAYS_PER_PATH)
}

/// A job under way.
pub(super) struct Work<'a> {
    pub job: &'a Job,
    /// Stops at the deadline.
    pub control: &'a Control,
    pub desk: &'a Desk<'a>,
    pub budget: Budget,
    /// Whether the asset is meant to be in its pictures as a whole: the camera is automatic or the same for all.
    pub framed: bool,
    pub outcome: &'a mut Outcome,
}

impl Work<'_> {
    /// All that comes before the pictures: the scene, its views and their exposure.
    pub fn make_ready(&mut self) -> Result<(PreparedScene, Vec<View>, f64), Failure> {
        self.control.check()?;
        let (scene, environment, views) = self.import()?;
        let mut prepared = self.prepare(scene, environment, &views)?;
        if prepared.triangles == 0 {
            let message =
                format!("nothing to draw: none of its {} triangles has an area", prepared.degenerate_triangles);
            return Err(Failure::new(ErrorCode::Empty.as_str(), message));
        }
        self.lighten(&mut prepared, &views)?;
        let exposure = self.exposure(&prepared, &views)?;
        Ok((prepared, views, exposure))
    }

    /// Tells of a stage, whose progress begins anew.
    pub fn begin(&self, stage: Stage) {
        self.control.begin(0);
        (self.desk.on_stage)(stage);
    }

    /// Reads the asset and plans its views.
    fn import(&mut self) -> Result<(Scene, EnvironmentSource, Vec<View>), Failure> {
        self.begin(Stage::Import);
        let clock = StageClock::begin();
        let settings = &self.job.settings;
        let loaded = match (&self.desk.environment, &settings.environment) {
            (None, EnvironmentSettings::File(file)) => {
                let loaded = LoadedEnvironment::read(&file.path).map_err(|e| Failure::new("environment", e))?;
                Some(Arc::new(loaded))
            }
            (loaded, _) => loaded.clone(),
        };
        let digest = digest::of_settings(settings, loaded.as_deref().map(LoadedEnvironment::digest));
        self.outcome.settings = Some(digest.map_err(|e| Failure::new("settings", e.to_string()))?);
        let job = self.job.clone();
        let helped = self.control.helpers_cpu();
        let read = by_deadline(self.control, move |control| read(&job, control));
        // A failed import costs time too.
        let (wall, cpu) = clock.seconds();
        let by_helpers = self.control.helpers_cpu().saturating_sub(helped).as_secs_f64();
        (self.outcome.seconds.import, self.outcome.cpu_seconds.import) = (wall, cpu + by_helpers);
        let ((touched, read), cpu) = read?;
        self.outcome.cpu_seconds.import = self.outcome.cpu_seconds.import.max(cpu + by_helpers);
        note(self.outcome, self.job, &touched);
        let Read { imported, views, finishing: (wall, cpu) } = read?;
        self.outcome.seconds.prepare = wall;
        self.outcome.cpu_seconds.prepare = cpu;
        self.outcome.cpu_seconds.import = (self.outcome.cpu_seconds.import - cpu).max(0.0);
        self.outcome.warnings = imported.warnings;
        let scene = imported.scene;
        let own_camera = match settings.views.camera {
            CameraChoice::Auto => false,
            CameraChoice::Default => !scene.cameras.is_empty(),
            CameraChoice::Named(_) => true,
        };
        self.framed = settings.views.fixed.is_some() || settings.views.turntable.is_some() || !own_camera;
        self.outcome.scene = Some(SceneFacts {
            triangles: scene.triangle_count(),
            instances: scene.instances.len() as u64,
            ..SceneFacts::default()
        });
        let (environment, light) =
            environment::choose(&scene, Format::of(&self.job.input), &settings.environment, loaded.as_ref());
        self.outcome.light = Some(light);
        self.outcome.seconds.import = (clock.seconds().0 - wall).max(0.0);
        Ok((scene, environment, views?))
    }

    fn prepare(
        &mut self,
        scene: Scene,
        environment: EnvironmentSource,
        views: &[View],
    ) -> Result<PreparedScene, Failure> {
        self.begin(Stage::Prepare);
        let clock = StageClock::begin();
        let pixels: u64 = views.iter().map(|view| u64::from(view.width) * u64::from(view.height)).sum();
        let own = self.job.settings.prepare;
        let planned = own.planned_rays.unwrap_or_else(|| planned_rays(pixels, self.job.settings.render.spp));
        let settings = PrepareSettings { planned_rays: Some(planned), ..own };
        let work = move |control: &Control| guarded(|| prepare(scene, &environment, &settings, control));
        let helped = self.control.helpers_cpu();
        let (prepared, cpu) = by_deadline(self.control, work)?;
        let prepared = prepared??;
        if self.job.settings.render.integrator != Integrator::Whitted {
            self.outcome.warnings.extend(prepared.rare_light.as_ref().map(hardly_found));
        }
        if self.job.settings.render.shares() && !shares_paths(&prepared, &self.job.settings.render) {
            let message = "pixels do not use each other's paths: no surface that lanes can shade is diffuse and nothing else, or the strategy, the sampler or light that shines through glass does not allow it";
            self.outcome.warnings.push(Warning::new("nothing-to-reuse", "", message));
        }
        let by_helpers = self.control.helpers_cpu().saturating_sub(helped).as_secs_f64();
        let tree = prepared.times;
        self.outcome.seconds.kdtree = tree.kdtree;
        self.outcome.seconds.prepare += (clock.seconds().0 - tree.kdtree).max(0.0);
        self.outcome.cpu_seconds.kdtree = tree.kdtree_cpu;
        // What the thread did for the tree is in the tree's share already.
        self.outcome.cpu_seconds.prepare += (cpu - tree.kdtree_caller_cpu).max(0.0) + by_helpers;
        if let Some(facts) = &mut self.outcome.scene {
            facts.triangles = prepared.triangles;
            facts.emitters = prepared.emitters;
            facts.effects = prepared.effect_names().into_iter().map(str::to_owned).collect();
        }
        Ok(prepared)
    }

    /// Adds the studio where the asset's own light leaves it black: lamps that only light their inside, weak emission
    /// that was meant as a colour, lights too far away.
    fn lighten(&mut self, prepared: &mut PreparedScene, views: &[View]) -> Result<(), Failure> {
        let settings = &self.job.settings;
        let own = self.outcome.light.as_deref() == Some("own") && settings.environment == EnvironmentSettings::Auto;
        let Some(view) = views.first().filter(|_| own) else { return Ok(()) };
        let clock = StageClock::begin();
        let (dark, rendered) = exposure::is_dark(prepared, view, &settings.render, self.control)?;
        self.count(&rendered.tally(), None);
        if dark {
            prepared.relight(&EnvironmentSource::Studio, &settings.prepare);
            self.outcome.light = Some("own + studio".into());
            let message =
                "its own light leaves the picture black: the studio lights it as well (--env none: it does not)";
            self.outcome.warnings.push(Warning::new("own-light-too-dark", "", message));
        }
        self.outcome.seconds.render += clock.seconds().0;
        Ok(())
    }

    /// The exposure of all views, EV.
    fn exposure(&mut self, prepared: &PreparedScene, views: &[View]) -> Result<f64, Failure> {
        let settings = &self.job.settings;
        match settings.pictures.exposure {
            Exposure::Ev(ev) => Ok(ev),
            // Linear files are not exposed.
            Exposure::Auto if !settings.pictures.formats.contains(&PictureFormat::Png) => Ok(0.0),
            Exposure::Auto => {
                self.begin(Stage::Expose);
                let clock = StageClock::begin();
                let (ev, rendered) = exposure::meter(prepared, views, &settings.render, self.control)?;
                rendered.iter().for_each(|r| self.count(&r.tally(), None));
                self.outcome.seconds.render += clock.seconds().0;
                Ok(ev)
            }
        }
    }

    /// Counts what a render took; `view`: the one whose picture it is.
    pub fn count(&mut self, tally: &PassTally, view: Option<u32>) {
        self.outcome.cpu_seconds.render += tally.cpu_seconds;
        self.outcome.rays += tally.rays;
        self.outcome.count_dropped(&tally.dropped, view);
    }
}

fn hardly_found(rare: &RareLight) -> Warning {
    let what = if rare.roughness > 0.0 {
        "hardly found by paths: it comes as specks, so the bound of the error is stated further away, and `--error` takes 256 samples or more"
    } else {
        "not found by paths: it is missing, and the stated error does not know of it"
    };
    Warning::new("unsampled-caustics", "", format!("{rare} is {what}"))
}
