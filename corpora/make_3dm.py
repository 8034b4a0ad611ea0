"""Makes models/3dm: extrusions (with holes, mitred, capped, open), blocks (moved, turned, mirrored, scaled, in each other), hidden and
locked objects, meshes. Beside each file stands what rhino3dm says of its objects: points of their faces with outward normals, moved
by rhino3dm where a block reference places them. Run by hand with rhino3dm 8.35.0: `python3 corpora/make_3dm.py`. All shapes are our own."""

import json
import math
import pathlib

import rhino3dm as r

FOLDER = pathlib.Path(__file__).parent / "models" / "3dm"
# Along the faces: ends and the middle.
WALL = [0.0, 0.3, 0.55, 1.0]
MIDDLE = [0.4, 0.5, 0.6]


def normalised(v):
    length = math.sqrt(v.X * v.X + v.Y * v.Y + v.Z * v.Z)
    return [v.X / length, v.Y / length, v.Z / length]


def at(domain, s):
    return domain.T0 + (domain.T1 - domain.T0) * s


def face_points(face, us, vs):
    sign = -1.0 if face.OrientationIsReversed else 1.0
    points = []
    for s in us:
        for t in vs:
            u, v = at(face.Domain(0), s), at(face.Domain(1), t)
            p, n = face.PointAt(u, v), normalised(face.NormalAt(u, v))
            points.append([p.X, p.Y, p.Z] + [sign * x for x in n])
    return points


def extrusion_facts(extrusion):
    """Of the walls; their ends bound the caps. The end of the path is left out where it is mitred or open: there a wall ends."""
    brep = extrusion.ToBrep(True)
    caps = extrusion.CapCount
    walls = len(brep.Faces) - caps
    points = []
    for i in range(walls):
        points += face_points(brep.Faces[i], [0.3, 0.55], [0.0, 0.5, 1.0])
    inner = []
    for i in range(walls):
        inner += face_points(brep.Faces[i], [0.3, 0.55], [0.5])
    return {"solid": brep.IsSolid, "faces": len(brep.Faces), "on": points, "beside": inner}


def brep_facts(brep):
    """Of a convex body: a normal is outward if it leads away from the middle. (Mirrored by rhino3dm, its flags do not say so.)"""
    box = brep.GetBoundingBox()
    middle = [(a + b) / 2 for a, b in zip([box.Min.X, box.Min.Y, box.Min.Z], [box.Max.X, box.Max.Y, box.Max.Z])]
    points = []
    for i in range(len(brep.Faces)):
        for p in face_points(brep.Faces[i], MIDDLE, MIDDLE):
            away = sum((p[k] - middle[k]) * p[3 + k] for k in range(3))
            points.append(p[:3] + [math.copysign(1, away) * n for n in p[3:]])
    return {"solid": brep.IsSolid, "faces": len(brep.Faces), "on": points, "beside": points}


def polyline(points):
    line = r.Polyline(0)
    for x, y in points:
        line.Add(x, y, 0.0)
    return line.ToPolylineCurve()


def circle(x, y, radius):
    return r.ArcCurve.CreateFromCircle(r.Circle(r.Point3d(x, y, 0), radius))


def slot():
    """Two lines and two arcs, joined."""
    curve = r.PolyCurve()
    curve.Append(r.LineCurve(r.Point3d(-3, -1, 0), r.Point3d(3, -1, 0)))
    curve.Append(r.ArcCurve.CreateFromArc(r.Arc(r.Point3d(3, -1, 0), r.Point3d(4, 0, 0), r.Point3d(3, 1, 0))))
    curve.Append(r.LineCurve(r.Point3d(3, 1, 0), r.Point3d(-3, 1, 0)))
    curve.Append(r.ArcCurve.CreateFromArc(r.Arc(r.Point3d(-3, 1, 0), r.Point3d(-4, 0, 0), r.Point3d(-3, -1, 0))))
    return curve


def blob():
    """A closed cubic."""
    points = [(2, 0), (2, 1.5), (0, 2.5), (-2, 1), (-1.5, -1), (0.5, -2), (2, -1), (2, 0)]
    return r.NurbsCurve.Create(False, 3, [r.Point3d(x, y, 0) for x, y in points])


def extruded(profile, holes=(), start=(0, 0, 0), end=(0, 0, 5), up=(0, 1, 0), cap=True, mitres=(None, None)):
    extrusion = r.Extrusion()
    assert extrusion.SetPathAndUp(r.Point3d(*start), r.Point3d(*end), r.Vector3d(*up))
    assert extrusion.SetOuterProfile(profile, cap)
    for hole in holes:
        assert extrusion.AddInnerProfile(hole)
    if mitres[0]:
        extrusion.MiterPlaneNormalAtStart = r.Vector3d(*mitres[0])
    if mitres[1]:
        extrusion.MiterPlaneNormalAtEnd = r.Vector3d(*mitres[1])
    assert extrusion.IsMiteredAtStart == bool(mitres[0]) and extrusion.IsMiteredAtEnd == bool(mitres[1])
    assert extrusion.IsValid
    return extrusion


SQUARE = [(-2, -2), (2, -2), (2, 2), (-2, 2), (-2, -2)]
ELL = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3), (0, 0)]
# Along (1, 2, 2) / 3, with the up direction across it.
SLANTED = {"start": (1, 2, 3), "end": (3, 6, 7), "up": (0, -1, 1)}
LEAN = (0.3, -0.2, 0.9)
BACK = (-0.4, 0.1, 0.8)


def extrusions():
    """All kinds: name and extrusion."""
    return [
        ("box", extruded(polyline(SQUARE))),
        ("ell", extruded(polyline(ELL), **SLANTED)),
        ("cylinder", extruded(circle(1, -0.5, 1.5))),
        ("pipe", extruded(circle(0, 0, 2), [circle(0.25, 0, 1)], **SLANTED)),
        ("plate", extruded(slot(), [circle(3, 0, 0.5), circle(-3, 0, 0.5)], end=(0, 0, 1))),
        ("blob", extruded(blob(), **SLANTED)),
        ("frame", extruded(polyline(SQUARE), [polyline([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])])),
        ("mitred_box", extruded(polyline(SQUARE), mitres=(LEAN, BACK))),
        ("mitred_cylinder", extruded(circle(0, 0, 1.5), mitres=(None, LEAN), **SLANTED)),
        ("mitred_pipe", extruded(circle(0, 0, 2), [circle(0.25, 0, 1)], mitres=(BACK, LEAN))),
        ("mitred_slot", extruded(slot(), mitres=(LEAN, None), **SLANTED)),
        ("mitred_blob", extruded(blob(), mitres=(LEAN, BACK))),
        ("tube", extruded(circle(0, 0, 2), cap=False)),
        ("sheet", extruded(polyline([(0, 0), (2, 1), (3, 3)]), cap=False)),
    ]


def matrix(rows):
    m = r.Transform(0.0)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            setattr(m, f"M{i}{j}", x)
    return m


def named(name, **more):
    attributes = r.ObjectAttributes()
    attributes.Name = name
    for key, value in more.items():
        setattr(attributes, key, value)
    return attributes


TURN = [[0, -1, 0, 10], [1, 0, 0, 0.5], [0, 0, 1, -2], [0, 0, 0, 1]]
MIRROR = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
DOUBLE = [[2, 0, 0, 0], [0, 2, 0, 20], [0, 0, 2, 0], [0, 0, 0, 1]]
COS, SIN = math.cos(0.7), math.sin(0.7)
TILT = [[1.3 * COS, -1.3 * SIN, 0, 3], [1.3 * SIN, 1.3 * COS, 0, -30], [0, 0, 1.3, 1], [0, 0, 0, 1]]
FLIP_TILT = [[COS, SIN, 0, -20], [SIN, -COS, 0, 3], [0, 0, 1, 0], [0, 0, 0, 1]]
STRETCH = [[3, 0, 0, 40], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def box(x, y, z):
    return r.Brep.CreateFromBox(r.Box(r.BoundingBox(0, 0, 0, x, y, z)))


def rod():
    return r.Brep.CreateFromCylinder(r.Cylinder(r.Circle(r.Point3d(5, 1, 0), 1.5), 4.0), True, True)


def write(name, model, facts, version=8):
    model.Settings.ModelUnitSystem = r.UnitSystem.Millimeters
    assert model.Write(str(FOLDER / f"{name}.3dm"), version)
    if version != 8:
        # The same as of the newest.
        return
    text = ",\n".join("  " + json.dumps(f) for f in facts)
    (FOLDER / f"{name}.json").write_text('{"objects": [\n' + text + "\n]}\n")


def moved(geometry, *maps):
    copy = geometry.Duplicate()
    for m in maps:
        assert copy.Transform(matrix(m))
    return copy


def blocks_file(version):
    model = r.File3dm()
    # Meshes are counted, not read.
    model.InstanceDefinitions.Add("parts", "a box and a rod", "", "", r.Point3d(0, 0, 0), (box(2, 3, 4), rod()), (named("crate"), named("rod")))
    model.InstanceDefinitions.Add("bar", "an extrusion", "", "", r.Point3d(0, 0, 0), (extruded(polyline(ELL)),), (named("ell"),))
    # rhino3dm's lists have no index operator by position for all versions: by iteration.
    ids = {d.Name: d.Id for d in model.InstanceDefinitions}
    inner = r.InstanceReference(ids["parts"], matrix(TURN))
    model.InstanceDefinitions.Add("pair", "a block in a block", "", "", r.Point3d(0, 0, 0), (inner, box(1, 1, 1)), (named("inner"), named("cube")))
    ids = {d.Name: d.Id for d in model.InstanceDefinitions}
    facts = []
    # The members stand in the object table first.
    count = len(model.Objects)

    def place(block, m, members, exact):
        nonlocal count
        model.Objects.AddInstanceObject(r.InstanceReference(ids[block], matrix(m)), named(f"{block} {count}"))
        parts = []
        for geometry, maps in members:
            shape = moved(geometry, *maps)
            parts.append(extrusion_facts(shape) if isinstance(shape, r.Extrusion) else brep_facts(shape))
        facts.append({"object": count, "block": block, "exact": exact, "parts": parts})
        count += 1

    place("parts", TURN, [(box(2, 3, 4), [TURN]), (rod(), [TURN])], True)
    place("parts", MIRROR, [(box(2, 3, 4), [MIRROR]), (rod(), [MIRROR])], True)
    place("parts", DOUBLE, [(box(2, 3, 4), [DOUBLE]), (rod(), [DOUBLE])], True)
    place("parts", TILT, [(box(2, 3, 4), [TILT]), (rod(), [TILT])], False)
    place("parts", FLIP_TILT, [(box(2, 3, 4), [FLIP_TILT]), (rod(), [FLIP_TILT])], False)
    place("bar", TILT, [(extruded(polyline(ELL)), [TILT])], False)
    # Members first, then what blocks within the block place.
    place("pair", FLIP_TILT, [(box(1, 1, 1), [FLIP_TILT]), (box(2, 3, 4), [TURN, FLIP_TILT]), (rod(), [TURN, FLIP_TILT])], False)
    # Uneven: boxes of planes only; the rod of the same block is refused.
    place("parts", STRETCH, [(box(2, 3, 4), [STRETCH])], False)
    write("blocks" if version == 8 else f"blocks_v{version}", model, facts, version)


def extrusions_file(version):
    model = r.File3dm()
    facts = []
    for i, (name, extrusion) in enumerate(extrusions()):
        model.Objects.AddExtrusion(extrusion, named(name))
        facts.append({"object": i, "name": name, **extrusion_facts(extrusion)})
    write("extrusions" if version == 8 else f"extrusions_v{version}", model, facts, version)


def modes_file():
    model = r.File3dm()
    for name, visible, locked in [("shown", True, False), ("hidden layer", False, False), ("locked layer", True, True)]:
        layer = r.Layer()
        layer.Name = name
        layer.Visible = visible
        layer.Locked = locked
        model.Layers.Add(layer)
    facts = []
    rows = [
        ("plain", 0, "Normal"),
        ("hidden", 0, "Hidden"),
        ("locked", 0, "Locked"),
        ("on a hidden layer", 1, "Normal"),
        ("on a locked layer", 2, "Normal"),
    ]
    for i, (name, layer, mode) in enumerate(rows):
        attributes = named(name, LayerIndex=layer, Mode=getattr(r.ObjectMode, mode))
        model.Objects.AddBrep(box(1 + i, 1, 1), attributes)
        facts.append({
            "object": i,
            "name": name,
            "layer": ["shown", "hidden layer", "locked layer"][layer],
            "hidden": mode == "Hidden" or layer == 1,
            "locked": mode == "Locked" or layer == 2,
        })
    mesh = r.Mesh()
    for p in [(0, 0, 0), (1, 0, 0), (0, 1, 0)]:
        mesh.Vertices.Add(*p)
    mesh.Faces.AddFace(0, 1, 2)
    model.Objects.AddMesh(mesh, named("mesh"))
    model.Objects.AddMesh(mesh, named("mesh"))
    write("modes", model, facts)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for version in (5, 8):
        extrusions_file(version)
        blocks_file(version)
    modes_file()


main()
