//! Which samples of a tile are followed together.

use super::{Memories, PATHS, Wave, reuse};
use crate::film::group_in_square;
use crate::integrate::View;
use crate::integrate::camera::RayCamera;
use crate::integrate::occupied::Occupied;
use crate::integrate::tile::{SIDE, Tile};
use crate::integrate::walk::Course;
use kiln_formats::{Control, Stopped};
use std::ops::Range;

/// How the scene is looked at.
pub(in crate::integrate) struct Sight<'a> {
    pub view: &'a View,
    pub camera: &'a RayCamera,
    /// Where rays can meet anything; without it, everywhere. Rays elsewhere bring nothing.
    pub occupied: Option<&'a Occupied>,
}

/// Adds to a tile the samples that its pixels lack.
pub(in crate::integrate) fn render_tile(
    course: &Course,
    sight: &Sight,
    memories: &Memories,
    tile: &mut Tile,
    control: &Control,
) -> Result<(), Stopped> {
    let Sight { view, camera, occupied } = *sight;
    let order = if course.shares() { reuse::in_groups } else { blockwise };
    let near = if course.shares() { group_in_square } else { block };
    let mut pixels: Vec<([u32; 2], Range<u32>)> = order(tile.width, tile.height)
        .into_iter()
        .map(|[x, y]| ([x, y], tile.wanted([x, y])))
        .filter(|(_, wanted)| !wanted.is_empty())
        .collect();
    if let Some(occupied) = occupied {
        let meets = |([x, y], _): &([u32; 2], Range<u32>)| occupied.at([tile.x + x, tile.y + y]);
        let (meeting, empty) = pixels.into_iter().partition(meets);
        pixels = meeting;
        for (pixel, wanted) in empty {
            tile.pass_over(pixel);
            control.advance(u64::from(wanted.end - wanted.start));
        }
    }
    if pixels.is_empty() {
        return control.check();
    }
    let mut memory = memories.take(course);
    let mut starts = Vec::with_capacity(PATHS);
    let mut follow = |starts: &mut Vec<Start>| {
        control.check()?;
        Wave { course, memory: &mut memory, tile }.render(view, camera, starts);
        control.advance(starts.len() as u64);
        starts.clear();
        Ok(())
    };
    // All samples of neighbours before those of others: paths that are followed side by side so have the most in common.
    for neighbours in pixels.chunk_by(|a, b| near(a.0) == near(b.0)) {
        let from = neighbours.iter().map(|(_, wanted)| wanted.start).min().unwrap_or(0);
        let to = neighbours.iter().map(|(_, wanted)| wanted.end).max().unwrap_or(0);
        for sample in from..to {
            if starts.len() + neighbours.len() > PATHS {
                follow(&mut starts)?;
            }
            let wanting = neighbours.iter().filter(|(_, wanted)| wanted.contains(&sample));
            starts.extend(wanting.map(|(pixel, _)| Start { pixel: *pixel, sample }));
        }
    }
    follow(&mut starts)?;
    memories.give_back(memory);
    Ok(())
}

/// The pixels of a tile in blocks of four by four, so that sixteen neighbours in the order are neighbours in the picture.
fn blockwise(width: u32, height: u32) -> Vec<[u32; 2]> {
    let block = |k: u32| [k % (SIDE / 4) * 4, k / (SIDE / 4) * 4];
    let all = (0..SIDE * SIDE / 16).flat_map(|k| (0..16).map(move |i| [block(k)[0] + i % 4, block(k)[1] + i / 4]));
    all.filter(|[x, y]| *x < width && *y < height).collect()
}

/// The block of [`blockwise`] that a pixel is in.
fn block([x, y]: [u32; 2]) -> u32 {
    y / 4 * SIDE + x / 4
}

/// A sample of a pixel within a tile.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub pixel: [u32; 2],
    pub sample: u32,
}
