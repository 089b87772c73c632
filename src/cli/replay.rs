//! `kiln render --replay`: one path, step by step.

use super::console::print_line;
use super::exit::{Exit, Fatal};
use glam::{DVec3, Vec3};
use kiln::Control;
use kiln::batch::{Job, LoadedEnvironment, make_ready};
use kiln::integrate::{PathEvent, PathTrace, replay};
use serde_json::Value;
use std::str::FromStr;
use std::sync::Arc;

/// Which path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathAddress {
    pixel: [u32; 2],
    sample: u32,
    view: u32,
}

impl FromStr for PathAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok([x, y, sample]) => Ok(Self { pixel: [*x, *y], sample: *sample, view: 0 }),
            Ok([x, y, sample, view]) => Ok(Self { pixel: [*x, *y], sample: *sample, view: *view }),
            _ => Err("column, row and sample, as in 12,34,5; of turntables a fourth number is the view".into()),
        }
    }
}

/// Follows the path of a job's sample again and prints what happens to it.
///
/// # Errors
/// When the asset cannot be made ready, or has no such pixel.
pub fn run(
    job: &Job,
    address: PathAddress,
    environment: Option<Arc<LoadedEnvironment>>,
    json: bool,
) -> Result<Exit, Fatal> {
    let ready = make_ready(job, &Control::default(), environment).map_err(|outcome| {
        let [code, message] = [outcome.error_code, outcome.error_message].map(Option::unwrap_or_default);
        Fatal::failed(format!("{}: {code}: {message}", outcome.input))
    })?;
    let view = ready.views.get(address.view as usize);
    let view = view.ok_or_else(|| Fatal::usage(format!("there are {} views, counted from 0", ready.views.len())))?;
    let [x, y] = address.pixel;
    if x >= view.width || y >= view.height {
        return Err(Fatal::usage(format!("pixel {x},{y} is not in a picture of {}×{}", view.width, view.height)));
    }
    let trace = replay(&ready.scene, view, &job.settings.render, address.pixel, address.sample);
    if json {
        let mut value = serde_json::to_value(&trace).map_err(|e| Fatal::failed(e.to_string()))?;
        if let Value::Object(object) = &mut value {
            object.insert("input".into(), job.name.clone().into());
            object.insert("view".into(), address.view.into());
        }
        print_line(&value.to_string());
    } else {
        text(&trace).iter().for_each(|line| print_line(line));
    }
    Ok(Exit::Done)
}

fn text(trace: &PathTrace) -> Vec<String> {
    let [x, y] = trace.pixel;
    let mut lines = vec![format!("pixel {x},{y}, sample {}, seed {}", trace.sample, trace.seed)];
    lines.extend(trace.events.iter().map(line));
    lines.push(match trace.cause {
        None => format!("radiance {}", vector(trace.radiance)),
        Some(cause) => format!("radiance {}: dropped, not finite since {cause:?}", vector(trace.radiance)),
    });
    lines
}

fn line(event: &PathEvent) -> String {
    let v = vector;
    match event {
        PathEvent::Ray { depth, origin, direction } => {
            format!("{depth:3} from {} towards {}", point(*origin), v(*direction))
        }
        PathEvent::Hit { distance, point: at, mesh, triangle, material, front } => {
            let side = if *front { "front" } else { "back" };
            let distance = number(*distance);
            format!(
                "    meets {} after {distance}: {side} of triangle {triangle} of \"{mesh}\", \"{material}\"",
                point(*at)
            )
        }
        PathEvent::Absorbed { transmittance, throughput } => {
            format!("    absorption leaves {}: throughput {}", v(*transmittance), v(*throughput))
        }
        PathEvent::Dispersed { nanometres, weight, throughput } => {
            let nanometres = number(f64::from(*nanometres));
            format!("    goes on at {nanometres} nm: weight {}, throughput {}", v(*weight), v(*throughput))
        }
        PathEvent::Emission { radiance, weight, contribution } => {
            format!("    it emits {}, weight {}: + {}", v(*radiance), number(f64::from(*weight)), v(*contribution))
        }
        PathEvent::Environment { light, contribution } => {
            format!("    environment {}: + {}", v(*light), v(*contribution))
        }
        PathEvent::Surface { shading_normal, lobes } => {
            let lobes: Vec<_> = lobes.iter().map(|(name, p)| format!("{name} {}", number(f64::from(*p)))).collect();
            format!("    shading normal {}, lobes: {}", v(*shading_normal), lobes.join(", "))
        }
        PathEvent::LightSample { direction, pdf, bsdf, bsdf_pdf, visible, weight, contribution } => {
            let pdf = pdf.map_or("none".into(), |p| number(f64::from(p)));
            let [bsdf_pdf, weight] = [bsdf_pdf, weight].map(|x| number(f64::from(*x)));
            format!(
                "    light towards {}: pdf {pdf}, BSDF {}, its pdf {bsdf_pdf}, visible {}, weight {weight}: {}",
                v(*direction),
                v(*bsdf),
                v(*visible),
                v(*contribution)
            )
        }
        PathEvent::DirectLight { radiance, contribution } => {
            format!("    direct light {}: + {}", v(*radiance), v(*contribution))
        }
        PathEvent::Scattered { direction, pdf, delta, transmitted, weight, throughput } => {
            let way = if *transmitted { "goes through" } else { "is reflected" };
            let (kind, pdf) = (if *delta { "probability" } else { "pdf" }, number(f64::from(*pdf)));
            let (weight, throughput) = (v(*weight), v(*throughput));
            format!("    {way} towards {}: {kind} {pdf}, weight {weight}, throughput {throughput}", v(*direction))
        }
        PathEvent::Roulette { survival, throughput } => {
            format!("    survives roulette of {}: throughput {}", number(f64::from(*survival)), v(*throughput))
        }
        PathEvent::End { why } => format!("    ends: {why}"),
    }
}

fn vector(v: Vec3) -> String {
    point(v.as_dvec3())
}

fn point(v: DVec3) -> String {
    format!("({}, {}, {})", number(v.x), number(v.y), number(v.z))
}

/// Six significant digits.
fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let before = [10.0, 100.0, 1e3, 1e4].iter().filter(|power| size >= **power).count();
        format!("{x:.*}", 5 - before)
    } else {
        format!("{x:.5e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_three_or_four_numbers() {
        assert_eq!("12,34,5".parse(), Ok(PathAddress { pixel: [12, 34], sample: 5, view: 0 }));
        assert_eq!("12, 34, 5, 2".parse(), Ok(PathAddress { pixel: [12, 34], sample: 5, view: 2 }));
        for wrong in ["", "1,2", "1,2,-3", "1,2,3,4,5", "a,b,c"] {
            assert!(wrong.parse::<PathAddress>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_have_six_digits() {
        assert_eq!(
            [0.0, 1.0, 123.456_789, 0.012_345_678, 1e9].map(number),
            ["0", "1.00000", "123.457", "0.01235", "1.00000e9"]
        );
        assert_eq!(number(f64::NAN), "NaN");
    }
}
