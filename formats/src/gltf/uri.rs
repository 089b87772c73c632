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
    let first = match resources.read(&decoded) {
        Err(error) if matches!(error.code, ErrorCode::Io | ErrorCode::Refused) => error,
        result => return result,
    };
    // Exporters that forget to encode write names with a literal '%'. Web pages append queries. Names of files on the
    // author's own disk, and folders that got lost, leave the name itself, which may lie beside the asset.
    let without_query = decoded.split(['?', '#']).next().unwrap_or_default();
    let last = without_query.rsplit(['/', '\\']).next().unwrap_or_default();
    let others = [uri, without_query, last];
    let found = others.into_iter().filter(|name| *name != decoded).find(|name| resources.resolve(name).is_ok());
    found.map_or(Err(first), |name| resources.read(name))
}

fn invalid(message: impl Into<String>) -> ImportError {
    ImportError::new(ErrorCode::Invalid, message)
}

/// Base64 as people write it into URIs: broken into lines, with percent encodings, or with the characters meant for URLs.
fn base64(body: &[u8]) -> Result<Vec<u8>, base64::DecodeError> {
    let first = match LENIENT.decode(body) {
        Ok(bytes) => return Ok(bytes),
        Err(error) => error,
    };
    let plain = percent_decode(body).filter(|b| !b.is_ascii_whitespace()).map(|b| match b {
        b'-' => b'+',
        b'_' => b'/',
        b => b,
    });
    LENIENT.decode(plain.collect::<Vec<u8>>()).map_err(|_| first)
}

fn decode(data: &str) -> Result<Vec<u8>, ImportError> {
    let (head, body) = data.split_once(',').ok_or_else(|| invalid("the data URI has no comma"))?;
    if head.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        base64(body.as_bytes()).map_err(|e| invalid(format!("the data URI is not base64: {e}")))
    } else {
        Ok(percent_decode(body.as_bytes()).collect())
    }
}
