"""Makes models/step: solids of all kinds of surfaces, with curves in uv and without, an assembly, other units, a B-spline with its
seams left out, and beside each file what OCCT says of the shape it was written from: distances and sides of points. Run by hand with
cadquery-ocp 7.9: `python3 corpora/make_step.py`. All shapes are our own."""

import json
import math
import pathlib
import random
import re

from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeVertex,
                                BRepBuilderAPI_MakeWire, BRepBuilderAPI_NurbsConvert, BRepBuilderAPI_Transform)
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism,
                             BRepPrimAPI_MakeRevol, BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus)
from OCP.Geom import Geom_BSplineCurve
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Elips, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TColgp import TColgp_HArray1OfPnt
from OCP.TopAbs import TopAbs_EDGE, TopAbs_IN
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Builder, TopoDS_Compound

FOLDER = pathlib.Path(__file__).parent / "models" / "step"
POINTS = 60


def interpolated(points, periodic=False):
    array = TColgp_HArray1OfPnt(1, len(points))
    for i, p in enumerate(points):
        array.SetValue(i + 1, gp_Pnt(*p))
    made = GeomAPI_Interpolate(array, periodic, 1e-9)
    made.Perform()
    curve = made.Curve()
    if periodic:
        curve.SetNotPeriodic()
    return curve


def wire(*curves):
    made = BRepBuilderAPI_MakeWire()
    for c in curves:
        made.Add(BRepBuilderAPI_MakeEdge(c).Edge())
    return made.Wire()


def line(a, b):
    return BRepBuilderAPI_MakeEdge(gp_Pnt(*a), gp_Pnt(*b)).Edge()


def slanted(point=(0.3, -0.2, 0.1), direction=(0.2, -0.3, 0.9)):
    return gp_Ax2(gp_Pnt(*point), gp_Dir(*direction))


def lofted():
    """Extruded: an interpolated curve closed by two lines."""
    top = interpolated([(0, 0, 0), (3, 1, 0), (5, -1, 0), (8, 0, 0)])
    made = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(top).Edge(), line((8, 0, 0), (8, -4, 0)), line((8, -4, 0), (0, -4, 0)),
                                   line((0, -4, 0), (0, 0, 0)))
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(made.Wire()).Face(), gp_Vec(0.5, 0.25, 3)).Shape()


def turned(angle):
    side = interpolated([(3, 0, 0), (4, 0, 2), (2.5, 0, 4), (3, 0, 6)])
    made = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(side).Edge(), line((3, 0, 6), (1, 0, 6)), line((1, 0, 6), (1, 0, 0)),
                                   line((1, 0, 0), (3, 0, 0)))
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(made.Wire()).Face(), gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), angle).Shape()


def elliptic():
    ellipse = BRepBuilderAPI_MakeEdge(gp_Elips(gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(0, 0, 1)), 3, 2)).Edge()
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(ellipse).Wire()).Face(), gp_Vec(0, 0, 4)).Shape()


def tube():
    closed = interpolated([(3, 0, 0), (0, 2, 0), (-3, 0, 0), (0, -2.5, 0)], periodic=True)
    face = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(closed).Edge()).Wire()).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, 4)).Shape()


def filleted():
    box = BRepPrimAPI_MakeBox(10, 7, 5).Shape()
    fillet = BRepFilletAPI_MakeFillet(box)
    edges = TopExp_Explorer(box, TopAbs_EDGE)
    while edges.More():
        fillet.Add(1.0, TopoDS.Edge_s(edges.Current()))
        edges.Next()
    return fillet.Shape()


def bored():
    """A block with a slanted bore, which leaves ellipses, and a crossing one, which leaves a curve of the fourth order."""
    box = BRepPrimAPI_MakeBox(gp_Pnt(-5, -5, -5), gp_Pnt(5, 5, 5)).Shape()
    one = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-2, 0, -10), gp_Dir(0.2, 0, 1)), 2, 22).Shape()
    two = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-10, 0.5, 0), gp_Dir(1, 0, 0)), 1.5, 20).Shape()
    return BRepAlgoAPI_Cut(BRepAlgoAPI_Cut(box, one).Shape(), two).Shape()


def ball_and_cone():
    ball = BRepPrimAPI_MakeSphere(slanted(), 3).Shape()
    cone = BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(1, 0.3, 0.1)), 2.2, 0.0, 7).Shape()
    return BRepAlgoAPI_Fuse(ball, cone).Shape()


def drilled_torus():
    torus = BRepPrimAPI_MakeTorus(slanted(), 5, 1.5).Shape()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, 0, -10), gp_Dir(0.05, 0.02, 1)), 0.6, 20).Shape()
    return BRepAlgoAPI_Cut(torus, drill).Shape()


def compound(*shapes):
    made, builder = TopoDS_Compound(), TopoDS_Builder()
    builder.MakeCompound(made)
    for s in shapes:
        builder.Add(made, s)
    return made


def assembly():
    """The same two parts at several places, turned."""
    a, b = bored(), BRepPrimAPI_MakeCone(2, 1, 3).Shape()
    placed = []
    for i, (shape, turn) in enumerate([(a, 0.0), (a, 0.7), (b, 0.0), (b, 2.1)]):
        t, s = gp_Trsf(), gp_Trsf()
        t.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), turn)
        s.SetTranslation(gp_Vec(25.0 * i, 3.0, 0))
        placed.append(shape.Moved(TopLoc_Location(s * t)))
    return compound(*placed)


CASES = {
    "box": lambda: BRepPrimAPI_MakeBox(slanted(), 2, 3, 4).Shape(),
    "cylinder": lambda: BRepPrimAPI_MakeCylinder(slanted(), 2, 5).Shape(),
    "part_cylinder": lambda: BRepPrimAPI_MakeCylinder(slanted(), 2, 5, 4.0).Shape(),
    "cone": lambda: BRepPrimAPI_MakeCone(slanted(), 2, 0, 5).Shape(),
    "frustum": lambda: BRepPrimAPI_MakeCone(slanted(), 1, 3, 5).Shape(),
    "sphere": lambda: BRepPrimAPI_MakeSphere(slanted(), 3).Shape(),
    "sphere_slice": lambda: BRepPrimAPI_MakeSphere(slanted(), 3, -0.5, 0.9, 4.5).Shape(),
    "torus": lambda: BRepPrimAPI_MakeTorus(slanted(), 5, 1.5).Shape(),
    "torus_part": lambda: BRepPrimAPI_MakeTorus(slanted(), 5, 1.5, -1.0, 2.0, 4.0).Shape(),
    "extrusion": lofted,
    "elliptic_cylinder": elliptic,
    "tube": tube,
    "revolution": lambda: turned(2 * math.pi),
    "revolution_part": lambda: turned(2.5),
    "filleted": filleted,
    "bored": bored,
    "ball_and_cone": ball_and_cone,
    "drilled_torus": drilled_torus,
    "filleted_nurbs": lambda: BRepBuilderAPI_NurbsConvert(filleted(), True).Shape(),
    "bored_nurbs": lambda: BRepBuilderAPI_NurbsConvert(bored(), True).Shape(),
    "revolution_nurbs": lambda: BRepBuilderAPI_NurbsConvert(turned(2 * math.pi), True).Shape(),
    "assembly": assembly,
}

# Without curves in uv, in other units, in other schemas.
VARIANTS = {
    "": {},
    "_bare": {"write.surfacecurve.mode": 0},
    "_inch_203": {"write.step.unit": "INCH", "write.step.schema": 3, "write.surfacecurve.mode": 0},
    "_242": {"write.step.schema": 5},
}
DEFAULTS = {"write.surfacecurve.mode": 1, "write.step.unit": "MM", "write.step.schema": 4}
MORE = {"": list(CASES), "_bare": list(CASES), "_inch_203": ["bored", "assembly"], "_242": ["filleted", "assembly"]}


def set_statics(values):
    for name, value in values.items():
        if isinstance(value, str):
            assert Interface_Static.SetCVal_s(name, value), name
        else:
            assert Interface_Static.SetIVal_s(name, value), name


def facts(name, shape):
    """Of some points: how far the shape's boundary is, and whether they are inside, as OCCT has it."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    xmin, ymin, zmin, xmax, ymax, zmax = box.Get()
    faces = []
    found = TopExp_Explorer(shape, TopAbs_FACE)
    while found.More():
        faces.append(found.Current())
        found.Next()
    boundary = compound(*faces)
    solids = []
    found = TopExp_Explorer(shape, TopAbs_SOLID)
    while found.More():
        solids.append(found.Current())
        found.Next()
    rng = random.Random(name)
    points = []
    for _ in range(POINTS):
        p = [rng.uniform(1.2 * a - 0.2 * b, 1.2 * b - 0.2 * a) for a, b in [(xmin, xmax), (ymin, ymax), (zmin, zmax)]]
        v = BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex()
        distance = BRepExtrema_DistShapeShape(v, boundary).Value()
        inside = any(BRepClass3d_SolidClassifier(s, gp_Pnt(*p), 1e-9).State() == TopAbs_IN for s in solids)
        points.append({"point": p, "distance": distance, "inside": inside})
    return {"faces": len(faces), "solids": len(solids), "points": points}


def seamless(text):
    """The same file as programs write it that know no seams: an edge that a loop uses twice is left out, which leaves a loop at each of
    its ends, or none; then the border is one point."""
    flat = text.replace("\n", "").replace("\r", "")
    head, data = flat.split("DATA;", 1)
    entities = dict(re.findall(r"#(\d+)\s*=\s*(.*?);", data))
    of = {n: re.match(r"ORIENTED_EDGE\('',\*,\*,#(\d+),", e).group(1) for n, e in entities.items() if e.startswith("ORIENTED_EDGE")}
    count = max(map(int, entities))
    found = 0
    for bound in [n for n, e in entities.items() if e.startswith("FACE_BOUND")]:
        loop, orientation = re.match(r"FACE_BOUND\('',#(\d+),(\.[TF]\.)\)", entities[bound]).groups()
        if not entities[loop].startswith("EDGE_LOOP"):
            continue
        edges = re.findall(r"#(\d+)", entities[loop])
        once = [[of[o] for o in edges].count(of[e]) == 1 for e in edges]
        if all(once):
            continue
        found += 1
        # Runs of edges that are left, around the loop.
        start = once.index(False)
        chains, last = [], False
        for i in range(len(edges)):
            k = (start + i) % len(edges)
            if once[k]:
                if not last:
                    chains.append([])
                chains[-1].append("#" + edges[k])
            last = once[k]
        # A hole through which a seam went is one loop again.
        def ends(oriented):
            edge = entities[of[oriented[1:]]]
            pair = re.findall(r"#(\d+)", edge)[:2]
            return pair if entities[oriented[1:]].endswith(".T.)") else pair[::-1]

        joined = []
        while chains:
            chain = chains.pop(0)
            while ends(chain[-1])[1] != ends(chain[0])[0]:
                chain += chains.pop(next(i for i, c in enumerate(chains) if ends(c[0])[0] == ends(chain[-1])[1]))
            joined.append(chain)
        bounds = []
        for chain in joined:
            entities[str(count + 1)] = f"EDGE_LOOP('',({','.join(chain)}))"
            entities[str(count + 2)] = f"FACE_BOUND('',#{count + 1},{orientation})"
            count += 2
            bounds.append(f"#{count}")
        if not joined:
            vertex = re.search(r"#(\d+)", entities[of[edges[0]]]).group(1)
            entities[loop] = f"VERTEX_LOOP('',#{vertex})"
            continue
        for n, e in entities.items():
            if e.startswith("ADVANCED_FACE"):
                entities[n] = re.sub(rf"#{bound}(?=[,)])", ",".join(bounds), e, count=1)
    lines = [f"#{n}={entities[n]};\n" for n in sorted(entities, key=int)]
    return found, head + "DATA;\n" + "".join(lines) + "ENDSEC;\nEND-ISO-10303-21;\n"


def main():
    FOLDER.mkdir(exist_ok=True)
    STEPControl_Writer()
    for name, make in CASES.items():
        shape = make()
        (FOLDER / f"{name}.json").write_text(json.dumps(facts(name, shape)) + "\n")
        for suffix, statics in VARIANTS.items():
            if name not in MORE[suffix]:
                continue
            set_statics(DEFAULTS | statics)
            writer = STEPControl_Writer()
            assert writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone
            path = FOLDER / f"{name}{suffix}.step"
            assert writer.Write(str(path)) == IFSelect_RetDone
            # Nothing of the day it was made.
            text = path.read_text()
            text = re.sub(r"'\d{4}-\d\d-\d\dT[\d:]+'", "'2000-01-01T00:00:00'", text)
            path.write_text(text)
            if suffix == "_bare":
                found, text = seamless(text)
                if found:
                    (FOLDER / f"{name}_seamless.step").write_text(text)


main()
