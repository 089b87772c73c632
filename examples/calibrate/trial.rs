use kiln::accuracy::{Accuracy, CONFIDENCE, Display, Progressive};
use kiln::batch::Ready;
use kiln::film::Film;
use kiln::integrate::View;
use kiln::prepare::PreparedScene;
use kiln::settings::{Goal, PictureSettings, RenderSettings};
use kiln::{Control, Stopped};

/// The errors that are asked for.
pub const TARGETS: [f64; 3] = [8.0, 4.0, 2.0];
/// Samples per pixel at which every render is looked at.
pub const FIXED: [u32; 2] = [16, 64];

/// A picture of one seed, with what it states and what is true.
pub struct Row {
    pub asset: String,
    /// `error 4` or `spp 64`.
    pub way: String,
    pub seed: u64,
    pub spp: u32,
    pub stated: Accuracy,
    /// RMS error as displayed.
    pub error: f64,
    pub relmse: f64,
}

struct Look {
    way: String,
    spp: u32,
    stated: Accuracy,
    means: Vec<[f64; 4]>,
}

struct Seed {
    looks: Vec<Look>,
    spp: u32,
    /// Mean of all samples, and the error that it states.
    means: Vec<[f64; 4]>,
    last: Accuracy,
}

fn means(film: &Film) -> Vec<[f64; 4]> {
    film.pixels.iter().map(|p| p.mean()).collect()
}

fn render(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    display: Display,
) -> Result<Option<Seed>, Stopped> {
    // Never reached: the render goes on through all the targets.
    let goal = Goal { error: Some(1e-9), time: None };
    let mut progressive = Progressive::new(scene, view, settings, &goal, display);
    let mut looks: Vec<Look> = Vec::new();
    let mut targets = TARGETS.iter().peekable();
    // As `--error` would, a picture with specks takes more samples before a bound counts.
    let least = progressive.least_samples();
    loop {
        let ended = progressive.step(&Control::default())?;
        let (film, Some(judged)) = (progressive.film(), progressive.accuracy()) else { return Ok(None) };
        let mut look = |way: String, stated| looks.push(Look { way, spp: film.spp, stated, means: means(film) });
        while let Some(target) = targets.next_if(|t| film.spp >= least && judged.error_bound <= **t) {
            look(format!("error {target}"), judged);
        }
        if FIXED.contains(&film.spp) {
            let stated = Accuracy::of(film, &display, CONFIDENCE).map(|a| a.of_scene(scene));
            stated.into_iter().for_each(|stated| look(format!("spp {}", film.spp), stated));
        }
        let enough = targets.peek().is_none() && film.spp >= FIXED[1];
        if ended.is_some() || enough {
            return Ok(Some(Seed { looks, spp: film.spp, means: means(film), last: judged }));
        }
    }
}

/// What renders are compared with: a picture for each seed, and the squared errors that it has itself.
struct Converged {
    picture: Box<dyn Fn(usize) -> Vec<[f64; 4]>>,
    error: f64,
    relmse: f64,
}

impl Converged {
    /// The mean of all seeds but one.
    fn others(rendered: &[Seed]) -> Self {
        let samples: f64 = rendered.iter().map(|s| f64::from(s.spp)).sum();
        let pixels = rendered.first().map_or(0, |s| s.means.len());
        let sum = |p: usize, c: usize| rendered.iter().map(|s| s.means[p][c] * f64::from(s.spp)).sum::<f64>();
        let sums: Vec<[f64; 4]> = (0..pixels).map(|p| std::array::from_fn(|c| sum(p, c))).collect();
        let own: Vec<Vec<[f64; 4]>> = rendered.iter().map(|s| s.means.clone()).collect();
        let spp: Vec<f64> = rendered.iter().map(|s| f64::from(s.spp)).collect();
        // Squared errors fall at least as fast as the number of samples; replicates of all seeds are independent.
        let noise = |get: fn(&Accuracy) -> f64| {
            let n = rendered.len() as f64;
            rendered.iter().map(|s| get(&s.last)).sum::<f64>() / n / (n - 1.0)
        };
        let picture = move |k: usize| {
            let other = |p: usize, c: usize| (sums[p][c] - own[k][p][c] * spp[k]) / (samples - spp[k]);
            (0..pixels).map(|p| std::array::from_fn(|c| other(p, c))).collect()
        };
        Self { picture: Box::new(picture), error: noise(|a| a.error * a.error), relmse: noise(|a| a.relmse) }
    }

    /// A render with many samples.
    fn render(ready: &Ready, spp: u32, display: Display) -> Result<Self, Stopped> {
        let settings = RenderSettings { seed: 1 << 40, spp, ..RenderSettings::default() };
        let goal = Goal::default();
        let mut progressive = Progressive::new(&ready.scene, &ready.views[0], &settings, &goal, display);
        progressive.run(&Control::default())?;
        let accuracy = Accuracy::of(progressive.film(), &display, CONFIDENCE);
        let means = means(progressive.film());
        let own = |get: fn(&Accuracy) -> f64| accuracy.as_ref().map_or(0.0, get);
        println!("converged picture: error {:.2}", own(|a| a.error));
        Ok(Self {
            picture: Box::new(move |_| means.clone()),
            error: own(|a| a.error * a.error),
            relmse: own(|a| a.relmse),
        })
    }
}

/// All looks at renders with the seeds from 1, done this `way`, against a picture of `converged` samples or of all other seeds.
pub fn run(
    asset: &str,
    ready: &Ready,
    way: &RenderSettings,
    seeds: u64,
    converged: Option<u32>,
) -> Result<Vec<Row>, Stopped> {
    let display = Display::new(&PictureSettings::default(), ready.exposure);
    let mut rendered = Vec::new();
    for seed in 1..=seeds {
        let settings = RenderSettings { seed, ..*way };
        rendered.extend(render(&ready.scene, &ready.views[0], &settings, display)?);
    }
    let reference = match converged {
        Some(spp) => Converged::render(ready, spp, display)?,
        None => Converged::others(&rendered),
    };
    let mut rows = Vec::new();
    for (k, own) in rendered.iter().enumerate() {
        let (seed, converged) = (k as u64 + 1, (reference.picture)(k));
        for look in &own.looks {
            let (square, relative) = difference(&look.means, &converged, &display);
            rows.push(Row {
                asset: asset.into(),
                way: look.way.clone(),
                seed,
                spp: look.spp,
                stated: look.stated,
                error: (square - reference.error).max(0.0).sqrt(),
                relmse: (relative - reference.relmse).max(0.0),
            });
        }
    }
    Ok(rows)
}

/// Mean squared difference as displayed, and relMSE, over the pixels that either covers.
fn difference(a: &[[f64; 4]], converged: &[[f64; 4]], display: &Display) -> (f64, f64) {
    let (mut square, mut relative, mut count) = (0.0, 0.0, 0.0);
    for (x, mu) in a.iter().zip(converged).filter(|(x, mu)| x[3] > 0.0 || mu[3] > 0.0) {
        let (shown, wanted) = (display.levels(x.map(|v| v as f32)), display.levels(mu.map(|v| v as f32)));
        count += 3.0;
        for c in 0..3 {
            square += (shown[c] - wanted[c]).powi(2);
            relative += (x[c] - mu[c]).powi(2) / (mu[c] * mu[c] + 0.01);
        }
    }
    (square / f64::max(count, 1.0), relative / f64::max(count, 1.0))
}
