//! `cargo xtask sanitize`: the oracle's tests with its C++ under the compiler's sanitizers.
//!
//! Only the C++ is instrumented, so that the stable toolchain and its ready-made standard library serve:
//! the checks of memory and of undefined behaviour speak of `cpp/` and of CGAL's headers, and so
//! does the check of data races. Rust's standard library shows that one its threads' starts and
//! ends and every allocation (through `pthread_create` and `malloc`), but not its atomics; the test
//! `threads` therefore shares nothing else between threads.

use std::process::Command;
use xtask_test::root;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// One sanitizer alone.
    #[arg(value_enum)]
    sanitizer: Option<Sanitizer>,
    /// One module of the tests of crate `feeler-oracle` alone, or `threads`.
    #[arg(long)]
    test: Option<String>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Sanitizer {
    /// Memory that is not ours, leaks (AddressSanitizer), and what the language leaves undefined
    /// (UndefinedBehaviorSanitizer): one build, one run.
    Memory,
    /// Data races (ThreadSanitizer), on the tests with threads.
    Thread,
}

impl Sanitizer {
    const ALL: [Self; 2] = [Self::Memory, Self::Thread];

    /// The folder of its build.
    fn name(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Thread => "thread",
        }
    }

    /// What g++ calls it.
    fn kinds(self) -> &'static str {
        match self {
            Self::Memory => "address,undefined",
            Self::Thread => "thread",
        }
    }

    /// The libraries that the program needs beside g++'s.
    fn libraries(self) -> &'static [&'static str] {
        match self {
            Self::Memory => &["libasan.so", "libubsan.so"],
            Self::Thread => &["libtsan.so"],
        }
    }
}

/// The tests of the oracle's functions one by one: every source of `cpp/` runs but `critical_points.cpp` and its bridge. Left
/// out are those that ask the same functions about many models, and those of the second method, which is Rust alone, but
/// for one that calls Eigen; and the critical points, because CGAL 5.5.1 copies an enumerator there that is not set yet
/// (`Curve_pair_analysis_2.h`, line 109), which UndefinedBehaviorSanitizer stops at.
const TESTS: [&str; 16] = [
    "arcs::",
    "contacts::",
    "contacts_native::",
    "core::",
    "derivative_roots::",
    "distance::",
    "edges::",
    "extremes::",
    "line_in_face::",
    "line_tangency::",
    "native::",
    "native_distance::",
    "native_space::",
    "second_exact::candidates_of_eigen_find_what_was_missed",
    "space::",
    "synthetic::",
];

/// A program of its own.
const THREADS: &str = "threads";

pub(crate) fn run(args: &Args) -> Result<(), String> {
    xtask_test::install_packages()?;
    let all = args.sanitizer.map_or(Sanitizer::ALL.to_vec(), |s| vec![s]);
    for sanitizer in all {
        one(sanitizer, args.test.as_deref())?;
    }
    Ok(())
}

fn one(sanitizer: Sanitizer, test: Option<&str>) -> Result<(), String> {
    let name = sanitizer.name();
    println!("==> {name} sanitizer");
    let root = root();
    let flag = format!("-fsanitize={}", sanitizer.kinds());
    let host = host()?;
    let all = sanitizer.libraries().iter();
    let runtimes = all.map(|l| runtime(l)).collect::<Result<Vec<_>, _>>()?;
    let link: Vec<String> = runtimes.iter().map(|r| format!("-Clink-arg={r}")).collect();
    let mut command = Command::new(env!("CARGO"));
    command
        .current_dir(&root)
        .args("test --release -p feeler-oracle --features cgal".split(' '))
        // With a target named, flags do not reach build scripts and procedural macros.
        .args(["--target", &host])
        .arg("--target-dir")
        .arg(root.join("target/sanitize").join(name))
        .env(
            "CXXFLAGS",
            format!("{flag} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1"),
        )
        // rustc links without a compiler's default libraries, so the runtime is named; and it must come
        // before the C library, which only preloading gives.
        .env("RUSTFLAGS", link.join(" "))
        .env(
            format!(
                "CARGO_TARGET_{}_RUNNER",
                host.to_uppercase().replace('-', "_")
            ),
            format!("env LD_PRELOAD={}", runtimes.join(":")),
        )
        .env("UBSAN_OPTIONS", "print_stacktrace=1")
        .env("TSAN_OPTIONS", "halt_on_error=1");
    match (sanitizer, test) {
        (_, Some(THREADS)) | (Sanitizer::Thread, None) => command.args(["--test", THREADS]),
        (_, Some(test)) => command.args(["--test", "oracle", "--", &format!("{test}::")]),
        (_, None) => {
            command.args(["--test", THREADS, "--test", "oracle", "--"]);
            command.args(TESTS)
        }
    };
    let status = command
        .status()
        .map_err(|e| format!("cargo cannot be started: {e}"))?;
    if status.success() {
        println!("    {name}: nothing found");
        Ok(())
    } else {
        Err(format!("the {name} sanitizer found something (see above)"))
    }
}

/// The path of a sanitizer's library, which is the C++ compiler's.
fn runtime(library: &str) -> Result<String, String> {
    let output = Command::new("g++")
        .arg(format!("-print-file-name={library}"))
        .output()
        .map_err(|e| format!("g++ cannot be started: {e}"))?;
    let path = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    // The name alone is the answer where there is none.
    if path.contains('/') {
        Ok(path)
    } else {
        Err(format!("g++ has no {library}; install its sanitizers"))
    }
}

/// The triple of this machine.
pub(crate) fn host() -> Result<String, String> {
    let output = Command::new("rustc")
        .arg("-vV")
        .output()
        .map_err(|e| format!("rustc cannot be started: {e}"))?;
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .find_map(|l| l.strip_prefix("host: ").map(str::to_owned))
        .ok_or_else(|| "`rustc -vV` names no host".to_owned())
}
