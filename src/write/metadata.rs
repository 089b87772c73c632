use serde::Serialize;

/// A picture's error, as in the manifest: [`crate::accuracy::Accuracy`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatedError {
    /// RMS error as displayed, 0–255 levels.
    pub error: f64,
    /// Upper 95 % bound of it.
    pub error_bound: f64,
    /// Relative mean square error in linear light.
    pub relmse: f64,
    /// Upper 95 % bound of it.
    pub relmse_bound: f64,
}

/// What a picture file says about itself. Nothing in it varies from run to run: no times, thread counts or dates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metadata {
    /// The program and its version.
    pub software: String,
    /// File name of the asset, without its folder. Only in PNG files: an EXR file's bytes do not depend on names.
    #[serde(skip)]
    pub source: String,
    /// Hash of the asset with all files that it refers to.
    pub content: String,
    /// Hash of the settings.
    pub settings: String,
    /// Selects the random numbers.
    pub seed: u64,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Which of the asset's views, from 0.
    pub view: u32,
    /// Its error; `None`: not known.
    #[serde(flatten)]
    pub stated: Option<StatedError>,
    /// What removed the noise: of a PNG file as a whole, of an EXR file in its layers `denoised`; `None`: nothing did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoised: Option<String>,
}

impl Metadata {
    /// `kiln` with its version.
    pub fn software() -> String {
        concat!("kiln ", env!("CARGO_PKG_VERSION")).into()
    }

    /// Keyword and text of each entry, in a fixed order, keywords as PNG registers them where it does.
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        let mut entries = vec![
            ("Software", self.software.clone()),
            ("Source", self.source.clone()),
            ("kiln:content", self.content.clone()),
            ("kiln:settings", self.settings.clone()),
            ("kiln:seed", self.seed.to_string()),
            ("kiln:spp", self.spp.to_string()),
            ("kiln:view", self.view.to_string()),
        ];
        if let Some(stated) = &self.stated {
            entries.extend([
                ("kiln:error", stated.error.to_string()),
                ("kiln:error_bound", stated.error_bound.to_string()),
                ("kiln:relmse", stated.relmse.to_string()),
                ("kiln:relmse_bound", stated.relmse_bound.to_string()),
            ]);
        }
        entries.extend(self.denoised.iter().map(|by| ("kiln:denoised", by.clone())));
        entries
    }
}
