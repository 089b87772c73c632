use super::schedule::FIRST_LOOK;
use super::{Accuracy, Allotment, Display, Schedule, Spreads, comes_as_specks, specks::ENOUGH_WITH_SPECKS};
use crate::cpu_clock::{CpuClock, Helpers};
use crate::film::Film;
use crate::integrate::{PassTally, View, render_until, shares_paths};
use crate::prepare::PreparedScene;
use crate::sampling::REPLICATES;
use crate::settings::{Goal, Integrator, RenderSettings};
use kiln_formats::{Control, Stopped};
use std::time::{Duration, Instant};

/// Why a render is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All samples were taken.
    Samples,
    /// The bound of the error is at or below the one asked for.
    Error,
    /// The time is up.
    Deadline,
}

/// A render under way, pass by pass.
///
/// After each pass the film is a whole picture. Which pass is the last follows from the scene, the settings and the seed
/// alone, unless a deadline decides it.
pub struct Progressive<'a> {
    scene: &'a PreparedScene,
    view: &'a View,
    settings: &'a RenderSettings,
    goal: &'a Goal,
    display: Display,
    schedule: Schedule,
    allotment: Allotment,
    film: Film,
    tally: PassTally,
    /// Times that the error was judged.
    looks: u32,
    accuracy: Option<Accuracy>,
    /// Wall seconds per sample of every pixel in the last pass.
    pace: f64,
}

/// What a render gives.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The sums behind the picture.
    pub film: Film,
    /// Rays, dropped samples and CPU seconds.
    pub tally: PassTally,
    /// Its error; `None` with one sample per pixel.
    pub accuracy: Option<Accuracy>,
}

impl<'a> Progressive<'a> {
    /// Before the first pass. At most `settings.spp` samples per pixel are taken, on average where noise decides who gets them.
    pub fn new(
        scene: &'a PreparedScene,
        view: &'a View,
        settings: &'a RenderSettings,
        goal: &'a Goal,
        display: Display,
    ) -> Self {
        let clock = CpuClock::begin();
        let film = Film::new(view.width, view.height, view.show_environment);
        let allotment = Allotment::new(settings.allotted(shares_paths(scene, settings)), display);
        Self {
            scene,
            view,
            settings,
            goal,
            display,
            schedule: Schedule::new(goal, settings.spp),
            allotment,
            film,
            tally: PassTally { cpu_seconds: clock.seconds(), ..PassTally::default() },
            looks: 0,
            accuracy: None,
            pace: 0.0,
        }
    }

    /// Does passes until the goal, the last sample or the deadline of `control` is reached. At least one pass must have been
    /// done by then.
    ///
    /// # Errors
    /// [`Stopped`] when `control` asks for it, or its deadline has passed before the first pass was done.
    pub fn run(&mut self, control: &Control) -> Result<Ended, Stopped> {
        loop {
            if let Some(ended) = self.step(control)? {
                return Ok(ended);
            }
        }
    }

    /// Does one pass and gives why there is no further one, if so.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn step(&mut self, control: &Control) -> Result<Option<Ended>, Stopped> {
        let spp = self.film.spp;
        let Some(next) = self.next(spp) else { return Ok(Some(Ended::Samples)) };
        let begun = spp > 0;
        if begun && !self.fits(next, control) {
            return Ok(Some(Ended::Deadline));
        }
        self.announce(control);
        let (clock, cpu) = (Instant::now(), CpuClock::begin());
        let aim = self.allotment.aim(&self.film, next, &cpu.helpers);
        self.tally.cpu_seconds += cpu.seconds();
        match render_until(self.scene, self.view, self.settings, &mut self.film, (next, aim), control) {
            Ok(tally) => self.tally += tally,
            Err(Stopped) if begun && !control.was_asked_to_stop() => return Ok(Some(Ended::Deadline)),
            Err(Stopped) => return Err(Stopped),
        }
        self.pace = clock.elapsed().as_secs_f64() / f64::from(next - spp);
        if self.look() {
            return Ok(Some(Ended::Error));
        }
        Ok(self.next(next).is_none().then_some(Ended::Samples))
    }

    /// Samples per pixel after the next pass.
    fn next(&self, spp: u32) -> Option<u32> {
        Some(self.schedule.after(spp)?.min(self.allotment.reach(spp)))
    }

    /// The film so far.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// What it has cost so far.
    pub fn tally(&self) -> &PassTally {
        &self.tally
    }

    /// The error of the film as it is.
    pub fn accuracy(&self) -> Option<Accuracy> {
        self.judge(&CpuClock::begin().helpers)
    }

    fn judge(&self, helpers: &Helpers) -> Option<Accuracy> {
        // Without an error asked for nobody looks.
        let accuracy = Spreads::of(&self.film, &self.display, helpers)?.accuracy_at_look(self.looks);
        Some(if self.specks() { accuracy.of_scene(self.scene) } else { accuracy })
    }

    /// Samples per pixel before which no bound ends the render.
    pub fn least_samples(&self) -> u32 {
        if self.specks() { ENOUGH_WITH_SPECKS } else { FIRST_LOOK }
    }

    /// Whether light comes as specks, which make bounds uncertain.
    fn specks(&self) -> bool {
        self.settings.integrator != Integrator::Whitted && comes_as_specks(self.scene)
    }

    /// The film with its error.
    pub fn finish(mut self) -> Finished {
        let clock = CpuClock::begin();
        let accuracy = self.accuracy.or_else(|| self.judge(&clock.helpers));
        self.tally.cpu_seconds += clock.seconds();
        Finished { film: self.film, tally: self.tally, accuracy }
    }

    /// Whether a pass would probably be done by the deadline.
    fn fits(&self, next: u32, control: &Control) -> bool {
        let Some(deadline) = control.deadline() else { return true };
        // Passes of one sample are too short to foretell anything by.
        let predicted = if self.film.spp < 4 { 0.0 } else { self.pace * f64::from(next - self.film.spp) };
        Instant::now() + Duration::from_secs_f64(predicted / OPTIMISM) < deadline
    }

    /// Judges the error where one was asked for, and gives whether it is small enough.
    fn look(&mut self) -> bool {
        let Some(target) = self.goal.error else { return false };
        self.accuracy = None;
        if self.film.spp < FIRST_LOOK || !self.film.spp.is_multiple_of(REPLICATES) {
            return false;
        }
        self.looks += 1;
        let clock = CpuClock::begin();
        self.accuracy = self.judge(&clock.helpers);
        self.tally.cpu_seconds += clock.seconds();
        self.film.spp >= self.least_samples() && self.accuracy.is_some_and(|a| a.error_bound <= target)
    }

    /// Tells the progress how many camera paths there will be, as far as one can know.
    fn announce(&self, control: &Control) {
        let spp = f64::from(self.film.spp);
        let foretold = match (self.goal.error, self.accuracy) {
            // The error falls with the root of the samples, or faster.
            (Some(target), Some(a)) => {
                (spp * (a.error_bound / target) * (a.error_bound / target)).max(f64::from(self.least_samples()))
            }
            _ => f64::from(self.settings.spp),
        };
        let taken = self.film.samples() as f64;
        let pixels = if spp > 0.0 { taken / spp } else { self.film.pixels.len() as f64 };
        control.begin_at(taken as u64, (foretold.min(f64::from(self.settings.spp)) * pixels) as u64);
    }
}

/// How much faster than the last pass the next one may turn out to be.
const OPTIMISM: f64 = 1.3;
