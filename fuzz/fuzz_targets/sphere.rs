//! The target `sphere` under libFuzzer.
#![no_main]
feeler_fuzz::drive!("sphere");
