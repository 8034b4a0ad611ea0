"""Which objects of .3dm files rhino3dm finds valid.

Usage: valid.py FILE...    One line of JSON for each file: [[class, whether valid, the log's first line], ...], null if it cannot be read.
"""

import json
import sys

import rhino3dm


def look(geometry):
    valid = geometry.IsValid
    log = ""
    if not valid:
        said = geometry.IsValidWithLog
        log = (said if isinstance(said, str) else str(said)).strip()[:300]
    return [type(geometry).__name__, valid, log]


for path in sys.argv[1:]:
    model = rhino3dm.File3dm.Read(path)
    print(json.dumps([look(o.Geometry) for o in model.Objects] if model else None))
