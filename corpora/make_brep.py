"""Makes models/brep: every kind of surface and curve of OCCT's text format, placed, mirrored, across seams, without curves in uv,
in its three versions. Beside each file stands what OCCT says of it: points of its faces by their parameters, sides of points and
distances. Run by hand with cadquery-ocp 8.0.1: `python3 corpora/make_brep.py`. All shapes are our own."""

import json
import math
import pathlib
import random

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepLib import BRepLib
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.BRepTools import BRepTools
from OCP.Geom import (
    Geom_BezierCurve,
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_OffsetSurface,
    Geom_Parabola,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import Geom2d_Ellipse, Geom2d_Line, Geom2d_TrimmedCurve
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax2d, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d, gp_Trsf, gp_Vec
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.TopAbs import TopAbs_FACE, TopAbs_IN, TopAbs_ON, TopAbs_REVERSED, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Shell
from OCP.TopTools import (
    TopTools_FormatVersion_VERSION_1,
    TopTools_FormatVersion_VERSION_2,
    TopTools_FormatVersion_VERSION_3,
)

OUT = pathlib.Path(__file__).parent / "models" / "brep"
VERSIONS = [
    TopTools_FormatVersion_VERSION_1,
    TopTools_FormatVersion_VERSION_2,
    TopTools_FormatVersion_VERSION_3,
]


def compound(shapes):
    result = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(result)
    for s in shapes:
        builder.Add(result, s)
    return result


def explore(shape, kind):
    e = TopExp_Explorer(shape, kind)
    while e.More():
        yield e.Current()
        e.Next()


def reals(values):
    a = Array1_double(1, len(values))
    for i, v in enumerate(values):
        a.SetValue(i + 1, v)
    return a


def integers(values):
    a = Array1_int(1, len(values))
    for i, v in enumerate(values):
        a.SetValue(i + 1, v)
    return a


def points(values):
    a = Array1_gp_Pnt(1, len(values))
    for i, v in enumerate(values):
        a.SetValue(i + 1, gp_Pnt(*v))
    return a


def grid(nu, nv, f):
    a = Array2_gp_Pnt(1, nu, 1, nv)
    for i in range(nu):
        for j in range(nv):
            a.SetValue(i + 1, j + 1, gp_Pnt(*f(i, j)))
    return a


def weights(nu, nv, f):
    a = Array2_double(1, nu, 1, nv)
    for i in range(nu):
        for j in range(nv):
            a.SetValue(i + 1, j + 1, f(i, j))
    return a


def truth(shape, rng):
    """What OCCT says of a shape."""
    faces = []
    for f in explore(shape, TopAbs_FACE):
        face = TopoDS.Face(f)
        surface = BRepAdaptor_Surface(face, False)
        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        rows = []
        for i in range(4):
            for j in range(4):
                u = u0 + (u1 - u0) * (i + 0.5) / 4
                v = v0 + (v1 - v0) * (j + 0.5) / 4
                p = surface.Value(u, v)
                rows.append([u, v, p.X(), p.Y(), p.Z()])
        faces.append({"reversed": face.Orientation() == TopAbs_REVERSED, "points": rows})
    solids = list(explore(shape, TopAbs_SOLID))
    xs = [[r[2 + c] for f in faces for r in f["points"]] for c in range(3)]
    box = [(min(x) - 1, max(x) + 1) for x in xs]
    asked = []
    for _ in range(24):
        q = gp_Pnt(*[rng.uniform(*b) for b in box])
        d = BRepExtrema_DistShapeShape(compound(list(explore(shape, TopAbs_FACE))), BRepBuilderAPI_MakeVertex(q).Vertex()).Value()
        states = [BRepClass3d_SolidClassifier(s, q, 1e-7).State() for s in solids]
        inside = any(s == TopAbs_IN for s in states)
        if d > 1e-3 and not any(s == TopAbs_ON for s in states):
            asked.append([q.X(), q.Y(), q.Z(), d, inside])
    return {"solids": len(solids), "faces": faces, "distances": asked}


def write(name, shape, version=2, mesh=False):
    path = OUT / f"{name}.brep"
    if not BRepTools.Write_s(shape, str(path), mesh, mesh and version == 2, VERSIONS[version]):
        raise SystemExit(f"{path} cannot be written")
    # From the file, so that what is said is said of what is written.
    back = TopoDS_Compound()
    BRepTools.Read_s(back, str(path), BRep_Builder())
    text = json.dumps(truth(back, random.Random(name)))
    path.with_suffix(".json").write_text(text.replace('{"reversed"', '\n{"reversed"') + "\n")


def turned(angle, axis=(0, 0, 1), at=(0, 0, 0)):
    t = gp_Trsf()
    t.SetRotation(gp_Ax1(gp_Pnt(*at), gp_Dir(*axis)), angle)
    return t


def shifted(*v):
    t = gp_Trsf()
    t.SetTranslation(gp_Vec(*v))
    return t


def moved(shape, t):
    """A copy whose geometry is transformed, not placed."""
    return BRepBuilderAPI_Transform(shape, t, True).Shape()


def face_of(surface, ranges):
    return BRepBuilderAPI_MakeFace(surface, *ranges, 1e-7).Face()


AX = gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 2), gp_Dir(1, -1, 0))


def primitives():
    return compound(
        [
            moved(BRepPrimAPI_MakeCone(2, 1, 3).Shape(), turned(0.7, (1, 2, 3))),
            moved(BRepPrimAPI_MakeCone(2, 0, 3).Shape(), shifted(10, 0, 0)),
            moved(BRepPrimAPI_MakeTorus(3, 1).Shape(), shifted(0, 10, 0)),
            moved(BRepPrimAPI_MakeTorus(3, 1, 0.5, 2.5, 2.0).Shape(), shifted(10, 10, 0)),
            moved(BRepPrimAPI_MakeSphere(2, -0.5, 1.0, 3.0).Shape(), shifted(0, 0, 10)),
            moved(BRepPrimAPI_MakeCylinder(AX, 2, 5, 4.0).Shape(), shifted(10, 0, 10)),
        ]
    )


def seams():
    """Holes across the seams of a cylinder, a sphere and a cone."""
    hole = lambda at, r: BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*at), gp_Dir(1, 0, 0)), r, 10).Shape()
    parts = [
        BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(2, 6).Shape(), hole((0, 0.2, 3), 0.7)).Shape(),
        BRepAlgoAPI_Cut(BRepPrimAPI_MakeSphere(3).Shape(), hole((0, -0.3, 0.4), 1.0)).Shape(),
        BRepAlgoAPI_Cut(BRepPrimAPI_MakeCone(3, 1, 6).Shape(), hole((0, 0, 2.5), 0.5)).Shape(),
    ]
    return compound([moved(s, shifted(10 * i, 0, 0)) for i, s in enumerate(parts)])


def placed():
    """One solid five times: products, powers and inverses of locations, the outer ones of compounds."""
    part = BRepAlgoAPI_Cut(
        BRepPrimAPI_MakeBox(3, 2, 1).Shape(),
        BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(1, 1, -1), gp_Dir(0, 0, 1)), 0.5, 3).Shape(),
    ).Shape()
    a = TopLoc_Location(turned(0.5, (1, 2, 2), (5, 0, 0)))
    b = TopLoc_Location(shifted(0, 7, 1))
    inner = compound([part, part.Located(a), part.Located(a * b * b)])
    return compound([inner.Located(b), part.Located(a.Inverted() * b.Inverted()), part.Located(b.Powered(-3) * a)])


def mirrored():
    t = gp_Trsf()
    t.SetMirror(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)))
    return moved(primitives(), t)


def spline_curve(periodic=False):
    if periodic:
        return Geom_BSplineCurve(
            points([(3, 0, 0), (3, 3, 1), (-1, 4, 0), (-3, 0, -1), (0, -4, 0)]),
            reals([0, 1, 2.5, 3, 4, 6]), integers([1] * 6), 3, True)
    return Geom_BSplineCurve(
        points([(1, 0, 0), (2, 0, 1), (2, 0, 2.5), (1.2, 0, 3), (1.5, 0, 4)]), reals([1, 2, 1, 0.5, 1]),
        reals([0, 0.4, 1]), integers([4, 1, 4]), 3, False)


def surfaces():
    """Faces of all other kinds, each over a part of its surface."""
    circle = Geom_Circle(AX, 2.0)
    parabola = Geom_Parabola(AX, 0.75)
    wave = lambda i, j: (i, j, math.sin(1.3 * i + 0.7 * j * j))
    around = lambda i, j: ((3 + j) * math.cos(i * math.tau / 7), (3 + j) * math.sin(i * math.tau / 7), j * j + 0.3 * (i % 2))
    faces = [
        (Geom_SurfaceOfLinearExtrusion(circle, gp_Dir(1, 0, 3)), (0.5, 4, -1, 2)),
        (Geom_SurfaceOfLinearExtrusion(parabola, gp_Dir(0, 0, 1)), (-2, 1.5, 0, 3)),
        (Geom_SurfaceOfLinearExtrusion(spline_curve(), gp_Dir(0, 1, 0.2)), (0, 1, -2, 2)),
        (Geom_SurfaceOfLinearExtrusion(spline_curve(True), gp_Dir(0, 1, 3)), (1.2, 5.5, 0, 2)),
        (Geom_SurfaceOfRevolution(spline_curve(), gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0.1, 1))), (0.3, 5, 0, 1)),
        (Geom_SurfaceOfRevolution(Geom_TrimmedCurve(circle, 0.2, 1.5), gp_Ax1(gp_Pnt(9, 0, 0), gp_Dir(0, 0, 1))), (5, 8, 0.4, 1.3)),
        (Geom_BezierSurface(grid(4, 3, wave)), (0, 1, 0, 1)),
        (Geom_BezierSurface(grid(3, 3, wave), weights(3, 3, lambda i, j: 1 + 0.3 * i * j)), (0.1, 0.8, 0.3, 1)),
        (Geom_BSplineSurface(grid(7, 3, around), reals([0, 1, 2, 3, 4, 5, 6, 7]), reals([0, 1]),
                             integers([1] * 8), integers([3, 3]), 3, 2, True, False), (0, 7, 0, 1)),
        (Geom_BSplineSurface(grid(7, 3, around), weights(7, 3, lambda i, j: 1 + 0.1 * i + j),
                             reals([0, 1, 2, 3, 4, 5, 6, 7]), reals([0, 1]),
                             integers([1] * 8), integers([3, 3]), 2, 2, True, False), (5.25, 9.75, 0.25, 1)),
        (Geom_RectangularTrimmedSurface(Geom_CylindricalSurface(gp_Ax3(AX), 1.5), 4, 8, -1, 1), (4.5, 7.5, -0.5, 1)),
        (Geom_RectangularTrimmedSurface(Geom_Plane(gp_Ax3(AX)), -4, 8, -1, 1), (-2, 1, -1, 1)),
    ]
    return compound([face_of(s, r) for s, r in faces])


def planar():
    """Plates whose edges are conics and splines: their curves in uv are not stored."""
    ellipse = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(Geom_Ellipse(AX, 3, 1.5)).Edge()).Wire()
    arcs = []
    for curve, a, b in [(Geom_Parabola(AX, 0.75), -2, 3), (Geom_Hyperbola(AX, 1, 2), -1.0, 1.2)]:
        edge = BRepBuilderAPI_MakeEdge(curve, a, b).Edge()
        chord = BRepBuilderAPI_MakeEdge(curve.Value(b), curve.Value(a)).Edge()
        arcs.append(BRepBuilderAPI_MakeWire(edge, chord).Wire())
    spline = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(
        Geom_BSplineCurve(points([(0, 0, 5), (4, 0, 5), (4, 4, 5), (0, 5, 5)]), reals([0, 1, 2, 3, 4]), integers([1] * 5), 2, True)
    ).Edge()).Wire()
    bezier = Geom_BezierCurve(points([(0, 0, 9), (1, 4, 9), (3, 4, 9), (4, 0, 9)]), reals([1, 2, 0.7, 1]))
    bent = BRepBuilderAPI_MakeWire(
        BRepBuilderAPI_MakeEdge(bezier).Edge(), BRepBuilderAPI_MakeEdge(gp_Pnt(4, 0, 9), gp_Pnt(0, 0, 9)).Edge()).Wire()
    wires = [ellipse, *arcs, spline, bent]
    return compound([BRepBuilderAPI_MakeFace(w, True).Face() for w in wires])


def between(surface, a, b):
    """The edge on a surface that is straight in uv."""
    a, b = gp_Pnt2d(*a), gp_Pnt2d(*b)
    line = Geom2d_Line(a, gp_Dir2d(b.X() - a.X(), b.Y() - a.Y()))
    return BRepBuilderAPI_MakeEdge(line, surface, 0, a.Distance(b)).Edge()


def winding():
    """Faces that wind around their surface by more than a turn: a screw's thread, as in OCCT's bottle, and bands on a cylinder and a cone."""
    wires = []
    for radius, minor in [(2.0, 0.4), (2.5, 0.2)]:
        cylinder = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), radius)
        ellipse = Geom2d_Ellipse(gp_Ax2d(gp_Pnt2d(math.tau, 2), gp_Dir2d(math.tau, 1)), 5.5, minor)
        a, b = ellipse.Value(math.pi), ellipse.Value(0)
        arc = BRepBuilderAPI_MakeEdge(Geom2d_TrimmedCurve(ellipse, 0, math.pi), cylinder).Edge()
        wire = BRepBuilderAPI_MakeWire(arc, between(cylinder, (a.X(), a.Y()), (b.X(), b.Y()))).Wire()
        BRepLib.BuildCurves3d_s(wire)
        wires.append(wire)
    sections = BRepOffsetAPI_ThruSections(True)
    for wire in wires:
        sections.AddWire(wire)
    sections.CheckCompatibility(False)
    shapes = [sections.Shape()]
    # From -4 to 11.5: 2.47 turns, half a unit of v wide and two apart.
    corners = [(-4, 0), (11.5, 5), (11.5, 5.5), (-4, 0.5)]
    for surface in [
        Geom_CylindricalSurface(gp_Ax3(gp_Pnt(8, 0, 0), gp_Dir(0, 0, 1)), 2.0),
        Geom_ConicalSurface(gp_Ax3(gp_Pnt(0, 8, 0), gp_Dir(0, 0, 1)), 0.25, 1.0),
    ]:
        edges = [between(surface, a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
        wire = BRepBuilderAPI_MakeWire(*edges).Wire()
        BRepLib.BuildCurves3d_s(wire)
        face = BRepBuilderAPI_MakeFace(surface, wire, True).Face()
        shell = TopoDS_Shell()
        BRep_Builder().MakeShell(shell)
        BRep_Builder().Add(shell, face)
        shapes.append(shell)
    return compound(shapes)


def conics():
    """Solids with faces that are extruded or turned ellipses, hyperbolas and parabolas, across their seams and at a slant."""
    frame = gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0))
    plate = lambda *edges: BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(*edges).Wire(), True).Face()
    edge = lambda curve, *ends: BRepBuilderAPI_MakeEdge(curve, *ends).Edge()
    up = gp_Vec(0, 0, 4)

    def extruded(curve, a, b):
        chord = BRepBuilderAPI_MakeEdge(curve.Value(b), curve.Value(a)).Edge()
        return BRepPrimAPI_MakePrism(plate(edge(curve, a, b), chord), up).Shape()

    def turned_about(line, curve, a, b):
        """Closed by straight edges to the axis, an (origin, direction)."""
        o, d = (gp_Vec(*x) for x in line)
        on = lambda p: gp_Pnt(*(o + d * ((gp_Vec(p.XYZ()) - o) * d)).Coord())
        ends = [curve.Value(b), curve.Value(a)]
        feet = [on(p) for p in ends]
        corners = [ends[0], *feet, ends[1]]
        straight = [BRepBuilderAPI_MakeEdge(p, q).Edge() for p, q in zip(corners, corners[1:]) if p.Distance(q) > 1e-9]
        face = plate(edge(curve, a, b), *straight)
        return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(*line[0]), gp_Dir(*line[1]))).Shape()

    ellipse, hyperbola = Geom_Ellipse(frame, 3, 1.5), Geom_Hyperbola(frame, 1, 2)
    parabola = Geom_Parabola(frame, 0.75)
    tilted = turned(0.4, (1, 2, 0), (0, 0, 3))
    half = BRepBuilderAPI_Transform(BRepPrimAPI_MakeBox(gp_Pnt(-9, -9, 3), gp_Pnt(9, 9, 20)).Shape(), tilted, True).Shape()
    whole = BRepPrimAPI_MakePrism(plate(edge(ellipse)), up).Shape()
    shapes = [
        whole,
        BRepAlgoAPI_Cut(whole, half).Shape(),
        BRepAlgoAPI_Cut(whole, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0.3, 2), gp_Dir(1, 0, 0)), 0.6, 9).Shape()).Shape(),
        extruded(hyperbola, -1.0, 1.2),
        BRepAlgoAPI_Cut(extruded(hyperbola, -1.0, 1.2), half).Shape(),
        extruded(parabola, -2, 3),
        turned_about(((0, 0, 0), (1, 0, 0)), ellipse, 0, math.pi),
        turned_about(((0, 0, 0), (1, 0, 0)), hyperbola, 0, 1.2),
        turned_about(((0, 0, 0), (1, 0, 0)), parabola, 0, 3),
        turned_about(((0, -4, 0), (1, 0, 0)), ellipse, 0.5, 2.5),
    ]
    return compound([moved(s, shifted(12 * i, 0, 0)) for i, s in enumerate(shapes)])


def refused():
    """Each face a shell of its own."""
    plane = Geom_Plane(gp_Ax3(AX))
    bumpy = Geom_BezierSurface(grid(3, 3, lambda i, j: (i, j, i * j * (2 - i) * 0.5)))
    ellipse, hyperbola = Geom_Ellipse(AX, 3, 1.5), Geom_Hyperbola(AX, 1, 2)
    up = gp_Dir(1, 0, 3)
    axis = gp_Ax1(gp_Pnt(9, 0, 0), gp_Dir(0, 0, 1))
    faces = [
        face_of(Geom_OffsetSurface(bumpy, 0.3), (0, 1, 0, 1)),
        face_of(Geom_SurfaceOfLinearExtrusion(ellipse, up), (0, 2, 0, 1)),
        face_of(Geom_SurfaceOfLinearExtrusion(hyperbola, up), (0, 2, 0, 1)),
        face_of(Geom_SurfaceOfRevolution(ellipse, axis), (0, 1, 0, 1)),
        face_of(plane, (0, 1, 0, 1)),
    ]
    shells = []
    for f in faces:
        shell = TopoDS_Shell()
        BRep_Builder().MakeShell(shell)
        BRep_Builder().Add(shell, f)
        shells.append(shell)
    return compound(shells)


def main():
    OUT.mkdir(exist_ok=True)
    write("primitives", primitives())
    write("mirrored", mirrored())
    write("seams", seams())
    write("placed", placed())
    write("surfaces", surfaces())
    write("planar", planar())
    write("winding", winding())
    write("conics", conics())
    write("refused", refused())
    meshed = BRepAlgoAPI_Cut(
        BRepPrimAPI_MakeBox(4, 3, 2).Shape(), BRepPrimAPI_MakeSphere(gp_Pnt(4, 3, 2), 1).Shape()).Shape()
    BRepMesh_IncrementalMesh(meshed, 0.2)
    for v in range(3):
        write(f"version{v + 1}", meshed, v, True)
    nurbs = BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeTorus(3, 1).Shape(), True).Shape()
    write("torus_nurbs", nurbs)


main()
