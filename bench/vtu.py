"""Reads the .vtu files that Mortise writes, without Mortise's code, and measures regions and interfaces.

Needs Python 3.9 and nothing else.
"""

import re
import struct
import sys
import zlib
from array import array
from typing import Dict, List, NamedTuple, Tuple

# Facets of VTK's elements by type, normals outward: tetrahedron, hexahedron, wedge, pyramid.
_FACETS = {
    10: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    12: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    13: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    14: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
_CODES = {"Float64": "d", "Float32": "f", "Int64": "q", "Int32": "i", "UInt32": "I", "UInt16": "H",
          "UInt8": "B"}


class File:
    """Arrays of a file by name, decompressed when asked for."""

    def __init__(self, path: str) -> None:
        with open(path, "rb") as file:
            self._data = file.read()
        marker = b'<AppendedData encoding="raw">\n_'
        at = self._data.index(marker)
        self._base = at + len(marker)
        self._arrays: Dict[str, Tuple[str, int]] = {}
        for line in re.findall(r"<DataArray [^>]*>", self._data[:at].decode("ascii")):
            words = dict(re.findall(r'(\w+)="([^"]*)"', line))
            self._arrays[words["Name"]] = (words["type"], int(words["offset"]))

    def array(self, name: str) -> array:
        kind, offset = self._arrays[name]
        at = self._base + offset
        blocks, _, _ = struct.unpack_from("<3Q", self._data, at)
        sizes = struct.unpack_from(f"<{blocks}Q", self._data, at + 24)
        at += 24 + 8 * blocks
        values = array(_CODES[kind])
        for size in sizes:
            values.frombytes(zlib.decompress(self._data[at:at + size]))
            at += size
        if sys.byteorder == "big":
            values.byteswap()
        return values


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _triangles(nodes: Tuple[int, ...]) -> List[Tuple[int, int, int, float]]:
    """Triangles with weights; the two ways to divide a quadrilateral, half each: the volume below a bilinear
    patch is their mean."""
    if len(nodes) == 3:
        return [(*nodes, 1.0)]
    a, b, c, d = nodes
    return [(a, b, c, 0.5), (a, c, d, 0.5), (a, b, d, 0.5), (b, c, d, 0.5)]


class Regions(NamedTuple):
    volume: List[float]  # by region, from the facets around it (divergence theorem)
    interface: float  # area between regions
    defects: List[str]


def facet_volumes(path: str) -> Tuple[File, Dict[int, float], Dict[Tuple[int, int], List[tuple]]]:
    """The file, volume by region number, facets by (inside, outside)."""
    file = File(path)
    points = file.array("Points")
    nodes, inside, outside = (file.array(name) for name in ("facet_nodes", "facet_inside", "facet_outside"))
    origin = points[0:3]
    volume: Dict[int, float] = {}
    facets: Dict[Tuple[int, int], List[tuple]] = {}
    for i, (first, second) in enumerate(zip(inside, outside)):
        facet = tuple(nodes[4 * i:4 * i + 4])
        if facet[3] == facet[2]:
            facet = facet[:3]
        facets.setdefault((first, second), []).append(facet)
        flux = 0.0
        for a, b, c, weight in _triangles(facet):
            p, q, r = ([points[3 * n + j] - origin[j] for j in range(3)] for n in (a, b, c))
            n = _cross(q, r)
            flux += weight * (p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) / 6
        volume[first] = volume.get(first, 0.0) + flux
        if second:
            volume[second] = volume.get(second, 0.0) - flux
    return file, volume, facets


def measure(path: str, regions: int) -> Regions:
    """Volumes from the facets; every facet between two regions must be one of exactly one element on each
    side, areas equal."""
    file, volume, facets = facet_volumes(path)
    defects: List[str] = []
    total = 0.0
    if any(pair[1] for pair in facets):
        total = _interface(file, facets, defects)
    return Regions([volume.get(r + 1, 0.0) for r in range(regions)], total, defects)


def _interface(file: File, facets, defects: List[str]) -> float:
    points = file.array("Points")

    def area(facet: Tuple[int, ...]) -> float:
        total = 0.0
        for a, b, c, weight in _triangles(facet):
            p, q, r = (points[3 * n:3 * n + 3] for n in (a, b, c))
            n = _cross([q[j] - p[j] for j in range(3)], [r[j] - p[j] for j in range(3)])
            total += weight * 0.5 * (n[0] ** 2 + n[1] ** 2 + n[2] ** 2) ** 0.5
        return total

    # Facets of elements between nodes that lie on interfaces, by region.
    listed: Dict[tuple, Tuple[int, int]] = {}
    on_interface = set()
    for (inside, outside), group in facets.items():
        if not outside:
            continue
        for facet in group:
            listed[tuple(sorted(facet))] = (inside, outside)
            on_interface.update(facet)
    seen: Dict[tuple, List[Tuple[int, tuple]]] = {}
    connectivity, offsets = file.array("connectivity"), file.array("offsets")
    begin = 0
    for kind, region, end in zip(file.array("types"), file.array("region"), offsets):
        nodes = connectivity[begin:end]
        begin = end
        marked = [node in on_interface for node in nodes]
        if sum(marked) < 3:
            continue
        for places in _FACETS[kind]:
            if all(marked[place] for place in places):
                facet = tuple(nodes[place] for place in places)
                seen.setdefault(tuple(sorted(facet)), []).append((region, facet))
    sides: Dict[Tuple[int, int], float] = {}
    for key, both in seen.items():
        between = {region for region, _ in both}
        if len(between) == 2 and set(listed.get(key, ())) != between:
            defects.append("a facet between two regions is not listed")
        if len(between) == 2:
            for region, facet in both:
                other = (between - {region}).pop()
                sides[region, other] = sides.get((region, other), 0.0) + area(facet)
    for key, pair in listed.items():
        if {region for region, _ in seen.get(key, ())} != set(pair):
            defects.append("a listed facet between two regions has not one element on each side")
    total = 0.0
    for (first, second), value in sides.items():
        if abs(value - sides.get((second, first), 0.0)) > 1e-12 * value:
            defects.append(f"interface {first}-{second}: areas differ")
        total += value / 2
    return total
