//! The target `side` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("side");
