"""Writes `corpora/models/parts` and `corpora/models/analytic`, with OpenCASCADE.

    pip install cadquery-ocp        (made with 8.0.1.1.0, which is OCCT 8.0)
    python corpora/make_parts.py [FOLDER [NAME ...]]

Run by hand, and rarely: the parts are committed, and another version of OCCT makes others. OCCT models the shape; what is written is its
exact data, as f64, in the project's own model files (see `crates/feeler-corpus/src/model_file.rs`):

- planes, and cylinders, cones, spheres and tori as native revolutions; surfaces of revolution likewise;
  extrusions as sums; the rest as B-splines. What OCCT calls a left-handed frame becomes an axis turned round: the
  angle runs as it did.
- curves in uv: lines, circles as arcs, B-splines; others converted to B-splines by OCCT.
- seams are edges used twice by one face, poles are trims without an edge, as OCCT has them.

Each face's data is what OCCT holds: its edges' images on two faces differ by up to OCCT's tolerance where a curve is
an intersection. Truth is about the faces, so this is a crack of the part and not an error of the file.
"""

import gzip
import json
import math
import sys
from pathlib import Path

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeChamfer, BRepFilletAPI_MakeFillet
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipe, BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import (
    Geom2d_BSplineCurve,
    Geom2d_Circle,
    Geom2d_Line,
    Geom2d_TrimmedCurve,
)
from OCP.Geom2dConvert import Geom2dConvert
from OCP.GeomAPI import GeomAPI_Interpolate, GeomAPI_PointsToBSplineSurface
from OCP.GeomConvert import GeomConvert
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_REVERSED,
    TopAbs_SOLID,
    TopAbs_WIRE,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.collections import (
    Array2_gp_Pnt,
    HArray1_gp_Pnt,
)
from OCP.gp import (
    gp_Ax1,
    gp_Ax2,
    gp_Circ,
    gp_Dir,
    gp_Pln,
    gp_Pnt,
    gp_Trsf,
    gp_Vec,
)


# Writing: OCCT's data as a model file.


def triple(p):
    return [p.X(), p.Y(), p.Z()]


def plus(a, *terms):
    """a + k1 v1 + k2 v2 + ..., each component added in this order."""
    out = list(a)
    for k, v in terms:
        out = [x + k * y for x, y in zip(out, v)]
    return out


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def sequence(array):
    return [array.Value(i) for i in range(array.Lower(), array.Upper() + 1)]


def bspline_curve(c, dim, first, last):
    """A B-spline of OCCT as homogeneous points and full knots, over [first, last] or more."""
    shift = None
    if c.IsPeriodic():
        if dim == 3:
            c = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(c, first, last))
        else:
            c = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(c, first, last))
        if c.IsPeriodic():
            c.SetNotPeriodic()
    if first >= c.LastParameter() or last <= c.FirstParameter():
        # OCCT made it whole periods away from where it is used.
        shift = first - c.FirstParameter()
    points = []
    for i in range(1, c.NbPoles() + 1):
        p, w = c.Pole(i), c.Weight(i)
        xyz = [p.X(), p.Y()] + ([p.Z()] if dim == 3 else [])
        points += [w * x for x in xyz] + [w]
    knots = sequence(c.KnotSequence())
    if shift is not None:
        a, b = c.FirstParameter(), c.LastParameter()
        knots = [first if k <= a else last if k >= b else k + shift for k in knots]
    return {"nurbs": {"degree": c.Degree(), "knots": knots, "points": points}}


def curve2(c, first, last):
    """A curve in uv whose domain is, or holds, [first, last]."""
    while isinstance(c, Geom2d_TrimmedCurve):
        c = c.BasisCurve()
    if isinstance(c, Geom2d_Line):
        a, b = c.Value(first), c.Value(last)
        return {
            "line": {
                "from": [a.X(), a.Y()],
                "to": [b.X(), b.Y()],
                "domain": [first, last],
            }
        }
    if isinstance(c, Geom2d_Circle):
        frame = c.Circ2d().Axis()
        x, y, o = frame.XDirection(), frame.YDirection(), frame.Location()
        return {
            "arc": {
                "center": [o.X(), o.Y()],
                "x": [x.X(), x.Y()],
                "y": [y.X(), y.Y()],
                "z": [0.0, 0.0],
                "radius": c.Circ2d().Radius(),
                "angle": [first, last],
                "domain": [first, last],
            }
        }
    if not isinstance(c, Geom2d_BSplineCurve):
        c = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(c, first, last))
    return bspline_curve(c.Copy(), 2, first, last)


def curve3(c, first, last):
    while isinstance(c, Geom_TrimmedCurve):
        c = c.BasisCurve()
    if isinstance(c, Geom_Line):
        a, b = c.Value(first), c.Value(last)
        return {
            "line": {"from": triple(a), "to": triple(b), "domain": [first, last]}
        }
    if isinstance(c, Geom_Circle):
        frame = c.Circ().Position()
        return {
            "arc": {
                "center": triple(frame.Location()),
                "x": triple(frame.XDirection()),
                "y": triple(frame.YDirection()),
                "z": triple(frame.Direction()),
                "radius": c.Circ().Radius(),
                "angle": [first, last],
                "domain": [first, last],
            }
        }
    if not isinstance(c, Geom_BSplineCurve):
        c = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(c, first, last))
    return bspline_curve(c.Copy(), 3, first, last)


def surface(s, u, v):
    """A surface over the rectangle u x v (B-splines: over their own)."""
    while isinstance(s, Geom_RectangularTrimmedSurface):
        s = s.BasisSurface()
    if isinstance(s, Geom_Plane):
        frame = s.Position()
        return {
            "plane": {
                "origin": triple(frame.Location()),
                "x": triple(frame.XDirection()),
                "y": triple(frame.YDirection()),
                "domain": [u, v],
                "extents": [u, v],
            }
        }
    if isinstance(s, Geom_SurfaceOfRevolution):
        return {
            "revolution": {
                "origin": triple(s.Location()),
                "axis": triple(s.Direction()),
                "angle": u,
                "angle_domain": u,
                "profile": curve3(s.BasisCurve(), *v),
            }
        }
    if isinstance(s, Geom_SurfaceOfLinearExtrusion):
        d = triple(s.Direction())
        return {
            "sum": {
                "base": [0.0, 0.0, 0.0],
                "first": curve3(s.BasisCurve(), *u),
                "second": {
                    "line": {
                        "from": plus([0.0] * 3, (v[0], d)),
                        "to": plus([0.0] * 3, (v[1], d)),
                        "domain": v,
                    }
                },
            }
        }
    if isinstance(s, Geom_BSplineSurface):
        s = s.Copy()
        if s.IsUPeriodic():
            s.SetUNotPeriodic()
        if s.IsVPeriodic():
            s.SetVNotPeriodic()
        points = []
        for i in range(1, s.NbUPoles() + 1):
            for j in range(1, s.NbVPoles() + 1):
                w = s.Weight(i, j)
                points += [w * x for x in triple(s.Pole(i, j))] + [w]
        return {
            "nurbs": {
                "degrees": [s.UDegree(), s.VDegree()],
                "knots": [sequence(s.UKnotSequence()), sequence(s.VKnotSequence())],
                "points": points,
            }
        }
    frame = s.Position()
    o, x, y = (
        triple(p)
        for p in (frame.Location(), frame.XDirection(), frame.YDirection())
    )
    z = triple(frame.Direction())

    def line(r, slope):
        """(R + v sin a) X + v cos a Z."""
        at = lambda t: plus(o, (r + t * slope[0], x), (t * slope[1], z))
        return {"line": {"from": at(v[0]), "to": at(v[1]), "domain": v}}

    def arc(center, r):
        return {
            "arc": {
                "center": center,
                "x": x,
                "y": z,
                "z": cross(x, z),
                "radius": r,
                "angle": v,
                "domain": v,
            }
        }

    if isinstance(s, Geom_CylindricalSurface):
        profile = line(s.Radius(), (0.0, 1.0))
    elif isinstance(s, Geom_ConicalSurface):
        a = s.SemiAngle()
        profile = line(s.RefRadius(), (math.sin(a), math.cos(a)))
    elif isinstance(s, Geom_SphericalSurface):
        profile = arc(o, s.Radius())
    elif isinstance(s, Geom_ToroidalSurface):
        profile = arc(plus(o, (s.MajorRadius(), x)), s.MinorRadius())
    else:
        raise ValueError(f"no surface of ours: {s}")
    return {
        "revolution": {
            "origin": o,
            "axis": cross(x, y),
            "angle": u,
            "angle_domain": u,
            "profile": profile,
        }
    }


def reach(c, first, last):
    """The corners of a box of a uv curve that is written."""
    if "line" in c:
        points = [c["line"]["from"], c["line"]["to"]]
    elif "nurbs" in c:
        p = c["nurbs"]["points"]
        points = [[p[i] / p[i + 2], p[i + 1] / p[i + 2]] for i in range(0, len(p), 3)]
    else:
        (x, y), r = c["arc"]["center"], c["arc"]["radius"]
        points = [[x - r, y - r], [x + r, y + r]]
    return points


class Index(list):
    """Shapes by what they are, whatever their orientation."""

    def number(self, shape):
        for i, s in enumerate(self):
            if s.IsSame(shape):
                return i
        self.append(shape)
        return len(self) - 1


def brep(shape):
    vertices, edges = Index(), Index()
    out = {
        name: []
        for name in "surfaces curves2 curves3 vertices edges trims loops faces".split()
    }

    def vertex(v):
        n = vertices.number(v)
        if n == len(out["vertices"]):
            point = triple(BRep_Tool.Pnt_s(v))
            out["vertices"].append({"point": point, "edges": []})
        return n

    def ends(edge):
        forward = TopoDS.Edge(edge.Oriented(TopAbs_FORWARD))
        return [
            vertex(TopExp.FirstVertex_s(forward)),
            vertex(TopExp.LastVertex_s(forward)),
        ]

    def edge_number(edge):
        n = edges.number(edge)
        if n == len(out["edges"]):
            adaptor = BRepAdaptor_Curve(edge)
            span = [adaptor.FirstParameter(), adaptor.LastParameter()]
            c = BRep_Tool.Curve_s(edge, 0.0, 0.0)
            out["curves3"].append(curve3(c, *span))
            both = ends(edge)
            out["edges"].append(
                {
                    "curve": len(out["curves3"]) - 1,
                    "span": span,
                    "vertices": both,
                    "trims": [],
                }
            )
            for v in sorted(set(both)):
                out["vertices"][v]["edges"].append(n)
        return n

    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        own = TopoDS.Face(faces.Current())
        # Loops as they run round the surface's own normal: the outer one counter-clockwise in uv.
        face = TopoDS.Face(own.Oriented(TopAbs_FORWARD))
        loops, points = [], []
        wires = TopExp_Explorer(face, TopAbs_WIRE)
        outer = BRepTools.OuterWire_s(face)
        while wires.More():
            wire = TopoDS.Wire(wires.Current())
            trims = []
            explorer = BRepTools_WireExplorer(wire, face)
            while explorer.More():
                edge = TopoDS.Edge(explorer.Current())
                adaptor = BRepAdaptor_Curve2d(edge, face)
                span = [adaptor.FirstParameter(), adaptor.LastParameter()]
                pcurve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
                c = curve2(pcurve, *span)
                out["curves2"].append(c)
                points += reach(c, *span)
                back = edge.Orientation() == TopAbs_REVERSED
                from_to = ends(edge)
                trim = {
                    "curve": len(out["curves2"]) - 1,
                    "span": span,
                    "vertices": from_to[::-1] if back else from_to,
                    "iso": "none",
                    "loop": len(out["loops"]),
                }
                number = len(out["trims"])
                if back:
                    trim["reversed"] = True
                if BRep_Tool.Degenerated_s(edge):
                    trim["kind"] = "singular"
                else:
                    trim["edge"] = edge_number(edge)
                    if back:
                        trim["edge_reversed"] = True
                    seam = BRep_Tool.IsClosed_s(edge, face)
                    trim["kind"] = "seam" if seam else "mated"
                    out["edges"][trim["edge"]]["trims"].append(number)
                out["trims"].append(trim)
                trims.append(number)
                explorer.Next()
            out["loops"].append(
                {
                    "kind": "outer" if wire.IsSame(outer) else "inner",
                    "trims": trims,
                    "face": len(out["faces"]),
                }
            )
            loops.append(len(out["loops"]) - 1)
            wires.Next()
        loops.sort(key=lambda l: out["loops"][l]["kind"] != "outer")
        u, v = ([min(p[k] for p in points), max(p[k] for p in points)] for k in (0, 1))
        out["surfaces"].append(surface(BRep_Tool.Surface_s(face), u, v))
        entry = {"surface": len(out["surfaces"]) - 1, "loops": loops}
        if own.Orientation() == TopAbs_REVERSED:
            entry["reversed"] = True
        out["faces"].append(entry)
        faces.Next()
    return out


def solids(shape):
    found = []
    explorer = TopExp_Explorer(shape, TopAbs_SOLID)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def write(folder, name, shape):
    all_solids = solids(shape)
    assert len(all_solids) == 1, f"{name}: {len(all_solids)} solids"
    out = brep(all_solids[0])
    file = {"feeler_model": 1, "unit": "mm", "breps": [out]}
    text = json.dumps(file, separators=(",", ":"), allow_nan=False) + "\n"
    path = folder / f"{name}.json.gz"
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    kinds = {}
    for f in out["faces"]:
        kind = next(iter(out["surfaces"][f["surface"]]))
        kinds[kind] = kinds.get(kind, 0) + 1
    print(f"{name}: {len(out['faces'])} faces {kinds}, {path.stat().st_size} bytes")


# The parts.


def point(*p):
    return gp_Pnt(*map(float, p))


def axes(origin, z, x=None):
    if x is None:
        return gp_Ax2(point(*origin), gp_Dir(*map(float, z)))
    return gp_Ax2(point(*origin), gp_Dir(*map(float, z)), gp_Dir(*map(float, x)))


def box(x, y, z, at=(0, 0, 0)):
    return BRepPrimAPI_MakeBox(point(*at), float(x), float(y), float(z)).Shape()


def cylinder(at, z, r, h):
    return BRepPrimAPI_MakeCylinder(axes(at, z), float(r), float(h)).Shape()


def cone(at, z, r1, r2, h):
    return BRepPrimAPI_MakeCone(axes(at, z), float(r1), float(r2), float(h)).Shape()


def sphere(at, r):
    return BRepPrimAPI_MakeSphere(point(*at), float(r)).Shape()


def torus(at, z, big, small):
    return BRepPrimAPI_MakeTorus(axes(at, z), float(big), float(small)).Shape()


def done(builder):
    builder.Build()
    assert builder.IsDone(), builder
    return builder.Shape()


def cut(a, *tools):
    for b in tools:
        a = done(BRepAlgoAPI_Cut(a, b))
    return a


def fuse(a, *others):
    for b in others:
        a = done(BRepAlgoAPI_Fuse(a, b))
    return a


def edges_of(shape, wanted=lambda a, b: True):
    """Each edge once; by its end points."""
    found = Index()
    explorer = TopExp_Explorer(shape, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        if not BRep_Tool.Degenerated_s(edge):
            a, b = (
                triple(BRep_Tool.Pnt_s(f(edge)))
                for f in (TopExp.FirstVertex_s, TopExp.LastVertex_s)
            )
            if wanted(a, b):
                found.number(edge)
        explorer.Next()
    return [TopoDS.Edge(e) for e in found]


def fillet(shape, r, wanted=lambda a, b: True):
    builder = BRepFilletAPI_MakeFillet(shape)
    for e in edges_of(shape, wanted):
        builder.Add(float(r), e)
    return done(builder)


def chamfer(shape, d, wanted):
    builder = BRepFilletAPI_MakeChamfer(shape)
    for e in edges_of(shape, wanted):
        builder.Add(float(d), e)
    return done(builder)


def spline(points, closed=False):
    array = HArray1_gp_Pnt(1, len(points))
    for i, p in enumerate(points):
        array.SetValue(i + 1, point(*p))
    builder = GeomAPI_Interpolate(array, closed, 1e-9)
    builder.Perform()
    return builder.Curve()


def wire(*curves):
    builder = BRepBuilderAPI_MakeWire()
    for c in curves:
        edge = c if not hasattr(c, "Value") else BRepBuilderAPI_MakeEdge(c).Edge()
        builder.Add(edge)
    return builder.Wire()


def segment(a, b):
    return BRepBuilderAPI_MakeEdge(point(*a), point(*b)).Edge()


def polygon(points):
    builder = BRepBuilderAPI_MakePolygon()
    for p in points:
        builder.Add(point(*p))
    builder.Close()
    return builder.Wire()


def extruded(w, d):
    face = BRepBuilderAPI_MakeFace(w).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(*map(float, d))).Shape()


def turned(w):
    face = BRepBuilderAPI_MakeFace(w).Face()
    axis = gp_Ax1(point(0, 0, 0), gp_Dir(0.0, 0.0, 1.0))
    return BRepPrimAPI_MakeRevol(face, axis).Shape()


def rotated(shape, angle, axis=(0, 0, 1)):
    t = gp_Trsf()
    t.SetRotation(gp_Ax1(point(0, 0, 0), gp_Dir(*map(float, axis))), angle)
    return BRepBuilderAPI_Transform(shape, t, True).Shape()


def as_nurbs(shape):
    return BRepBuilderAPI_NurbsConvert(shape, True).Shape()


def loft(wires, ruled=False):
    builder = BRepOffsetAPI_ThruSections(True, ruled, 1e-9)
    for w in wires:
        builder.AddWire(w)
    return done(builder)


def freeform_tool(height, bulge, nx, ny, size):
    """A block whose top is an interpolated surface, to cut with."""
    grid = Array2_gp_Pnt(1, nx, 1, ny)
    for i in range(nx):
        for j in range(ny):
            x, y = (size * (2 * k / (n - 1) - 1) for k, n in ((i, nx), (j, ny)))
            z = height + bulge * math.sin(0.21 * x + 0.4) * math.cos(0.17 * y)
            grid.SetValue(i + 1, j + 1, point(x, y, z))
    s = GeomAPI_PointsToBSplineSurface()
    s.Interpolate(grid)
    face = BRepBuilderAPI_MakeFace(s.Surface(), 1e-9).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, 60.0)).Shape()


def star(n, inner, outer, z=0.0):
    """A closed spline through 2n points."""
    points = []
    for i in range(2 * n):
        r = outer if i % 2 else inner
        a = math.pi * i / n
        points.append((r * math.cos(a), r * math.sin(a), z))
    return points


def fillet_box():
    return fillet(box(40, 30, 20), 3)


def bored_block():
    """Holes that cross, one with a countersink."""
    block = cut(
        box(40, 40, 30, (-20, -20, -15)),
        cylinder((0, 0, -20), (0, 0, 1), 8, 40),
        cylinder((-25, 0, 0), (1, 0, 0), 6, 50),
        cylinder((12, -25, 9), (0, 1, 0), 2.5, 50),
        cone((0, 0, 12), (0, 0, 1), 8, 12, 4),
    )
    return block


def flange():
    """A disc with a hub, a fillet between them, and bolt holes."""
    body = fuse(
        cylinder((0, 0, 0), (0, 0, 1), 30, 6), cylinder((0, 0, 6), (0, 0, 1), 12, 14)
    )
    foot = lambda a, b: abs(a[2] - 6) < 1e-9 and abs(math.hypot(a[0], a[1]) - 12) < 1e-6
    body = fillet(body, 2.5, foot)
    body = cut(body, cylinder((0, 0, -1), (0, 0, 1), 7, 30))
    for k in range(6):
        a = math.pi * k / 3 + 0.1
        at = (22 * math.cos(a), 22 * math.sin(a), -1)
        body = cut(body, cylinder(at, (0, 0, 1), 2.2, 10))
    return body


def bracket():
    """An L with rounded corners and holes."""
    body = extruded(
        polygon([(0, 0, 0), (40, 0, 0), (40, 8, 0), (8, 8, 0), (8, 30, 0), (0, 30, 0)]),
        (0, 0, 24),
    )
    inner = lambda a, b: a[:2] == b[:2] == [8, 8]
    corners = lambda a, b: a[:2] == b[:2] and a[0] in (0, 40) and a[1] in (8, 30)
    body = fillet(body, 5, inner)
    body = fillet(body, 2, corners)
    return cut(
        body,
        cylinder((30, -1, 12), (0, 1, 0), 4, 12),
        cylinder((-1, 22, 12), (1, 0, 0), 3, 12),
    )


def thin_tube():
    """A wall of 1e-3 between two cylinders, and a lid as thin."""
    return cut(
        cylinder((0, 0, 0), (0, 0, 1), 10, 20),
        cylinder((0, 0, 1e-3), (0, 0, 1), 10 - 1e-3, 30),
    )


def thin_sphere():
    """A hollow ball with a wall of 1e-4, open at the top."""
    shell = cut(sphere((0, 0, 0), 10), sphere((0, 0, 0), 10 - 1e-4))
    return cut(shell, box(30, 30, 20, (-15, -15, 6)))


def spline_plate():
    """A spline profile under a freeform top: splines trimmed by splines."""
    body = extruded(wire(spline(star(5, 14, 20), True)), (0, 0, 20))
    return cut(body, freeform_tool(12, 2.5, 9, 8, 30))


def spline_bored():
    """The same with bores, one of them slanting."""
    return cut(
        spline_plate(),
        cylinder((4, 3, -5), (0.2, 0.1, 1), 3, 40),
        rotated(extruded(wire(spline(star(3, 2, 3.5, -5), True)), (0, 0, 40)), 0.3, (1, 0, 0)),
    )


def vase():
    """A spline turned: walls of 1.5 mm that are revolutions of splines."""
    outer = [(8, 0), (14, 8), (11, 20), (6, 28), (9, 36)]
    inner = [(7.5, 36), (4.5, 28), (9.5, 20), (12.5, 8), (6, 2)]
    on = lambda p: (p[0], 0, p[1])
    return turned(
        wire(
            segment((0, 0, 0), on(outer[0])),
            spline([on(p) for p in outer]),
            segment(on(outer[-1]), on(inner[0])),
            spline([on(p) for p in inner]),
            segment(on(inner[-1]), (0, 0, 2)),
            segment((0, 0, 2), (0, 0, 0)),
        )
    )


def square_to_round():
    """A loft from a square over stars to a circle-like spline."""
    ring = lambda n, r, z: wire(
        spline(
            [
                (r(k) * math.cos(2 * math.pi * k / n), r(k) * math.sin(2 * math.pi * k / n), z)
                for k in range(n)
            ],
            True,
        )
    )
    return loft(
        [
            ring(12, lambda k: 12 + 2 * (k % 3 == 0), 0),
            ring(12, lambda k: 9 + (k % 2), 10),
            ring(12, lambda k: 11 - (k % 2), 20),
            ring(12, lambda k: 6, 28),
        ]
    )


def twisted_prism():
    """Ruled sides between a square and the same square turned."""
    square = lambda r, z, a: polygon(
        [
            (r * math.cos(a + math.pi * k / 2), r * math.sin(a + math.pi * k / 2), z)
            for k in range(4)
        ]
    )
    return loft([square(12, 0, 0), square(9, 25, 0.6)], True)


def pipe():
    """A circle swept along a spline."""
    spine = spline([(0, 0, 0), (10, 4, 6), (20, -5, 14), (34, 0, 12)])
    start = gp_Ax2(point(0, 0, 0), gp_Dir(spine.DN(spine.FirstParameter(), 1)))
    edge = BRepBuilderAPI_MakeEdge(gp_Circ(start, 3.0)).Edge()
    face = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(edge).Wire()).Face()
    return BRepOffsetAPI_MakePipe(wire(spine), face).Shape()


def bored_sphere():
    """A ball with three bores across each other."""
    return cut(
        sphere((0, 0, 0), 12),
        cylinder((0, 1, -20), (0, 0, 1), 4, 40),
        cylinder((-20, 0, 2), (1, 0, 0), 3, 40),
        cylinder((2, -20, -3), (0, 1, 0), 2, 40),
    )


def chain_link():
    """Two rings with a bar: tori cut by a cylinder."""
    return fuse(
        torus((0, 0, 0), (0, 0, 1), 10, 3),
        cylinder((-8.5, 0, 0), (1, 0, 0), 2, 17),
    )


def nozzle():
    """Cones and cylinders in a row with chamfers and a bore that narrows."""
    body = fuse(
        cylinder((0, 0, 0), (0, 0, 1), 12, 10),
        cone((0, 0, 10), (0, 0, 1), 12, 5, 12),
        cylinder((0, 0, 22), (0, 0, 1), 5, 6),
    )
    rim = lambda a, b: abs(a[2]) < 1e-9
    body = chamfer(body, 1.5, rim)
    return cut(
        body,
        cone((0, 0, -0.5), (0, 0, 1), 8, 2, 20),
        cylinder((0, 0, 18), (0, 0, 1), 2.25, 12),
        cylinder((-15, 0, 5), (1, 0, 0), 1.5, 30),
    )


def ratchet():
    """24 teeth: 50 flat and round faces."""
    points = []
    n = 24
    for k in range(n):
        a = 2 * math.pi * k / n
        points.append((20 * math.cos(a), 20 * math.sin(a), 0))
        points.append((17 * math.cos(a + 0.05), 17 * math.sin(a + 0.05), 0))
    body = extruded(polygon(points), (0, 0, 8))
    return cut(
        body,
        cylinder((0, 0, -1), (0, 0, 1), 6, 10),
        box(3, 3, 10, (5, -1.5, -1)),
    )


def tangent_rounds():
    """Two radii of fillet that run into each other."""
    body = box(30, 20, 12)
    upright = lambda a, b: a[:2] == b[:2]
    body = fillet(body, 5, upright)
    top = lambda a, b: abs(a[2] - 12) < 1e-9 and abs(b[2] - 12) < 1e-9
    return fillet(body, 2, top)


PARTS = {
    f.__name__: f
    for f in (
        fillet_box,
        bored_block,
        flange,
        bracket,
        thin_tube,
        thin_sphere,
        spline_plate,
        spline_bored,
        vase,
        square_to_round,
        twisted_prism,
        pipe,
        bored_sphere,
        chain_link,
        nozzle,
        ratchet,
        tangent_rounds,
    )
}
# Also with every face as NURBS, as OCCT converts them.
AS_NURBS = ["fillet_box", "bored_block", "flange", "bored_sphere", "chain_link", "tangent_rounds", "vase", "nozzle"]


# Solids with closed forms, each also as NURBS; `crates/xtask/src/scenes/analytic.rs` knows these numbers.
ANALYTIC = {
    "sphere": lambda: sphere((0.5, -0.25, 1), 2),
    "cylinder": lambda: cylinder((0.25, 0.5, -1), (0, 0, 1), 1.5, 5),
    "cylinder_slanted": lambda: cylinder((1, 0, 0.5), (1, 2, 2), 1.25, 6),
    "cone": lambda: cone((0, 0, 0), (0, 0, 1), 3, 0, 4),
    "frustum": lambda: cone((-1, 0.5, 0.25), (0, 0, 1), 3, 1, 2.5),
    "torus": lambda: torus((0.125, 0.25, -0.5), (0, 0, 1), 4, 1),
    "block": lambda: box(3, 4, 5, (-1, -2, 0.5)),
}


def main():
    models = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "models")
    for subject, shapes, nurbs in (
        ("parts", PARTS, AS_NURBS),
        ("analytic", ANALYTIC, ANALYTIC),
    ):
        folder = models / subject
        folder.mkdir(parents=True, exist_ok=True)
        for name, make in shapes.items():
            if len(sys.argv) > 2 and name not in sys.argv[2:]:
                continue
            shape = make()
            write(folder, name, shape)
            if name in nurbs:
                write(folder, f"{name}_nurbs", as_nurbs(shape))


if __name__ == "__main__":
    main()
