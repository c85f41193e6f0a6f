"""Shared by quality.py, targets.py and smooth.py: runs the mesher, figures of a mesh file, tables, random poses.

All figures of meshes come from `mortise check FILE --quality --json`, which reads Gmsh's text formats, so that
meshes of all programs are measured by the same code. Needs Python 3.9 and nothing else.
"""

import json
import math
import os
import random
import struct
import subprocess
import sys
import time
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple


class Failure(Exception):
    """A program that did not do what was asked of it; its last line tells why."""


class Figures(NamedTuple):
    """What `mortise check` says of a file. Angles in degrees, over all dihedral angles of all elements."""

    valid: bool
    defects: int
    elements: int
    nodes: int
    volume: float
    low: float
    low_percentile: float
    high_percentile: float
    high: float
    scaled_jacobian: float


def say(text: str) -> None:
    """Progress and warnings go to stderr: the tables on stdout can be kept as they are."""
    print(f"{os.path.basename(sys.argv[0])[:-3]}: {text}", file=sys.stderr, flush=True)


def run(arguments: Sequence[str], limit: float, environment: Optional[Dict[str, str]] = None,
        accept: Tuple[int, ...] = (0,), folder: Optional[str] = None) -> Tuple[str, float]:
    """Runs a program; its stdout and its wall time in seconds. Raises Failure after `limit` seconds, too."""
    begin = time.monotonic()
    try:
        done = subprocess.run(list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit,
                              env={**os.environ, **(environment or {})}, text=True, errors="replace",
                              check=False, cwd=folder)
    except subprocess.TimeoutExpired:
        raise Failure(f"more than {limit:g} s") from None
    except OSError as error:
        raise Failure(f"{arguments[0]}: {error.strerror}") from None
    seconds = time.monotonic() - begin
    if done.returncode not in accept:
        lines = [line for line in (done.stderr + "\n" + done.stdout).splitlines() if line.strip()]
        raise Failure(lines[0].strip() if lines else f"exit code {done.returncode}")
    return done.stdout, seconds


def limit_cores(threads: int) -> Dict[str, str]:
    """Environment that limits OpenCL on the CPU: PoCL up to 3 reads the first variable, later ones the next."""
    return {"POCL_MAX_PTHREAD_COUNT": str(threads), "POCL_CPU_MAX_CU_COUNT": str(threads)}


def check(mortise: str, path: str) -> Figures:
    """Figures of a mesh file. Exit code 3 only says that the mesh has defects."""
    text, _ = run([mortise, "check", path, "--quality", "--json"], 600, accept=(0, 3))
    report = json.loads(text)
    angles = report["quality"]["dihedral_angles"]
    shapes = [shape for shape in report["quality"]["scaled_jacobian"].values() if shape and shape["count"]]
    return Figures(report["valid"], len(report["defects"]), sum(shape["count"] for shape in shapes),
                   report["nodes"], report["volume"], angles["min"], angles["percentile_1"],
                   angles["percentile_99"], angles["max"], min(shape["min"] for shape in shapes))


# Edges of Gmsh's linear volume elements by type: tetrahedron, hexahedron, wedge, pyramid.
_EDGES = {
    4: ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)),
    5: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    6: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    7: ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
}
_NODES = {15: 1, 1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5}


def _read_text_2(data: bytes) -> Tuple[dict, list]:
    """Points by tag and volume elements (type, tags) of a Gmsh 2.2 text file."""
    lines = data.decode("ascii").splitlines()
    at = lines.index("$Nodes") + 1
    points = {}
    for line in lines[at + 1:at + 1 + int(lines[at])]:
        tag, x, y, z = line.split()
        points[int(tag)] = (float(x), float(y), float(z))
    at = lines.index("$Elements") + 1
    elements = []
    for line in lines[at + 1:at + 1 + int(lines[at])]:
        numbers = [int(word) for word in line.split()]
        if numbers[1] in _EDGES:
            elements.append((numbers[1], numbers[3 + numbers[2]:]))
    return points, elements


def _read_binary_4(data: bytes) -> Tuple[dict, list]:
    """The same of a Gmsh 4.1 binary file."""
    at = data.index(b"\n$Nodes\n") + 8
    blocks, _, _, _ = struct.unpack_from("<4Q", data, at)
    at += 32
    points = {}
    for _ in range(blocks):
        _, _, _, count = struct.unpack_from("<iiiQ", data, at)
        at += 20
        tags = struct.unpack_from(f"<{count}Q", data, at)
        at += 8 * count
        for tag, point in zip(tags, struct.iter_unpack("<3d", data[at:at + 24 * count])):
            points[tag] = point
        at += 24 * count
    at = data.index(b"\n$Elements\n", at) + 11
    blocks, _, _, _ = struct.unpack_from("<4Q", data, at)
    at += 32
    elements = []
    for _ in range(blocks):
        _, _, kind, count = struct.unpack_from("<iiiQ", data, at)
        at += 20
        size = 8 * (1 + _NODES[kind])
        if kind in _EDGES:
            rows = struct.iter_unpack(f"<{1 + _NODES[kind]}Q", data[at:at + size * count])
            elements.extend((kind, row[1:]) for row in rows)
        at += size * count
    return points, elements


def mean_edge_length(path: str) -> float:
    """Mean length of the edges of a mesh, each counted once: Gmsh 2.2 text, or 4.1 binary as Mortise writes."""
    with open(path, "rb") as file:
        data = file.read()
    is_text = data.startswith(b"$MeshFormat\n2")
    points, elements = _read_text_2(data) if is_text else _read_binary_4(data)
    edges = set()
    for kind, nodes in elements:
        for first, second in _EDGES[kind]:
            a, b = nodes[first], nodes[second]
            edges.add((a, b) if a < b else (b, a))
    total = 0.0
    for a, b in edges:
        p, q = points[a], points[b]
        total += ((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2) ** 0.5
    return total / len(edges)


def print_table(rows: List[List[str]], words: int = 2) -> None:
    """First row: titles. So many columns are words, the others numbers."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        cells = [cell.ljust(width) if column < words else cell.rjust(width)
                 for column, (cell, width) in enumerate(zip(row, widths))]
        print("  ".join(cells).rstrip())
    sys.stdout.flush()


Vector = Tuple[float, float, float]
Frame = Tuple[Vector, Vector, Vector]


def random_frame(source: random.Random) -> Frame:
    """Three orthonormal vectors, uniform over all rotations: a unit quaternion from the unit ball of R^4."""
    while True:
        q = [2 * source.random() - 1 for _ in range(4)]
        square = sum(x * x for x in q)
        if 0.01 < square <= 1:
            break
    w, x, y, z = (c / math.sqrt(square) for c in q)
    return ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
