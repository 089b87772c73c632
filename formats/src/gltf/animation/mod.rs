//! Animations: the document as it is at a moment.
//!
//! A channel writes the value of its property into the JSON document before the typed model is made of it. So whatever
//! the importer reads can be animated (KHR_animation_pointer), and nothing behind this module knows of time.

mod curve;
mod pointer;

use super::accessor::Accessors;
use super::contents;
use super::document::invalid;
use super::report::Report;
use crate::ImportError;
use crate::show::Show;
use serde_json::Value;

const IGNORED: &str = "animation-ignored";

/// Puts the document into the state of the moment that `show` asks for. Channels that are not sound leave their
/// property as it is, with a warning.
///
/// # Errors
/// [`crate::ErrorCode::Invalid`] when there are animations but none that `show` names.
pub(super) fn pose(
    document: &mut Value,
    accessors: &Accessors,
    show: &Show,
    report: &mut Report,
) -> Result<(), ImportError> {
    let names = contents::names(document, "/animations");
    let clips = choose(&names, show.animation.as_deref())?;
    let time = show.time.unwrap_or(0.0);
    let mut end: f64 = 0.0;
    for clip in clips {
        let Some(animation) = document.pointer_mut(&format!("/animations/{clip}")).map(Value::take) else { continue };
        let samplers = animation.get("samplers").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        for (k, channel) in animation.get("channels").and_then(Value::as_array).into_iter().flatten().enumerate() {
            let place = format!("/animations/{clip}/channels/{k}");
            // A channel without a target is for extensions that are not known.
            let Some(target) = pointer::of_channel(channel) else { continue };
            let index = channel.get("sampler").and_then(Value::as_u64).and_then(|i| usize::try_from(i).ok());
            let Some((index, sampler)) = index.and_then(|i| Some((i, samplers.get(i)?))) else {
                report.warn(IGNORED, format!("{place}/sampler"), "there is no such sampler");
                continue;
            };
            let at = format!("/animations/{clip}/samplers/{index}");
            match curve::sample(accessors, sampler, &at, time, pointer::is_rotation(&target)) {
                Ok(sampled) => {
                    end = end.max(sampled.end);
                    if let Err(why) = pointer::put(document, &target, &sampled.value) {
                        report.warn(IGNORED, format!("{place}/target"), format!("{target} {why}"));
                    }
                }
                Err(error) => report.warn(IGNORED, error.place.to_string(), error.message),
            }
        }
    }
    if time > end && !names.is_empty() {
        let message = format!("{time} s is past the end at {end} s: the last pose is shown");
        report.warn("time-past-end", "/animations", message);
    }
    Ok(())
}

/// Indices of the animations that a choice means.
fn choose(names: &[String], choice: Option<&str>) -> Result<Vec<usize>, ImportError> {
    if names.is_empty() {
        return Ok(Vec::new());
    }
    let Some(choice) = choice else { return Ok(vec![0]) };
    match Show::find(names, choice) {
        Some(index) => Ok(vec![index]),
        None if choice == "all" => Ok((0..names.len()).collect()),
        None => Err(invalid("/animations", format!("there is no animation '{choice}', but {}", listed(names)))),
    }
}

/// Names for a message.
pub(super) fn listed(names: &[String]) -> String {
    const MOST: usize = 12;
    let mut words: Vec<String> = names
        .iter()
        .enumerate()
        .take(MOST)
        .map(|(i, name)| if name.is_empty() { i.to_string() } else { format!("'{name}'") })
        .collect();
    if names.len() > MOST {
        words.push(format!("{} more", names.len() - MOST));
    }
    words.join(", ")
}
