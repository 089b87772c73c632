//! Numbers that no renderer can use.

use super::report::Report;
use crate::scene::Mesh;
use glam::Vec3;

/// Drops triangles with positions that are not finite; replaces other such attributes, and normals and tangents of no
/// length.
pub(super) fn mend(mesh: &mut Mesh, place: &str, report: &mut Report) {
    positions(mesh, place, report);
    normals(mesh, place, report);
    let usable = |t: &[f32; 4]| finite(t) && Vec3::new(t[0], t[1], t[2]).length_squared() > 0.0;
    if !mesh.tangents.iter().all(usable) {
        report.warn("bad-tangents", format!("{place}/attributes/TANGENT"), "are not usable; others are computed");
        mesh.tangents = Vec::new();
    }
    for [.., w] in &mut mesh.tangents {
        *w = if *w < 0.0 { -1.0 } else { 1.0 };
    }
    for (set, uvs) in mesh.uvs.iter_mut().enumerate() {
        let bad = replace(uvs, finite, [0.0; 2]);
        if bad > 0 {
            let message = format!("{bad} values are not finite and are taken as 0");
            report.warn("not-finite", format!("{place}/attributes/TEXCOORD_{set}"), message);
        }
    }
    let bad = replace(&mut mesh.colors, |c| finite(c) && c.iter().all(|x| *x >= 0.0), [1.0; 4]);
    if bad > 0 {
        let message = format!("{bad} values are not finite or negative and are taken as white");
        report.warn("not-finite", format!("{place}/attributes/COLOR_0"), message);
    }
}

fn finite<const N: usize>(value: &[f32; N]) -> bool {
    value.iter().all(|x| x.is_finite())
}

fn replace<T: Copy>(values: &mut [T], sound: impl Fn(&T) -> bool, instead: T) -> usize {
    values.iter_mut().filter(|v| !sound(v)).map(|v| *v = instead).count()
}

fn positions(mesh: &mut Mesh, place: &str, report: &mut Report) {
    if mesh.positions.iter().all(finite) {
        return;
    }
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|t| t.iter().all(|i| positions.get(*i as usize).is_some_and(finite)));
    let dropped = before - mesh.triangles.len();
    replace(&mut mesh.positions, finite, [0.0; 3]);
    let message = format!("some values are not finite; {dropped} triangles with them are left out");
    report.warn("not-finite", format!("{place}/attributes/POSITION"), message);
}

fn normals(mesh: &mut Mesh, place: &str, report: &mut Report) {
    let usable = |n: &[f32; 3]| finite(n) && Vec3::from_array(*n).length_squared() > 0.0;
    if mesh.normals.iter().all(usable) {
        return;
    }
    let bad: Vec<bool> = mesh.normals.iter().map(|n| !usable(n)).collect();
    replace(&mut mesh.normals, usable, [0.0; 3]);
    let at = |i: u32| mesh.positions.get(i as usize).map_or(Vec3::ZERO, |p| Vec3::from_array(*p));
    for t in mesh.triangles.iter().filter(|t| t.iter().any(|i| bad.get(*i as usize) == Some(&true))) {
        let [a, b, c] = t.map(at);
        let face = (b - a).cross(c - a).normalize_or_zero();
        for i in t.iter().map(|i| *i as usize).filter(|i| bad.get(*i) == Some(&true)) {
            if let Some(n) = mesh.normals.get_mut(i) {
                *n = (Vec3::from_array(*n) + face).to_array();
            }
        }
    }
    replace(&mut mesh.normals, usable, [0.0, 0.0, 1.0]);
    let count = bad.iter().filter(|b| **b).count();
    let message = format!("{count} values have no direction and follow the faces");
    report.warn("bad-normals", format!("{place}/attributes/NORMAL"), message);
}
