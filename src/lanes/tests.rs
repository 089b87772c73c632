#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use super::*;

/// Numbers of every kind, the odd ones included.
fn numbers(seed: u32) -> Vec<u32> {
    let odd =
        [0, 1 << 31, 1, 0x8000_0001, 0x7F80_0000, 0xFF80_0000, 0x7FC0_0000, 0x3F80_0000, 0xBF80_0000, 0x4F00_0000];
    let mut state = seed | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    let mut all: Vec<u32> = odd.iter().flat_map(|a| odd.map(|b| if seed.is_multiple_of(2) { *a } else { b })).collect();
    // Any bits, and numbers of like magnitude.
    all.extend((0..1500).map(|_| next()));
    all.extend((0..1500).map(|_| (next() as i32 as f32 * 1e-9).to_bits()));
    all.resize(all.len() / LANES * LANES, 0);
    all
}

/// A number's bits, all that are not numbers alike: which one comes out is the machine's choice.
fn bits(x: f32) -> u32 {
    if x.is_nan() { 0x7FC0_0000 } else { x.to_bits() }
}

/// Everything that lanes can do, over many numbers, in one list.
struct Everything;

impl Work for Everything {
    type Output = Vec<(&'static str, [u32; LANES])>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (first, second) = (numbers(2), numbers(3));
        let table: Vec<f32> = (0..100).map(|i| i as f32 * 0.5).collect();
        let mut out = Vec::new();
        for at in (0..first.len()).step_by(LANES) {
            let (u, v) = (l.load_words_at(&first, at), l.load_words_at(&second, at));
            let (a, b) = (u.from_bits(), v.from_bits());
            let mut float = |name, x: L::F| out.push((name, x.array().map(bits)));
            float("add", a + b);
            float("sub", a - b);
            float("mul", a * b);
            float("div", a / b);
            float("neg", -a);
            float("scalar", (a * 3.0 + 1.5 - 0.25) / 7.0);
            float("sqrt", a.sqrt());
            float("min", a.min(b));
            float("max", a.max(b));
            float("abs", a.abs());
            float("floor", a.floor());
            float("copysign", a.copysign(b));
            float("only", a.only(a.is_finite()));
            float("select", L::F::select(a.lt(b), a, b));
            float("to_floats", u.to_floats());
            float("gather", l.gather(&table, u & 127));
            float("gather of nothing", l.gather(&[], u));
            for (k, x) in l.gather_four(&table, u & 127).into_iter().enumerate() {
                float(["first of four", "second", "third", "fourth"][k], x);
            }
            float("four of three", l.gather_four(&table[..3], u)[3]);
            float("compress", a.compress(a.lt(b)));
            float("atan2", functions::atan2(a, b));
            let turns = (u & 0xFFFF).to_floats() * (1.0 / 65536.0) - 0.5;
            float("sin", functions::sin_cos_turns(turns).0);
            float("cos", functions::sin_cos_turns(turns).1);
            let w = V3::new(a, b, a + b);
            float("vector", (w.normalized() + w.cross(V3::splat(b)).times(w)).max_element());
            let mut word = |name, x: L::U| out.push((name, x.array()));
            word("truncate", a.truncate());
            word("plus", u + v);
            word("minus", u - v);
            word("times", u * v);
            word("and", u & v);
            word("or", u | v);
            word("xor", (u ^ v) + 17);
            word("shl", u.shl::<7>());
            word("shr", u.shr::<9>());
            word("rotl", u.rotl::<5, 27>());
            word("shr_by", u.shr_by(v));
            word("reverse", u.reverse_bits());
            word("least", u.min(v));
            word("select words", L::U::select(u.lt(v), u, v));
            word("compress words", u.compress(v.lt(u)));
            word("gather words", l.gather_words(&first, u & 511));
            let mut mask = |name, m: L::M| out.push((name, std::array::from_fn(|i| m.bits() >> i & 1)));
            mask("lt", a.lt(b));
            mask("le", a.le(b));
            mask("eq", a.eq(b));
            mask("gt", a.gt(b));
            mask("ge", a.ge(b));
            mask("word eq", (u & 3).eq(v & 3));
            mask("word lt", u.lt(v));
            mask("logic", (a.lt(b) & u.lt(v)) | !(a.eq(a) ^ l.mask(0x5A5A)));
            mask("first", l.first(at % 20));
            mask("lane numbers", l.lane_numbers().lt(l.word(at as u32 % 20)));
        }
        out
    }
}

#[test]
fn all_tiers_give_the_same_bits() {
    let plain = AnyLanes::new(SimdTier::Scalar).run(Everything);
    assert!(plain.len() > 1000);
    for tier in SimdTier::ALL {
        for (a, b) in plain.iter().zip(AnyLanes::new(tier).run(Everything)) {
            assert_eq!(*a, b, "{tier}");
        }
    }
}

#[test]
fn plain_lanes_do_what_the_language_does() {
    let l = plain::Plain;
    let a: [f32; LANES] = std::array::from_fn(|i| i as f32 * 1.25 - 7.0);
    let x = l.load(&a);
    assert_eq!((x * x - 2.0).array(), a.map(|a| a * a - 2.0));
    assert_eq!(x.floor().array(), a.map(f32::floor));
    assert_eq!(x.truncate().array(), a.map(|a| a as i32 as u32));
    assert_eq!(x.lt(x.fill(0.0)).bits(), 0b11_1111);
    assert_eq!(x.compress(x.gt(x.fill(9.0))).array()[..4], [9.25, 10.5, 11.75, 0.0]);
    assert_eq!(l.gather(&[1.0, 2.0], l.lane_numbers()).array()[..3], [1.0, 2.0, 2.0]);
    let four = l.gather_four(&[1.0, 2.0, 3.0, 4.0, 5.0], l.lane_numbers()).map(|x| [x.array()[0], x.array()[9]]);
    assert_eq!(four, [[1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 5.0]]);
    assert_eq!(l.word(0x8000_0001).reverse_bits().array(), [0x8000_0001; LANES]);
    assert_eq!(l.word(0x1234_5678).reverse_bits().array(), [0x1234_5678u32.reverse_bits(); LANES]);
}

struct Angles(Vec<f32>);

impl Work for Angles {
    type Output = Vec<[f32; 3]>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<[f32; 3]> {
        let mut all = Vec::new();
        for at in (0..self.0.len()).step_by(LANES) {
            let turns = l.load_at(&self.0, at);
            let (sin, cos) = functions::sin_cos_turns(turns);
            let angle = functions::atan2(sin * 3.0, cos * 3.0);
            let (sin, cos, angle) = (sin.array(), cos.array(), angle.array());
            all.extend((0..LANES).map(|i| [sin[i], cos[i], angle[i]]));
        }
        all
    }
}

#[test]
fn functions_are_near_the_true_ones() {
    let turns: Vec<f32> = (0..1600).map(|i| (i as f32 - 800.0) / 1601.0).collect();
    let all = AnyLanes::new(SimdTier::detect()).run(Angles(turns.clone()));
    for (turn, [sin, cos, angle]) in turns.iter().zip(all) {
        let x = f64::from(*turn) * std::f64::consts::TAU;
        for (what, got, wanted) in [("sin", sin, x.sin()), ("cos", cos, x.cos()), ("atan2", angle, x)] {
            let off = (f64::from(got) - wanted).abs();
            assert!(off < 3e-7 * wanted.abs().max(0.5), "{what} of {turn} turns: {got}, not {wanted}");
        }
    }
}
