use super::climb::Run;
use super::identity::{content, key, metadata, text_of};
use super::reference::Effort;
use super::run::{Observer, Progress, Study, Subject};
use super::{Reference, Store, Way};
use crate::accuracy::Display;
use crate::batch::{Job, Ready, make_ready};
use crate::metrics::Show;
use crate::settings::{Exposure, PrepareSettings, Settings};
use kiln_formats::{Control, Stopped};

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
}
