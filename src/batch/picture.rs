use super::{Job, Outcome, OutputRecord, job};
use crate::accuracy::Accuracy;
use crate::film::{Film, Surfaces};
use crate::integrate::PassTally;
use crate::settings::PictureFormat;
use crate::write::{Metadata, StatedError, display, exr, png};
use std::path::PathBuf;

/// A view that is rendered, ready to become files.
pub(super) struct Shot<'a> {
    pub film: &'a Film,
    pub accuracy: Option<Accuracy>,
    pub tally: &'a PassTally,
    /// What further layers are made of.
    pub surfaces: &'a Surfaces,
    /// Which of the asset's views, from 0.
    pub view: u32,
    /// EV.
    pub exposure: f64,
}

/// A file to be written.
pub(super) struct Encoded {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
    pub record: OutputRecord,
}

impl Shot<'_> {
    /// The view in every format that is asked for.
    ///
    /// # Errors
    /// A sentence.
    pub fn encode(&self, job: &Job, outcome: &Outcome) -> Result<Vec<Encoded>, String> {
        job.settings.pictures.formats.iter().map(|format| self.encode_as(*format, job, outcome)).collect()
    }

    fn encode_as(&self, format: PictureFormat, job: &Job, outcome: &Outcome) -> Result<Encoded, String> {
        let settings = &job.settings;
        let metadata = self.metadata(job, outcome);
        let picture = self.film.picture();
        let bytes = match format {
            PictureFormat::Png => {
                let p = &settings.pictures;
                let displayed = display::develop(&picture, self.exposure, p.tonemap, p.background);
                png::encode(&displayed, p.bits, &metadata).map_err(|e| e.to_string())?
            }
            PictureFormat::Exr => {
                let (noise, layers) = (self.film.noise(), &settings.pictures.layers);
                exr::encode_with_layers(&picture, &noise, self.surfaces, layers, &metadata)
                    .map_err(|e| e.to_string())?
            }
        };
        let path = job.output.picture(settings.views.turntable.map(|_| self.view), format);
        Ok(Encoded { record: self.record(job, format, job::slashed(&path), bytes.len() as u64), path, bytes })
    }

    fn metadata(&self, job: &Job, outcome: &Outcome) -> Metadata {
        Metadata {
            software: Metadata::software(),
            source: job.input.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            content: outcome.content.clone().unwrap_or_default(),
            settings: outcome.settings.clone().unwrap_or_default(),
            seed: job.settings.render.seed,
            spp: self.film.spp,
            view: self.view,
            stated: self.accuracy.map(|a| StatedError {
                error: a.error,
                error_bound: a.error_bound,
                relmse: a.relmse,
                relmse_bound: a.relmse_bound,
            }),
        }
    }

    fn record(&self, job: &Job, format: PictureFormat, path: String, bytes: u64) -> OutputRecord {
        let (width, height, spp) = (self.film.width, self.film.height, self.film.spp);
        let bound = self.accuracy.map(|a| a.error_bound);
        OutputRecord {
            path,
            format,
            bytes,
            view: self.view,
            width,
            height,
            spp,
            samples: self.film.samples(),
            exposure: self.exposure,
            error: self.accuracy.map(|a| a.error),
            error_bound: bound,
            relmse: self.accuracy.map(|a| a.relmse),
            relmse_bound: self.accuracy.map(|a| a.relmse_bound),
            target_met: job.settings.goal.error.map(|target| bound.is_some_and(|b| b <= target)),
            bias: self.bias(job),
        }
    }

    /// What was asked for that changes the expected picture, with how much where that is known.
    fn bias(&self, job: &Job) -> Vec<String> {
        let without: Vec<_> = job.settings.prepare.effects.without.iter().map(|effect| effect.name()).collect();
        let left_out = (!without.is_empty()).then(|| format!("without {} (--effects)", without.join(", ")));
        left_out.into_iter().chain(self.clamped(job)).collect()
    }

    fn clamped(&self, job: &Job) -> Option<String> {
        let limit = job.settings.render.clamp?;
        let kept: f64 = self.film.pixels.iter().flat_map(|p| p.replicate_sums()).map(|s| s[0] + s[1] + s[2]).sum();
        let all = kept + self.tally.clamped;
        let share = if all > 0.0 { 100.0 * self.tally.clamped / all } else { 0.0 };
        Some(format!("clamp {limit}: removed {share:.4} % of the light"))
    }
}
