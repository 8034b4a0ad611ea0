//! The tests of the oracle in one program: what they share is linked once, and a long one leaves the other cores to the rest.

mod scene;
mod second;

#[cfg(feature = "cgal")]
mod arcs;
#[cfg(feature = "cgal")]
mod contacts;
#[cfg(feature = "cgal")]
mod contacts_native;
#[cfg(feature = "cgal")]
mod core;
#[cfg(feature = "cgal")]
mod cracks;
#[cfg(feature = "cgal")]
mod critical_points;
#[cfg(feature = "cgal")]
mod derivative_roots;
#[cfg(feature = "cgal")]
mod distance;
#[cfg(feature = "cgal")]
mod distance_models;
#[cfg(feature = "cgal")]
mod edges;
#[cfg(feature = "cgal")]
mod extremes;
#[cfg(feature = "cgal")]
mod line_in_face;
#[cfg(feature = "cgal")]
mod line_measure;
#[cfg(feature = "cgal")]
mod line_tangency;
#[cfg(feature = "cgal")]
mod native;
#[cfg(feature = "cgal")]
mod native_distance;
#[cfg(feature = "cgal")]
mod native_space;
#[cfg(feature = "cgal")]
mod properties;
#[cfg(feature = "cgal")]
mod second_exact;
#[cfg(feature = "cgal")]
mod side_models;
#[cfg(feature = "cgal")]
mod space;
#[cfg(feature = "cgal")]
mod synthetic;
