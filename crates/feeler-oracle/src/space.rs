//! Lines, the side of a point in space, and signed separations: safe calls into C++.

use crate::bridge::ffi;
use crate::oracle::{Oracle, enclosure};
use crate::truth::{
    DistanceStatus, DistanceTruth, InsideTruth, LineHitTruth, LineOpen, LineTruth, OracleError,
    TruthEnclosure,
};
use feeler::numeric::Dyadic;
use feeler::query::LineKind;

fn hit(raw: &ffi::RawHit) -> Result<LineHitTruth, OracleError> {
    Ok(LineHitTruth {
        face: raw.face,
        t: enclosure(&raw.t)?,
        t_end: raw.lies_in.then(|| enclosure(&raw.t_end)).transpose()?,
        boundary: raw.boundary,
        multiplicity: (raw.multiplicity > 0).then_some(raw.multiplicity),
        transversal: raw.transversal,
        tangential: raw.tangential,
        uv: [raw.u, raw.v],
    })
}

fn open(raw: &ffi::RawOpen) -> Result<LineOpen, OracleError> {
    Ok(LineOpen {
        face: raw.face,
        t: enclosure(&raw.t)?,
        why: raw.why.clone(),
    })
}

impl Oracle {
    /// All hits of a line with the trimmed faces.
    ///
    /// NURBS faces: two planes through the line give two polynomials on each Bezier patch; their
    /// common roots are isolated by subdivision in 320-bit intervals, each proven to exist and to
    /// be alone by Krawczyk's operator, and its uv box is put to the region. A root on a joint of
    /// patches or on a loop along a line of constant u or v is proven to be so exactly (algebraic
    /// kernel) and counted once. Where the line touches a face, or nearly, the exact polynomials are
    /// followed along the curve that one of them makes in uv, and all hits near there are told with their
    /// multiplicities (`cpp/arc_roots.hpp`). Where the two polynomials have a factor in common the line
    /// lies in the face along the curve where that is 0: lines of constant u or v, and graphs of
    /// rational functions, are cut where they meet a loop, exactly. Planar faces: exact rationals; where
    /// the line lies in the plane, the intervals between its crossings with the loops, arcs included.
    /// Native revolutions and sums: as NURBS, with polynomials whose coefficients are enclosed, for
    /// hits at an angle (`cpp/line_native.hpp`); tangencies of spheres, cylinders, cones and other quadrics
    /// by these, exactly (`cpp/line_quadric.hpp`). A tangency of another native surface, or a line in a
    /// native face, is `open`.
    ///
    /// What counts as one hit: one point of the face, so that a joint of patches, a pole (a side whose
    /// control points are one point) and a seam (first and last line of the surface are equal by their
    /// data) give one hit, which at pole and seam is on the boundary; each other pair of uv gives its
    /// own. The intervals on which the line lies in a face are united where they overlap; what else it
    /// meets of that face at such a t adds no hit. Ends of such intervals that are nearer than 2^-240 of
    /// a patch to each other count as one.
    ///
    /// What cannot be settled is in `open`: two patches' joint to all digits, a point next to a loop to
    /// all digits, a line in a face along a curve of another kind, a contact of an order above five, what is
    /// left after a budget of boxes. Median 0.5 to 5 ms.
    ///
    /// # Errors
    /// Origin and direction must be finite, the direction not zero.
    pub fn line(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        kind: LineKind,
    ) -> Result<LineTruth, OracleError> {
        let kind = match kind {
            LineKind::Line => 0,
            LineKind::Ray => 1,
            LineKind::Segment => 2,
        };
        let raw = ffi::line_truth(self.core(), &origin, &direction, kind)?;
        let hits = raw.hits.iter().map(hit).collect::<Result<Vec<_>, _>>()?;
        let open = raw.open.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        Ok(LineTruth {
            crossings: usize::try_from(raw.crossings).ok(),
            in_crack: match raw.in_crack {
                0 => Some(false),
                1 => Some(true),
                _ => None,
            },
            hits,
            open,
        })
    }

    /// Whether a point is in material: parity of the hits along one ray that is proven to stay off
    /// every crack and every vertex region, and to meet the faces transversally inside their regions;
    /// the theorem is in `cpp/edge_images.hpp`. `Boundary`: proven to be on a face. Within the width of
    /// an edge's crack, or in a vertex region: `Undecided` with the reason `crack`. A BREP that is not
    /// closed has no material; of several BREPs a point is in material if it is in any. 0.1 to 10 ms; the first
    /// query also prepares the model and its edges.
    ///
    /// # Errors
    /// The point must be finite.
    pub fn inside(&self, point: [f64; 3]) -> Result<InsideTruth, OracleError> {
        self.inside_by_rays(point, 1)
    }

    /// For tests: [`Self::inside`] by so many rays, which must agree.
    #[doc(hidden)]
    pub fn inside_by_rays(&self, point: [f64; 3], rays: i32) -> Result<InsideTruth, OracleError> {
        let [x, y, z] = point;
        let raw = ffi::inside_of(self.core(), x, y, z, rays)?;
        Ok(match raw.kind {
            0 => InsideTruth::Inside,
            1 => InsideTruth::Outside,
            2 => InsideTruth::Boundary,
            3 => InsideTruth::Undecided(raw.why),
            _ => return Err(OracleError::Defect("an unknown side")),
        })
    }

    /// The separation of a ball: the distance of its centre, negative in material, less the radius;
    /// of several BREPs the least. `None` if there is no face. Where the side of the
    /// centre is undecided the enclosure holds both signs and the status is `Budget`.
    ///
    /// # Errors
    /// As [`Self::distance`]; the radius must be finite and not negative.
    pub fn sphere(
        &self,
        center: [f64; 3],
        radius: f64,
        nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        if radius < 0.0 {
            return Err(OracleError::Refused("the radius is negative".to_owned()));
        }
        let r = Dyadic::from_f64(radius)
            .ok_or_else(|| OracleError::Refused("the radius is not finite".to_owned()))?;
        let mut least: Option<DistanceTruth> = None;
        for one in self.each_brep()? {
            let Some(found) = one.signed(center, nodes)? else {
                continue;
            };
            least = Some(match least {
                None => found,
                Some(best) => lesser(best, found),
            });
        }
        Ok(least.map(|mut d| {
            d.enclosure = TruthEnclosure {
                lo: &d.enclosure.lo - &r,
                hi: &d.enclosure.hi - &r,
            };
            d
        }))
    }

    /// The signed distance to a single BREP.
    fn signed(
        &self,
        center: [f64; 3],
        nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        let Some(mut d) = self.distance(center, nodes)? else {
            return Ok(None);
        };
        match self.inside(center)? {
            InsideTruth::Outside => {}
            InsideTruth::Inside => {
                d.enclosure = TruthEnclosure {
                    lo: -&d.enclosure.hi,
                    hi: -&d.enclosure.lo,
                };
            }
            // The distance is 0 on the boundary; otherwise either sign is possible.
            InsideTruth::Boundary | InsideTruth::Undecided(_) => {
                d.enclosure.lo = -&d.enclosure.hi;
                d.status = DistanceStatus::Budget;
            }
        }
        Ok(Some(d))
    }
}

/// The minimum of two signed distances.
fn lesser(a: DistanceTruth, b: DistanceTruth) -> DistanceTruth {
    let (first, second) = if a.enclosure.lo <= b.enclosure.lo {
        (a, b)
    } else {
        (b, a)
    };
    let mut result = first;
    if second.enclosure.hi < result.enclosure.hi {
        result.enclosure.hi = second.enclosure.hi;
    }
    for k in 0..result.nodes.len() {
        result.nodes[k] += second.nodes[k];
    }
    result
}
