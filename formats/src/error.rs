use std::fmt;

/// Where in a file something is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    #[default]
    File,
    /// A line and a column of a text file, both from 1; column 0 means "somewhere in the line".
    Text {
        /// Line, from 1.
        line: u32,
        /// Column in characters, from 1, or 0.
        column: u32,
    },
    /// A JSON pointer into a glTF document, such as `/materials/3/normalTexture`.
    Json(String),
    /// An offset in bytes.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Text { line, column: 0 } => write!(f, "{line}"),
            Self::Text { line, column } => write!(f, "{line}:{column}"),
            Self::Json(pointer) => write!(f, "{pointer}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// Why an asset could not be read. Stable words for scripts: see [`ErrorCode::as_str`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorCode {
    /// A file is missing or cannot be read.
    Io,
    /// Not a format that Kiln knows, or a version that it does not.
    UnknownFormat,
    /// The text or bytes break the format's grammar.
    Syntax,
    /// Well-formed, but what it says makes no sense (index out of range, cycle, …).
    Invalid,
    /// A required feature that Kiln lacks; the message names it.
    Unsupported,
    /// A limit of [`crate::Limits`] is exceeded.
    TooLarge,
    /// A reference leaves the root folder, or is no local file.
    Refused,
    /// Nothing to draw.
    Empty,
    /// Stopped by the caller.
    Stopped,
    /// A defect in Kiln or in a library that it uses.
    Internal,
}

impl ErrorCode {
    /// The stable word, in kebab case.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Io => "io",
            Self::UnknownFormat => "unknown-format",
            Self::Syntax => "syntax",
            Self::Invalid => "invalid",
            Self::Unsupported => "unsupported",
            Self::TooLarge => "too-large",
            Self::Refused => "refused",
            Self::Empty => "empty",
            Self::Stopped => "stopped",
            Self::Internal => "internal",
        }
    }
}

/// An asset could not be read at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ImportError {
    /// What kind of failure.
    pub code: ErrorCode,
    /// The file at fault, as the asset refers to it (the asset's own path when empty).
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// What is wrong, in a sentence without a full stop.
    pub message: String,
}

impl fmt::Display for ImportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.file.is_empty(), &self.place) {
            (true, Place::File) => write!(f, "{}", self.message),
            (true, place) => write!(f, "{place}: {}", self.message),
            (false, Place::File) => write!(f, "{}: {}", self.file, self.message),
            (false, place) => write!(f, "{}:{place}: {}", self.file, self.message),
        }
    }
}

impl ImportError {
    /// An error about a file as a whole.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self { code, file: String::new(), place: Place::File, message: message.into() }
    }

    /// The same error at a place.
    pub fn at(self, place: Place) -> Self {
        Self { place, ..self }
    }

    /// The same error in a file, unless it names one already.
    pub fn in_file(self, file: impl Into<String>) -> Self {
        if self.file.is_empty() { Self { file: file.into(), ..self } } else { self }
    }
}

impl From<crate::Stopped> for ImportError {
    fn from(_: crate::Stopped) -> Self {
        Self::new(ErrorCode::Stopped, "stopped")
    }
}

/// Something that the asset asks for and does not get, or that had to be mended. The asset is still shown.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Warning {
    /// Stable word in kebab case, such as `missing-texture`.
    pub code: String,
    /// Line and column, JSON pointer, or a file; may be empty.
    pub place: String,
    /// What was found and what was done about it.
    pub message: String,
}

impl Warning {
    /// A warning at a place.
    pub fn new(code: &str, place: impl fmt::Display, message: impl Into<String>) -> Self {
        Self { code: code.into(), place: place.to_string(), message: message.into() }
    }
}
