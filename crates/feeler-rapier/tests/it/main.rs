//! A BREP in Parry and Rapier, against closed forms.

mod bending;
mod compound;
mod contacts;
mod convex;
#[cfg(feature = "experiments")]
mod experiments;
#[cfg(feature = "files")]
mod files;
mod in_rapier;
mod leaving;
mod nearly;
mod pairs;
mod scenes;
mod shape;
#[cfg(feature = "parallel")]
mod threads;
