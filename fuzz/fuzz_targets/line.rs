//! The target `line` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("line");
