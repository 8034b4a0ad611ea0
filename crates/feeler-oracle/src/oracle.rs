//! The oracle itself: safe calls into C++.

use crate::bridge::ffi;
use crate::convert;
use crate::truth::{Evaluation, OracleError, Shared, SideTruth, TruthEnclosure};
use dashu_int::IBig;
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::Limit;
use feeler::trim::Side;
use std::cell::OnceCell;

/// Exact truth about BREPs. Faces are numbered through all of them in order.
///
/// Neither `Send` nor `Sync`; make one a thread.
pub struct Oracle {
    core: cxx::UniquePtr<ffi::Core>,
    faces: usize,
    /// Each BREP on its own, where there are several; empty otherwise.
    single: Vec<(Brep, OnceCell<Box<Oracle>>)>,
    /// Length within which points of the faces count as joined, for contacts.
    pub(crate) join: OnceCell<f64>,
}

/// For tests of the containment: sets this thread's rounding mode, upward or to nearest.
#[doc(hidden)]
pub fn set_rounding_upward(upward: bool) {
    ffi::set_rounding_upward(upward);
}

impl std::fmt::Debug for Oracle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Oracle")
            .field("faces", &self.faces)
            .finish_non_exhaustive()
    }
}

pub(crate) fn dyadic(raw: &ffi::RawDyadic) -> Result<Dyadic, OracleError> {
    IBig::from_str_radix(&raw.mantissa, 16)
        .map(|m| Dyadic::new(m, raw.exponent))
        .map_err(|_| OracleError::Defect("a mantissa that is no hexadecimal number"))
}

pub(crate) fn enclosure(raw: &ffi::RawEnclosure) -> Result<TruthEnclosure, OracleError> {
    let (lo, hi) = (dyadic(&raw.lo)?, dyadic(&raw.hi)?);
    if lo > hi {
        return Err(OracleError::Defect("an enclosure that is reversed"));
    }
    Ok(TruthEnclosure { lo, hi })
}

impl Oracle {
    /// Takes the raw control data and topology of the BREPs; regions and patches are made when
    /// a query first needs them.
    ///
    /// # Errors
    /// [`OracleError::Refused`] names the face and what is wrong with it.
    pub fn new(breps: &[&Brep]) -> Result<Self, OracleError> {
        let (core, faces) = convert::core(breps)?;
        let single = if breps.len() > 1 {
            breps
                .iter()
                .map(|b| ((*b).clone(), OnceCell::new()))
                .collect()
        } else {
            Vec::new()
        };
        Ok(Self {
            core,
            faces,
            single,
            join: OnceCell::new(),
        })
    }

    /// An oracle for each BREP.
    pub(crate) fn each_brep(&self) -> Result<Vec<&Self>, OracleError> {
        if self.single.is_empty() {
            return Ok(vec![self]);
        }
        self.single
            .iter()
            .map(|(brep, cell)| {
                if let Some(oracle) = cell.get() {
                    return Ok(&**oracle);
                }
                let made = Box::new(Self::new(&[brep])?);
                Ok(&**cell.get_or_init(|| made))
            })
            .collect()
    }

    /// Whether there is one BREP alone.
    pub(crate) fn is_single(&self) -> bool {
        self.single.is_empty()
    }

    /// How many faces all BREPs have together.
    pub fn faces(&self) -> usize {
        self.faces
    }

    pub(crate) fn core(&self) -> &ffi::Core {
        &self.core
    }

    pub(crate) fn check_face(&self, face: usize) -> Result<(), OracleError> {
        if face < self.faces {
            Ok(())
        } else {
            Err(OracleError::NoFace {
                face,
                count: self.faces,
            })
        }
    }

    /// Makes now what queries would make on first use and keep. What is left to them are exact widths of
    /// cracks that they come near, and arcs of loops, halved where they look closely. 0.1 ms a patch, 0.3 ms
    /// a trim curve.
    ///
    /// # Errors
    /// Where a query that needs it would fail.
    pub fn prepare(&self, what: Shared) -> Result<(), OracleError> {
        let (what, face) = match what {
            Shared::Face(face) => {
                self.check_face(face)?;
                (0, face)
            }
            Shared::Pieces => (1, 0),
            Shared::Edges => (2, 0),
        };
        ffi::prepare(&self.core, what, face)?;
        // Signed separations of several BREPs ask each of them.
        if what == 2 && !self.is_single() {
            for one in self.each_brep()? {
                ffi::prepare(&one.core, what, 0)?;
            }
        }
        Ok(())
    }

    /// The point of a face's surface at `uv` and its derivatives up to the second, rounded outward
    /// to 192 bits; from above at knots and joints. Exact before that where the surface is
    /// rational, else enclosed to about 2^-300 of the model's size. About 0.2 ms.
    ///
    /// # Errors
    /// `uv` must be finite and in the surface's domain.
    pub fn evaluate(&self, face: usize, uv: [f64; 2]) -> Result<Evaluation, OracleError> {
        self.evaluate_from(face, uv, [Limit::FromAbove; 2])
    }

    /// Like [`evaluate`](Self::evaluate), with the sides from which derivatives are taken at knots and
    /// joints along u and v.
    ///
    /// # Errors
    /// Likewise.
    pub fn evaluate_from(
        &self,
        face: usize,
        uv: [f64; 2],
        limits: [Limit; 2],
    ) -> Result<Evaluation, OracleError> {
        self.check_face(face)?;
        let [below_u, below_v] = limits.map(|l| l == Limit::FromBelow);
        let raw = ffi::evaluate_face(&self.core, face, uv[0], uv[1], below_u, below_v)?;
        let numbers = raw
            .numbers
            .iter()
            .map(enclosure)
            .collect::<Result<Vec<_>, _>>()?;
        let mut vectors = numbers
            .chunks_exact(3)
            .map(|v| <[_; 3]>::try_from(v.to_vec()));
        let mut next = || {
            vectors
                .next()
                .and_then(Result::ok)
                .ok_or(OracleError::Defect("an evaluation has eighteen numbers"))
        };
        Ok(Evaluation {
            point: next()?,
            du: next()?,
            dv: next()?,
            second: [next()?, next()?, next()?],
        })
    }

    /// The side of a point of a face's parameter space, exactly: parity of the loops, each joined
    /// by straight segments where end points differ, cut with the surface's domain. 10 to 500 us.
    ///
    /// # Errors
    /// `uv` must be finite.
    pub fn side(&self, face: usize, uv: [f64; 2]) -> Result<SideTruth, OracleError> {
        self.check_face(face)?;
        let raw = ffi::side_of(&self.core, face, uv[0], uv[1])?;
        let side = match raw.side {
            0 => Side::Inside,
            1 => Side::Outside,
            2 => Side::Boundary,
            _ => return Err(OracleError::Defect("an unknown side")),
        };
        Ok(SideTruth {
            side,
            in_gap: raw.in_gap,
        })
    }
}
