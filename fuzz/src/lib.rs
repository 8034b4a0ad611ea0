//! Fuzz targets: bytes into geometry and queries aimed at where it breaks, and answers held against exact arithmetic.
//!
//! A target is a plain function of bytes ([`Target::run`]): libFuzzer drives it (`cargo xtask fuzz`, or cargo-fuzz in this folder), an
//! ordinary test gives each a few hundred inputs, and whatever a run finds can be given to it again.
//!
//! | module | holds |
//! |---|---|
//! | `source` | numbers from bytes: near knots by ulps, extreme weights |
//! | `loops` | trim loops: cusps, tangents, slivers, shared edges, joints on the ray, gaps |
//! | `surfaces` | surfaces, sheets and solids: poles, high degree, creases |
//! | `scene` | a BREP and queries about it, from bytes or from text; back to text |
//! | `check` | answers held against exact points of the faces, themselves, and the second method |
//! | `words` | texts of OCCT (.brep, STEP) with some words changed |
//! | `target` | the targets |
//! | `smoke` | a few inputs for each, the same every time |
//!
//! # What an answer is held against
//! In the loop: for sides, evaluations and derivative roots the second method of the oracle, exact (sides as the kernel decides them, only more plainly: it is quick, and
//! no check on what the two share); for separations a one-sided refuter, exact
//! points of the faces nearer than the claim allows, and what must hold between answers to the same question. One input in a
//! hundred (by its hash, so that it is the same ones every time) is given to the second method whole, sides by Sturm chains among it, which nothing else uses. Inputs that a campaign kept for their coverage
//! `cargo xtask fuzz` gives to the oracle, as far as its minutes go.

mod check;
mod loops;
mod scene;
mod smoke;
mod source;
mod surfaces;
mod target;
mod words;

pub use check::{Distances, Effort, answer, examine};
pub use scene::{Kind, LARGEST_INPUT, Scene};
pub use smoke::{Smoke, input, smoke};
pub use target::{Outcome, TARGETS, Target, target};

/// The entry point of a program that libFuzzer drives: the named target, its memory counted.
#[cfg(feature = "engine")]
#[macro_export]
macro_rules! drive {
    ($name:literal) => {
        #[global_allocator]
        static MEMORY: $crate::engine::PeakAlloc = $crate::engine::PeakAlloc;

        $crate::engine::fuzz_target!(|data: &[u8]| -> $crate::engine::Corpus {
            static TARGET: std::sync::OnceLock<$crate::Target> = std::sync::OnceLock::new();
            let target = TARGET.get_or_init(|| $crate::target($name).expect("a target"));
            MEMORY.reset_peak_usage();
            let before = MEMORY.current_usage();
            let outcome = target.run(data);
            let used = MEMORY.peak_usage().saturating_sub(before);
            assert!(
                used <= target.memory,
                "memory: {used} bytes for an input of {}, allowed are {}",
                data.len(),
                target.memory
            );
            match outcome {
                $crate::Outcome::Rejected => $crate::engine::Corpus::Reject,
                $crate::Outcome::Checked => $crate::engine::Corpus::Keep,
            }
        });
    };
}

/// What [`drive!`] needs.
#[cfg(feature = "engine")]
#[doc(hidden)]
pub mod engine {
    pub use libfuzzer_sys::{Corpus, fuzz_target};
    pub use peak_alloc::PeakAlloc;
}
