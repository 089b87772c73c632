use super::budget::Budget;
use super::by_deadline::by_deadline;
use super::environment::{self, LoadedEnvironment};
use super::failure::{Failure, guarded};
use super::picture::Shot;
use super::read::{Read, note, read};
use super::sink::{FileSink, Sink};
use super::stages::{StageClock, peak_bytes};
use super::{Job, Outcome, SceneFacts, Stage, Status, digest, exposure, looks, selfcheck};
use crate::accuracy::{Display, Ended, Finished, Progressive};
use crate::film::Surfaces;
use crate::integrate::{PassTally, View, surfaces};
use crate::prepare::{EnvironmentSource, PreparedScene, prepare};
use crate::settings::{CameraChoice, EnvironmentSettings, Exposure, PictureFormat, PrepareSettings, Settings};
use kiln_formats::{Control, ErrorCode, Format, Scene, Stopped, Warning};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Rays that a path takes, about: what is planned for does not have to be exact.
const RAYS_PER_PATH: u64 = 6;

/// Camera rays of a pixel behind the layers that tell of surfaces, at most.
const MOST_SURFACE_SAMPLES: u32 = 64;

/// What surrounds a job.
pub struct Desk<'a> {
    /// Takes the finished files.
    pub sink: &'a dyn Sink,
    /// Told of each stage before it begins, on the thread that works.
    pub on_stage: &'a (dyn Fn(Stage) + Sync),
    /// The job's environment file where it has been read already.
    pub environment: Option<Arc<LoadedEnvironment>>,
}

/// Turns one asset into pictures in its output folder, on the current rayon pool.
///
/// Never panics and never prints: whatever goes wrong is in the outcome. `control` carries progress out (of the stage
/// under way) and the wish to stop in.
pub fn run_asset(job: &Job, control: &Control) -> Outcome {
    let sink = FileSink { folder: job.output.folder.clone() };
    run_asset_with(job, control, &Desk { sink: &sink, on_stage: &|_| (), environment: None })
}

/// As [`run_asset`], with the files going to a sink and the stages being told.
pub fn run_asset_with(job: &Job, control: &Control, desk: &Desk) -> Outcome {
    if job.settings.look.are_many() {
        return looks::run(job, control, desk);
    }
    let clock = StageClock::begin();
    let mut outcome = Outcome::of(job);
    let views = &job.settings.views;
    let budget = Budget::begin(&job.settings.goal, control, u64::from(views.width) * u64::from(views.height));
    let control = &budget.before_the_first_pass(control);
    let work = AssertUnwindSafe(|| Work { job, control, desk, budget, framed: false, outcome: &mut outcome }.run());
    let ended = catch_unwind(work).unwrap_or_else(|panic| Err(Failure::of_panic(&*panic)));
    selfcheck::conclude(&mut outcome, matches!(ended, Ok(Ended::Deadline)));
    match ended {
        Ok(Ended::Deadline) => outcome.status = Status::Partial,
        Ok(_) if outcome.warnings.is_empty() => outcome.status = Status::Ok,
        Ok(_) => outcome.status = Status::Warned,
        Err(failure) => {
            let late = failure.stopped && !control.was_asked_to_stop();
            let failure = if late { Failure::late(&job.settings.goal, outcome.outputs.is_empty()) } else { failure };
            outcome.status = match (failure.stopped, outcome.outputs.is_empty()) {
                (true, true) if !late => Status::Skipped,
                (true, false) => Status::Partial,
                _ => Status::Failed,
            };
            outcome.error_code = Some(failure.code);
            outcome.error_message = Some(failure.message);
        }
    }
    outcome.seconds.total = clock.seconds().0;
    outcome.cpu_seconds.total = outcome.cpu_seconds.sum();
    outcome.peak_bytes = peak_bytes();
    outcome
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
    fn run(&mut self) -> Result<Ended, Failure> {
        let (prepared, views, exposure) = self.make_ready()?;
        let mut all = Ended::Samples;
        for index in 0..views.len() {
            let (ended, finished, surfaces) = self.render(&prepared, &views, index, exposure)?;
            let place = (index as u32, views.len());
            self.write(&finished, &surfaces, place, exposure)?;
            if ended? == Ended::Deadline {
                all = Ended::Deadline;
            }
        }
        if self.control.deadline().is_some() {
            // Giving back gigabytes takes a while that the deadline does not leave.
            let _ = std::thread::Builder::new().spawn(move || drop(prepared));
        }
        Ok(all)
    }

    /// Looks at what lies at a view's pixels, if that is asked for.
    fn surfaces(&mut self, prepared: &PreparedScene, view: &View) -> Result<Surfaces, Stopped> {
        let Settings { render, pictures, .. } = &self.job.settings;
        if pictures.layers.is_empty() || !pictures.formats.contains(&PictureFormat::Exr) {
            return Ok(Surfaces::default());
        }
        let (surfaces, tally) = surfaces(prepared, view, render, render.spp.min(MOST_SURFACE_SAMPLES), self.control)?;
        self.count(&tally, None);
        Ok(surfaces)
    }

    /// Renders a view, pass by pass. Stopped after the first pass, it gives the picture so far.
    fn render(
        &mut self,
        prepared: &PreparedScene,
        views: &[View],
        index: usize,
        exposure: f64,
    ) -> Result<(Result<Ended, Stopped>, Finished, Surfaces), Failure> {
        self.begin(Stage::Render { view: index as u32, views: views.len() as u32 });
        let clock = StageClock::begin();
        let settings = &self.job.settings;
        let display = Display::new(&settings.pictures, exposure);
        let surfaces = self.surfaces(prepared, &views[index])?;
        let mut progressive = Progressive::new(prepared, &views[index], &settings.render, &settings.goal, display);
        let ended = progressive.step(self.control)?;
        if ended.is_none() && index == 0 && self.budget.affords_trial() {
            let trial = StageClock::begin();
            let shot = Shot {
                film: progressive.film(),
                accuracy: progressive.accuracy(),
                tally: progressive.tally(),
                surfaces: &surfaces,
                view: 0,
                exposure,
            };
            shot.encode(self.job, self.outcome).map_err(|e| Failure::new("unwritable", e))?;
            self.budget.learn(&trial);
        }
        let ended = match ended {
            Some(ended) => Ok(ended),
            None => progressive.run(&self.budget.of_view(self.control, views.len() - index)),
        };
        let finished = progressive.finish();
        self.count(&finished.tally, Some(index as u32));
        self.outcome.seconds.render += clock.seconds().0;
        Ok((ended, finished, surfaces))
    }

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
    fn begin(&self, stage: Stage) {
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
        let read = by_deadline(self.control, move |control| read(&job, control));
        // A failed import costs time too.
        (self.outcome.seconds.import, self.outcome.cpu_seconds.import) = clock.seconds();
        let ((touched, read), cpu) = read?;
        self.outcome.cpu_seconds.import = self.outcome.cpu_seconds.import.max(cpu);
        note(self.outcome, self.job, &touched);
        let Read { imported, views } = read?;
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
        self.outcome.seconds.import = clock.seconds().0;
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
        let planned = pixels.saturating_mul(u64::from(self.job.settings.render.spp) * RAYS_PER_PATH);
        let settings = PrepareSettings { planned_rays: Some(planned), ..self.job.settings.prepare };
        let work = move |control: &Control| guarded(|| prepare(scene, &environment, &settings, control));
        let (prepared, cpu) = by_deadline(self.control, work)?;
        let prepared = prepared??;
        let tree = prepared.times;
        self.outcome.seconds.kdtree = tree.kdtree;
        self.outcome.seconds.prepare = (clock.seconds().0 - tree.kdtree).max(0.0);
        self.outcome.cpu_seconds.kdtree = tree.kdtree_cpu;
        // What the thread did for the tree is in the tree's share already.
        self.outcome.cpu_seconds.prepare = (cpu - tree.kdtree_caller_cpu).max(0.0);
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
    fn count(&mut self, tally: &PassTally, view: Option<u32>) {
        self.outcome.cpu_seconds.render += tally.cpu_seconds;
        self.outcome.rays += tally.rays;
        self.outcome.count_dropped(&tally.dropped, view);
    }

    /// Encodes and writes one view in every format.
    fn write(
        &mut self,
        finished: &Finished,
        surfaces: &Surfaces,
        (index, views): (u32, usize),
        exposure: f64,
    ) -> Result<(), Failure> {
        self.begin(Stage::Write);
        let clock = StageClock::begin();
        let Finished { film, tally, accuracy } = finished;
        let shot = Shot { film, accuracy: *accuracy, tally, surfaces, view: index, exposure };
        for file in shot.encode(self.job, self.outcome).map_err(|e| Failure::new("unwritable", e))? {
            let put = self.desk.sink.put(&file.path, file.bytes);
            put.map_err(|e| Failure::unwritable(&file.record.path, &e))?;
            self.outcome.outputs.push(file.record);
        }
        selfcheck::note(
            self.outcome,
            selfcheck::of_view(&film.picture(), exposure, self.framed, &self.job.settings),
            index,
            views,
        );
        let (wall, cpu) = clock.seconds();
        self.outcome.seconds.write += wall;
        self.outcome.cpu_seconds.write += cpu;
        Ok(())
    }
}
