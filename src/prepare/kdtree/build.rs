//! The recursion that all builders share: choose a plane, deal the references to its sides, cut those on both.

use super::bounds::{Bounds, Reference};
use super::built::{Built, BuiltCell, BuiltKind};
use super::cpu::CpuMeter;
use super::split::{Cell, MAX_DEPTH, Plane, mix, sides};
use super::{BuildOptions, Triangles, clip, median, sah, sah_simd, sampled};
use crate::settings::KdTreeBuilder;
use kiln_formats::{Control, Stopped};
use rayon::prelude::*;

/// Above this many references, the two sides of a plane are built in parallel.
const FORK_ABOVE: usize = 16 * 1024;
/// A tree has at most this many references for each triangle.
const MAX_REFERENCES_PER_TRIANGLE: f64 = 3.0;
/// The same where the surface area heuristic chooses: it spends more only on long thin triangles in all directions, where three
/// leave leaves of two hundred.
const MAX_REFERENCES_BY_COST: f64 = 4.0;
/// Duplicates that any scene of more than [`FEW`] triangles may have.
const MIN_BUDGET: usize = 32;
/// Trees of so few triangles are mostly walked in packets, which test each triangle by itself: a duplicate saves them next to nothing.
const FEW: usize = 64;
/// How many references are made between two looks at the control.
const POLL_EVERY: usize = 4096;

struct Context<'a, T> {
    triangles: &'a T,
    options: &'a BuildOptions,
    control: &'a Control,
    cpu: &'a CpuMeter,
}

/// Builds the binary tree.
pub fn build<T: Triangles>(
    triangles: &T,
    options: &BuildOptions,
    control: &Control,
    cpu: &CpuMeter,
) -> Result<Built, Stopped> {
    control.check()?;
    let n = u32::try_from(triangles.len()).unwrap_or(u32::MAX);
    let mut refs = vec![Bounds::EMPTY; n as usize];
    refs.par_chunks_mut(POLL_EVERY).enumerate().try_for_each(|(chunk, refs)| {
        control.check()?;
        cpu.measure(|| {
            for (i, reference) in refs.iter_mut().enumerate() {
                let triangle = (chunk * POLL_EVERY + i) as u32;
                let corners = corners(triangles, triangle);
                *reference = clip::whole(&corners).of_triangle(triangle, clip::thickness(&corners));
            }
        });
        Ok(())
    })?;
    let mut out = Built::default();
    if refs.is_empty() {
        return Ok(out);
    }
    let most = match options.builder {
        KdTreeBuilder::Auto | KdTreeBuilder::Sah => MAX_REFERENCES_BY_COST,
        KdTreeBuilder::Median | KdTreeBuilder::Sampled => MAX_REFERENCES_PER_TRIANGLE,
    };
    let few = refs.len() <= FEW;
    let budget = if few { refs.len() / 4 } else { MIN_BUDGET + (refs.len() as f64 * (most - 1.0)) as usize };
    let root = cpu.measure(|| {
        out.thickness = refs.iter().map(Bounds::thickness).fold(0.0, f32::max);
        Cell { bounds: Bounds::around(&refs), depth: 0, budget, path: 1 }
    });
    Context { triangles, options, control, cpu }.fork(refs, root, &mut out)?;
    cpu.measure(|| out.widen());
    Ok(out)
}

#[inline(always)]
fn corners<T: Triangles>(triangles: &T, triangle: u32) -> [[f32; 3]; 3] {
    let [a, b, c] = triangles.vertices(triangle);
    [a.to_array(), b.to_array(), c.to_array()]
}

/// The two sides of a plane.
struct Sides {
    plane: Plane,
    left: Cell,
    right: Cell,
}

impl<T: Triangles> Context<'_, T> {
    /// Builds a large cell: its sides in parallel, each with memory of its own.
    fn fork(&self, mut refs: Vec<Reference>, cell: Cell, out: &mut Built) -> Result<(), Stopped> {
        self.control.check()?;
        if refs.len() <= FORK_ABOVE {
            return self.cpu.measure(|| self.descend(&mut refs, 0, cell, out));
        }
        let mut right_refs = Vec::new();
        let sides = self.cpu.measure(|| {
            let plane = self.choose(&refs, &cell)?;
            let sides = self.deal(&mut refs, 0, &mut right_refs, plane, &cell)?;
            refs.shrink_to_fit();
            Some(sides)
        });
        let Some(sides) = sides else {
            leaf(&refs, out);
            return Ok(());
        };
        let at = out.begin_split(&cell, sides.plane);
        let mut right_out = Built::default();
        let (left, right) =
            rayon::join(|| self.fork(refs, sides.left, out), || self.fork(right_refs, sides.right, &mut right_out));
        left?;
        right?;
        out.begin_right(at);
        self.cpu.measure(|| {
            out.cells.append(&mut right_out.cells);
            out.triangles.append(&mut right_out.triangles);
        });
        Ok(())
    }

    /// Builds a small cell whose references are `arena[base..]`; takes them off the arena.
    fn descend(&self, arena: &mut Vec<Reference>, base: usize, cell: Cell, out: &mut Built) -> Result<(), Stopped> {
        let n = arena.len() - base;
        if n >= POLL_EVERY {
            self.control.check()?;
        }
        let mut right_refs = Vec::new();
        let sides =
            self.choose(&arena[base..], &cell).and_then(|plane| self.deal(arena, base, &mut right_refs, plane, &cell));
        let Some(sides) = sides else {
            leaf(&arena[base..], out);
            arena.truncate(base);
            return Ok(());
        };
        let at = out.begin_split(&cell, sides.plane);
        self.descend(arena, base, sides.left, out)?;
        out.begin_right(at);
        self.descend(&mut right_refs, 0, sides.right, out)
    }

    fn choose(&self, refs: &[Reference], cell: &Cell) -> Option<Plane> {
        if sah::is_small(refs.len()) || cell.depth >= MAX_DEPTH {
            return None;
        }
        match self.options.builder {
            KdTreeBuilder::Median => median::choose(refs, cell),
            KdTreeBuilder::Sampled => sampled::choose(refs, cell, self.options.seed),
            KdTreeBuilder::Auto | KdTreeBuilder::Sah => sah_simd::choose(refs, cell, self.options.simd),
        }
    }

    /// Deals `refs[base..]` to the sides of a plane: the left side stays in place, the right one goes to `right`. `None`,
    /// with the references as they were, when the plane gains nothing or costs more duplicates than the cell may have.
    fn deal(
        &self,
        refs: &mut Vec<Reference>,
        base: usize,
        right: &mut Vec<Reference>,
        plane: Plane,
        cell: &Cell,
    ) -> Option<Sides> {
        let n = refs.len() - base;
        let (n_left, n_right, both) = super::split::count_sides(&refs[base..], plane);
        if n_left == 0 || n_right == 0 || (n_left == n && n_right == n) || both > cell.budget {
            return None;
        }
        right.reserve_exact(n_right);
        let (mut left_bounds, mut right_bounds) = (Bounds::EMPTY, Bounds::EMPTY);
        let mut kept = base;
        for i in base..refs.len() {
            let reference = refs[i];
            let (l, r) = sides(&reference, plane);
            let (left_part, right_part) = match (l, r) {
                (true, true) => self.cut(&reference, plane),
                (true, false) => (Some(reference), None),
                _ => (None, Some(reference)),
            };
            if let Some(part) = left_part {
                left_bounds.merge(&part);
                refs[kept] = part;
                kept += 1;
            }
            if let Some(part) = right_part {
                right_bounds.merge(&part);
                right.push(part);
            }
        }
        refs.truncate(kept);
        let (n_left, n_right) = (kept - base, right.len());
        let spare = cell.budget.saturating_sub((n_left + n_right).saturating_sub(n));
        let left_share = (spare as f64 * n_left as f64 / (n_left + n_right) as f64) as usize;
        let child = |bounds: Bounds, budget: usize, side: u64| Cell {
            bounds,
            depth: cell.depth + 1,
            budget,
            path: mix(cell.path.wrapping_mul(2).wrapping_add(side)),
        };
        Some(Sides {
            plane,
            left: child(left_bounds, left_share, 0),
            right: child(right_bounds, spare - left_share, 1),
        })
    }

    /// Cuts a reference at a plane. At least one part remains: a box around nothing would lose a triangle.
    fn cut(&self, reference: &Reference, plane: Plane) -> (Option<Reference>, Option<Reference>) {
        let triangle = reference.triangle();
        let corners = corners(self.triangles, triangle);
        let tag = |part: Option<Bounds>| part.map(|b| b.of_triangle(triangle, reference.thickness()));
        match clip::cut(&corners, reference, plane.axis, plane.at) {
            (None, None) => {
                let (mut below, mut above) = (*reference, *reference);
                below.set_hi(plane.axis, plane.at);
                above.set_lo(plane.axis, plane.at);
                (Some(below), Some(above))
            }
            (below, above) => (tag(below), tag(above)),
        }
    }
}

fn leaf(refs: &[Reference], out: &mut Built) {
    let mut bounds = Bounds::EMPTY;
    for reference in refs {
        bounds.merge(&reference.widened(reference.thickness()));
    }
    out.cells.push(BuiltCell { bounds, kind: BuiltKind::Leaf { count: refs.len() as u32 } });
    out.triangles.extend(refs.iter().map(Reference::triangle));
}
