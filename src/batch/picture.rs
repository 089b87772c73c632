use super::failure::Failure;
use super::{Job, Outcome, Output, OutputRecord, job};
use crate::accuracy::Accuracy;
use crate::denoise::{Denoised, Denoiser};
use crate::film::{Film, Picture, Surfaces};
use crate::integrate::PassTally;
use crate::settings::{PathText, PictureFormat};
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
    /// The view in every format that is asked for, and without noise if that is: should that fail, the others are there.
    ///
    /// # Errors
    /// Why there are no pictures.
    pub fn encode(&self, job: &Job, outcome: &Outcome) -> Result<(Vec<Encoded>, Result<(), Failure>), Failure> {
        let settings = &job.settings.pictures;
        let picture = self.film.picture();
        let denoise = |program: &PathText| {
            let threads = rayon::current_num_threads();
            let denoised = Denoiser::new(&program.0).denoise(&picture, self.surfaces, threads);
            denoised.map_err(|e| Failure::new("denoiser", e))
        };
        let (denoised, failure) = match settings.denoise.as_ref().map(denoise).transpose() {
            Ok(denoised) => (denoised, Ok(())),
            Err(failure) => (None, Err(failure)),
        };
        let mut files = Vec::new();
        for format in &settings.formats {
            let path = job.output.picture(job.settings.views.turntable.map(|_| self.view), *format);
            let metadata = self.metadata(job, outcome);
            match format {
                PictureFormat::Png => {
                    files.push(self.png(job, path.clone(), &picture, &metadata)?);
                    if let Some(Denoised { picture, by }) = &denoised {
                        let metadata = Metadata { stated: None, denoised: Some(by.clone()), ..metadata };
                        files.push(self.png(job, Output::denoised(&path), picture, &metadata)?);
                    }
                }
                PictureFormat::Exr => {
                    let metadata = Metadata { denoised: denoised.as_ref().map(|d| d.by.clone()), ..metadata };
                    let (noise, without) = (self.film.noise(), denoised.as_ref().map(|d| &d.picture));
                    let layers = &settings.layers;
                    let bytes = exr::encode_with_layers(&picture, &noise, without, self.surfaces, layers, &metadata);
                    let bytes = bytes.map_err(|e| Failure::new("unwritable", e.to_string()))?;
                    files.push(self.encoded(job, *format, path, bytes, &metadata));
                }
            }
        }
        Ok((files, failure))
    }

    fn png(&self, job: &Job, path: PathBuf, picture: &Picture, metadata: &Metadata) -> Result<Encoded, Failure> {
        let p = &job.settings.pictures;
        let displayed = display::develop(picture, self.exposure, p.tonemap, p.background);
        let bytes = png::encode(&displayed, p.bits, metadata).map_err(|e| Failure::new("unwritable", e.to_string()))?;
        Ok(self.encoded(job, PictureFormat::Png, path, bytes, metadata))
    }

    fn encoded(&self, job: &Job, format: PictureFormat, path: PathBuf, bytes: Vec<u8>, metadata: &Metadata) -> Encoded {
        let mut record = self.record(job, format, job::slashed(&path), bytes.len() as u64);
        record.denoised.clone_from(&metadata.denoised);
        if let (PictureFormat::Png, Some(by)) = (format, &metadata.denoised) {
            // The error is that of the picture as it was rendered.
            (record.error, record.error_bound, record.relmse, record.relmse_bound) = (None, None, None, None);
            record.target_met = None;
            record.bias.push(format!("denoised by {by}: its error is not known"));
        }
        Encoded { path, bytes, record }
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
            denoised: None,
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
            reuse: self.film.shares,
            denoised: None,
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
