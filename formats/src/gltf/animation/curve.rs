//! Keys and what lies between them (glTF 2.0, appendix C).

use crate::ImportError;
use crate::gltf::accessor::Accessors;
use crate::gltf::document::invalid;
use serde_json::Value;

/// A sampler's value at a moment.
pub(super) struct Sampled {
    /// The components of all elements of the value.
    pub(super) value: Vec<f64>,
    /// Time of the last key, seconds.
    pub(super) end: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// Where a moment is among the keys: at one of them, or between one and the next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moment {
    At(usize),
    /// After key `k`, by `part` (0 … 1) of `length` seconds.
    Between {
        k: usize,
        part: f64,
        length: f64,
    },
}

/// The value of a sampler at `time`. `place` is the sampler's JSON pointer; `rotation`: the value is a quaternion.
///
/// # Errors
/// [`crate::ErrorCode::Invalid`] at the JSON pointer of what is not sound.
pub(super) fn sample(
    accessors: &Accessors,
    sampler: &Value,
    place: &str,
    time: f64,
    rotation: bool,
) -> Result<Sampled, ImportError> {
    let index = |name: &str| {
        let index = sampler.get(name).and_then(Value::as_u64).and_then(|i| usize::try_from(i).ok());
        index.ok_or_else(|| invalid(format!("{place}/{name}"), "names no accessor"))
    };
    let interpolation = match sampler.get("interpolation").map(Value::as_str) {
        None | Some(Some("LINEAR")) => Interpolation::Linear,
        Some(Some("STEP")) => Interpolation::Step,
        Some(Some("CUBICSPLINE")) => Interpolation::CubicSpline,
        Some(_) => return Err(invalid(format!("{place}/interpolation"), "is no interpolation")),
    };
    let (input, output) = (index("input")?, index("output")?);
    let (input_at, output_at) = (|| format!("{place}/input"), || format!("{place}/output"));
    accessors.check_backed(input, &input_at)?;
    let times: Vec<f64> = accessors.floats::<1>(input, None, &input_at)?.iter().map(|[t]| f64::from(*t)).collect();
    let Some(moment) = find(&times, time) else {
        return Err(invalid(input_at(), "there are no times, or they do not increase"));
    };
    let count = accessors.count(output, &output_at)?;
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    // Morph weights are many elements a key.
    let elements = count / times.len() / per_key;
    if elements == 0 || count != elements * times.len() * per_key {
        return Err(invalid(output_at(), format!("{count} values do not fit {} times", times.len())));
    }
    // The elements of one key: its in-tangent, value and out-tangent, or its value only.
    let key = |k: usize| {
        let group = elements * per_key;
        let select: Vec<u32> = (k * group..(k + 1) * group).map(|i| i as u32).collect();
        let values = flat(accessors, output, &select, &output_at)?;
        if values.iter().all(|x| x.is_finite()) { Ok(values) } else { Err(invalid(output_at(), "is not finite")) }
    };
    let value_of = |key: &[f64]| {
        let part = key.len() / per_key;
        let from = if per_key == 3 { part } else { 0 };
        key.get(from..from + part).unwrap_or_default().to_vec()
    };
    let value = match moment {
        Moment::At(k) => value_of(&key(k)?),
        Moment::Between { k, .. } if interpolation == Interpolation::Step => value_of(&key(k)?),
        Moment::Between { k, part, length } => {
            let (a, b) = (key(k)?, key(k + 1)?);
            match interpolation {
                Interpolation::CubicSpline => hermite(&a, &b, part, length),
                _ if rotation => slerp(&a, &b, part),
                _ => a.iter().zip(&b).map(|(a, b)| a + (b - a) * part).collect(),
            }
        }
    };
    Ok(Sampled { value, end: times.last().copied().unwrap_or_default() })
}

fn flat(
    accessors: &Accessors,
    index: usize,
    select: &[u32],
    from: &dyn Fn() -> String,
) -> Result<Vec<f64>, ImportError> {
    let values = if accessors.has_components(index, 1) {
        accessors.floats::<1>(index, Some(select), from)?.into_flattened()
    } else if accessors.has_components(index, 2) {
        accessors.floats::<2>(index, Some(select), from)?.into_flattened()
    } else if accessors.has_components(index, 3) {
        accessors.floats::<3>(index, Some(select), from)?.into_flattened()
    } else {
        accessors.floats::<4>(index, Some(select), from)?.into_flattened()
    };
    Ok(values.into_iter().map(f64::from).collect())
}

/// `None` when there are no times, or they are not in order.
fn find(times: &[f64], time: f64) -> Option<Moment> {
    if times.is_empty() || !times.is_sorted() || !time.is_finite() {
        return None;
    }
    let next = times.partition_point(|t| *t <= time);
    let Some(k) = next.checked_sub(1) else { return Some(Moment::At(0)) };
    let (Some(from), Some(to)) = (times.get(k), times.get(next)) else { return Some(Moment::At(k)) };
    let length = to - from;
    Some(Moment::Between { k, part: (time - from) / length, length })
}

fn hermite(a: &[f64], b: &[f64], t: f64, length: f64) -> Vec<f64> {
    let n = a.len() / 3;
    let (t2, t3) = (t * t, t * t * t);
    let third = |key: &[f64], which: usize, i: usize| key.get(which * n + i).copied().unwrap_or_default();
    (0..n)
        .map(|i| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * third(a, 1, i)
                + length * (t3 - 2.0 * t2 + t) * third(a, 2, i)
                + (3.0 * t2 - 2.0 * t3) * third(b, 1, i)
                + length * (t3 - t2) * third(b, 0, i)
        })
        .collect()
}

/// Spherical linear interpolation by the shorter arc.
fn slerp(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let angle = libm::acos(dot.abs().min(1.0));
    let sine = libm::sin(angle);
    let (from, to) = match sine > 1e-6 {
        true => (libm::sin(angle * (1.0 - t)) / sine, libm::sin(angle * t) / sine),
        false => (1.0 - t, t),
    };
    let to = if dot < 0.0 { -to } else { to };
    a.iter().zip(b).map(|(a, b)| from * a + to * b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_before_between_and_after_the_keys() {
        let times = [1.0, 2.0, 4.0];
        assert_eq!(find(&times, 0.0), Some(Moment::At(0)));
        assert_eq!(find(&times, 3.0), Some(Moment::Between { k: 1, part: 0.5, length: 2.0 }));
        assert_eq!(find(&times, 4.0), Some(Moment::At(2)));
        assert_eq!(find(&times, 9.0), Some(Moment::At(2)));
        assert_eq!(find(&[], 1.0), None);
        assert_eq!(find(&[2.0, 1.0], 1.0), None);
        assert_eq!(find(&[f64::NAN], 1.0), Some(Moment::At(0)), "one key holds always");
    }

    #[test]
    fn rotations_go_the_shorter_way_at_constant_speed() {
        let half = |degrees: f64| libm::sin(degrees.to_radians() / 2.0);
        let turn = |degrees: f64| [0.0, half(degrees), 0.0, libm::cos(degrees.to_radians() / 2.0)];
        let opposite = turn(90.0).map(|x| -x);
        for target in [turn(90.0), opposite] {
            let got = slerp(&turn(0.0), &target, 1.0 / 3.0);
            for (got, want) in got.iter().zip(turn(30.0)) {
                assert!((got - want).abs() < 1e-12, "{got} {want}");
            }
        }
        assert_eq!(slerp(&turn(20.0), &turn(20.0), 0.5), turn(20.0));
    }

    #[test]
    fn cubic_splines_follow_values_and_tangents() {
        // x³ from 1 to 3: values 1 and 27, slopes 3 and 27; a cubic is its own Hermite spline.
        let got = hermite(&[0.0, 1.0, 3.0], &[27.0, 27.0, 0.0], 0.25, 2.0);
        assert!((got[0] - 3.375).abs() < 1e-12, "{got:?}");
    }
}
