#!/usr/bin/env python3
"""OCCT as an engine for `feeler gate`, through its Python binding (`pip install cadquery-ocp`).

    cargo run --release -- gate --engine 'python3 crates/feeler-gate/engines/occt.py' --suite side

Reads our own model files and speaks the query protocol on standard input and output. OCCT gets the file's surfaces and
trim curves as they are: planes, revolutions and B-splines, each trim an edge of its own with the file's
curve as its pcurve. Edges get their 3D curves from the pcurves (BRepLib::BuildCurve3d), which is exact for lines and
circles in planes and for parameter lines, and approximate to TOLERANCE elsewhere; OCCT measures to these.

sphere      BRepExtrema_DistShapeShape from a vertex; the sign by BRepClass3d_SolidClassifier
half_space  BRepExtrema_DistShapeShape from a large planar face beyond the part
line        IntCurvesFace_ShapeIntersector
side        BRepClass_FaceClassifier
inside      BRepClass3d_SolidClassifier
evaluate    Geom_Surface::D1
"""

import json
import math
import sys

from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeVertex
from OCP.BRepClass import BRepClass_FaceClassifier
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepLib import BRepLib
from OCP.collections import (
    Array1_double,
    Array1_gp_Pnt,
    Array1_gp_Pnt2d,
    Array1_int,
    Array2_double,
    Array2_gp_Pnt,
)
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_Line,
    Geom_Plane,
    Geom_SurfaceOfRevolution,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Circle, Geom2d_Line
from OCP.GeomAbs import GeomAbs_Shape
from OCP.gp import (
    gp_Ax1,
    gp_Ax2,
    gp_Ax22d,
    gp_Ax3,
    gp_Circ,
    gp_Circ2d,
    gp_Dir,
    gp_Dir2d,
    gp_Lin,
    gp_Pln,
    gp_Pnt,
    gp_Pnt2d,
    gp_Vec,
)
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector
from OCP.Standard import Standard_Failure
from OCP.TopAbs import TopAbs_Orientation, TopAbs_State
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

# Precision::Confusion(): what OCCT itself takes for one place, and its default everywhere.
TOLERANCE = 1e-7
# A direction in a file is taken for a unit vector within a few roundings.
ROUNDINGS = 1e-14
# "On" means within a tolerance (1e-10 of the parameters inside BRepClass, TOLERANCE in space): no claim to be exactly
# on the boundary, and so no side.
SIDES = {
    TopAbs_State.TopAbs_IN: {"side": "inside"},
    TopAbs_State.TopAbs_OUT: {"side": "outside"},
    TopAbs_State.TopAbs_ON: {"undecided": "on, within its tolerance"},
}


def dot(a, b):
    return math.fsum(x * y for x, y in zip(a, b))


def add(p, v, t=1.0):
    return [a + t * b for a, b in zip(p, v)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def one(item):
    """Kind and fields of {"kind": {fields}}."""
    ((kind, fields),) = item.items()
    return kind, fields


def lerp(t, a, b):
    """Where t is in b as it is in a."""
    return t if a == b else b[0] + (t - a[0]) * ((b[1] - b[0]) / (a[1] - a[0]))


def array(make, values, wrap=lambda x: x):
    made = make(1, len(values))
    for i, value in enumerate(values):
        made.SetValue(i + 1, wrap(value))
    return made


def knots_and_multiplicities(knots):
    distinct, counts = [], []
    for k in knots:
        if distinct and distinct[-1] == k:
            counts[-1] += 1
        else:
            distinct.append(k)
            counts.append(1)
    return array(Array1_double, distinct), array(Array1_int, counts)


def bspline(dimension, degree, knots, points, weights):
    knots, counts = knots_and_multiplicities(knots)
    weights = array(Array1_double, weights)
    if dimension == 2:
        poles = array(Array1_gp_Pnt2d, points, lambda p: gp_Pnt2d(*p))
        return Geom2d_BSplineCurve(poles, weights, knots, counts, degree)
    poles = array(Array1_gp_Pnt, points, lambda p: gp_Pnt(*p))
    return Geom_BSplineCurve(poles, weights, knots, counts, degree)


def curve(item, dimension):
    """A curve of OCCT, and the map from the file's parameter to its own."""
    kind, c = one(item)
    if kind == "line":
        way = add(c["to"], c["from"], -1.0)
        length = math.hypot(*way)
        place = lambda t: lerp(t, c["domain"], [0.0, length])
        if dimension == 2:
            return Geom2d_Line(gp_Pnt2d(*c["from"]), gp_Dir2d(*way)), place
        return Geom_Line(gp_Pnt(*c["from"]), gp_Dir(*way)), place
    if kind == "arc":
        place = lambda t: lerp(t, c["domain"], c["angle"])
        if dimension == 2:
            axes = gp_Ax22d(gp_Pnt2d(*c["center"]), gp_Dir2d(*c["x"]), gp_Dir2d(*c["y"]))
            return Geom2d_Circle(gp_Circ2d(axes, c["radius"])), place
        normal = gp_Dir(*cross(c["x"], c["y"]))
        axes = gp_Ax2(gp_Pnt(*c["center"]), normal, gp_Dir(*c["x"]))
        return Geom_Circle(gp_Circ(axes, c["radius"])), place
    if kind == "polyline":
        points = chunks(c["points"], dimension)
        knots = [c["params"][0], *c["params"], c["params"][-1]]
        return bspline(dimension, 1, knots, points, [1.0] * len(points)), lambda t: t
    if kind == "nurbs":
        points = chunks(c["points"], dimension + 1)
        places = [[x / p[-1] for x in p[:-1]] for p in points]
        weights = [p[-1] for p in points]
        return bspline(dimension, c["degree"], c["knots"], places, weights), lambda t: t
    raise ValueError(f"a curve of kind {kind} is not treated")


def chunks(flat, n):
    return [flat[i : i + n] for i in range(0, len(flat), n)]


def tensor(degrees, knots, points, weights):
    """points[i][j], i along u."""
    rows, columns = len(points), len(points[0])
    poles, heavy = Array2_gp_Pnt(1, rows, 1, columns), Array2_double(1, rows, 1, columns)
    for i in range(rows):
        for j in range(columns):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*points[i][j]))
            heavy.SetValue(i + 1, j + 1, weights[i][j])
    (ku, mu), (kv, mv) = map(knots_and_multiplicities, knots)
    return Geom_BSplineSurface(poles, heavy, ku, kv, mu, mv, *degrees)


def as_spline(item):
    """Degree, knots, places, weights of a line or NURBS in space."""
    kind, c = one(item)
    if kind == "line":
        a, b = c["domain"]
        return 1, [a, a, b, b], [c["from"], c["to"]], [1.0, 1.0]
    if kind == "nurbs":
        points = chunks(c["points"], 4)
        places = [[x / p[3] for x in p[:3]] for p in points]
        return c["degree"], c["knots"], places, [p[3] for p in points]
    raise ValueError(f"a sum with a curve of kind {kind} is not treated")


def surface(item):
    """A surface of OCCT with the file's parameters, and its domain."""
    kind, s = one(item)
    if kind == "plane":
        x, y = s["x"], s["y"]
        units = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(x, y)]
        if s["domain"] == s["extents"] and all(abs(e) < ROUNDINGS for e in units):
            axes = gp_Ax3(gp_Pnt(*s["origin"]), gp_Dir(*cross(x, y)), gp_Dir(*x))
            return Geom_Plane(axes), s["domain"]
        points = [[add(add(s["origin"], x, a), y, b) for b in s["extents"][1]] for a in s["extents"][0]]
        knots = [[a, a, b, b] for a, b in s["domain"]]
        return tensor((1, 1), knots, points, [[1.0, 1.0]] * 2), s["domain"]
    if kind == "revolution":
        if s["angle"] != s["angle_domain"] or s.get("transposed"):
            raise ValueError("a revolution with parameters of its own is not treated")
        profile, place = curve(s["profile"], 3)
        _, fields = one(s["profile"])
        ends = fields.get("domain") or [fields["knots"][0], fields["knots"][-1]]
        if [place(t) for t in ends] != ends:
            # The file's parameters must stay: sides and evaluations name them.
            kind, c = one(s["profile"])
            if kind != "line":
                raise ValueError(f"a profile of kind {kind} with a domain of its own is not treated")
            profile = bspline(3, 1, [ends[0]] * 2 + [ends[1]] * 2, [c["from"], c["to"]], [1.0, 1.0])
        elif fields.get("domain"):
            profile = Geom_TrimmedCurve(profile, *ends)
        axis = gp_Ax1(gp_Pnt(*s["origin"]), gp_Dir(*s["axis"]))
        return Geom_SurfaceOfRevolution(profile, axis), [s["angle"], ends]
    if kind == "sum":
        du, ku, pu, wu = as_spline(s["first"])
        dv, kv, pv, wv = as_spline(s["second"])
        points = [[add(add(p, q), s["base"]) for q in pv] for p in pu]
        weights = [[a * b for b in wv] for a in wu]
        return tensor((du, dv), (ku, kv), points, weights), [[ku[du], ku[-du - 1]], [kv[dv], kv[-dv - 1]]]
    (pu, pv), (ku, kv) = s["degrees"], s["knots"]
    net = chunks(chunks(s["points"], 4), len(kv) - pv - 1)
    points = [[[x / p[3] for x in p[:3]] for p in row] for row in net]
    weights = [[p[3] for p in row] for row in net]
    return tensor((pu, pv), (ku, kv), points, weights), [[ku[pu], ku[-pu - 1]], [kv[pv], kv[-pv - 1]]]


class Part:
    """One BREP."""

    def __init__(self, brep):
        self.build = BRep_Builder()
        self.faces = [self.face(brep, f) for f in brep["faces"]]
        shell = TopoDS_Shell()
        self.build.MakeShell(shell)
        for _, face in self.faces:
            if face is not None:
                self.build.Add(shell, face)
        # Distances are to the shell: to a solid they are 0 for all that is in it.
        self.shape = self.shell = shell
        uses = [len(e["trims"]) for e in brep["edges"]]
        free = any(t.get("edge") is None and t["kind"] != "singular" for t in brep["trims"])
        whole = all(f.get("loops") is not None for f in brep["faces"])
        self.classifier = None
        # As the kernel has it: a solid is closed when every non-singular edge is used twice.
        if whole and not free and all(n == 2 for n in uses):
            solid = TopoDS_Solid()
            self.build.MakeSolid(solid)
            self.build.Add(solid, shell)
            BRepLib.OrientClosedSolid_s(solid)
            self.shape = solid
            self.classifier = BRepClass3d_SolidClassifier(solid)
        self.lines = IntCurvesFace_ShapeIntersector()
        self.lines.Load(self.shape, TOLERANCE)
        box = Bnd_Box()
        BRepBndLib.Add_s(self.shape, box)
        low, high = box.CornerMin(), box.CornerMax()
        self.box = [[low.X(), low.Y(), low.Z()], [high.X(), high.Y(), high.Z()]]

    def face(self, brep, f):
        geometry, domain = surface(brep["surfaces"][f["surface"]])
        (u0, u1), (v0, v1) = domain
        loops = f.get("loops")
        if loops == []:
            return geometry, None
        if loops is None:
            face = BRepBuilderAPI_MakeFace(geometry, u0, u1, v0, v1, TOLERANCE).Face()
        else:
            face = TopoDS_Face()
            self.build.MakeFace(face, geometry, TOLERANCE)
            for number in loops:
                wire = TopoDS_Wire()
                self.build.MakeWire(wire)
                for trim in brep["loops"][number]["trims"]:
                    self.build.Add(wire, self.edge(brep, brep["trims"][trim], geometry))
                wire.Closed(True)
                self.build.Add(face, wire)
        if f.get("reversed"):
            face.Reverse()
        return geometry, face

    def edge(self, brep, trim, geometry):
        pcurve, place = curve(brep["curves2"][trim["curve"]], 2)
        first, last = map(place, trim["span"])
        edge = TopoDS_Edge()
        self.build.MakeEdge(edge)
        self.build.UpdateEdge(edge, pcurve, geometry, TopLoc_Location(), TOLERANCE)
        self.build.Range(edge, first, last)
        reverse = trim.get("reversed", False)
        names = trim["vertices"][::-1] if reverse else trim["vertices"]
        orientations = [TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED]
        for name, t, orientation in zip(names, (first, last), orientations):
            point = gp_Pnt(*brep["vertices"][name]["point"])
            at = pcurve.Value(t)
            off = geometry.Value(at.X(), at.Y()).Distance(point)
            vertex = TopoDS_Vertex()
            self.build.MakeVertex(vertex, point, max(TOLERANCE, off))
            self.build.Add(edge, vertex.Oriented(orientation))
        if trim["kind"] == "singular":
            self.build.Degenerated(edge, True)
        elif not BRepLib.BuildCurve3d_s(edge, TOLERANCE, GeomAbs_Shape.GeomAbs_C1, 14, 100):
            raise ValueError("an edge without a curve in space: BRepLib::BuildCurve3d failed")
        if reverse:
            edge.Reverse()
        return edge

    def state(self, point):
        if self.classifier is None:
            return TopAbs_State.TopAbs_OUT
        self.classifier.Perform(gp_Pnt(*point), TOLERANCE)
        return self.classifier.State()


class Engine:
    def __init__(self, text):
        self.parts = [Part(b) for b in text["breps"]]
        self.faces = [face for part in self.parts for face in part.faces]

    def nearest(self, other):
        """The least distance of all parts from a shape: (distance, place on the part, part)."""
        found = None
        for part in self.parts:
            extrema = BRepExtrema_DistShapeShape(other, part.shell)
            if not extrema.IsDone() or extrema.NbSolution() == 0:
                raise ValueError("BRepExtrema_DistShapeShape found nothing")
            if found is None or extrema.Value() < found[0]:
                p = extrema.PointOnShape2(1)
                found = extrema.Value(), [p.X(), p.Y(), p.Z()], part
        return found

    def inside(self, point):
        states = [part.state(point) for part in self.parts]
        for state in (TopAbs_State.TopAbs_IN, TopAbs_State.TopAbs_ON):
            if state in states:
                return state
        return TopAbs_State.TopAbs_OUT

    @staticmethod
    def contact(query, separation, on_brep, on_probe, normal):
        value = {"value": separation}
        contacts = []
        if separation <= query.get("prediction", 0.0) and query.get("contacts") != "none":
            place = {"on_brep": on_brep, "on_probe": on_probe, "normal": normal}
            contacts = [{**place, "separation": value}]
        return {"separation": value, "contacts": contacts}

    def sphere(self, query, center, radius):
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*center)).Vertex()
        distance, foot, _ = self.nearest(vertex)
        sign = -1.0 if self.inside(center) == TopAbs_State.TopAbs_IN else 1.0
        if query.get("overlap"):
            return {"overlap": sign * distance < radius}
        way = add(center, foot, -1.0)
        length = math.hypot(*way)
        normal = [sign * x / length for x in way] if length > 0.0 else [0.0, 0.0, 1.0]
        on_probe = add(center, normal, -radius)
        return self.contact(query, sign * distance - radius, foot, on_probe, normal)

    def half_space(self, query, normal, offset):
        boxes = [p.box for p in self.parts]
        corners = [[b[k >> c & 1][c] for c in range(3)] for b in boxes for k in range(8)]
        size = max(max(abs(x) for x in corner) for corner in corners) + 1.0
        # Below all of the part, and wide enough that the foot's counterpart is on it.
        below = min(dot(normal, c) for c in corners) - size
        along = gp_Pnt(*[below * x for x in normal])
        wide = 8.0 * size
        plane = gp_Pln(along, gp_Dir(*normal))
        face = BRepBuilderAPI_MakeFace(plane, -wide, wide, -wide, wide).Face()
        distance, foot, _ = self.nearest(face)
        separation = below + distance - offset
        if query.get("overlap"):
            return {"overlap": separation < 0.0}
        # The way from the part to the half-space.
        away = [-x for x in normal]
        return self.contact(query, separation, foot, add(foot, away, separation), away)

    def line(self, query, origin, direction, kind="line"):
        length = math.hypot(*direction)
        ends = {"line": (-1e100, 1e100), "ray": (0.0, 1e100), "segment": (0.0, length)}[kind]
        line = gp_Lin(gp_Pnt(*origin), gp_Dir(*direction))
        hits = []
        for part in self.parts:
            part.lines.Perform(line, *ends)
            if not part.lines.IsDone():
                raise ValueError("IntCurvesFace_ShapeIntersector is not done")
            for i in range(1, part.lines.NbPnt() + 1):
                p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
                u, v = part.lines.UParameter(i), part.lines.VParameter(i)
                BRep_Tool.Surface_s(part.lines.Face(i)).D1(u, v, p, du, dv)
                n = du.Crossed(dv)
                scale = n.Magnitude() or 1.0
                hits.append({
                    "t": {"value": part.lines.WParameter(i) / length},
                    "point": [p.X(), p.Y(), p.Z()],
                    "normal": [n.X() / scale, n.Y() / scale, n.Z() / scale],
                    "uv": [u, v],
                })
        # It finds one place many times, at poles and on edges: within its tolerance they are one, as its users take them.
        hits.sort(key=lambda h: h["t"]["value"])
        distinct = hits[:1]
        for hit in hits[1:]:
            if (hit["t"]["value"] - distinct[-1]["t"]["value"]) * length > TOLERANCE:
                distinct.append(hit)
        hits = distinct
        if query.get("hits", "all") != "all":
            hits = hits[:1]
        return {"hits": hits}

    def side(self, query, face, uv):
        shape = self.faces[face][1]
        if shape is None:
            return {"side": "outside"}
        # The least tolerance there is: BRepClass has one of its own below which it says "on".
        found = BRepClass_FaceClassifier(shape, gp_Pnt2d(*uv), 0.0)
        return SIDES[found.State()]

    def evaluate(self, query, face, uv):
        p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        self.faces[face][0].D1(*uv, p, du, dv)
        return {name: [x.X(), x.Y(), x.Z()] for name, x in (("point", p), ("du", du), ("dv", dv))}

    def answer(self, query):
        for kind in TREATS:
            if kind == "inside" and kind in query:
                return SIDES[self.inside(query["inside"]["point"])]
            if kind in query:
                return getattr(self, kind)(query, **query[kind])
        raise ValueError(f"none of {', '.join(TREATS)}")


TREATS = ["sphere", "half_space", "line", "side", "inside", "evaluate"]


def main():
    def say(answer):
        print(json.dumps(answer), flush=True)

    try:
        with open(json.loads(sys.stdin.readline())["model"], encoding="utf-8") as file:
            engine = Engine(json.load(file))
    except (Exception, Standard_Failure) as error:
        say({"error": f"{type(error).__name__}: {error}"})
        return
    import OCP

    version = getattr(OCP, "__version__", "")
    say({"engine": "occt", "version": version, "faces": len(engine.faces), "treats": TREATS})
    for line in sys.stdin:
        answer = {}
        try:
            query = json.loads(line)
            answer = {"id": query.get("id")}
            answer |= engine.answer(query)
        except (Exception, Standard_Failure) as error:
            answer["error"] = f"{type(error).__name__}: {error}"
        say(answer)


if __name__ == "__main__":
    main()
