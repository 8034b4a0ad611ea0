//! The target `split` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("split");
