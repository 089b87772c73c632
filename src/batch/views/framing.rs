use super::side::is_seen;
use super::{AZIMUTH, ELEVATION, HALF_FIELD, MARGIN, UpFrame, half_tangents, points};
use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::Camera;

/// The least distance of an automatic camera from the nearest point, as a share of the asset's size.
const LEAST_DISTANCE: f64 = 0.05;

/// What bounds the place of a camera that is to see all points, in its own axes (x right, y up, z forward).
///
/// With half-field tangents tx and ty, a camera at c sees p when |x − cx| ≤ tx (z − cz) and |y − cy| ≤ ty (z − cz).
/// Each of these four is linear in c, so four extremes over the points describe all of them exactly.
#[derive(Clone, Copy, Debug)]
pub struct Extremes {
    /// Maximum of x − tx·z.
    pub right: f64,
    /// Minimum of x + tx·z.
    pub left: f64,
    /// Maximum of y − ty·z.
    pub top: f64,
    /// Minimum of y + ty·z.
    pub bottom: f64,
    /// Minimum of z.
    pub near: f64,
}

impl Extremes {
    /// Of no points.
    pub const EMPTY: Self = Self {
        right: f64::NEG_INFINITY,
        left: f64::INFINITY,
        top: f64::NEG_INFINITY,
        bottom: f64::INFINITY,
        near: f64::INFINITY,
    };

    /// Adds a point in the camera's axes.
    pub fn add(&mut self, p: DVec3, (tx, ty): (f64, f64)) {
        self.right = self.right.max(p.x - tx * p.z);
        self.left = self.left.min(p.x + tx * p.z);
        self.top = self.top.max(p.y - ty * p.z);
        self.bottom = self.bottom.min(p.y + ty * p.z);
        self.near = self.near.min(p.z);
    }

    /// The camera that sees all points, is as near as it can be and at least `distance` before the nearest one;
    /// centred across the axis in which there is room left.
    pub fn camera(&self, (tx, ty): (f64, f64), distance: f64) -> DVec3 {
        // The two sides of an axis meet where the camera is nearest: right + tx·cz = cx = left − tx·cz.
        let z_across = (self.left - self.right) / (2.0 * tx);
        let z_up = (self.bottom - self.top) / (2.0 * ty);
        let z = z_across.min(z_up).min(self.near - distance);
        DVec3::new(0.5 * (self.right + self.left), 0.5 * (self.top + self.bottom), z)
    }
}

/// The tangents within which points must lie for the margin to stay free.
pub fn inner_tangents(aspect: f64) -> (f64, f64) {
    let (tx, ty) = half_tangents(aspect);
    (tx * (1.0 - 2.0 * MARGIN), ty * (1.0 - 2.0 * MARGIN))
}

/// Size of an asset for distances: its diagonal, or something sane for a point.
pub fn size_of((low, high): (DVec3, DVec3)) -> f64 {
    let diagonal = (high - low).length();
    let place = low.abs().max(high.abs()).max_element();
    // A point far out still needs a distance that f64 can tell from its coordinates.
    if diagonal > 1e-9 * place { diagonal } else { (1e-3 * place).max(1.0) }
}

/// A perspective camera for the whole picture at `eye`, looking along `forward`.
pub fn looking(eye: DVec3, forward: DVec3, up: DVec3, aspect: f64) -> Camera {
    let (_, ty) = half_tangents(aspect);
    let vertical_fov = if aspect >= 1.0 { 2.0 * HALF_FIELD } else { 2.0 * libm::atan(ty) };
    Camera::perspective(eye, forward, up, vertical_fov, aspect)
}

/// The three-quarter view from the front, the right and above that shows the whole asset as large as the margin
/// allows; where nothing but backs that cameras look through would be seen from there, the view from behind or from below.
pub fn frame(scene: &Scene, axes: &UpFrame, aspect: f64) -> Camera {
    let towards =
        |(azimuth, elevation): (f64, f64)| axes.around(azimuth) * libm::cos(elevation) + axes.up * libm::sin(elevation);
    let usual = (AZIMUTH, ELEVATION);
    let sides = [usual, (AZIMUTH + std::f64::consts::PI, ELEVATION), (AZIMUTH, -ELEVATION)];
    let forward = -towards(sides.into_iter().find(|side| is_seen(scene, towards(*side))).unwrap_or(usual));
    let right = forward.cross(axes.up).normalize();
    let up = right.cross(forward);
    let Some(bounds) = points::bounds(scene) else {
        return looking(-4.0 * forward, forward, up, aspect);
    };
    // Relative to the middle, so that far-out assets lose no digits.
    let middle = 0.5 * (bounds.0 + bounds.1);
    let tangents = inner_tangents(aspect);
    let mut extremes = Extremes::EMPTY;
    points::for_each(scene, |p| {
        let p = p - middle;
        extremes.add(DVec3::new(p.dot(right), p.dot(up), p.dot(forward)), tangents);
    });
    let eye = extremes.camera(tangents, LEAST_DISTANCE * size_of(bounds));
    looking(middle + right * eye.x + up * eye.y + forward * eye.z, forward, up, aspect)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::DAffine3;
    use kiln_formats::scene::{Instance, Mesh, UpAxis};
    use proptest::prelude::*;

    /// A scene whose triangles use these points.
    pub fn cloud(points: &[[f32; 3]], transform: DAffine3, up: UpAxis) -> Scene {
        let triangles = (0..points.len() as u32).map(|i| [i, i, i]).collect();
        let mesh = Mesh { positions: points.to_vec(), triangles, ..Mesh::default() };
        let instance = Instance { name: String::new(), mesh: 0, transform };
        Scene { up, meshes: vec![mesh], instances: vec![instance], ..Scene::default() }
    }

    /// Picture coordinates in [−1, 1] of a point, and its depth in units of the camera's `forward`.
    pub fn project(camera: &Camera, p: DVec3) -> (f64, f64, f64) {
        let d = p - camera.origin;
        let depth = d.dot(camera.forward) / camera.forward.length_squared();
        let in_plane = d / depth;
        (
            in_plane.dot(camera.right) / camera.right.length_squared(),
            in_plane.dot(camera.up) / camera.up.length_squared(),
            depth,
        )
    }

    /// Largest |x| and |y| of the points in the picture; panics when one is not before the camera.
    pub fn reach(camera: &Camera, scene: &Scene) -> (f64, f64) {
        let (mut x, mut y) = (0.0f64, 0.0f64);
        points::for_each(scene, |p| {
            let (px, py, depth) = project(camera, p);
            assert!(depth > 0.0, "{p} is behind the camera");
            (x, y) = (x.max(px.abs()), y.max(py.abs()));
        });
        (x, y)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]
        #[test]
        fn clouds_are_never_cropped_and_fill_the_frame(
            points in proptest::collection::vec([-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0], 3..40),
            scale in prop_oneof![Just([1.0, 1.0, 1.0]), Just([1e-4, 1e-4, 1e-4]), Just([1e5, 3.0, 40.0]), Just([1.0, 0.0, 1.0])],
            offset in prop_oneof![Just(DVec3::ZERO), Just(DVec3::new(1e6, -2e6, 3e6))],
            aspect in 0.2f64..5.0,
            z_up in any::<bool>(),
        ) {
            let transform = DAffine3 { matrix3: glam::DMat3::from_diagonal(DVec3::from_array(scale)), translation: offset };
            let up = if z_up { UpAxis::Z } else { UpAxis::Y };
            let scene = cloud(&points, transform, up);
            let axes = UpFrame::of(&scene, crate::settings::UpChoice::Auto);
            let camera = frame(&scene, &axes, aspect);
            let (x, y) = reach(&camera, &scene);
            let inner = 1.0 - 2.0 * MARGIN;
            prop_assert!(x <= inner + 1e-6 && y <= inner + 1e-6, "cropped: {x} {y}");
            // Tight: one axis touches the margin at both sides, unless the camera would come too near.
            let bounds = points::bounds(&scene).unwrap();
            let mut nearest = f64::INFINITY;
            points::for_each(&scene, |p| nearest = nearest.min((p - camera.origin).dot(camera.forward.normalize())));
            let too_near = nearest <= LEAST_DISTANCE * size_of(bounds) * (1.0 + 1e-6);
            prop_assert!(too_near || x.max(y) > inner - 1e-4, "loose: {x} {y}");
        }
    }

    #[test]
    fn degenerate_assets_get_sane_cameras() {
        let axes = || UpFrame::of(&Scene::default(), crate::settings::UpChoice::Y);
        let scenes = [
            Scene::default(),
            cloud(&[[3.0, 4.0, 5.0]], DAffine3::IDENTITY, UpAxis::Y),
            cloud(&[[1e30, 0.0, 0.0]], DAffine3::IDENTITY, UpAxis::Y),
            cloud(&[[0.0; 3], [0.0, 7.0, 0.0]], DAffine3::IDENTITY, UpAxis::Y),
            cloud(&[[-1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], DAffine3::IDENTITY, UpAxis::Y),
        ];
        for scene in scenes {
            let camera = frame(&scene, &axes(), 1.0);
            let volume = camera.forward.dot(camera.right.cross(camera.up));
            assert!(camera.origin.is_finite() && volume.is_finite() && volume.abs() > 1e-6, "{camera:?}");
            let (x, y) = reach(&camera, &scene);
            assert!(x < 1.0 && y < 1.0, "cropped: {x} {y}");
        }
    }

    #[test]
    fn the_camera_stands_before_right_and_above() {
        for (up, choice) in [(UpAxis::Y, crate::settings::UpChoice::Z), (UpAxis::Z, crate::settings::UpChoice::Auto)] {
            let scene = cloud(&[[-1.0; 3], [1.0; 3]], DAffine3::IDENTITY, up);
            let eye = frame(&scene, &UpFrame::of(&scene, choice), 1.0).origin;
            assert!(eye.x > 0.0 && eye.y < 0.0 && eye.z > 0.0, "{eye}");
        }
    }
}
