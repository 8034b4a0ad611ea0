//! Installing what the tests need.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Debian packages: the oracle's libraries, Python for the cross-check of the reader, and what counts instructions.
const PACKAGES: [&str; 9] = [
    "g++",
    "libcgal-dev",
    "libgmp-dev",
    "libmpfr-dev",
    "libmpfi-dev",
    "libboost-dev",
    "libeigen3-dev",
    "python3-venv",
    "valgrind",
];

/// PyPI packages of the cross-check, pinned: an independent reader of .3dm files.
const PYTHON_PACKAGES: [&str; 1] = ["rhino3dm==8.35.0"];

fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|s| s.success())
}

fn is_installed(package: &str) -> bool {
    Command::new("dpkg-query")
        .args(["-W", "-f=${Status}", package])
        .stderr(Stdio::null())
        .output()
        .is_ok_and(|o| String::from_utf8_lossy(&o.stdout).contains("install ok installed"))
}

fn is_root() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|o| o.stdout.trim_ascii() == b"0")
}

/// Installs the Debian packages that are missing; without root says how.
///
/// # Errors
/// What is missing, and how to install it.
pub fn install_packages() -> Result<(), String> {
    if !succeeds(Command::new("dpkg-query").arg("--version")) {
        println!(
            "No dpkg here: install CGAL 5.5 or newer, GMP, MPFR, MPFI, Boost and Eigen headers, and valgrind \
             yourself (on Debian: {}).",
            PACKAGES.join(" ")
        );
        return Ok(());
    }
    let missing: Vec<_> = PACKAGES.into_iter().filter(|p| !is_installed(p)).collect();
    if missing.is_empty() {
        println!("All {} Debian packages are there.", PACKAGES.len());
        return Ok(());
    }
    let list = missing.join(" ");
    if !is_root() {
        return Err(format!(
            "missing Debian packages; run `sudo apt-get install {list}` and start again"
        ));
    }
    println!("Installing by apt-get: {list}");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdin(Stdio::null())
            .args(["-qq", "-o", "Dpkg::Use-Pty=0"])
            .args(arguments);
        command.status().is_ok_and(|s| s.success())
    };
    // A failed update is no reason to stop: the lists may be good enough.
    if !apt(&["update"]) {
        println!("`apt-get update` failed; going on with the package lists there are.");
    }
    let mut arguments = vec!["install", "-y", "--no-install-recommends"];
    arguments.extend(&missing);
    if apt(&arguments) {
        Ok(())
    } else {
        Err(format!("`apt-get install {list}` failed"))
    }
}

/// A Python with the packages of the cross-check, in `target/venv`; `None` (said aloud) where it cannot be
/// had: the tests that need it then say that they did nothing.
pub(crate) fn python(root: &Path) -> Option<PathBuf> {
    let venv = root.join("target/venv");
    let python = venv.join("bin/python");
    let has_packages = || succeeds(Command::new(&python).args(["-c", "import rhino3dm"]));
    if has_packages() {
        return Some(python);
    }
    println!(
        "Making a Python environment in target/venv with {}.",
        PYTHON_PACKAGES.join(" ")
    );
    let made = succeeds(Command::new("python3").args(["-m", "venv"]).arg(&venv));
    let pip = |packages: &[&str]| {
        let mut command = Command::new(&python);
        command.args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
        ]);
        succeeds(command.args(packages))
    };
    if made && pip(&PYTHON_PACKAGES) && has_packages() {
        return Some(python);
    }
    println!(
        "SKIPPED: rhino3dm could not be installed; the reader is not compared with it in this run."
    );
    None
}
