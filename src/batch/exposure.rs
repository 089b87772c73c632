use crate::film::Picture;
use crate::integrate::{Rendered, View, render};
use crate::math::luminance;
use crate::prepare::PreparedScene;
use crate::settings::RenderSettings;
use glam::Vec3;
use kiln_formats::{Control, Stopped};

/// Width and height of the metering pictures.
const SIZE: u32 = 32;
/// Camera paths per pixel of the metering pictures.
const SPP: u32 = 16;
/// Views of a turntable that are metered, evenly spread.
const VIEWS: usize = 4;
/// What the mean is brought to: the reflectance of a grey card.
const MIDDLE_GREY: f64 = 0.18;
/// Metered exposures stay within this many EV of 0.
const MOST_EV: f64 = 12.0;

/// Meters one exposure for all views by small pictures with fixed random numbers, so that it depends on the scene and
/// the views but not on the seed or the noise of the render. Gives EV and what was rendered for it.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn meter(
    scene: &PreparedScene,
    views: &[View],
    settings: &RenderSettings,
    control: &Control,
) -> Result<(f64, Vec<Rendered>), Stopped> {
    let settings = RenderSettings { spp: SPP, seed: 0, ..*settings };
    let count = views.len().min(VIEWS);
    let rendered = (0..count)
        .map(|k| {
            let view = &views[k * views.len() / count];
            render(scene, &View { width: SIZE, height: SIZE, ..view.clone() }, &settings, control)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let ev = middle_grey_ev(rendered.iter().map(|r| &r.picture));
    Ok((ev, rendered))
}

/// Camera paths per pixel of the look whether anything is lit.
const DARK_SPP: u32 = 8;
/// Width and height of that look.
const DARK_SIZE: u32 = 16;
/// Luminance below which a pixel counts as black; displayed it is at 15 %. A scene at night is above it nearly everywhere.
const BLACK: f32 = 0.02;
/// The share of what is covered that must not be black. Metal under lamps that are points is black but for its highlights,
/// while a ball that is half in its own shadow is what its author wanted.
const LEAST_LIT: f32 = 0.36;

/// Whether the first view shows next to nothing but black. Depends on scene and view alone, like [`meter`].
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn is_dark(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    control: &Control,
) -> Result<(bool, Rendered), Stopped> {
    let settings = RenderSettings { spp: DARK_SPP, seed: 0, ..*settings };
    let rendered = render(scene, &View { width: DARK_SIZE, height: DARK_SIZE, ..view.clone() }, &settings, control)?;
    let (mut covered, mut lit) = (0.0, 0.0);
    for [r, g, b, alpha] in &rendered.picture.pixels {
        covered += alpha;
        if luminance(Vec3::new(*r, *g, *b)) > BLACK * alpha {
            lit += alpha;
        }
    }
    Ok((lit < LEAST_LIT * covered, rendered))
}

/// The EV that brings the log-average luminance of what is covered to middle grey; 0 when nothing is lit.
fn middle_grey_ev<'a>(pictures: impl Iterator<Item = &'a Picture>) -> f64 {
    let (mut sum, mut weight) = (0.0f64, 0.0f64);
    for [r, g, b, alpha] in pictures.flat_map(|p| &p.pixels) {
        let alpha = f64::from(*alpha);
        let luminance = 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b);
        // Black does not count: its logarithm would drown everything else.
        if alpha > 0.0 && luminance / alpha > 1e-6 && luminance.is_finite() {
            sum += alpha * libm::log2(luminance / alpha);
            weight += alpha;
        }
    }
    if weight == 0.0 { 0.0 } else { (libm::log2(MIDDLE_GREY) - sum / weight).clamp(-MOST_EV, MOST_EV) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ev(pixels: Vec<[f32; 4]>) -> f64 {
        middle_grey_ev(std::iter::once(&Picture { width: pixels.len() as u32, height: 1, pixels }))
    }

    #[test]
    fn middle_grey_is_met() {
        assert!(ev(vec![[0.18, 0.18, 0.18, 1.0]]).abs() < 1e-6);
        assert!((ev(vec![[0.36, 0.36, 0.36, 1.0], [0.18, 0.18, 0.18, 0.5]]) + 1.0).abs() < 1e-6);
        // Uncovered and black pixels do not count.
        assert!((ev(vec![[0.045, 0.045, 0.045, 1.0], [0.0; 4], [0.0, 0.0, 0.0, 1.0]]) - 2.0).abs() < 1e-6);
        assert_eq!(ev(vec![[0.0; 4]]), 0.0);
        assert_eq!(ev(vec![[f32::NAN, 0.0, 0.0, 1.0]]), 0.0);
        assert_eq!(ev(vec![[1e30, 1e30, 1e30, 1.0]]), -MOST_EV);
    }
}
