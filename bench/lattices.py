"""Lattices as people print them, and how they are meshed: rods in the patterns of crystals, as OpenSCAD text,
and solids and sheets between triply periodic minimal surfaces, as formulas. --write FOLDER keeps the models."""

import argparse
import itertools
import os
import sys
import tempfile
from typing import Callable, Dict, List, Set, Tuple

from parts import tabulate

Point = Tuple[float, float, float]
Rod = Tuple[Point, Point]

CORNERS: List[Point] = list(itertools.product((0.0, 1.0), repeat=3))
FACES: List[Point] = [(.5, .5, 0), (.5, .5, 1), (.5, 0, .5), (.5, 1, .5), (0, .5, .5), (1, .5, .5)]
CENTRE: Point = (.5, .5, .5)
CELLS = 2  # of a lattice along each axis

# The zero set bounds the solid; the sheet is where the function is at most so large.
SURFACES: Dict[str, Tuple[str, float]] = {
    "gyroid": ("sin(x)*cos(y) + sin(y)*cos(z) + sin(z)*cos(x)", 0.3),
    "schwarz_p": ("cos(x) + cos(y) + cos(z)", 0.3),
    "schwarz_d": ("sin(x)*sin(y)*sin(z) + sin(x)*cos(y)*cos(z) + cos(x)*sin(y)*cos(z) + cos(x)*cos(y)*sin(z)", 0.3),
    "iwp": ("2*(cos(x)*cos(y) + cos(y)*cos(z) + cos(z)*cos(x)) - (cos(2*x) + cos(2*y) + cos(2*z))", 0.8),
    "neovius": ("3*(cos(x) + cos(y) + cos(z)) + 4*cos(x)*cos(y)*cos(z)", 0.8),
    "frd": ("4*cos(x)*cos(y)*cos(z) - (cos(2*x)*cos(2*y) + cos(2*y)*cos(2*z) + cos(2*z)*cos(2*x))", 0.6),
    "lidinoid": ("0.5*(sin(2*x)*cos(y)*sin(z) + sin(2*y)*cos(z)*sin(x) + sin(2*z)*cos(x)*sin(y))"
                 " - 0.5*(cos(2*x)*cos(2*y) + cos(2*y)*cos(2*z) + cos(2*z)*cos(2*x)) + 0.15", 0.3),
    "split_p": ("1.1*(sin(2*x)*cos(y)*sin(z) + sin(2*y)*cos(z)*sin(x) + sin(2*z)*cos(x)*sin(y))"
                " - 0.2*(cos(2*x)*cos(2*y) + cos(2*y)*cos(2*z) + cos(2*z)*cos(2*x))"
                " - 0.4*(cos(2*x) + cos(2*y) + cos(2*z))", 0.3),
}


def square(a: Point, b: Point) -> float:
    return sum((p - q) ** 2 for p, q in zip(a, b))


def pairs(first: List[Point], second: List[Point], length2: float) -> List[Rod]:
    return [(a, b) for a in first for b in second if abs(square(a, b) - length2) < 1e-9]


def octahedron_corners() -> List[Point]:
    """Of the truncated octahedra that fill space: a square in each face of the cube."""
    points: Set[Point] = set()
    for face in FACES:
        for axis in (j for j in range(3) if face[j] == .5):
            for step in (-.25, .25):
                moved = list(face)
                moved[axis] += step
                points.add((moved[0], moved[1], moved[2]))
    return sorted(points)


PATTERNS: Dict[str, Callable[[], List[Rod]]] = {
    "cubic": lambda: pairs(CORNERS, CORNERS, 1),
    "body_centred": lambda: pairs(CORNERS, [CENTRE], .75),
    "face_centred": lambda: pairs(CORNERS, FACES, .5),
    "octet": lambda: pairs(CORNERS, FACES, .5) + pairs(FACES, FACES, .5),
    "diamond": lambda: pairs([(.25, .25, .25), (.75, .75, .25), (.75, .25, .75), (.25, .75, .75)], CORNERS + FACES,
                             3 / 16),
    "octahedra": lambda: pairs(octahedron_corners(), octahedron_corners(), .125),
}


def rods_of(pattern: str) -> List[Rod]:
    rods: Set[Rod] = set()
    for step in itertools.product(range(CELLS), repeat=3):
        for rod in PATTERNS[pattern]():
            a, b = (tuple(p + s for p, s in zip(end, step)) for end in rod)
            rods.add((min(a, b), max(a, b)))
    return sorted(rods)


def scad(pattern: str, radius: float, balls: bool, within: str) -> str:
    rods = rods_of(pattern)
    lines = [f"rod({list(a)}, {list(b)}, {radius});" for a, b in rods]
    if balls:
        lines += [f"translate({list(p)}) sphere(r = {radius});" for p in sorted({p for rod in rods for p in rod})]
    body = "union() {\n" + "\n".join(lines) + "\n}\n"
    if within:
        body = f"intersection() {{ {within} {body} }}\n"
    return ("$fn = 24;\nmodule rod(a, b, r) { v = b - a; l = norm(v); translate(a)"
            " rotate([0, acos(v[2] / l), atan2(v[1], v[0])]) cylinder(h = l, r = r); }\n" + body)


def models() -> Dict[str, str]:
    result: Dict[str, str] = {}
    for pattern in PATTERNS:
        result[f"{pattern}_thick.scad"] = scad(pattern, 0.1, True, "")
        result[f"{pattern}_thin.scad"] = scad(pattern, 0.06, True, "")
        result[f"{pattern}_bare.scad"] = scad(pattern, 0.06, False, "")
        result[f"{pattern}_in_box.scad"] = scad(pattern, 0.1, True, f"cube({CELLS});")
        result[f"{pattern}_in_cylinder.scad"] = scad(pattern, 0.06, False, "translate([1, 1, 0]) cylinder(h = 2, r = 1);")
    box = "max(abs(x) - 6.3, abs(y) - 6.3, abs(z) - 6.3)"
    ball = "sqrt(x*x + y*y + z*z) - 6"
    for name, (function, thickness) in SURFACES.items():
        result[f"{name}_sheet.formula"] = f"max(abs({function}) - {thickness}, {box})\n"
        result[f"{name}_solid.formula"] = f"max({function}, {box})\n"
        result[f"{name}_ball.formula"] = f"max({function}, {ball})\n"
        result[f"{name}_in_shell.formula"] = f"min(max({function}, {ball}), abs({ball}) - 0.5)\n"
    return result


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench/lattices.sh", description=__doc__)
    parser.add_argument("--mortise", help=argparse.SUPPRESS, required=True)
    parser.add_argument("names", nargs="*", metavar="NAME", help="part of the names of those to mesh (all)")
    parser.add_argument("--level", default="6", help="level of the meshes (6)")
    parser.add_argument("--write", metavar="FOLDER", help="only write the models there")
    arguments = parser.parse_args()
    chosen = {name: text for name, text in models().items()
              if not arguments.names or any(part in name for part in arguments.names)}
    if not chosen:
        parser.error("no lattice has such a name")
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.write or scratch
        os.makedirs(folder, exist_ok=True)
        for name, text in chosen.items():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        if arguments.write:
            return 0
        return tabulate(arguments.mortise, [os.path.join(folder, name) for name in chosen], scratch, arguments.level)


if __name__ == "__main__":
    sys.exit(main())
