use super::{AlphaMode, Image, LightKind, Mesh, Pixels, Scene, Surface};

/// A broken guarantee of the scene IR: an importer's mistake, never the file's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct InvalidScene {
    /// Path of the offending item, such as `meshes[3].triangles[17]`.
    pub place: String,
    /// What is wrong with it.
    pub message: String,
}

fn broken<T>(place: impl Into<String>, message: impl Into<String>) -> Result<T, InvalidScene> {
    Err(InvalidScene { place: place.into(), message: message.into() })
}

fn in_range(place: String, index: u32, len: usize) -> Result<(), InvalidScene> {
    if (index as usize) < len { Ok(()) } else { broken(place, format!("index {index} of {len}")) }
}

pub(super) fn images(scene: &Scene) -> Result<(), InvalidScene> {
    let mut images = scene.images.iter().enumerate();
    images.try_for_each(|(i, image)| check_image(image).or_else(|m| broken(format!("images[{i}]"), m)))
}

pub(super) fn validate_but_images(scene: &Scene) -> Result<(), InvalidScene> {
    for (i, texture) in scene.textures.iter().enumerate() {
        in_range(format!("textures[{i}].image"), texture.image, scene.images.len())?;
    }
    for i in 0..scene.materials.len() {
        check_material(scene, i)?;
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        check_mesh(scene, i, mesh)?;
    }
    for (i, instance) in scene.instances.iter().enumerate() {
        in_range(format!("instances[{i}].mesh"), instance.mesh, scene.meshes.len())?;
        if !instance.transform.is_finite() {
            return broken(format!("instances[{i}].transform"), "not finite");
        }
    }
    for (i, light) in scene.lights.iter().enumerate() {
        let place = || format!("lights[{i}]");
        let unit = |d: glam::DVec3| (d.length_squared() - 1.0).abs() < 1e-6;
        if !light.color.iter().all(|c| c.is_finite() && *c >= 0.0) || !light.position.is_finite() {
            return broken(place(), "not finite, or negative colour");
        }
        if !matches!(light.kind, LightKind::Point { .. }) && !unit(light.direction) {
            return broken(place(), "direction is not a unit vector");
        }
        if let LightKind::Spot { inner, outer, .. } = light.kind
            && !(0.0 <= inner && inner < outer && outer <= std::f64::consts::FRAC_PI_2 + 1e-9)
        {
            return broken(place(), format!("cone angles {inner} and {outer}"));
        }
    }
    for (i, camera) in scene.cameras.iter().enumerate() {
        let all = [camera.origin, camera.forward, camera.right, camera.up];
        let volume = camera.forward.dot(camera.right.cross(camera.up));
        if !all.iter().all(|v| v.is_finite()) || volume == 0.0 || !volume.is_finite() {
            return broken(format!("cameras[{i}]"), "degenerate image plane");
        }
    }
    Ok(())
}

fn check_image(image: &Image) -> Result<(), String> {
    let want = 4 * image.width as usize * image.height as usize;
    let (got, finite) = match &image.pixels {
        Pixels::Rgba8(p) => (p.len(), true),
        Pixels::Rgba16(p) => (p.len(), true),
        Pixels::RgbaF32(p) => (p.len(), p.iter().all(|x| x.is_finite())),
    };
    if want == 0 || got != want {
        return Err(format!("{}×{} has {got} values, not {want}", image.width, image.height));
    }
    if finite { Ok(()) } else { Err("values that are not finite".into()) }
}

fn check_material(scene: &Scene, i: usize) -> Result<(), InvalidScene> {
    let material = &scene.materials[i];
    let place = |what: &str| format!("materials[{i}].{what}");
    for reference in material.textures() {
        in_range(place("texture"), reference.texture, scene.textures.len())?;
        let t = reference.transform;
        let finite = t.linear.as_flattened().iter().chain(&t.offset).all(|x| x.is_finite());
        if reference.uv_set > 1 || !finite {
            return broken(place("texture"), "uv set over 1, or transform not finite");
        }
    }
    let ok = |x: f32| x.is_finite() && x >= 0.0;
    let color = |c: &super::ColorInput| c.factor.iter().all(|x| ok(*x));
    let scalar = |s: &super::ScalarInput| ok(s.bias) && ok(s.bias + s.factor) && (s.bias > 0.0 || ok(s.factor));
    let fine = match &material.surface {
        Surface::MetalRough(m) => {
            let v = m.volume.is_none_or(|v| {
                v.attenuation_distance > 0.0 && v.attenuation_color.iter().all(|c| (0.0..=1.0).contains(c))
            });
            let scalars = [&m.metallic, &m.roughness, &m.specular, &m.transmission];
            let layers = m.layers.is_none_or(|l| {
                let numbers = [l.anisotropy, l.iridescence_ior];
                let colors = color(&l.sheen_color) && color(&l.diffuse_transmission_color);
                let normal = l.clearcoat_normal_map.is_none_or(|n| n.scale.is_finite());
                let rest = l.anisotropy_rotation.is_finite() && numbers.iter().all(|x| ok(*x));
                l.scalars().into_iter().all(scalar) && colors && normal && rest
            });
            let colors = color(&m.base_color) && color(&m.specular_color);
            colors && scalars.into_iter().all(scalar) && ok(m.ior) && ok(m.dispersion) && v && layers
        }
        Surface::Phong(p) => {
            let colors = [&p.ambient, &p.diffuse, &p.specular, &p.mirror, &p.transmission];
            colors.iter().all(|c| color(c)) && scalar(&p.exponent) && scalar(&p.ior)
        }
        Surface::Unlit(c) => color(c),
    };
    let cutoff = match material.alpha.mode {
        AlphaMode::Mask { cutoff } => cutoff.is_finite(),
        _ => true,
    };
    let normal = material.normal_map.is_none_or(|n| n.scale.is_finite());
    if fine && cutoff && normal && color(&material.emission) && scalar(&material.alpha.value) {
        Ok(())
    } else {
        broken(place("surface"), "a factor is negative, not finite or out of its range")
    }
}

fn check_mesh(scene: &Scene, i: usize, mesh: &Mesh) -> Result<(), InvalidScene> {
    let place = |what: &str| format!("meshes[{i}].{what}");
    let n = mesh.positions.len();
    let lengths = [
        ("normals", mesh.normals.len()),
        ("tangents", mesh.tangents.len()),
        ("uvs[0]", mesh.uvs[0].len()),
        ("uvs[1]", mesh.uvs[1].len()),
        ("colors", mesh.colors.len()),
        ("vertex_materials", mesh.vertex_materials.len()),
    ];
    for (what, len) in lengths {
        if len != 0 && len != n {
            return broken(place(what), format!("{len} values for {n} positions"));
        }
    }
    let flats: [(&str, &[f32]); 6] = [
        ("positions", mesh.positions.as_flattened()),
        ("normals", mesh.normals.as_flattened()),
        ("tangents", mesh.tangents.as_flattened()),
        ("uvs[0]", mesh.uvs[0].as_flattened()),
        ("uvs[1]", mesh.uvs[1].as_flattened()),
        ("colors", mesh.colors.as_flattened()),
    ];
    for (what, values) in flats {
        if let Some(k) = values.iter().position(|x| !x.is_finite()) {
            return broken(place(what), format!("value {k} is not finite"));
        }
    }
    for (k, t) in mesh.triangles.iter().enumerate() {
        for index in t {
            if *index as usize >= n {
                return broken(place(&format!("triangles[{k}]")), format!("index {index} of {n}"));
            }
        }
    }
    in_range(place("material"), mesh.material, scene.materials.len())?;
    for (k, m) in mesh.vertex_materials.iter().enumerate() {
        in_range(place(&format!("vertex_materials[{k}]")), *m, scene.materials.len())?;
        if !matches!(scene.materials[*m as usize].surface, Surface::Phong(_)) {
            return broken(place(&format!("vertex_materials[{k}]")), "not a Phong material");
        }
    }
    Ok(())
}
