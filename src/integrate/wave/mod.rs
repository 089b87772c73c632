//! The wavefront: some thousand camera paths of a tile side by side, a scattering at a time (Laine, Karras & Aila 2013,
//! "Megakernels Considered Harmful").
//!
//! Camera rays, then in turn: closest hits, shading with light samples in sixteen lanes, visibility of the light samples; the
//! paths that go on move up. Each path gathers its light in a slot of its own, and the slots are summed up in the order
//! of the samples, so that no sum depends on which paths survive. Surfaces that lanes know nothing of are visited one by one,
//! by the code of the plain integrator, with the same random numbers.

mod aim;
mod begin;
mod glass;
mod kernels;
mod lanes;
mod lights;
mod look;
mod order;
mod passed;
mod reuse;
mod rows;
mod shade;
mod smooth;
mod sort;
mod starts;
mod surface;
mod trace;
mod waiting;
mod walled;

use super::camera::RayCamera;
use super::cone::Cone;
use super::medium::Inside;
use super::tile::Tile;
use super::walk::{Course, Sent, Walk};
use super::{View, camera_ray};
use crate::lighting::{LightRoom, Receiver};
use crate::prepare::kdtree::{Coherence, NO_TRIANGLE};
use crate::sampling::{PathSampler, Purpose};
use crate::settings::SamplerKind;
use glam::Vec3;
use rows::Rows;
use starts::Start;
pub(super) use starts::{Sight, render_tile};
use std::sync::Mutex;

/// Paths in flight.
const PATHS: usize = 2048;
/// Light samples that wait to be traced.
const SHADOWS: usize = PATHS;

/// Rows of a path.
mod path {
    pub const ORIGIN: usize = 0;
    pub const DIR: usize = 3;
    pub const THROUGHPUT: usize = 6;
    pub const ETA_SCALE: usize = 9;
    /// Density of the direction at the last vertex, over the number of its light samples; 0 where nothing else could have sampled it.
    pub const PDF: usize = 10;
    /// The last vertex as a receiver of light.
    pub const POINT: usize = 11;
    pub const NORMAL: usize = 14;
    /// Of the path's cone.
    pub const WIDTH: usize = 17;
    pub const SPREAD: usize = 18;
    pub const FLOATS: usize = 19;

    pub const SLOT: usize = 0;
    pub const FLAGS: usize = 1;
    pub const KEY: usize = 2;
    pub const INDEX: usize = 3;
    /// Triangle that the path has left, and that is behind it; or none that is known.
    pub const LEAVES: usize = 4;
    pub const WORDS: usize = 5;

    /// The receiver takes light from both sides.
    pub const BOTH_SIDES: u32 = 1;
    /// The path is inside a body.
    pub const INSIDE: u32 = 2;
}

/// Rows of a hit.
mod hit {
    pub const T: usize = 0;
    pub const B1: usize = 1;
    pub const B2: usize = 2;
    pub const FLOATS: usize = 3;
    pub const TRIANGLE: usize = 0;
    pub const WORDS: usize = 1;
}

/// Rows of a light sample.
mod shadow {
    pub const ORIGIN: usize = 0;
    pub const DIR: usize = 3;
    pub const T_MAX: usize = 6;
    /// What it brings if nothing is in the way.
    pub const LIGHT: usize = 7;
    pub const FLOATS: usize = 10;
    pub const SLOT: usize = 0;
    pub const REACHES: usize = 1;
    /// Number of the light sample at its vertex, from 1.
    pub const DRAW: usize = 2;
    /// Triangle that it leaves, and that is behind it; or none that is known.
    pub const LEAVES: usize = 3;
    pub const WORDS: usize = 4;
}

/// What a path has gathered, at its slot.
#[derive(Clone, Copy, Default)]
struct Slot {
    radiance: Vec3,
    covered: bool,
}

/// What else a path has beside its rows, at its slot.
#[derive(Clone, Copy)]
struct State {
    sampler: PathSampler,
    inside: Inside,
}

/// The memory of a wavefront, for one thread.
pub(super) struct Memory {
    paths: Rows<{ path::FLOATS }, { path::WORDS }>,
    hits: Rows<{ hit::FLOATS }, { hit::WORDS }>,
    shadows: Rows<{ shadow::FLOATS }, { shadow::WORDS }>,
    blocked: Vec<bool>,
    walled: walled::Walled,
    /// Width and spread of the cones of light samples, where there are walls.
    cones: Rows<2, 0>,
    endless: Vec<f32>,
    slots: Vec<Slot>,
    /// As many; or none, where nobody asks for them.
    states: Vec<State>,
    lights: Box<LightRoom>,
    /// Where some surfaces let rays pass.
    passed: Option<Box<passed::Passed>>,
    /// Where pixels use each other's paths.
    reuse: Option<Box<reuse::Shared>>,
    /// Where it pays that neighbours go like ways.
    order: Option<Box<order::Order>>,
}

impl Memory {
    fn new(course: &Course) -> Self {
        let (prepared, shares) = (course.prepared, course.shares());
        // Who shares paths looks for them where they began.
        let in_packets = prepared.tree.packs(Coherence::Scattered) && !shares;
        Self {
            paths: Rows::new(PATHS),
            hits: Rows::new(PATHS),
            shadows: Rows::new(SHADOWS),
            blocked: vec![false; SHADOWS],
            walled: walled::Walled::default(),
            cones: Rows::new(if prepared.asks.walls { SHADOWS } else { 0 }),
            endless: vec![f32::INFINITY; PATHS],
            slots: Vec::with_capacity(PATHS),
            states: Vec::with_capacity(PATHS),
            lights: Box::default(),
            passed: None,
            reuse: shares.then(Box::default),
            order: in_packets.then(Box::default),
        }
    }
}

/// Memories that no thread uses, for the next tiles.
#[derive(Default)]
pub(super) struct Memories(Mutex<Vec<Memory>>);

impl Memories {
    fn take(&self, course: &Course) -> Memory {
        let free = self.0.lock().ok().and_then(|mut free| free.pop());
        free.unwrap_or_else(|| Memory::new(course))
    }

    fn give_back(&self, memory: Memory) {
        if let Ok(mut free) = self.0.lock() {
            free.push(memory);
        }
    }
}

/// A wavefront at work.
struct Wave<'a, 'b> {
    course: &'a Course<'a>,
    memory: &'a mut Memory,
    tile: &'a mut Tile<'b>,
}

impl Wave<'_, '_> {
    fn render(mut self, view: &View, camera: &RayCamera, starts: &[Start]) {
        self.begin(view, camera, starts);
        for depth in 0..=self.course.settings.max_depth {
            self.trace_paths(depth);
            self.shade(depth);
            self.trace_shadows(depth);
            if self.memory.paths.len == 0 {
                break;
            }
            if let (0, Some(order)) = (depth, &mut self.memory.order) {
                self.course.prepared.lanes.run(order::Sort { order, paths: &mut self.memory.paths });
            }
        }
        if self.memory.reuse.is_some() {
            self.course.prepared.lanes.run(reuse::Join { wave: &mut self, starts });
        }
        for (start, slot) in starts.iter().zip(&self.memory.slots) {
            self.tile.add(start.pixel, start.sample, slot.radiance, slot.covered);
        }
    }

    /// Scatters all paths, with the kernel that has what the scene calls for.
    fn shade(&mut self, depth: u32) {
        let lanes = self.course.prepared.lanes;
        if self.course.is_diffuse() {
            lanes.run(shade::Shade::<kernels::Diffuse>::new(self, depth));
        } else {
            lanes.run(shade::Shade::<kernels::Full>::new(self, depth));
        }
    }

    /// Camera rays.
    fn begin(&mut self, view: &View, camera: &RayCamera, starts: &[Start]) {
        let settings = self.course.settings;
        let memory = &mut *self.memory;
        memory.slots.clear();
        memory.states.clear();
        memory.shadows.len = 0;
        let addressed = matches!(settings.sampler, SamplerKind::Sobol | SamplerKind::Pcg);
        if let Some(near) = camera.near().filter(|_| addressed) {
            let corner = [self.tile.x, self.tile.y];
            let spread = camera.cone(near.origin, view.height).spread;
            let (camera, with_states) = (near, self.course.needs_states());
            let begin = begin::Begin { memory, settings, view, camera, spread, corner, starts, with_states };
            self.course.prepared.lanes.run(begin);
        } else {
            self.begin_one_by_one(view, camera, starts);
        }
        let memory = &mut *self.memory;
        memory.paths.len = memory.slots.len();
        if let Some(shared) = &mut memory.reuse {
            shared.begin(memory.slots.len());
        }
        self.tile.tally.rays.camera += self.memory.slots.len() as u64;
    }

    /// Camera rays in double precision, and for any sampler.
    fn begin_one_by_one(&mut self, view: &View, camera: &RayCamera, starts: &[Start]) {
        let settings = self.course.settings;
        let memory = &mut *self.memory;
        for Start { pixel: [x, y], sample } in starts {
            let pixel = [self.tile.x + x, self.tile.y + y];
            let mut sampler = PathSampler::new(settings.sampler, settings.seed, pixel, *sample);
            let walk = Walk::new(camera_ray(view, camera, pixel, sampler.get_2d(0, Purpose::Pixel)));
            let at = memory.slots.len();
            memory.slots.push(Slot::default());
            memory.states.push(State { sampler, inside: Inside::default() });
            memory.paths.set_word(path::SLOT, at, at as u32);
            memory.paths.set_word(path::KEY, at, sampler.key());
            memory.paths.set_word(path::INDEX, at, sampler.index());
            memory.put(at, &walk);
        }
    }
}

impl Memory {
    /// The path at a place in the rows.
    fn walk(&self, at: usize) -> Walk {
        let rows = &self.paths;
        let (pdf, flags) = (rows.float(path::PDF, at), rows.word(path::FLAGS, at));
        let receiver = Receiver {
            point: rows.vector(path::POINT, at),
            normal: rows.vector(path::NORMAL, at),
            both_sides: flags & path::BOTH_SIDES != 0,
        };
        Walk {
            origin: rows.vector(path::ORIGIN, at),
            dir: rows.vector(path::DIR, at),
            throughput: rows.vector(path::THROUGHPUT, at),
            eta_scale: rows.float(path::ETA_SCALE, at),
            cone: self.walk_cone(at),
            inside: self.states.get(rows.word(path::SLOT, at) as usize).map_or(Inside::default(), |state| state.inside),
            sent: Sent { smooth: (pdf > 0.0).then_some((receiver, pdf)) },
        }
    }

    fn walk_cone(&self, at: usize) -> Cone {
        Cone { width: self.paths.float(path::WIDTH, at), spread: self.paths.float(path::SPREAD, at) }
    }

    /// Puts a path at a place in the rows, where its slot and its sampler's words are already.
    fn put(&mut self, at: usize, walk: &Walk) {
        let rows = &mut self.paths;
        let mut flags = 0;
        rows.set_float(path::PDF, at, 0.0);
        if let Some((receiver, pdf)) = &walk.sent.smooth {
            rows.set_float(path::PDF, at, *pdf);
            rows.set_vector(path::POINT, at, receiver.point);
            rows.set_vector(path::NORMAL, at, receiver.normal);
            flags |= if receiver.both_sides { path::BOTH_SIDES } else { 0 };
        }
        rows.set_vector(path::ORIGIN, at, walk.origin);
        rows.set_vector(path::DIR, at, walk.dir);
        rows.set_vector(path::THROUGHPUT, at, walk.throughput);
        rows.set_float(path::ETA_SCALE, at, walk.eta_scale);
        rows.set_float(path::WIDTH, at, walk.cone.width);
        rows.set_float(path::SPREAD, at, walk.cone.spread);
        if walk.inside != Inside::default() {
            flags |= path::INSIDE;
        }
        rows.set_word(path::FLAGS, at, flags);
        rows.set_word(path::LEAVES, at, NO_TRIANGLE);
        self.states[rows.word(path::SLOT, at) as usize].inside = walk.inside;
    }
}
