use super::failure::Failure;
use super::picture::Shot;
use super::stages::StageClock;
use super::work::Work;
use super::{Stage, selfcheck};
use crate::accuracy::{Display, Ended, Finished, Progressive};
use crate::film::Surfaces;
use crate::integrate::{SurfaceSamples, View, surfaces};
use crate::prepare::PreparedScene;
use crate::settings::{PictureFormat, Settings};
use kiln_formats::{Control, Stopped};

impl Work<'_> {
    /// Does all of the job.
    ///
    /// # Errors
    /// Why it did not come to its end; pictures written until then stay.
    pub fn run(&mut self) -> Result<Ended, Failure> {
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
    fn surfaces(
        &mut self,
        prepared: &PreparedScene,
        view: &View,
        samples: SurfaceSamples,
        control: &Control,
    ) -> Result<Surfaces, Stopped> {
        let Settings { render, pictures, .. } = &self.job.settings;
        let layers = !pictures.layers.is_empty() && pictures.formats.contains(&PictureFormat::Exr);
        // They guide the denoiser.
        if !layers && pictures.denoise.is_none() {
            return Ok(Surfaces::default());
        }
        let (surfaces, tally) = surfaces(prepared, view, render, samples, control)?;
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
        // A deadline leaves no time for it afterwards.
        let before = self.control.deadline().is_some().then_some(SurfaceSamples::All(settings.render.spp));
        let mut surfaces = match before {
            Some(samples) => self.surfaces(prepared, &views[index], samples, self.control)?,
            None => Surfaces::default(),
        };
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
            let _ = shot.encode(self.job, self.outcome)?;
            self.budget.learn(&trial);
        }
        let ended = match ended {
            Some(ended) => Ok(ended),
            None => progressive.run(&self.budget.of_view(self.control, views.len() - index)),
        };
        let finished = progressive.finish();
        if before.is_none() {
            // Nothing stops it: what has been rendered until somebody asks to stop is to be written, with its layers.
            let samples = SurfaceSamples::Of(&finished.film);
            surfaces = self.surfaces(prepared, &views[index], samples, &Control::default())?;
        }
        self.count(&finished.tally, Some(index as u32));
        self.outcome.seconds.render += clock.seconds().0;
        Ok((ended, finished, surfaces))
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
        let (files, denoised) = shot.encode(self.job, self.outcome)?;
        for file in files {
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
        denoised
    }
}
