//! Smooth glass: which bodies paths are in, one by one.

use super::surface::Fetch;
use super::{Wave, hit, path};
use crate::integrate::medium::Inside;
use crate::integrate::vertex::Place;
use crate::lanes::LANES;
use crate::shading::{Glass, MetalRoughParams};
use glam::Vec3;
use kiln_formats::scene::{MetalRough, Surface};

impl Wave<'_, '_> {
    /// The bodies that a path is in.
    fn inside(&mut self, i: usize) -> &mut Inside {
        &mut self.memory.states[self.memory.paths.word(path::SLOT, i) as usize].inside
    }

    /// Has a path that meets smooth glass know which bodies it is in, absorbs on the way, and fetches the glass.
    pub(super) fn enter_glass(&mut self, i: usize, lane: usize, fetch: &mut Fetch) {
        let prepared = self.course.prepared;
        let (hit, dir) = (self.hit(i), self.memory.paths.vector(path::DIR, i));
        let Some(place) = Place::new(prepared, &hit, dir) else { return };
        let Surface::MetalRough(m) = &prepared.scene.materials[place.material as usize].surface else { return };
        let inside = self.inside(i);
        *inside = inside.met(prepared, &place);
        let inside = *inside;
        let transmittance = inside.transmittance(prepared, hit.t);
        if transmittance != Vec3::ONE {
            let throughput = self.memory.paths.vector(path::THROUGHPUT, i) * transmittance;
            self.memory.paths.set_vector(path::THROUGHPUT, i, throughput);
        }
        fetch.material[lane] = place.material;
        fetch.put_glass(lane, &glass(m, inside.index_around(prepared, &place), place.front));
    }

    /// Has glass that light went through count as entered or left, for some lanes from `at` on; gives the paths' flags.
    #[inline(never)]
    pub(super) fn cross_glass(&mut self, at: usize, lanes: u32, crossed: u32, fetch: &Fetch) -> [u32; LANES] {
        let prepared = self.course.prepared;
        let mut flags = [0; LANES];
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 != 0) {
            let triangle = self.memory.hits.word(hit::TRIANGLE, at + lane);
            let front =
                self.memory.paths.vector(path::DIR, at + lane).dot(prepared.geometry.unit_normal(triangle)) < 0.0;
            let inside = self.inside(at + lane);
            if crossed >> lane & 1 != 0 {
                *inside = inside.through(fetch.material[lane], front);
            }
            flags[lane] = if *inside == Inside::default() { 0 } else { path::INSIDE };
        }
        flags
    }
}

/// Smooth glass that reads no textures, with an index relative to what is around it.
fn glass(m: &MetalRough, index_around: f32, front: bool) -> Glass {
    Glass::new(&MetalRoughParams {
        base_color: m.base_color.factor.into(),
        metallic: 0.0,
        roughness: 0.0,
        specular: m.specular.bias + m.specular.factor,
        specular_color: m.specular_color.factor.into(),
        ior: m.ior / index_around,
        transmission: 1.0,
        thin_walled: false,
        entering: front,
    })
}
