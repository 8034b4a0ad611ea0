//! Tests that need the stored corpora, in one program.

mod brep_occt;
mod brep_truth;
mod case_paths;
mod closed_forms;
mod conics;
mod contact_lists;
mod continuum;
mod crack_lines;
mod on_faces;
mod rhino3dm_facts;
mod shortcuts;
mod undecided_side;
mod warm;
mod weights;
mod winding;
