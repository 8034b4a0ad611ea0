//! The target `half_space` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("half_space");
