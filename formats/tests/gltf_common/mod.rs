//! Small glTF documents for tests.
#![allow(dead_code, reason = "each test file uses a part")]

use base64::Engine;
use kiln_formats::{Contents, Control, ImportError, Limits, Resources, Scene, Show, Warning};
use serde_json::{Value, json};

pub const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A document with one triangle at node 0, to be changed by tests.
pub fn triangle() -> Builder {
    let mut b = Builder::new();
    let positions = b.floats("VEC3", TRIANGLE.as_flattened());
    b.doc["meshes"] = json!([{"name": "m", "primitives": [{"attributes": {"POSITION": positions}}]}]);
    b.doc["nodes"] = json!([{"name": "n", "mesh": 0}]);
    b
}

pub type Outcome = Result<(Scene, Vec<Warning>), ImportError>;

/// A document in the making; its one buffer is written last.
#[derive(Clone)]
pub struct Builder {
    pub doc: Value,
    data: Vec<u8>,
}

impl Builder {
    pub fn new() -> Self {
        let doc = json!({"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []});
        Self { doc, data: Vec::new() }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.doc[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn bytes(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    /// A buffer view of bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.data.len();
        self.data.extend(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn strided_view(&mut self, bytes: &[u8], stride: usize) -> usize {
        let view = self.view(bytes);
        self.doc["bufferViews"][view]["byteStride"] = json!(stride);
        view
    }

    /// An accessor as it stands.
    pub fn raw(&mut self, accessor: Value) -> usize {
        self.push("accessors", accessor)
    }

    /// An accessor over bytes of its own.
    pub fn accessor(&mut self, mut accessor: Value, bytes: &[u8]) -> usize {
        accessor["bufferView"] = json!(self.view(bytes));
        self.raw(accessor)
    }

    /// An accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => panic!("{kind}"),
        };
        let accessor = json!({"type": kind, "componentType": 5126, "count": values.len() / width});
        self.accessor(accessor, &Self::bytes(values))
    }

    /// Writes the buffer into the document.
    pub fn finish(&mut self) {
        let text = base64::engine::general_purpose::STANDARD.encode(&self.data);
        let uri = format!("data:application/octet-stream;base64,{text}");
        self.doc["buffers"] = json!([{"byteLength": self.data.len(), "uri": uri}]);
    }

    pub fn import(&mut self) -> Outcome {
        self.import_with(Limits::default())
    }

    pub fn import_with(&mut self, limits: Limits) -> Outcome {
        self.finish();
        import_bytes_with(self.doc.to_string().into_bytes(), limits)
    }

    /// Imports one of the asset's looks.
    pub fn import_showing(&mut self, show: &Show) -> Outcome {
        self.finish();
        import_bytes_showing(self.doc.to_string().into_bytes(), Limits::default(), show)
    }

    /// The document as a GLB file.
    pub fn glb(&mut self) -> Vec<u8> {
        self.doc["buffers"] = json!([{"byteLength": self.data.len()}]);
        let mut text = self.doc.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.data.len();
        let mut file = b"glTF".to_vec();
        for word in [2, length as u32, text.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(b"JSON");
        file.extend(&text);
        file.extend((self.data.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(&self.data);
        file
    }
}

pub fn import_bytes(bytes: Vec<u8>) -> Outcome {
    import_bytes_with(bytes, Limits::default())
}

pub fn import_json(document: &Value) -> Outcome {
    import_bytes(document.to_string().into_bytes())
}

/// Imports from a folder that holds nothing of the asset, and checks what the scene guarantees.
pub fn import_bytes_with(bytes: Vec<u8>, limits: Limits) -> Outcome {
    import_bytes_showing(bytes, limits, &Show::default())
}

fn import_bytes_showing(bytes: Vec<u8>, limits: Limits, show: &Show) -> Outcome {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mut resources = Resources::new(&folder.join("asset.gltf"), Some(folder), limits).unwrap();
    let mut warnings = Vec::new();
    let (contents, control) = (&mut Contents::default(), Control::default());
    let scene = kiln_formats::gltf::import(bytes, &mut resources, show, contents, &mut warnings, &control)?;
    scene.validate().unwrap();
    Ok((scene, warnings))
}

pub fn warned(warnings: &[Warning], code: &str) -> bool {
    warnings.iter().any(|w| w.code == code)
}

/// A PNG file of 2 × 2 pixels.
pub fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([255 * x as u8, 255 * y as u8, 128]));
    pixels.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}
