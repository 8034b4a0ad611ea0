//! Compiles the C++ of the oracle, if the feature `cgal` asks for it.

#[cfg(feature = "cgal")]
fn main() {
    use std::path::{Path, PathBuf};

    let here = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
    let cpp = here.join("../../cpp");
    println!("cargo::rerun-if-changed={}", cpp.display());
    println!("cargo::rerun-if-changed=src/bridge.rs");
    println!("cargo::rerun-if-env-changed=CXX");
    // Clippy looks at the Rust alone, and what is built for it serves nothing else: minutes of C++ for nothing.
    if std::env::var_os("CLIPPY_ARGS").is_some() {
        return;
    }

    let mut sources: Vec<PathBuf> = match std::fs::read_dir(&cpp) {
        Ok(entries) => entries
            .filter_map(|e| e.ok().map(|e| e.path()))
            .filter(|p| p.extension().is_some_and(|e| e == "cpp"))
            .collect(),
        Err(e) => fail(&format!("cannot read {}: {e}", cpp.display())),
    };
    // The order of a directory differs from machine to machine.
    sources.sort();

    probe(&cpp);

    let mut build = cxx_build::bridge("src/bridge.rs");
    build
        .files(&sources)
        .include(&cpp)
        .std("c++17")
        // At 2 it compiles for half as long again, and is no faster.
        .opt_level(1)
        .debug(false)
        // Interval arithmetic changes the rounding mode.
        .flag_if_supported("-frounding-math")
        // The error bounds in doubles count every rounding.
        .flag_if_supported("-ffp-contract=off")
        // The algebraic kernel over Gmpz needs MPFI.
        .define("CGAL_USE_MPFI", "1")
        // Only CGAL's LGPL parts may get in: its GPL headers fail to compile with this.
        .define("CGAL_LICENSE_ERROR", "1")
        .warnings(true)
        .extra_warnings(true);
    include_precompiled(&mut build, &cpp.join("core.hpp"));
    let compiled = build.try_compile("feeler_oracle_cpp");
    // Some 200 MB that nothing else needs.
    let out = PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default());
    std::fs::remove_file(out.join(PRECOMPILED)).ok();
    if let Err(e) = compiled {
        fail(&format!("the oracle's C++ does not compile:\n{e}"));
    }
    // In this order: MPFI uses MPFR, which uses GMP.
    for library in ["mpfi", "mpfr", "gmp"] {
        println!("cargo::rustc-link-lib={library}");
    }

    const PRECOMPILED: &str = "common.hpp.gch";

    /// Has a header that most files include be read once instead of some sixty times, by GCC (more than half of what most of them take); where that fails, it is
    /// included as ever.
    fn include_precompiled(build: &mut cc::Build, header: &Path) {
        let compiler = build.get_compiler();
        let (Ok(header), true) = (header.canonicalize(), compiler.is_like_gnu()) else {
            return;
        };
        let out = PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default());
        let own = out.join("common.hpp");
        let text = format!("#include \"{}\"\n", header.display());
        if std::fs::write(&own, text).is_err() {
            return;
        }
        let made = compiler
            .to_command()
            .args(["-x", "c++-header"])
            .arg(&own)
            .arg("-o")
            .arg(out.join(PRECOMPILED))
            .status();
        if made.is_ok_and(|s| s.success()) {
            build.flag("-include").flag(&own);
        }
    }

    /// Ends the build with what to install unless every header is found.
    fn probe(cpp: &Path) {
        const NEEDED: [(&str, &str); 6] = [
            ("CGAL/version.h", "libcgal-dev"),
            ("gmp.h", "libgmp-dev"),
            ("mpfr.h", "libmpfr-dev"),
            ("mpfi.h", "libmpfi-dev"),
            ("boost/version.hpp", "libboost-dev"),
            // Debian keeps it one folder down; elsewhere it may be in the path itself.
            ("eigen3/Eigen/Eigenvalues", "libeigen3-dev"),
        ];
        let missing: Vec<&str> = NEEDED
            .iter()
            .filter(|(header, _)| {
                let mut check = cc::Build::new();
                check.cpp(true).include(cpp).cargo_metadata(false);
                !found(&check, header)
            })
            .map(|(_, package)| *package)
            .collect();
        if !missing.is_empty() {
            fail(&format!(
                "the feature `cgal` needs {}.\n\
                 Tested with Debian 12 (CGAL 5.5.1). Install with:\n    \
                 apt-get install {}\n\
                 or build without the feature.",
                missing.join(", "),
                NEEDED.map(|(_, package)| package).join(" ")
            ));
        }
    }

    /// Whether the compiler in use finds a header.
    fn found(build: &cc::Build, header: &str) -> bool {
        let out = PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default());
        let file = out.join("probe.cpp");
        // gmp.h and friends need size_t and FILE first.
        let bare = header.strip_prefix("eigen3/").unwrap_or(header);
        let text = format!(
            "#include <cstddef>\n#include <cstdio>\n#if __has_include(<{bare}>)\n\
             #include <{bare}>\n#else\n#include <{header}>\n#endif\n"
        );
        if let Err(e) = std::fs::write(&file, text) {
            fail(&format!("cannot write {}: {e}", file.display()));
        }
        let mut command = match build.try_get_compiler() {
            Ok(compiler) => compiler.to_command(),
            Err(e) => fail(&format!("no C++ compiler: {e}")),
        };
        match command.arg("-E").arg(&file).output() {
            Ok(output) => output.status.success(),
            Err(e) => fail(&format!("the C++ compiler does not run: {e}")),
        }
    }

    fn fail(message: &str) -> ! {
        eprintln!("{message}");
        std::process::exit(1)
    }
}

#[cfg(not(feature = "cgal"))]
fn main() {}
