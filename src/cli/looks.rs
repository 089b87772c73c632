use clap::{Args, ValueEnum};
use kiln::formats::Show;
use kiln::formats::ray::{Basis, Dialect, RayOptions};
use kiln::settings::LookSettings;

/// Which looks of an asset are pictured.
#[derive(Args, Clone, Debug)]
pub struct LookOptions {
    /// Show the asset at a moment of its animation, seconds from its beginning [default: the rest pose]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Looks")]
    time_code: Option<f64>,
    /// The animation with this name or index, or all at once [default: the first]
    #[arg(long, value_name = "NAME|all", help_heading = "Looks")]
    animation: Option<String>,
    /// The material variant with this name or index, or pictures of all of them
    #[arg(long, value_name = "NAME|all", help_heading = "Looks")]
    variant: Option<String>,
    /// Which family of course tracers .ray files were written for
    #[arg(long, value_enum, default_value_t, value_name = "FAMILY", help_heading = "Looks")]
    ray_dialect: RayDialect,
    /// The camera of .ray files: as written, sheared and stretched as in the course tracers, or with straight axes
    #[arg(long, value_enum, default_value_t, value_name = "AXES", help_heading = "Looks")]
    ray_camera: RayCamera,
    /// Surfaces of .ray files emit what the ambient light would show
    #[arg(long, help_heading = "Looks")]
    ray_ambient: bool,
    /// Glass of .ray files blocks the light of lamps, which else goes straight through and takes on its colour
    #[arg(long, help_heading = "Looks")]
    ray_opaque_glass: bool,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum RayDialect {
    /// UT Austin
    #[default]
    Ut,
    /// University of Washington, and UT up to 2015
    Uw,
    /// HKUST
    Hk,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum RayCamera {
    /// As written
    #[default]
    Raw,
    /// Perpendicular axes of unit length
    Orthonormal,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
    seconds.ok_or_else(|| format!("'{text}' is no time: seconds, 0 or more"))
}

impl LookOptions {
    pub(super) fn settings(&self) -> LookSettings {
        let every_variant = self.variant.as_deref() == Some("all");
        LookSettings {
            show: Show {
                animation: self.animation.clone(),
                time: self.time_code,
                variant: self.variant.clone().filter(|_| !every_variant),
            },
            every_variant,
            play: false,
            ray: RayOptions {
                dialect: match self.ray_dialect {
                    RayDialect::Ut => Dialect::Ut,
                    RayDialect::Uw => Dialect::Uw,
                    RayDialect::Hk => Dialect::Hk,
                },
                basis: match self.ray_camera {
                    RayCamera::Raw => Basis::Raw,
                    RayCamera::Orthonormal => Basis::Orthonormal,
                },
                emit_ambient: self.ray_ambient,
                opaque_glass: self.ray_opaque_glass,
            },
        }
    }
}
