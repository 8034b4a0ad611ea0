//! The target `read_3dm` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("read_3dm");
