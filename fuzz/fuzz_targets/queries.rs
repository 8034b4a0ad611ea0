//! The target `queries` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("queries");
