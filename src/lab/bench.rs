use super::cell::measure;
use super::identity::{content, key, metadata, text_of};
use super::reference::Effort;
use super::run::{Observer, Progress, Study, Subject, picture_path};
use super::{Cell, Reference, Store, Way};
use crate::accuracy::{Accuracy, CONFIDENCE, Display};
use crate::batch::{Job, Ready, StageSeconds, make_ready};
use crate::film::Film;
use crate::integrate::{PassTally, render_pass};
use crate::metrics::Show;
use crate::settings::{Exposure, PrepareSettings, Settings};
use crate::write::{atomic, display, png};
use kiln_formats::{Control, Stopped};
use std::time::Instant;

/// The share of an asset's budget that its reference may take.
const REFERENCE_SHARE: f64 = 0.35;
/// Seeds of references lie this far from those of pictures.
const REFERENCE_SEED: u64 = 0x5EED_0000_4E7E_4E2C;

/// Why a study of an asset did not come to its end.
pub(super) enum Ended {
    Stopped,
    Unwritable(String),
}

impl From<Stopped> for Ended {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

/// Where one asset is studied.
pub(super) struct Bench<'a> {
    pub study: &'a Study<'a>,
    pub job: &'a Job,
    pub index: usize,
    pub control: &'a Control,
    pub observer: &'a dyn Observer,
    /// Seconds of the asset's budget that are accounted for.
    pub done: f64,
}

impl Bench<'_> {
    fn tell(&self, doing: &str) {
        let assets = self.study.jobs.len() as f64;
        let share = (self.index as f64 + (self.done / self.study.budget).min(1.0)) / assets;
        self.observer.begins(&Progress { asset: &self.job.name, doing, share });
    }

    pub fn run(&mut self, subject: &mut Subject, store: &mut Store) -> Result<(), Ended> {
        let study = self.study;
        self.tell("import");
        let mut ready: Vec<(PrepareSettings, Ready)> = Vec::new();
        if !self.prepare(&self.job.settings.prepare, &mut ready, subject)? {
            return Ok(());
        }
        subject.exposure = ready[0].1.exposure;
        let show =
            Show { tonemap: self.job.settings.pictures.tonemap, exposure_ev: subject.exposure, background: [0; 3] };
        let display = Display::new(&self.job.settings.pictures, subject.exposure);
        let reference = self.reference(&ready[0].1, (&display, &show), subject, store)?;
        let spent = if study.reference_spp.is_some() { 0.0 } else { REFERENCE_SHARE * study.budget };
        self.done = spent;
        let runs = study.ways.len() as f64 * f64::from(study.seeds);
        let share = (study.budget - spent) / runs;
        let threads = rayon::current_num_threads() as f64;
        for number in 0..study.seeds {
            for way in study.ways {
                let settings = self.settings(way, number);
                self.tell(&format!("{}, seed {} of {}", way.name, number + 1, study.seeds));
                if !self.prepare(&settings.prepare, &mut ready, subject)? {
                    return Ok(());
                }
                let Some((_, own)) = ready.iter().find(|(p, _)| *p == settings.prepare) else { continue };
                let run = Run {
                    way,
                    settings: &settings,
                    ready: own,
                    reference: &reference,
                    display: &display,
                    show: &show,
                    share: share * threads,
                };
                let ended = self.cells(&run, subject, store);
                self.done += share;
                ended?;
            }
        }
        Ok(())
    }

    /// The asset's settings done in a way, with the seed number `number`.
    fn settings(&self, way: &Way, number: u32) -> Settings {
        let mut settings = way.of(&self.job.settings);
        settings.render.seed = self.job.settings.render.seed.wrapping_add(u64::from(number));
        settings
    }

    /// Makes the asset ready with these settings, once. `false`: it cannot be; the subject says why.
    fn prepare(
        &self,
        prepare: &PrepareSettings,
        ready: &mut Vec<(PrepareSettings, Ready)>,
        subject: &mut Subject,
    ) -> Result<bool, Ended> {
        if ready.iter().any(|(p, _)| p == prepare) {
            return Ok(true);
        }
        let mut job = self.job.clone();
        job.settings.prepare = *prepare;
        // One exposure for all.
        if !ready.is_empty() {
            job.settings.pictures.exposure = Exposure::Ev(subject.exposure);
        }
        match make_ready(&job, self.control, self.study.environment.clone()) {
            Ok(own) => {
                if ready.is_empty() {
                    subject.outcome = own.outcome.clone();
                }
                ready.push((*prepare, own));
                Ok(true)
            }
            Err(_) if self.control.is_stopped() => Err(Ended::Stopped),
            Err(outcome) => {
                subject.outcome = *outcome;
                Ok(false)
            }
        }
    }

    fn reference(
        &self,
        ready: &Ready,
        (display, show): (&Display, &Show),
        subject: &mut Subject,
        store: &Store,
    ) -> Result<Reference, Ended> {
        let stem = store.folder().join("references").join(&subject.stem);
        let mut settings = self.job.settings.clone();
        settings.render.seed = settings.render.seed.wrapping_add(REFERENCE_SEED);
        let key = key(&[&content(ready), &text_of(&settings).map_err(Ended::Unwritable)?]);
        let view = &ready.views[0];
        let texels = u64::from(view.width) * u64::from(view.height);
        let effort = match self.study.reference_spp {
            Some(spp) => Effort::Samples(spp),
            None => Effort::CpuSeconds(REFERENCE_SHARE * self.study.budget * rayon::current_num_threads() as f64),
        };
        let enough = |r: &Reference| match effort {
            Effort::Samples(spp) => r.facts.spp >= spp,
            Effort::CpuSeconds(limit) => r.facts.cpu_seconds >= 0.5 * limit,
        };
        let reference = match Reference::read(&stem, &key, show, texels).filter(enough) {
            Some(reference) => reference,
            None => {
                self.tell("reference");
                let scene = (&ready.scene, view);
                let made = Reference::make(scene, &settings.render, (&key, display, show), effort, self.control)?;
                let metadata = metadata(&subject.name, &settings.render, made.facts.spp);
                made.write(&stem, &metadata).map_err(Ended::Unwritable)?;
                made
            }
        };
        subject.reference = Some(reference.clone());
        Ok(reference)
    }

    /// Renders one way with one seed, with more and more samples, as long as the next step fits into its share.
    fn cells(&self, run: &Run, subject: &mut Subject, store: &mut Store) -> Result<(), Ended> {
        let facts = &run.reference.facts;
        let spp = facts.spp.to_string();
        let name = key(&[&content(run.ready), &text_of(run.settings).map_err(Ended::Unwritable)?, &facts.key, &spp]);
        let known = store.of_run(&name);
        let ladder = self.study.ladder;
        let next = known.last().map_or(ladder.first(), |c| run.next(ladder, c.spp, c.cpu_seconds.render));
        if next.is_none() {
            subject.cells.extend(known);
            return Ok(());
        }
        let view = &run.ready.views[0];
        let mut film = Film::new(view.width, view.height, view.show_environment);
        let (mut tally, clock, mut asleep) = (PassTally::default(), Instant::now(), 0.0);
        let mut next = ladder.first().copied();
        while let Some(spp) = next {
            let (render, samples) = (&run.settings.render, film.spp..spp);
            tally += render_pass(&run.ready.scene, view, render, &mut film, samples, self.control)?;
            let render = clock.elapsed().as_secs_f64() - asleep;
            let cell = match known.iter().find(|c| c.spp == spp) {
                Some(cell) => cell.clone(),
                None => {
                    let cell = self.cell(run, &name, &film, &tally, (render, subject))?;
                    let unwritable = |e: std::io::Error| Ended::Unwritable(format!("cells cannot be written: {e}"));
                    store.append(&cell).map_err(unwritable)?;
                    if run.settings.render.seed == self.job.settings.render.seed {
                        self.keep_picture(run, &film, subject, store)?;
                    }
                    self.observer.measured(&cell);
                    cell
                }
            };
            subject.cells.push(cell);
            // Measuring is no part of rendering.
            asleep = clock.elapsed().as_secs_f64() - render;
            next = run.next(ladder, spp, tally.cpu_seconds).copied();
        }
        Ok(())
    }

    fn cell(
        &self,
        run: &Run,
        name: &str,
        film: &Film,
        tally: &PassTally,
        (render, subject): (f64, &Subject),
    ) -> Result<Cell, Ended> {
        let picture = film.picture();
        let stated = Accuracy::of(film, run.display, CONFIDENCE);
        let measured = measure(film, &picture, run.reference, run.show).map_err(Ended::Unwritable)?;
        let (before, before_cpu) = (run.ready.outcome.seconds, run.ready.outcome.cpu_seconds);
        let mut seconds = StageSeconds { render: render + before.render, ..before };
        let mut cpu_seconds = StageSeconds { render: tally.cpu_seconds + before_cpu.render, ..before_cpu };
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
            nonfinite: tally.nonfinite,
        })
    }

    fn keep_picture(&self, run: &Run, film: &Film, subject: &Subject, store: &Store) -> Result<(), Ended> {
        let path = picture_path(store.folder(), &subject.stem, &run.way.name, film.spp);
        let pictures = &self.job.settings.pictures;
        let shown = display::develop(&film.picture(), subject.exposure, pictures.tonemap, pictures.background);
        let metadata = metadata(&subject.name, &run.settings.render, film.spp);
        let unwritable = |e: String| Ended::Unwritable(format!("{}: cannot be written: {e}", path.display()));
        let bytes = png::encode(&shown, pictures.bits, &metadata).map_err(|e| unwritable(e.to_string()))?;
        atomic::write(&path, &bytes).map_err(|e| unwritable(e.to_string()))
    }
}

/// One way with one seed.
struct Run<'a> {
    way: &'a Way,
    settings: &'a Settings,
    ready: &'a Ready,
    reference: &'a Reference,
    display: &'a Display,
    show: &'a Show,
    /// CPU seconds that it may take, about: what others do on the machine does not shorten a study.
    share: f64,
}

impl Run<'_> {
    /// The next number of samples, when it can be had within the share.
    fn next<'l>(&self, ladder: &'l [u32], spp: u32, cpu_seconds: f64) -> Option<&'l u32> {
        let next = ladder.iter().find(|n| **n > spp)?;
        (cpu_seconds * f64::from(*next) / f64::from(spp) <= self.share).then_some(next)
    }
}
