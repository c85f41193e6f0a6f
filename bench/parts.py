"""Made-up parts in the idioms of OpenSCAD's users, or the models of the named files, a line each; run by parts.sh.

Each seed is a body (plate, rounded plate, angle, box, tube, plate with round ends, hull) with two to four of: bores,
slots, countersinks, bosses, ribs, nut traps, teardrops, pockets, balls, slanted cuts, cross bores; every second is
turned. All sizes are above a cell of level 6; what is finer comes from where the parts meet. The same seed gives the
same part everywhere.
"""

import argparse
import functools
import json
import os
import random
import subprocess
import sys
import tempfile
from typing import Dict, List, NamedTuple, Optional

from figures import say

LIMIT = 300.0  # seconds for one mesh


class Body(NamedTuple):
    kind: str
    length: float
    width: float
    height: float
    wall: float
    text: str


class Result(NamedTuple):
    worst: float  # scaled Jacobian
    elements: int
    merged: int
    dropped: int
    touching: int  # edges and nodes at which the mesh's skin touches itself
    warned: bool
    seconds: float  # CPU time of all stages
    cause: str


def rounded(source: random.Random, low: float, high: float) -> float:
    """A size with none, one or two decimals, as people write them."""
    return round(source.uniform(low, high), source.choice([0, 1, 2]))


def make_body(source: random.Random) -> Body:
    size = functools.partial(rounded, source)
    length, width, height, wall = size(28, 44), size(16, 30), size(4, 9), size(2, 4)
    radius = size(2, 5)
    ends = f"for (x = [{radius}, {length} - {radius}], y = [{radius}, {width} - {radius}]) translate([x, y, 0])"
    posts = f"{ends} cylinder(r = {radius}, h = {height});"
    half = width / 2
    bodies = {
        "plate": f"cube([{length}, {width}, {height}]);",
        "rounded": f"{posts} translate([0, {radius}, 0]) cube([{length}, {width} - 2 * {radius}, {height}]);"
                   f" translate([{radius}, 0, 0]) cube([{length} - 2 * {radius}, {width}, {height}]);",
        "hulled": f"hull() {{ {posts} }}",
        "angle": f"cube([{length}, {width}, {wall}]); cube([{length}, {wall}, {height} + 8]);",
        "box": f"difference() {{ cube([{length}, {width}, {height} + 6]); translate([{wall}, {wall}, {wall}])"
               f" cube([{length} - 2 * {wall}, {width} - 2 * {wall}, {height} + 6]); }}",
        "tube": f"translate([{length} / 2, {half}, 0]) difference() {{ cylinder(r = {half}, h = {height} + 6);"
                f" translate([0, 0, -1]) cylinder(r = {half} - {wall}, h = {height} + 9); }}",
        "stadium": f"for (x = [{half}, {length} - {half}]) translate([x, {half}, 0]) cylinder(r = {half}, h = {height});"
                   f" translate([{half}, 0, 0]) cube([{length} - {width}, {width}, {height}]);",
    }
    kind = source.choice(sorted(bodies))
    return Body(kind, length, width, height, wall, bodies[kind])


def make_feature(source: random.Random, body: Body) -> Dict[str, str]:
    """What is added and what is cut."""
    size = functools.partial(rounded, source)
    x, y, radius, run = size(6, body.length - 6), size(6, body.width - 6), size(1.5, 3), size(4, 9)
    at = f"translate([{x}, {y}, -1])"
    top, through, across = body.height, body.height + 20, body.width + 2
    bore = f"{at} cylinder(r = {radius}, h = {through});"
    features = {
        "bore": {"cut": bore},
        "countersink": {"cut": f"{bore} translate([{x}, {y}, {top} - 2])"
                               f" cylinder(r1 = {radius}, r2 = {radius} + 2.01, h = 2.01);"},
        "slot": {"cut": f"{at} {{ cylinder(r = {radius}, h = {through}); translate([{run}, 0, 0])"
                        f" cylinder(r = {radius}, h = {through}); translate([0, -{radius}, 0])"
                        f" cube([{run}, 2 * {radius}, {through}]); }}"},
        "boss": {"body": f"translate([{x}, {y}, 0]) cylinder(r = {radius} + 2, h = {top} + 4);", "cut": bore},
        "rib": {"body": f"translate([{x}, 0, 0]) cube([{body.wall}, {body.width}, {top} + 3]);"},
        "nut": {"cut": f"{bore} translate([{x}, {y}, {top} - 2.5]) cylinder(r = {radius} + 1.5, h = 20, $fn = 6);"},
        "teardrop": {"cut": f"translate([{x}, -1, {top} / 2 + 1]) rotate([-90, 0, 0]) {{ cylinder(r = {radius},"
                            f" h = {across}); rotate([0, 0, 225]) cube([{radius}, {radius}, {across}]); }}"},
        "pocket": {"cut": f"translate([{x}, {y}, {body.wall}]) cube([{run}, {size(4, 9)}, 20]);"},
        "ball": {"cut": f"translate([{x}, {y}, {top} + 1]) sphere(r = {radius} + 1.5);"},
        "slant": {"cut": f"translate([{body.length} - 5, -1, {top}]) rotate([0, {source.choice([30, 45, 60])}, 0])"
                         f" cube([20, {across}, 20]);"},
        "cross": {"cut": f"translate([-1, {y}, {top} / 2 + 0.5]) rotate([0, 90, 0])"
                         f" cylinder(r = {radius}, h = {body.length} + 2);"},
    }
    return features[source.choice(sorted(features))]


def make_part(seed: int) -> str:
    source = random.Random(seed)
    body = make_body(source)
    features = [make_feature(source, body) for _ in range(source.randint(2, 4))]
    added = " ".join(f.get("body", "") for f in features)
    cut = " ".join(f.get("cut", "") for f in features)
    turn = source.choice(["[0, 0, 0]", "[0, 0, 0]", "[0, 0, 30]", "[20, 10, 0]"])
    return (f"// {body.kind}\n$fn = {source.choice([24, 48, 64])};\n"
            f"rotate({turn}) difference() {{ union() {{ {body.text} {added} }} union() {{ {cut} }} }}\n")


def write_part(seed: int, folder: str) -> str:
    path = os.path.join(folder, f"{seed}.scad")
    with open(path, "w", encoding="utf-8") as file:
        file.write(make_part(seed))
    return path


def mesh(program: str, path: str, folder: str, options: List[str]) -> Optional[Result]:
    command = [program, path, "-o", os.path.join(folder, "mesh.vtu"), "--quality", "--json", *options]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return None
    if run.returncode != 0:
        say(run.stderr.strip())
        return None
    report = json.loads(run.stdout)
    return Result(min(v for v in report["min_scaled_jacobian"].values() if v is not None),
                  sum(report["elements"].values()), report["merged_nodes"], report["dropped_features"],
                  report["hinge_edges"] + report["hinge_nodes"], "warning" in run.stderr, sum(stage["cpu_seconds"] for stage in report["stages"]),
                  report["quality"]["worst"][0]["cause"])


def tabulate(program: str, paths: List[str], folder: str, level: str) -> int:
    """Meshes models and prints a line for each; the exit code."""
    results: List[Result] = []
    width = max(20, *(len(os.path.basename(path)) for path in paths))
    print(f"{'model':>{width}} {'worst':>9} {'elements':>9} {'merged':>7} {'dropped':>7} {'touching':>8} {'CPU s':>6}"
          "  cause of the worst element")
    for path in paths:
        name = os.path.basename(path)
        result = mesh(program, path, folder, ["--level", level])
        if result is None:
            print(f"{name:>{width}} no mesh", flush=True)
            continue
        results.append(result)
        print(f"{name:>{width}} {result.worst:>9.3g} {result.elements:>9} {result.merged:>7} {result.dropped:>7}"
              f" {result.touching:>8} {result.seconds:>6.1f}  {result.cause}", flush=True)
    print(f"{len(results)} of {len(paths)} meshed; below 0.15: {sum(r.worst < 0.15 for r in results)}, with warnings: "
          f"{sum(r.warned for r in results)}, merged: {sum(r.merged > 0 for r in results)}, dropped features: "
          f"{sum(r.dropped > 0 for r in results)}, touching themselves: {sum(r.touching > 0 for r in results)}; "
          f"{sum(r.elements for r in results)} elements in {sum(r.seconds for r in results):.1f} s of CPU time")
    return 0 if len(results) == len(paths) else 3


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench/parts.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mortise", help=argparse.SUPPRESS, required=True)
    parser.add_argument("files", nargs="*", metavar="FILE", help="models to mesh in place of made-up parts")
    parser.add_argument("--seed", type=int, default=0, help="the first seed (0)")
    parser.add_argument("--count", type=int, default=120, help="number of parts (120)")
    parser.add_argument("--level", default="6", help="level of the meshes (6)")
    parser.add_argument("--write", metavar="SEED", type=int, help="only print the .scad text of one part")
    arguments = parser.parse_args()
    if arguments.write is not None:
        print(make_part(arguments.write), end="")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        seeds = range(arguments.seed, arguments.seed + arguments.count)
        parts = arguments.files or [write_part(seed, folder) for seed in seeds]
        return tabulate(arguments.mortise, parts, folder, arguments.level)


if __name__ == "__main__":
    sys.exit(main())
