use super::bench::{Bench, Ended};
use super::cell::measure;
use super::identity::{content, key, metadata, text_of};
use super::run::{Subject, picture_path};
use super::{Cell, Reference, Store, Way};
use crate::accuracy::{Accuracy, Allotment, CONFIDENCE, Display, Progressive};
use crate::batch::{Ready, StageSeconds};
use crate::cpu_clock::CpuClock;
use crate::denoise::Denoiser;
use crate::film::{Film, Picture};
use crate::integrate::{PassTally, SurfaceSamples, render_until, shares_paths, surfaces};
use crate::metrics::Show;
use crate::settings::Settings;
use crate::write::{atomic, display, png};
use cpu_time::ProcessTime;
use std::time::Instant;

/// How many times its share a way with a goal may take before it is given up.
const PATIENCE: f64 = 2.0;

/// One way with one seed.
pub(super) struct Run<'a> {
    pub way: &'a Way,
    pub settings: &'a Settings,
    pub ready: &'a Ready,
    pub reference: &'a Reference,
    pub display: &'a Display,
    pub show: &'a Show,
    /// CPU seconds that it may take, about: what others do on the machine does not shorten a study.
    pub share: f64,
}

impl Run<'_> {
    /// The next number of samples, when it can be had within the share.
    fn next<'l>(&self, ladder: &'l [u32], spp: u32, cpu_seconds: f64) -> Option<&'l u32> {
        let next = ladder.iter().find(|n| **n > spp)?;
        (cpu_seconds * f64::from(*next) / f64::from(spp) <= self.share).then_some(next)
    }
}

/// What rendering a picture took.
struct Took {
    /// Seconds.
    wall: f64,
    cpu: f64,
    /// Samples dropped because they were not finite.
    nonfinite: u64,
}

impl Bench<'_> {
    /// Renders one way with one seed, with more and more samples, as long as the next step fits into its share.
    pub(super) fn cells(&self, run: &Run, subject: &mut Subject, store: &mut Store) -> Result<(), Ended> {
        let facts = &run.reference.facts;
        let spp = facts.spp.to_string();
        let name = key(&[&content(run.ready), &text_of(run.settings).map_err(Ended::Unwritable)?, &facts.key, &spp]);
        let known = store.of_run(&name);
        if run.way.preset.is_some() {
            return self.until_goal(run, (&name, known), subject, store);
        }
        let ladder = self.study.ladder;
        let next = known.last().map_or(ladder.first(), |c| run.next(ladder, c.spp, c.cpu_seconds.render));
        if next.is_none() {
            subject.cells.extend(known);
            return Ok(());
        }
        let view = &run.ready.views[0];
        let mut film = Film::new(view.width, view.height, view.show_environment);
        let mut allotment = Allotment::new(
            run.settings.render.allotted(shares_paths(&run.ready.scene, &run.settings.render)),
            *run.display,
        );
        let (mut tally, clock, mut asleep) = (PassTally::default(), Instant::now(), 0.0);
        let mut next = ladder.first().copied();
        while let Some(spp) = next {
            while film.spp < spp {
                let next = spp.min(allotment.reach(film.spp));
                let sharing = CpuClock::begin();
                let aim = (next, allotment.aim(&film, next, &sharing.helpers));
                tally.cpu_seconds += sharing.seconds();
                tally += render_until(&run.ready.scene, view, &run.settings.render, &mut film, aim, self.control)?;
            }
            let render = clock.elapsed().as_secs_f64() - asleep;
            let cell = match known.iter().find(|c| c.spp == spp) {
                Some(cell) => cell.clone(),
                None => {
                    let stated = Accuracy::of(&film, run.display, CONFIDENCE);
                    let stated = stated.map(|a| a.of_scene(&run.ready.scene));
                    let took = Took { wall: render, cpu: tally.cpu_seconds, nonfinite: tally.nonfinite };
                    self.keep(run, &name, (&film, stated, &took), subject, store)?
                }
            };
            subject.cells.push(cell);
            // Measuring is no part of rendering.
            asleep = clock.elapsed().as_secs_f64() - render;
            next = run.next(ladder, spp, tally.cpu_seconds).copied();
        }
        Ok(())
    }

    /// Renders one picture until its stated error is as small as the way asks for, with all that it takes to know that. Nothing
    /// is kept of one that takes much longer than its share.
    fn until_goal(
        &self,
        run: &Run,
        (name, known): (&str, Vec<Cell>),
        subject: &mut Subject,
        store: &mut Store,
    ) -> Result<(), Ended> {
        if !known.is_empty() {
            subject.cells.extend(known);
            return Ok(());
        }
        let (ready, settings) = (run.ready, run.settings);
        let (clock, cpu) = (Instant::now(), ProcessTime::now());
        let mut progressive =
            Progressive::new(&ready.scene, &ready.views[0], &settings.render, &settings.goal, *run.display);
        while progressive.step(self.control)?.is_none() {
            if cpu.elapsed().as_secs_f64() > PATIENCE * run.share {
                return Ok(());
            }
        }
        let finished = progressive.finish();
        let (wall, cpu) = (clock.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
        let took = Took { wall, cpu, nonfinite: finished.tally.nonfinite };
        let cell = self.keep(run, name, (&finished.film, finished.accuracy, &took), subject, store)?;
        subject.cells.push(cell);
        Ok(())
    }

    /// Measures a picture and writes down what was found.
    fn keep(
        &self,
        run: &Run,
        name: &str,
        (film, stated, took): (&Film, Option<Accuracy>, &Took),
        subject: &Subject,
        store: &mut Store,
    ) -> Result<Cell, Ended> {
        let (picture, more) = self.without_noise(run, film)?;
        // What a denoiser makes states no error.
        let stated = stated.filter(|_| more.is_none());
        let more = more.unwrap_or_default();
        let took = Took { wall: took.wall + more, cpu: took.cpu + more, nonfinite: took.nonfinite };
        let cell = self.cell(run, name, (film, &picture, stated, &took), subject)?;
        let unwritable = |e: std::io::Error| Ended::Unwritable(format!("cells cannot be written: {e}"));
        store.append(&cell).map_err(unwritable)?;
        if run.settings.render.seed == self.job.settings.render.seed {
            self.keep_picture(run, (film, &picture), subject, store)?;
        }
        self.observer.measured(&cell);
        Ok(cell)
    }

    /// The picture, and if a denoiser was at work the seconds that it took: of one thread, so wall and CPU seconds are the same.
    fn without_noise(&self, run: &Run, film: &Film) -> Result<(Picture, Option<f64>), Ended> {
        let picture = film.picture();
        let Some(program) = &run.settings.pictures.denoise else { return Ok((picture, None)) };
        let (render, view) = (&run.settings.render, &run.ready.views[0]);
        let samples = SurfaceSamples::Of(film);
        let (surfaces, looked) = surfaces(&run.ready.scene, view, render, samples, self.control)?;
        let clock = Instant::now();
        let denoised = Denoiser::new(&program.0).denoise(&picture, &surfaces, 1).map_err(Ended::Unwritable)?;
        Ok((denoised.picture, Some(looked.cpu_seconds + clock.elapsed().as_secs_f64())))
    }

    fn cell(
        &self,
        run: &Run,
        name: &str,
        (film, picture, stated, took): (&Film, &Picture, Option<Accuracy>, &Took),
        subject: &Subject,
    ) -> Result<Cell, Ended> {
        let measured = measure(film, picture, run.reference, run.show).map_err(Ended::Unwritable)?;
        let (before, before_cpu) = (run.ready.outcome.seconds, run.ready.outcome.cpu_seconds);
        let mut seconds = StageSeconds { render: took.wall + before.render, ..before };
        let mut cpu_seconds = StageSeconds { render: took.cpu + before_cpu.render, ..before_cpu };
        seconds.total = seconds.sum();
        cpu_seconds.total = cpu_seconds.sum();
        Ok(Cell {
            run: name.into(),
            asset: subject.name.clone(),
            way: run.way.name.clone(),
            seed: run.settings.render.seed,
            spp: film.spp,
            seconds,
            cpu_seconds,
            rmse: measured.comparison.rmse,
            relmse: measured.comparison.relmse,
            flip: measured.comparison.flip,
            flip_p95: measured.comparison.flip_p95,
            ssim: measured.comparison.ssim,
            stated_error: stated.map(|s| s.error),
            stated_bound: stated.map(|s| s.error_bound),
            luminance: measured.luminance,
            nonfinite: took.nonfinite,
        })
    }

    fn keep_picture(
        &self,
        run: &Run,
        (film, picture): (&Film, &Picture),
        subject: &Subject,
        store: &Store,
    ) -> Result<(), Ended> {
        let path = picture_path(store.folder(), &subject.stem, &run.way.name, film.spp);
        let pictures = &self.job.settings.pictures;
        let shown = display::develop(picture, subject.exposure, pictures.tonemap, pictures.background);
        let metadata = metadata(&subject.name, &run.settings.render, film.spp);
        let unwritable = |e: String| Ended::Unwritable(format!("{}: cannot be written: {e}", path.display()));
        let bytes = png::encode(&shown, pictures.bits, &metadata).map_err(|e| unwritable(e.to_string()))?;
        atomic::write(&path, &bytes).map_err(|e| unwritable(e.to_string()))
    }
}
