//! The documentation's table of what is read.

use std::path::Path;

#[test]
fn the_table_in_the_documentation_is_what_the_importers_go_by() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let made = kiln_formats::support::markdown();
    if std::env::var_os("KILN_UPDATE_DOCS").is_some() {
        std::fs::write(&path, &made).expect("the file can be written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "docs/formats.md is out of date: KILN_UPDATE_DOCS=1 cargo test -p kiln-formats --test support"
    );
}
