//! The target `evaluate` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("evaluate");
