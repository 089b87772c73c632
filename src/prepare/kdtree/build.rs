//! The recursion that all builders share: choose a plane, deal the references to its sides, cut those on both.

use super::bounds::{Bounds, MOST_TRIANGLES, Reference};
use super::built::{Built, BuiltCell, BuiltKind};
use super::deal::{Deal, Sides};
use super::split::{BLOCK, Cell, MAX_DEPTH, Plane};
use super::{BuildOptions, Triangles, median, references, sah, sah_simd, sampled};
use crate::cpu_clock::CpuMeter;
use crate::lanes::AnyLanes;
use crate::settings::KdTreeBuilder;
use kiln_formats::{Control, Stopped};
use rayon::prelude::*;

/// Above this many references, the two sides of a plane are built in parallel.
const FORK_ABOVE: usize = 16 * 1024;
/// A tree has at most this many references for each triangle.
const MAX_REFERENCES_PER_TRIANGLE: f64 = 3.0;
/// The same where the surface area heuristic chooses: it spends more only on long thin triangles in all directions, where three
/// leave leaves of two hundred. With four, those are a third smaller; rays are as fast, since the tree is larger by a seventh.
const MAX_REFERENCES_BY_COST: f64 = 3.5;
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
    lanes: AnyLanes,
}

/// Builds the binary tree.
pub fn build<T: Triangles>(
    triangles: &T,
    options: &BuildOptions,
    control: &Control,
    cpu: &CpuMeter,
) -> Result<Built, Stopped> {
    control.check()?;
    let n = u32::try_from(triangles.len()).map_or(MOST_TRIANGLES, |n| n.min(MOST_TRIANGLES)) as usize;
    let few = n <= FEW;
    let mut refs = vec![Bounds::EMPTY; n];
    let make = |(chunk, refs): (usize, &mut [Reference])| {
        control.check()?;
        Ok(cpu.measure(|| references::make(triangles, (chunk * POLL_EVERY) as u32, !few, refs)))
    };
    let made: Vec<usize> = refs.par_chunks_mut(POLL_EVERY).enumerate().map(make).collect::<Result<_, Stopped>>()?;
    cpu.measure(|| close_up(&mut refs, &made));
    let mut out = Built::default();
    if refs.is_empty() {
        return Ok(out);
    }
    let most = match options.builder {
        KdTreeBuilder::Auto | KdTreeBuilder::Sah => MAX_REFERENCES_BY_COST,
        KdTreeBuilder::Median | KdTreeBuilder::Sampled => MAX_REFERENCES_PER_TRIANGLE,
    };
    let budget = if few { n / 4 } else { MIN_BUDGET + (n as f64 * (most - 1.0)) as usize };
    let root = cpu.measure(|| {
        out.thickness = refs.iter().map(Bounds::thickness).fold(0.0, f32::max);
        Cell { bounds: Bounds::around(&refs), depth: 0, triangles: n, budget, path: 1 }
    });
    Context { triangles, options, control, cpu, lanes: AnyLanes::new(options.simd) }.fork(refs, root, &mut out)?;
    cpu.measure(|| out.widen());
    Ok(out)
}

/// Removes the room that chunks have left, of which so many are in use.
fn close_up(refs: &mut Vec<Reference>, made: &[usize]) {
    let mut end = 0;
    for (chunk, &len) in made.iter().enumerate() {
        refs.copy_within(chunk * POLL_EVERY..chunk * POLL_EVERY + len, end);
        end += len;
    }
    refs.truncate(end);
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
            let sides = self.divide(&mut refs, 0, &mut right_refs, &cell)?;
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
        let Some(sides) = self.divide(arena, base, &mut right_refs, &cell) else {
            leaf(&arena[base..], out);
            arena.truncate(base);
            return Ok(());
        };
        let at = out.begin_split(&cell, sides.plane);
        self.descend(arena, base, sides.left, out)?;
        out.begin_right(at);
        self.descend(&mut right_refs, 0, sides.right, out)
    }

    /// Divides the references `refs[base..]` of a cell by the plane that is chosen. Who chooses reckons with what a reference stands for in the mean: where
    /// that plane cuts too many pairs for what duplicates may still take, one is chosen that half of that is enough for, as a reference
    /// stands for two triangles at most.
    fn divide(&self, refs: &mut Vec<Reference>, base: usize, right: &mut Vec<Reference>, cell: &Cell) -> Option<Sides> {
        let plane = self.choose(&refs[base..], cell)?;
        self.deal(refs, base, right, plane, cell).or_else(|| {
            let careful = Cell { budget: cell.budget / 2, ..*cell };
            let plane = self.choose(&refs[base..], &careful)?;
            self.deal(refs, base, right, plane, cell)
        })
    }

    fn deal(
        &self,
        refs: &mut Vec<Reference>,
        base: usize,
        right: &mut Vec<Reference>,
        plane: Plane,
        cell: &Cell,
    ) -> Option<Sides> {
        self.lanes.run(Deal { triangles: self.triangles, refs, base, right, plane, cell })
    }

    fn choose(&self, refs: &[Reference], cell: &Cell) -> Option<Plane> {
        if sah::is_small(cell.triangles) || cell.depth >= MAX_DEPTH {
            return None;
        }
        match self.options.builder {
            KdTreeBuilder::Median => median::choose(refs, cell),
            KdTreeBuilder::Sampled => sampled::choose(refs, cell, self.options.seed),
            KdTreeBuilder::Auto | KdTreeBuilder::Sah => sah_simd::choose(refs, cell, self.options.simd),
        }
    }
}

fn leaf(refs: &[Reference], out: &mut Built) {
    let count: u32 = refs.iter().map(Reference::weight).sum();
    let mut bounds = Bounds::EMPTY;
    for reference in refs {
        bounds.merge(&reference.widened(reference.thickness()));
    }
    out.cells.push(BuiltCell { bounds, kind: BuiltKind::Leaf { count } });
    if count as usize <= BLOCK {
        out.triangles.extend(refs.iter().flat_map(Reference::triangles));
    } else {
        // Pairs first: so there are whole blocks of them, which have few corners.
        let of_weight = |weight| refs.iter().filter(move |r| r.weight() == weight).flat_map(Reference::triangles);
        out.triangles.extend(of_weight(2).chain(of_weight(1)));
    }
}

#[cfg(test)]
mod tests {
    use super::super::split::mix;
    use super::*;
    use glam::Vec3;

    /// Specks in a long box, and at its upper side strips of two triangles along all of it.
    struct Strips;

    const STRIPS: usize = 40;

    impl Triangles for Strips {
        fn len(&self) -> usize {
            2 * STRIPS + 3600
        }

        fn vertices(&self, triangle: u32) -> [Vec3; 3] {
            let number = |k: u64| (mix(u64::from(triangle) * 8 + k) >> 40) as f32 / 16_777_216.0;
            if triangle as usize >= 2 * STRIPS {
                let at = Vec3::new(100.0 * number(0), 0.8 * number(1), number(2));
                return [at, at + Vec3::X * 1e-3, at + Vec3::Y * 1e-3];
            }
            let z = (triangle / 2) as f32 / STRIPS as f32;
            let at = |x: f32, y: f32| Vec3::new(x, 0.9 + y, z);
            match triangle % 2 {
                0 => [at(0.0, 0.0), at(100.0, 0.0), at(100.0, 0.1)],
                _ => [at(0.0, 0.0), at(100.0, 0.1), at(0.0, 0.1)],
            }
        }
    }

    /// The best plane cuts forty references, for which sixty duplicates seem to be enough; but they are pairs.
    #[test]
    fn a_cell_whose_plane_cuts_too_many_pairs_is_divided_by_another() {
        let mut refs = vec![Bounds::EMPTY; Strips.len()];
        let len = references::make(&Strips, 0, true, &mut refs);
        refs.truncate(len);
        assert_eq!(len, STRIPS + 3600);
        let options = BuildOptions { builder: KdTreeBuilder::Sah, ..BuildOptions::default() };
        let (control, cpu) = (Control::default(), CpuMeter::default());
        let lanes = AnyLanes::new(options.simd);
        let context = Context { triangles: &Strips, options: &options, control: &control, cpu: &cpu, lanes };
        let bounds = Bounds::around(&refs);
        let cell = Cell { bounds, triangles: Strips.len(), depth: 0, budget: 60, path: 1 };
        let plane = context.choose(&refs, &cell).expect("one that seems to pay");
        let mut right = Vec::new();
        assert!(context.deal(&mut refs, 0, &mut right, plane, &cell).is_none(), "it cuts too many pairs");
        let sides = context.divide(&mut refs, 0, &mut right, &cell).expect("another plane");
        assert!(sides.left.triangles + sides.right.triangles - Strips.len() <= cell.budget && sides.plane != plane);
    }
}
