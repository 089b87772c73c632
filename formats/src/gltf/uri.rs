//! URIs of buffers and images: data URIs and relative files.

use crate::{ErrorCode, ImportError, Resources};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::{percent_decode, percent_decode_str};

const LENIENT: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The bytes behind a URI.
///
/// # Errors
/// [`ErrorCode::Invalid`] for data URIs and percent encodings that cannot be decoded; those of [`Resources::read`].
pub(super) fn load(uri: &str, resources: &mut Resources) -> Result<Vec<u8>, ImportError> {
    if let Some(data) = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).and_then(|_| uri.get(5..)) {
        return decode(data);
    }
    let decoded =
        percent_decode_str(uri).decode_utf8().map_err(|_| invalid("the URI's percent encoding is not UTF-8"))?;
    match resources.read(&decoded) {
        // Exporters that forget to encode write names with a literal '%'.
        Err(error) if error.code == ErrorCode::Io && decoded != uri => resources.read(uri).map_err(|_| error),
        result => result,
    }
}

fn invalid(message: impl Into<String>) -> ImportError {
    ImportError::new(ErrorCode::Invalid, message)
}

fn decode(data: &str) -> Result<Vec<u8>, ImportError> {
    let (head, body) = data.split_once(',').ok_or_else(|| invalid("the data URI has no comma"))?;
    if head.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        LENIENT.decode(body).map_err(|e| invalid(format!("the data URI is not base64: {e}")))
    } else {
        Ok(percent_decode(body.as_bytes()).collect())
    }
}
