//! The target `read_brep` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("read_brep");
