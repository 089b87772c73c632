//! Paths in JSON: a string, or the bytes of a name that is not UTF-8.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// A path that survives JSON whatever its bytes are.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PathText(pub PathBuf);

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Form {
    Text(String),
    Bytes { bytes: Vec<u8> },
}

impl Serialize for PathText {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serialize(&self.0, serializer)
    }
}

impl<'de> Deserialize<'de> for PathText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserialize(deserializer).map(Self)
    }
}

/// For `#[serde(with)]` on a [`PathBuf`].
///
/// # Errors
/// Those of the serializer; and, where names have no bytes (Windows), for names that are not Unicode.
pub fn serialize<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    form(path).ok_or_else(|| serde::ser::Error::custom("the path is not Unicode"))?.serialize(serializer)
}

/// For `#[serde(with)]` on a [`PathBuf`].
///
/// # Errors
/// Those of the deserializer.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PathBuf, D::Error> {
    match Form::deserialize(deserializer)? {
        Form::Text(text) => Ok(text.into()),
        Form::Bytes { bytes } => of_bytes(bytes).ok_or_else(|| serde::de::Error::custom("a path of bytes")),
    }
}

/// For `#[serde(with)]` on an [`Option`] of a [`PathBuf`].
pub mod optional {
    use super::PathText;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::path::PathBuf;

    /// For `#[serde(with)]`.
    ///
    /// # Errors
    /// As [`super::serialize`].
    pub fn serialize<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
        path.clone().map(PathText).serialize(serializer)
    }

    /// For `#[serde(with)]`.
    ///
    /// # Errors
    /// As [`super::deserialize`].
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<PathBuf>, D::Error> {
        Ok(Option::<PathText>::deserialize(deserializer)?.map(|path| path.0))
    }
}

fn form(path: &Path) -> Option<Form> {
    match path.to_str() {
        Some(text) => Some(Form::Text(text.into())),
        None => bytes(path).map(|bytes| Form::Bytes { bytes }),
    }
}

#[cfg(unix)]
fn bytes(path: &Path) -> Option<Vec<u8>> {
    use std::os::unix::ffi::OsStrExt;
    Some(path.as_os_str().as_bytes().to_vec())
}

#[cfg(unix)]
fn of_bytes(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn bytes(_: &Path) -> Option<Vec<u8>> {
    None
}

#[cfg(not(unix))]
fn of_bytes(_: Vec<u8>) -> Option<PathBuf> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStringExt;

    #[test]
    fn every_name_survives() {
        for bytes in [&b"a/b.glb"[..], "стул/椅子 \"x\".glb".as_bytes(), b"caf\xe9.glb", b"\xff\xfe", b""] {
            let path = PathText(std::ffi::OsString::from_vec(bytes.to_vec()).into());
            let text = serde_json::to_string(&path).expect("JSON");
            assert_eq!(serde_json::from_str::<PathText>(&text).expect("our own"), path, "{text}");
        }
        assert_eq!(serde_json::to_string(&PathText("a/b".into())).expect("JSON"), "\"a/b\"");
    }
}
