//! Installing what the tests need, and running them: what can be done before anything else is built.

mod setup;
mod test;

pub use setup::install_packages;
pub use test::run;

use std::path::{Path, PathBuf};

/// The workspace's folder.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}
