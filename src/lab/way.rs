use crate::denoise::{Denoiser, PROGRAM};
use crate::settings::{
    Adaptive, Caustics, Effect, EffectSet, EffectSettings, KdTreeBuilder, PathText, Preset, Reuse, SamplerKind,
    Settings, Strategy, roulette_after,
};
use clap::ValueEnum;
use serde::Serialize;

/// A way of rendering: what it does otherwise than the settings of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Way {
    /// One word.
    pub name: String,
    /// What it is, for people.
    pub title: String,
    /// How direct light is estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strategy: Option<Strategy>,
    /// Where random numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampler: Option<SamplerKind>,
    /// How the kd-tree is built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kdtree: Option<KdTreeBuilder>,
    /// Scattering events per path at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_depth: Option<u32>,
    /// Light samples per vertex.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light_samples: Option<u32>,
    /// Scattering events before Russian roulette.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roulette: Option<u32>,
    /// Which effects are simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<EffectSettings>,
    /// Whether noise decides which pixels get more samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adaptive>,
    /// Whether pixels use each other's paths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reuse: Option<Reuse>,
    /// How caustics are found.
    pub caustics: Option<Caustics>,
    /// The program that removes the noise of what was rendered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoise: Option<PathText>,
    /// A goal instead of growing samples: one picture, when its stated error is small enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
}

/// The ways that have a name: name, group, title, and what they do otherwise.
pub const WAYS: [(&str, &str, &str, &str); 29] = [
    ("kiln", "strategies", "Kiln's own way: MIS, Sobol' points, SAH tree", ""),
    ("light", "strategies", "light sampling alone", "strategy=light"),
    ("bsdf", "strategies", "BSDF sampling alone", "strategy=bsdf"),
    ("cosine", "strategies", "cosine-weighted directions", "strategy=cosine"),
    ("hemisphere", "strategies", "uniform directions on the hemisphere", "strategy=hemisphere"),
    ("pcg", "samplers", "independent random numbers (PCG hash)", "sampler=pcg"),
    ("lcg", "samplers", "independent random numbers (LCG in sequence)", "sampler=lcg"),
    ("xorshift32", "samplers", "independent random numbers (xorshift32 in sequence)", "sampler=xorshift32"),
    ("median", "trees", "kd-tree split at medians", "kdtree=median"),
    ("sampled", "trees", "kd-tree split at random samples (2018)", "kdtree=sampled"),
    ("depth-1", "depth", "one scattering event: direct light only", "max-depth=1"),
    ("depth-2", "depth", "two scattering events", "max-depth=2"),
    ("depth-4", "depth", "four scattering events", "max-depth=4"),
    ("depth-8", "depth", "eight scattering events", "max-depth=8"),
    ("lights-1", "lights", "1 light sample per vertex", "light-samples=1"),
    ("lights-2", "lights", "2 light samples per vertex", "light-samples=2"),
    ("lights-4", "lights", "4 light samples per vertex", "light-samples=4"),
    ("lights-8", "lights", "8 light samples per vertex", "light-samples=8"),
    ("lights-16", "lights", "16 light samples per vertex", "light-samples=16"),
    (
        "roulette-1",
        "roulette",
        "Russian roulette from the first scattering event on (instead of the third)",
        "roulette=1",
    ),
    ("no-roulette", "roulette", "no Russian roulette: every path to its full depth", "roulette=off"),
    ("even", "adaptive", "the same number of samples in all pixels", "adaptive=off"),
    ("unaimed", "caustics", "paths meet glass and metal by chance, as the BSDF sends them", "caustics=met"),
    ("reuse", "reuse", "pixels use each other's paths", "reuse=on"),
    (DENOISED, DENOISED, "without noise, by Open Image Denoise with one thread", "denoise=on"),
    ("draft", "presets", "--preset draft: until the stated error is 8 levels", "preset=draft"),
    ("preview", "presets", "--preset preview: until the stated error is 4 levels", "preset=preview"),
    ("final", "presets", "--preset final: until the stated error is 1.5 levels", "preset=final"),
    (
        "2018",
        "2018",
        "the 2018 tracer's way, made correct: uniform directions, xorshift32, sampled kd-tree",
        "strategy=hemisphere sampler=xorshift32 kdtree=sampled adaptive=off light-samples=1",
    ),
];

/// The way that needs a program which may not be there; lists leave it out then.
const DENOISED: &str = "denoised";

/// What a way can do otherwise.
const KEYS: &str = "strategy, sampler, kdtree, max-depth, light-samples, roulette, adaptive, caustics, reuse, effects, denoise, preset";

/// What is studied unless something else is asked for.
const USUAL: &str = "strategies,xorshift32,sampled,lights-4,depth-2,even,2018,denoised,presets";

impl Way {
    /// A way by its name, or one's own: `NAME: KEY=VALUE KEY=VALUE …` with the keys strategy, sampler, kdtree, max-depth,
    /// light-samples, roulette, adaptive, caustics, reuse, effects, denoise (on, or a program) and preset.
    ///
    /// # Errors
    /// A sentence.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some((name, _, title, changes)) = WAYS.iter().find(|w| w.0 == text.trim()) {
            return Self::with(name, title, changes);
        }
        let Some((name, changes)) = text.split_once(':') else {
            return Err(format!("'{text}' is no way; there are {}, and NAME: KEY=VALUE …", names().join(", ")));
        };
        let name = name.trim();
        if name.is_empty() || WAYS.iter().any(|w| w.0 == name) {
            return Err(format!("'{text}': a way of your own needs a name of its own"));
        }
        Self::with(name, changes.trim(), changes)
    }

    fn with(name: &str, title: &str, changes: &str) -> Result<Self, String> {
        let mut way = Self { name: name.into(), title: title.into(), ..Self::default() };
        for change in changes.split_whitespace() {
            let (key, value) = change.split_once('=').ok_or_else(|| format!("'{change}' is not KEY=VALUE"))?;
            let number = || value.parse::<u32>().map_err(|_| format!("'{change}': not a number"));
            let wrong = |e: String| format!("'{change}': {e}");
            match key {
                "strategy" => way.strategy = Some(Strategy::from_str(value, false).map_err(wrong)?),
                "sampler" => way.sampler = Some(SamplerKind::from_str(value, false).map_err(wrong)?),
                "kdtree" => way.kdtree = Some(KdTreeBuilder::from_str(value, false).map_err(wrong)?),
                "max-depth" => way.max_depth = Some(number()?),
                "light-samples" => way.light_samples = Some(number()?.clamp(1, 4096)),
                "roulette" => way.roulette = Some(roulette_after(value).ok_or_else(|| wrong("not a number".into()))?),
                "effects" => way.effects = Some(value.parse().map_err(wrong)?),
                "adaptive" => way.adaptive = Some(Adaptive::from_str(value, false).map_err(wrong)?),
                "caustics" => way.caustics = Some(Caustics::from_str(value, false).map_err(wrong)?),
                "reuse" => way.reuse = Some(Reuse::from_str(value, false).map_err(wrong)?),
                "denoise" => way.denoise = Some(PathText(if value == "on" { PROGRAM } else { value }.into())),
                "preset" => way.preset = Some(Preset::from_str(value, false).map_err(wrong)?),
                _ => return Err(format!("'{key}' is none of {KEYS}")),
            }
        }
        Ok(way)
    }

    /// These settings, done this way.
    pub fn of(&self, settings: &Settings) -> Settings {
        let mut own = settings.clone();
        own.render.strategy = self.strategy.unwrap_or(own.render.strategy);
        own.render.sampler = self.sampler.unwrap_or(own.render.sampler);
        own.prepare.kdtree = self.kdtree.unwrap_or(own.prepare.kdtree);
        own.render.max_depth = self.max_depth.unwrap_or(own.render.max_depth);
        own.render.light_samples = self.light_samples.or(own.render.light_samples);
        own.render.roulette_after = self.roulette.unwrap_or(own.render.roulette_after);
        own.render.adaptive = self.adaptive.unwrap_or(own.render.adaptive);
        own.render.caustics = self.caustics.unwrap_or(own.render.caustics);
        own.render.reuse = self.reuse.unwrap_or(own.render.reuse);
        own.prepare.effects = self.effects.unwrap_or(own.prepare.effects);
        own.pictures.denoise = self.denoise.clone().or(own.pictures.denoise);
        if let Some(preset) = self.preset {
            (own.goal, own.render.spp) = preset.goal();
        }
        own
    }
}

/// The ways that price effects: Kiln's own, with all effects reckoned with at every hit, and without each of these.
pub fn effect_ways(called: impl IntoIterator<Item = Effect>) -> Vec<Way> {
    let way = |name: String, title: String, effects| Way { name, title, effects: Some(effects), ..Way::default() };
    let all = EffectSettings { forced: EffectSet::all(), ..EffectSettings::default() };
    let mut ways = vec![way("all-effects".into(), "every effect reckoned with at every hit".into(), all)];
    ways.extend(called.into_iter().filter(|effect| *effect != Effect::Environment).map(|effect| {
        let without = [effect].into_iter().collect();
        way(
            format!("no-{effect}"),
            format!("without {effect}: another picture"),
            EffectSettings { without, ..EffectSettings::default() },
        )
    }));
    ways
}

fn names() -> Vec<&'static str> {
    WAYS.iter().map(|w| w.0).collect()
}

/// The ways of a list of names, groups (strategies, samplers, trees, depth, lights, roulette, adaptive, caustics, reuse, presets), `usual` and `all`, separated by
/// commas, each once; and those of one's own. `usual` and `all` have the denoised one only where its program is there.
///
/// # Errors
/// A sentence, also where a denoiser is asked for that is not there.
pub fn ways(list: &str, own: &[String]) -> Result<Vec<Way>, String> {
    let ways = named(list, own)?;
    let lists = |word: &str| matches!(word.trim(), "usual" | "all");
    let by_name = list.split(',').any(|word| word.trim() == DENOISED);
    let mut there = Vec::new();
    for way in ways {
        match way.denoise.as_ref().map_or(Ok(()), |program| Denoiser::new(&program.0).check()) {
            Ok(()) => there.push(way),
            Err(_) if way.name == DENOISED && !by_name && list.split(',').any(lists) => {}
            Err(message) => {
                let message = message.replace("--denoise=PROGRAM", "--way 'NAME: denoise=PROGRAM'");
                return Err(format!("{}: {message}", way.name));
            }
        }
    }
    Ok(there)
}

fn named(list: &str, own: &[String]) -> Result<Vec<Way>, String> {
    let mut ways: Vec<Way> = Vec::new();
    let list = list.split(',').map(str::trim).flat_map(|word| match word {
        "usual" => USUAL.split(',').collect(),
        word => vec![word],
    });
    for word in list {
        let group: Vec<&str> = WAYS.iter().filter(|w| w.1 == word || word == "all").map(|w| w.0).collect();
        for name in if group.is_empty() { vec![word] } else { group } {
            ways.push(Way::parse(name)?);
        }
    }
    for text in own {
        ways.push(Way::parse(text)?);
    }
    let mut once: Vec<Way> = Vec::new();
    for way in ways {
        if !once.iter().any(|w| w.name == way.name) {
            once.push(way);
        }
    }
    Ok(once)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_way_can_be_read_and_the_list_knows_groups() {
        let all = named("all", &[]).expect("all");
        assert_eq!(all.len(), WAYS.len());
        let settings = Settings::default();
        assert_eq!(all[0].of(&settings), settings);
        assert!(all[1..].iter().all(|w| w.of(&settings) != settings), "each does something otherwise");
        let some = ways("trees, kiln,median", &["mine: light-samples=3 sampler=pcg".into()]).expect("fine");
        let names: Vec<_> = some.iter().map(|w| w.name.as_str()).collect();
        assert_eq!(names, ["median", "sampled", "kiln", "mine"]);
        assert_eq!(some[3].of(&settings).render.light_samples, Some(3));
        for wrong in ["fast", "", "mine: speed=2", "kiln: sampler=pcg", "mine: sampler=dice", ": sampler=pcg"] {
            assert!(Way::parse(wrong).is_err(), "{wrong}");
        }
        assert!(ways("usual", &[]).expect("usual").len() > 8);
        let gone = ways("kiln", &["mine: denoise=/there/is/none".into()]).expect_err("no such program");
        assert!(gone.starts_with("mine: /there/is/none does not run"), "{gone}");
    }
}
