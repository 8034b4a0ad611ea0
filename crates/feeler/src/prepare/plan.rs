//! What a prepared BREP keeps of each face, and why.

use super::bytes::FaceBytes;
use super::closed::ClosedSurface;
use super::{Net, PreparedBrep};
use crate::nurbs::Surface;
use crate::trim::RegionShape;

/// How queries meet a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// By formulas: `plane`, `cylinder`, `cone`, `disc`, `sphere` or `torus`.
    Closed {
        /// Which.
        kind: &'static str,
        /// Curves of its boundary that are segments and arcs in space: formulas too.
        curves: usize,
        /// Curves of its boundary that are searched, as pieces of Bezier curves.
        searched_curves: usize,
    },
    /// By a search over its patches.
    Searched(Searched),
}

/// Why a face has no closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Searched {
    /// Closed forms are switched off ([`Shortcuts`](super::Shortcuts)).
    SwitchedOff,
    /// It lies in a shell around a sphere, cylinder, cone or torus, and is searched where that bound does not suffice.
    Shell {
        /// Which of them.
        kind: &'static str,
        /// How thick it is, in the unit of the model.
        thickness: f64,
    },
    /// It is a general surface, and no round one was recognised in it.
    General,
    /// A plane whose axes as stored span none to double-double, or a revolution of what is no segment or arc in a plane with
    /// its axis.
    Surface,
    /// Its surface has a closed form, but a loop leaves the surface's domain, or follows no curve that serves.
    Loops,
}

/// What is kept of one face.
#[derive(Clone, Debug, PartialEq)]
pub struct FacePlan {
    /// The surface's type in the BREP: see [`Surface::type_name`].
    pub surface: &'static str,
    /// How it is met.
    pub form: Form,
    /// What bounds it in uv.
    pub region: RegionShape,
    /// How many patches it would be searched in.
    pub patches: usize,
    /// Their largest degrees in u and v.
    pub degree: [usize; 2],
    /// Whether some patch is rational: where not, all weights are 1 and their products are left out.
    pub rational: bool,
    /// What is made of it, if all of it is.
    pub bytes: FaceBytes,
}

impl PreparedBrep {
    /// What is kept of each face.
    ///
    /// Makes all of every face to weigh it, boundary pieces and products of coefficients apart, which are made one by one:
    /// far slower than a query, which makes only what it comes near.
    pub fn plan(&self) -> Vec<FacePlan> {
        (0..self.faces.len()).map(|f| self.face_plan(f)).collect()
    }

    fn face_plan(&self, face: usize) -> FacePlan {
        let surface = self.brep.surface(face);
        let form = match self.closed(face) {
            Some(form) => Form::Closed {
                kind: form.surface.name(),
                curves: form.curves.len(),
                searched_curves: form.others.len(),
            },
            None => Form::Searched(self.why_searched(face)),
        };
        let nets: Vec<&Net<f64>> = self
            .double(face)
            .patches
            .make_all()
            .map(|p| &p.net)
            .collect();
        self.double_double(face).patches.make_all().for_each(drop);
        let most = |of: fn(&Net<f64>) -> usize| nets.iter().map(|n| of(n)).max().unwrap_or(0);
        FacePlan {
            surface: surface.type_name(),
            form,
            region: self.region(face).shape(),
            patches: nets.len(),
            degree: [most(|n| n.degree.u), most(|n| n.degree.v)],
            rational: nets.iter().any(|n| !n.unit_weights),
            bytes: FaceBytes::of(&self.faces[face]),
        }
    }

    fn why_searched(&self, face: usize) -> Searched {
        let surface = self.brep.surface(face);
        if let Some(shell) = self.shell(face) {
            return Searched::Shell {
                kind: shell.name(),
                thickness: shell.thickness(),
            };
        }
        match surface {
            Surface::Nurbs(_) | Surface::Sum(_) => Searched::General,
            _ if !self.shortcuts.closed_forms => Searched::SwitchedOff,
            _ if ClosedSurface::new(surface, self.size, false).is_none() => Searched::Surface,
            _ => Searched::Loops,
        }
    }
}
