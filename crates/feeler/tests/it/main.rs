//! Tests of what the kernel answers, in one program: each program of its own would be linked anew.

mod arrival;
mod batch;
mod borders;
mod brep;
mod coarse_lines;
mod common;
mod contact_analytic;
mod contacts;
mod conversion;
mod corners;
mod edges;
mod evaluation;
mod feet;
mod health;
mod invariance;
mod lines;
mod off_nominal;
mod one_sphere;
mod past;
mod questions;
mod regions;
mod rulings;
mod scenes;
mod solids;
mod steps;
mod warm;
