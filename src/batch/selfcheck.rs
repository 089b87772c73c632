//! What a picture shows of itself: whether anything is there, lit, whole and not burnt out.

use super::Outcome;
use crate::accuracy::Ended;
use crate::film::Picture;
use crate::settings::{Background, PictureFormat, Settings};
use crate::write::display::Developer;
use kiln_formats::Warning;

/// Coverage below which a pixel counts as empty.
const EMPTY: f32 = 1.0 / 510.0;
/// Displayed level (of 1) at or below which all channels count as black.
const BLACK: f32 = 2.5 / 255.0;
/// The share of the covered area that is black in a black picture.
const ALL_BLACK: f64 = 0.99;
/// Displayed level (of 1) at or above which all channels count as burnt out.
const BURNT: f32 = 254.5 / 255.0;
/// The share of the covered area that may be burnt out.
const MOST_BURNT: f64 = 0.05;

/// Smaller pictures are not judged by their edges: the margin of automatic cameras is less than a pixel there.
const LEAST_SIDE: u32 = 32;

/// What is to be looked for.
pub(super) struct Check {
    /// How the picture is displayed; `None`: it is not, so nothing is said about black and white.
    pub developer: Option<Developer>,
    /// Whether the asset is meant to be in the picture as a whole.
    pub whole: bool,
    /// Whether empty pixels are empty, and not the environment.
    pub empty_is_empty: bool,
}

/// Looks at the picture of a view; `framed`: the asset is meant to be in it as a whole.
pub(super) fn of_view(picture: &Picture, exposure: f64, framed: bool, settings: &Settings) -> Vec<Warning> {
    let p = &settings.pictures;
    let displayed = p.formats.contains(&PictureFormat::Png);
    // A background that is laid under says nothing about the asset.
    let developer = displayed.then(|| Developer::new(exposure, p.tonemap, Background::Transparent));
    let empty_is_empty = p.background != Background::Environment;
    check(picture, &Check { developer, whole: framed, empty_is_empty })
}

/// Looks at a picture.
pub(super) fn check(picture: &Picture, check: &Check) -> Vec<Warning> {
    let mut found = Vec::new();
    let mut warn = |code: &str, message: String| found.push(Warning::new(code, "", message));
    let covered: f64 = picture.pixels.iter().map(|p| f64::from(p[3])).sum();
    if check.empty_is_empty && picture.pixels.iter().all(|p| p[3] < EMPTY) {
        warn("blank-picture", "nothing of the asset is in the picture".into());
        return found;
    }
    if let Some(developer) = &check.developer {
        let (mut black, mut burnt) = (0.0, 0.0);
        for pixel in picture.pixels.iter().filter(|p| p[3] >= EMPTY) {
            let [r, g, b, _] = developer.develop(*pixel);
            let weight = f64::from(pixel[3]);
            black += if r.max(g).max(b) <= BLACK { weight } else { 0.0 };
            burnt += if r.min(g).min(b) >= BURNT { weight } else { 0.0 };
        }
        if black >= ALL_BLACK * covered {
            warn("black-picture", "what is in the picture is black".into());
        }
        if burnt > MOST_BURNT * covered {
            warn("clipped-highlights", format!("{:.0} % of what is in the picture is white", 100.0 * burnt / covered));
        }
    }
    if check.whole && check.empty_is_empty && picture.width.min(picture.height) >= LEAST_SIDE {
        let (cut, edge) = edges(picture);
        // Where it goes all around, the camera is within it.
        if cut > 0 && cut < edge {
            warn("cropped", format!("the asset goes on beyond {cut} of the picture's {edge} edge pixels"));
        }
    }
    found
}

/// How many of the pixels at the edges are mostly covered, and how many there are.
fn edges(picture: &Picture) -> (usize, usize) {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let is_edge = |index: usize| {
        let (x, y) = (index % width, index / width);
        x == 0 || y == 0 || x + 1 == width || y + 1 == height
    };
    let edge = picture.pixels.iter().enumerate().filter(|(index, _)| is_edge(*index));
    edge.fold((0, 0), |(cut, all), (_, pixel)| (cut + usize::from(pixel[3] > 0.5), all + 1))
}

/// Adds what was found in a view to an outcome; of many views, the first speaks for all with the same fault.
pub(super) fn note(outcome: &mut Outcome, found: Vec<Warning>, view: u32, views: usize) {
    for mut warning in found {
        if !outcome.warnings.iter().any(|known| known.code == warning.code) {
            if views > 1 {
                warning.place = format!("view {view}");
            }
            outcome.warnings.push(warning);
        }
    }
}

/// Adds what the whole of the work says; `ended`: how the renders did, if nothing went wrong.
pub(super) fn conclude(outcome: &mut Outcome, ended: Option<Ended>) {
    if outcome.nonfinite > 0 {
        let message = format!("{} samples were not finite and do not count", outcome.nonfinite);
        outcome.warnings.push(Warning::new("nonfinite-samples", "", message));
    }
    let missed = outcome.outputs.iter().find(|output| output.target_met == Some(false));
    if let (Some(Ended::Samples), Some(output)) = (ended, missed) {
        let spp = output.spp;
        let message =
            format!("after {spp} samples, as many as there are to be, the error may still be above the one asked for");
        outcome.warnings.push(Warning::new("error-not-met", "", message));
    }
    if ended == Some(Ended::Deadline) {
        let message = "the time was over before the picture was as good as asked for".to_owned();
        outcome.warnings.push(Warning::new("time-cut", "", message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::ToneMap;

    fn codes(pixels: Vec<[f32; 4]>, whole: bool) -> Vec<String> {
        let picture = Picture { width: SIDE as u32, height: SIDE as u32, pixels };
        let developer = Some(Developer::new(0.0, ToneMap::default(), Background::Transparent));
        let found = check(&picture, &Check { developer, whole, empty_is_empty: true });
        found.into_iter().map(|w| w.code).collect()
    }

    const SIDE: usize = 40;

    /// A square of pixels with one of 20 × 20 in the middle, moved to the right.
    fn block(color: [f32; 4], shift: usize) -> Vec<[f32; 4]> {
        let inside = |i: usize| (10..30).contains(&(i / SIDE)) && (10 + shift..30 + shift).contains(&(i % SIDE));
        (0..SIDE * SIDE).map(|i| if inside(i) { color } else { [0.0; 4] }).collect()
    }

    #[test]
    fn good_pictures_pass_and_bad_ones_are_named() {
        let grey = [0.2, 0.2, 0.2, 1.0];
        assert_eq!(codes(block(grey, 0), true), [""; 0]);
        assert_eq!(codes(vec![[0.0; 4]; SIDE * SIDE], true), ["blank-picture"]);
        assert_eq!(codes(block([0.0, 0.0, 0.0, 1.0], 0), true), ["black-picture"]);
        assert_eq!(codes(block([0.0, 0.0, 0.0, 0.5], 0), true), ["black-picture"]);
        assert_eq!(codes(block([900.0, 900.0, 900.0, 1.0], 0), true), ["clipped-highlights"]);
        assert_eq!(codes(block(grey, 10), true), ["cropped"]);
        assert_eq!(codes(block(grey, 10), false), [""; 0], "a camera of its own may cut");
        assert_eq!(codes(vec![grey; SIDE * SIDE], true), [""; 0], "from within");
        // A red lamp is bright and not burnt out; one black pixel of many is none.
        assert_eq!(codes(block([0.9, 0.0, 0.0, 1.0], 0), true), [""; 0]);
    }

    #[test]
    fn frames_are_told_once() {
        let mut outcome = Outcome::skipped("a", 0);
        let dark = || vec![Warning::new("black-picture", "", "dark")];
        note(&mut outcome, dark(), 2, 4);
        note(&mut outcome, dark(), 3, 4);
        let places: Vec<_> = outcome.warnings.iter().map(|w| w.place.as_str()).collect();
        assert_eq!(places, ["view 2"]);
    }
}
