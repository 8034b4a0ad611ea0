//! The gate and its reports, in one program.

mod baseline;
mod engines;
mod jobs;
mod layout;
mod mesh;
#[cfg(unix)]
mod process;
mod study;
mod tessellate;
mod thesis;
