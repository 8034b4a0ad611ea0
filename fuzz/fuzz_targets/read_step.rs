//! The target `read_step` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("read_step");
