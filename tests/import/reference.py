"""What rhino3dm, an independent reader of .3dm files, makes of the BREPs of some files.

Usage: reference.py FILE...    One line of JSON for each file:

{"file": str, "breps": [{
    "object": int,               place among the objects of the file
    "counts": {"faces", "loops", "trims", "edges", "vertices": int},
    "loops": [[{"edge": int, "start": int, "end": int}, ...], ...],   trims, face by face
    "faces": [{"reversed": bool, "domain": [u0, u1, v0, v1], "points": [[u, v, x, y, z], ...]}, ...],
    "edges": [[[x, y, z], ...], ...],            17 points evenly spaced in the edge's parameter
    "vertices": [[x, y, z], ...]}],
 "surfaces": [{"object", "domain", "points"}],   surfaces that are no part of a BREP
 "curves": [{"object", "points": [[x, y, z], ...]}]}   17 points, likewise

The 100 uv of a face are the grid of 10 x 10 fractions k/9 of its domain, corners included.
"""

import json
import sys

import rhino3dm

GRID = 10
EDGE_POINTS = 17
CURVES = ("LineCurve", "ArcCurve", "PolylineCurve", "NurbsCurve", "PolyCurve")
SURFACES = ("PlaneSurface", "RevSurface", "SumSurface", "NurbsSurface", "Surface")


def at(interval, k, n):
    if k == n - 1:
        return interval.T1
    return interval.T0 + (interval.T1 - interval.T0) * (k / (n - 1))


def xyz(p):
    return [p.X, p.Y, p.Z]


def surface(s):
    u, v = s.Domain(0), s.Domain(1)
    grid = [(at(u, i, GRID), at(v, j, GRID)) for i in range(GRID) for j in range(GRID)]
    return {
        "domain": [u.T0, u.T1, v.T0, v.T1],
        "points": [[a, b, *xyz(s.PointAt(a, b))] for a, b in grid],
    }


def curve(c):
    return [xyz(c.PointAt(at(c.Domain, k, EDGE_POINTS))) for k in range(EDGE_POINTS)]


def brep(b):
    faces = list(b.Faces)
    loops = [list(loop.Trims) for face in faces for loop in face.Loops]
    return {
        "counts": {
            "faces": len(faces),
            "loops": len(loops),
            "trims": sum(len(trims) for trims in loops),
            "edges": len(b.Edges),
            "vertices": len(b.Vertices),
        },
        "loops": [
            [
                {"edge": t.EdgeIndex, "start": t.StartVertexIndex, "end": t.EndVertexIndex}
                for t in trims
            ]
            for trims in loops
        ],
        "faces": [{"reversed": f.OrientationIsReversed, **surface(f)} for f in faces],
        "edges": [curve(b.Edges[i]) for i in range(len(b.Edges))],
        "vertices": [xyz(b.Vertices[i].Location) for i in range(len(b.Vertices))],
    }


def main():
    for path in sys.argv[1:]:
        model = rhino3dm.File3dm.Read(path)
        out = {"file": path, "objects": 0, "breps": [], "surfaces": [], "curves": []}
        for i, item in enumerate(model.Objects if model else []):
            geometry = item.Geometry
            kind = type(geometry).__name__
            if kind == "Light":
                # Last, from a table of its own.
                continue
            out["objects"] += 1
            if kind == "Brep":
                out["breps"].append({"object": i, **brep(geometry)})
            elif kind in SURFACES:
                out["surfaces"].append({"object": i, **surface(geometry)})
            elif kind in CURVES:
                out["curves"].append({"object": i, "points": curve(geometry)})
        print(json.dumps(out))


main()
