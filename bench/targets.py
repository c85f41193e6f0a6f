"""Worst elements of Mortise's meshes over a list of models, a line each; run by targets.sh.

The models: assets/models/*.csg; spheres, tori and ellipsoids of at least 3 cells' radius (one smooth surface);
boxes, cylinder ends, crossing cylinders, drilled blocks and wedges in random orientation (creases and corners),
written as Netgen .geo on the fly; and the files that are named. The same seed gives the same models everywhere.

Targets: dihedral angles from 18 to 155 degrees and scaled Jacobians of 0.2 on one smooth surface; 15 to 160 and
0.12 with creases and corners. Where a crease of a wedge, or of a file that is named, is sharper than 30 degrees, half
its angle instead; our other models but the gyroid have none below 90 degrees, so `sharpest` below that is an error
of the mesh.
"""

import argparse
import glob
import json
import math
import os
import random
import re
import sys
import tempfile
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import figures
from figures import Failure, Frame, Vector, random_frame, say

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMIT = 900.0  # seconds for one mesh



class Model(NamedTuple):
    name: str
    path: str
    smooth: bool
    ours: bool  # no crease is sharper than 90 degrees
    size: Optional[float]  # edge length of a cell; None: meshed at each level asked for


def text(v: Sequence[float]) -> str:
    return ", ".join(f"{c:.17g}" for c in v)


def along(frame: Frame, c: Sequence[float]) -> Vector:
    """The point with these coordinates in the frame."""
    return tuple(sum(frame[k][i] * c[k] for k in range(3)) for i in range(3))  # type: ignore[return-value]


def slab(frame: Frame, axis: int, half: float) -> str:
    """The planes at +half and -half of an axis."""
    n = frame[axis]
    m = tuple(-c for c in n)
    return (f"plane ({text([half * c for c in n])}; {text(n)}) and "
            f"plane ({text([half * c for c in m])}; {text(m)})")


def cylinder(frame: Frame, axis: int, radius: float, centre: Sequence[float] = (0, 0, 0)) -> str:
    a = along(frame, centre)
    b = tuple(p + d for p, d in zip(a, frame[axis]))
    return f"cylinder ({text(a)}; {text(b)}; {radius:.17g})"


def write_models(folder: str, count: int, seed: int) -> List[Model]:
    """`count` models of each kind."""
    source = random.Random()
    models: List[Model] = []

    def between(low: float, high: float) -> float:
        return low + (high - low) * source.random()

    def sphere(_: Frame) -> Tuple[str, Optional[float]]:
        return "sphere (0, 0, 0; 1)", 1 / between(3, 15)

    def torus(frame: Frame) -> Tuple[str, Optional[float]]:
        tube = between(0.25, 0.45)
        return f"torus (0, 0, 0; {text(frame[0])}; 1; {tube:.17g})", tube / between(3, 6)

    def ellipsoid(frame: Frame) -> Tuple[str, Optional[float]]:
        lengths = [1.0, between(0.7, 1), between(0.7, 1)]
        axes = [[length * c for c in frame[k]] for k, length in enumerate(lengths)]
        # Its smallest radius of curvature is at least 0.7 * 0.7.
        return f"ellipsoid (0, 0, 0; {'; '.join(text(axis) for axis in axes)})", 0.49 / between(3, 6)

    def box(frame: Frame) -> Tuple[str, Optional[float]]:
        return " and ".join(slab(frame, k, between(0.4, 1)) for k in range(3)), None

    def cylinder_end(frame: Frame) -> Tuple[str, Optional[float]]:
        return f"{cylinder(frame, 2, between(0.4, 1))} and {slab(frame, 2, between(0.4, 1))}", None

    def steinmetz(frame: Frame) -> Tuple[str, Optional[float]]:
        return f"{cylinder(frame, 0, 1)} and {cylinder(frame, 1, 1)}", None

    def crossing(frame: Frame) -> Tuple[str, Optional[float]]:
        second = between(0.6, 0.95)
        return f"{cylinder(frame, 0, 1)} and {cylinder(frame, 1, second)}", None

    def drilled(frame: Frame) -> Tuple[str, Optional[float]]:
        holes = [f"not {cylinder(frame, 2, between(0.25, 0.4), (side * 0.5, between(-0.1, 0.1), 0))}"
                 for side in (-1, 1)]
        sides = [slab(frame, k, half) for k, half in enumerate((1, between(0.6, 0.8), between(0.3, 0.5)))]
        return " and ".join(sides + holes), None

    def wedge(frame: Frame) -> Tuple[str, Optional[float]]:
        angle = math.radians(between(6, 29))
        normal = tuple(math.sin(angle) * p - math.cos(angle) * q for p, q in zip(frame[0], frame[1]))
        cut = f"plane (0, 0, 0; {text([-c for c in normal])})"  # above it v > u * tan(angle): taken away
        bottom = f"plane (0, 0, 0; {text([-c for c in frame[1]])})"
        end = f"plane ({text(frame[0])}; {text(frame[0])})"
        return f"{bottom} and {cut} and {end} and {slab(frame, 2, between(0.3, 0.6))}", None

    kinds: Dict[str, Callable[[Frame], Tuple[str, Optional[float]]]] = {
        "sphere": sphere, "torus": torus, "ellipsoid": ellipsoid,
        "box": box, "cylinder-end": cylinder_end, "steinmetz": steinmetz,
        "crossing": crossing, "drilled": drilled, "wedge": wedge}
    for kind, make in kinds.items():
        for number in range(1, count + 1):
            source.seed(f"{seed} {kind} {number}")  # a model does not depend on the others
            solid, size = make(random_frame(source))
            path = os.path.join(folder, f"{kind}-{number}.geo")
            with open(path, "w", encoding="ascii") as file:
                file.write(f"algebraic3d\nsolid part = {solid};\ntlo part;\n")
            models.append(Model(f"{kind}-{number}", path, size is not None, kind != "wedge", size))
    return models


class Line(NamedTuple):
    model: str
    resolution: str
    figures: figures.Figures
    corners: Tuple[int, int]  # found, expected
    sharpest: float           # smallest angle of the model along creases of the mesh, degrees; 360 without
    too_fine: int             # complex cells that are not kept exactly, by Mortise's own warning
    ours: bool
    seconds: float            # all stages but the reports
    improve: float            # the stages that move nodes and improve elements alone
    short: List[str]          # figures that miss their target


def measure(model: Model, resolution: List[str], options: argparse.Namespace, folder: str) -> Line:
    path = os.path.join(folder, "mesh.msh")
    output, _ = figures.run([options.mortise, model.path, "-o", path, *resolution, "--quality", "--json",
                             *options.mortise_option], LIMIT)
    report = json.loads(output)
    quality = report["quality"]
    found = figures.check(options.mortise, path)
    sharpest = min((crease["model_angle"] for crease in quality["creases"]), default=360.0)
    times = {stage["stage"]: stage["wall_seconds"] for stage in report["stages"]}
    # 17.999 degrees is what improvement takes for 18.
    low, high, jacobian = (17.995, 155.005, 0.1999) if model.smooth else (15.0, 160.0, 0.12)
    if sharpest < 30 and not model.ours:  # no element can be better than the model
        low, high, jacobian = 0.5 * sharpest, 180.0 - 0.5 * sharpest, 0.0
    corners = quality["corners"]
    short = []
    if found.low < low:
        short.append("min")
    if found.high > high:
        short.append("max")
    if found.scaled_jacobian < jacobian:
        short.append("Jacobian")
    if corners["found"] < corners["expected"]:
        short.append("corners")
    if model.ours and sharpest < 89:
        short.append("crease")
    if not found.valid:
        short.append("INVALID")
    too_fine = sum(int(match) for warning in report["warnings"]
                   for match in re.findall(r"^(\d+) of \d+ complex cells hold", warning))
    return Line(model.name, " ".join(resolution)[2:], found, (corners["found"], corners["expected"]), sharpest,
                too_fine, model.ours,
                sum(time for stage, time in times.items() if stage not in ("quality", "figures", "compile")),
                sum(times.get(s, 0.0) for s in ("reposition", "planes", "improve")), short)


COLUMNS = (("model", 20), ("resolution", 13), ("valid", 5), ("elements", 8), ("min", 6), ("max", 6),
           ("Jacobian", 8), ("corners", 7), ("sharpest", 8), ("too fine", 8), ("seconds", 7),
           ("improve", 7), ("target", 6))


def print_line(cells: Sequence[str]) -> None:
    line = [cell.ljust(width) if number < 2 or number == len(COLUMNS) - 1 else cell.rjust(width)
            for number, (cell, (_, width)) in enumerate(zip(cells, COLUMNS))]
    print("  ".join(line).rstrip(), flush=True)


def show(line: Line) -> None:
    f = line.figures
    print_line([line.model, line.resolution, "yes" if f.valid else "NO", str(f.elements), f"{f.low:.2f}",
                f"{f.high:.2f}", f"{f.scaled_jacobian:.3f}", f"{line.corners[0]}/{line.corners[1]}",
                f"{line.sharpest:.1f}" if line.sharpest < 360 else "-", str(line.too_fine),
                f"{line.seconds:.2f}", f"{line.improve:.2f}",
                "short: " + ", ".join(line.short) if line.short else "ok"])


def summary(lines: List[Line], failed: int) -> None:
    print(f"\n{len(lines) + failed} meshes: {failed} not made, "
          f"{sum(not line.figures.valid for line in lines)} invalid, "
          f"{sum(not line.short for line in lines)} within their targets")
    ordinary = [line for line in lines if line.ours or line.sharpest >= 30]
    if ordinary:
        print("  models without creases below 30 degrees: dihedral angles "
              f"{min(l.figures.low for l in ordinary):.2f} to "
              f"{max(l.figures.high for l in ordinary):.2f} degrees, scaled Jacobian from "
              f"{min(l.figures.scaled_jacobian for l in ordinary):.3f}")
    total = sum(line.seconds for line in lines)
    improve = sum(line.improve for line in lines)
    print(f"  {total:.1f} s in all stages but the reports, {improve:.1f} s of it to improve elements")


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench/targets.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", metavar="FILE",
                        help="models to add (.csg, .geo), such as other people's")
    parser.add_argument("--mortise", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--levels", default="5,6", help="levels of assets, files and creased models (5,6)")
    parser.add_argument("--count", type=int, default=4, help="generated models of each kind (4)")
    parser.add_argument("--seed", type=int, default=1, help="of the generated models (1)")
    parser.add_argument("--files-only", action="store_true", help="only the files that are named")
    parser.add_argument("--keep", metavar="FOLDER", help="writes the generated models there and keeps them")
    parser.add_argument("--mortise-option", action="append", default=[], metavar="OPTION",
                        help="handed to Mortise, as in --mortise-option=--elements=tet; may be repeated")
    parser.add_argument("--json", metavar="FILE", help="writes all figures")
    options = parser.parse_args()
    try:
        levels = [int(level) for level in options.levels.split(",")]
    except ValueError:
        parser.error(f"--levels: '{options.levels}' is not a list such as 5,6")
    lines: List[Line] = []
    failed = 0
    print_line([name for name, _ in COLUMNS])
    with tempfile.TemporaryDirectory() as folder:
        models = []
        if not options.files_only:
            if options.keep:
                os.makedirs(options.keep, exist_ok=True)
            assets = sorted(glob.glob(os.path.join(ROOT, "assets", "models", "*.csg")))
            models += [Model(os.path.basename(path)[:-4], path, False, "gyroid" not in path, None) for path in assets]
            models += write_models(options.keep or folder, options.count, options.seed)
        models += [Model(os.path.splitext(os.path.basename(path))[0], path, False, False, None)
                   for path in options.models]
        for model in models:
            resolutions = [["--level", str(level)] for level in levels]
            for resolution in [["--size", f"{model.size:.6g}"]] if model.size else resolutions:
                try:
                    lines.append(measure(model, resolution, options, folder))
                    show(lines[-1])
                except Failure as failure:
                    failed += 1
                    say(f"{model.name} {' '.join(resolution)}: {failure}")
    summary(lines, failed)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([{**line._asdict(), "figures": line.figures._asdict()} for line in lines], file, indent=1)
    return 3 if failed or any(not line.figures.valid for line in lines) else 0


sys.exit(main())
