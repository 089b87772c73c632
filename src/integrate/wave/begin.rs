//! Camera paths, sixteen at a time.

use super::{Memory, Slot, Start, State, path};
use crate::integrate::View;
use crate::integrate::camera::NearCamera;
use crate::integrate::medium::Inside;
use crate::lanes::{LANES, Lanes, Words, Work};
use crate::sampling::{PathSampler, PathSamplers, Purpose};
use crate::settings::RenderSettings;

/// Begins the paths of samples of pixels.
pub(super) struct Begin<'a> {
    pub memory: &'a mut Memory,
    pub settings: &'a RenderSettings,
    pub view: &'a View,
    pub camera: NearCamera,
    /// Of the rays' cones.
    pub spread: f32,
    /// The tile's left upper pixel.
    pub corner: [u32; 2],
    pub starts: &'a [Start],
    /// Whether anybody will ask for states.
    pub with_states: bool,
}

impl Work for Begin<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { memory, settings, view, camera, spread, corner, starts, with_states } = self;
        for starts in starts.chunks(LANES) {
            let at = memory.slots.len();
            let of = |i: usize| starts.get(i).copied().unwrap_or(starts[0]);
            let word = |axis: usize| std::array::from_fn(|i| corner[axis] + of(i).pixel[axis]);
            let pixel = [l.load_words(&word(0)), l.load_words(&word(1))];
            let sample = std::array::from_fn(|i| of(i).sample);
            let samplers = PathSamplers::<L>::of_pixels(l, settings.sampler, settings.seed, pixel, &sample);
            let Some(samplers) = samplers else { return };
            let [dx, dy] = samplers.get_2d(0, Purpose::Pixel);
            let x = (pixel[0].to_floats() + dx) / view.width as f32;
            let y = (pixel[1].to_floats() + dy) / view.height as f32;
            let (origin, dir, skipped) = camera.rays(x, y);
            let (zero, one) = (l.splat(0.0), l.splat(1.0));
            let mut floats = [zero; path::FLOATS];
            for (k, (o, d)) in origin.components().into_iter().zip(dir.components()).enumerate() {
                floats[path::ORIGIN + k] = o;
                floats[path::DIR + k] = d;
                floats[path::THROUGHPUT + k] = one;
            }
            floats[path::ETA_SCALE] = one;
            floats[path::WIDTH] = skipped * spread;
            floats[path::SPREAD] = l.splat(spread);
            let [key, index] = samplers.words();
            let mut words = [l.word(0); path::WORDS];
            words[path::SLOT] = l.lane_numbers() + at as u32;
            words[path::KEY] = key;
            words[path::INDEX] = index;
            memory.paths.store::<L>(at, l.first(LANES), floats, words);
            memory.slots.resize(at + starts.len(), Slot::default());
            if with_states {
                let (key, index) = (key.array(), index.array());
                memory.states.extend((0..starts.len()).map(|i| State {
                    sampler: PathSampler::addressed(settings.sampler, key[i], index[i]),
                    inside: Inside::default(),
                }));
            }
        }
    }
}
