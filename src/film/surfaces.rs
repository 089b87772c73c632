/// What the first surfaces along the camera's rays are: layers for compositing, free of light. All of the same size, row by row
/// from the top, premultiplied by the coverage like the picture unless said otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfaces {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Base or diffuse colour, linear Rec. 709.
    pub albedo: Vec<[f32; 3]>,
    /// Unit shading normal on the viewer's side, world space.
    pub normal: Vec<[f32; 3]>,
    /// Distance from the camera along its axis, world units: the mean over the rays that met something, infinite where none
    /// did.
    pub depth: Vec<f32>,
    /// Which placement of a mesh.
    pub objects: Identity,
    /// Which material.
    pub materials: Identity,
}

/// Which of several things covers how much of each pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// What they are called, each differently.
    pub names: Vec<String>,
    /// For each pixel the things that cover most of it, in falling order: a thing's number, and its share of the pixel in
    /// [0, 1], 0 where there is no further one.
    pub ranks: Vec<[(u32, f32); RANKS]>,
}

/// Things that a pixel knows apart.
pub const RANKS: usize = 6;

impl Identity {
    /// For things of these names, which are made different from each other, and `what number` where there is none.
    pub fn new<'a>(what: &str, names: impl Iterator<Item = &'a str>, pixels: usize) -> Self {
        let mut taken = std::collections::HashSet::new();
        let unique = |(index, name): (usize, &str)| {
            let mut unique = if name.is_empty() { format!("{what} {index}") } else { name.to_owned() };
            while !taken.insert(unique.clone()) {
                unique = format!("{unique} {index}");
            }
            unique
        };
        Self { names: names.enumerate().map(unique).collect(), ranks: vec![[(0, 0.0); RANKS]; pixels] }
    }

    /// The ranks of a pixel whose rays met these things, by number and how often.
    pub fn ranked(mut met: Vec<(u32, u32)>, samples: u32) -> [(u32, f32); RANKS] {
        met.sort_unstable_by_key(|(thing, count)| (std::cmp::Reverse(*count), *thing));
        let mut ranks = [(0, 0.0); RANKS];
        for (rank, (thing, count)) in ranks.iter_mut().zip(met) {
            *rank = (thing, count as f32 / samples.max(1) as f32);
        }
        ranks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_made_different() {
        let identity = Identity::new("object", ["wheel", "", "wheel", "wheel 2", ""].into_iter(), 0);
        assert_eq!(identity.names, ["wheel", "object 1", "wheel 2", "wheel 2 3", "object 4"]);
    }

    #[test]
    fn what_covers_most_comes_first() {
        let ranks = Identity::ranked((0..9).map(|thing| (thing, 1 + thing % 3)).collect(), 18);
        let things: Vec<u32> = ranks.iter().map(|(thing, _)| *thing).collect();
        assert_eq!(things, [2, 5, 8, 1, 4, 7]);
        assert_eq!(ranks[0].1, 3.0 / 18.0);
    }
}
