//! Portable float maps: what Open Image Denoise's program reads and writes.

/// Three floats a pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl FloatMap {
    /// As a file: little-endian, with the bottom row first.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = format!("PF\n{} {}\n-1.0\n", self.width, self.height).into_bytes();
        let rows = self.pixels.chunks(self.width.max(1) as usize).rev();
        bytes.extend(rows.flatten().flatten().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    /// Reads a little-endian file with three channels and this size.
    ///
    /// # Errors
    /// A sentence, when it is anything else.
    pub fn decode(bytes: &[u8], width: u32, height: u32) -> Result<Self, String> {
        let mut words = bytes.splitn(5, |byte| byte.is_ascii_whitespace());
        let mut word = || words.next().and_then(|word| std::str::from_utf8(word).ok()).unwrap_or_default();
        let head = [word(), word(), word(), word()].map(str::to_owned);
        let scale = head[3].parse::<f32>().unwrap_or(0.0);
        let sized = head[1].parse() == Ok(width) && head[2].parse() == Ok(height);
        if head[0] != "PF" || !sized || !(scale < 0.0) {
            return Err(format!("is no little-endian float map of {width} × {height} pixels: {}", head.join(" ")));
        }
        let data = words.next().unwrap_or_default();
        if data.len() as u64 != 12 * u64::from(width) * u64::from(height) {
            return Err(format!("has {} bytes for {width} × {height} pixels", data.len()));
        }
        let number = |b: &[u8]| b.try_into().map_or(0.0, f32::from_le_bytes);
        let pixel = |p: &[u8]| [number(&p[..4]), number(&p[4..8]), number(&p[8..])];
        let rows = data.chunks_exact(12 * width.max(1) as usize).rev();
        Ok(Self { width, height, pixels: rows.flat_map(|row| row.chunks_exact(12)).map(pixel).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_read_back_and_others_refused() {
        let map = FloatMap { width: 2, height: 3, pixels: (0..6).map(|i| [i as f32, 0.1, -1e30]).collect() };
        let bytes = map.encode();
        assert_eq!(FloatMap::decode(&bytes, 2, 3), Ok(map.clone()));
        assert!(
            bytes.starts_with(b"PF\n2 3\n-1.0\n") && bytes[12..16] == 4f32.to_le_bytes(),
            "the bottom row is first"
        );
        for (width, height, bytes) in
            [(3, 2, &bytes[..]), (2, 3, &bytes[..bytes.len() - 1]), (2, 3, b"Pf"), (2, 3, b"")]
        {
            assert!(FloatMap::decode(bytes, width, height).is_err());
        }
    }
}
