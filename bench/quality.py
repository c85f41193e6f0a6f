"""Quality of Mortise's meshes beside Gmsh's and Netgen's at equal element size; run by quality.sh.

Equal size: Mortise meshes a model at a level of its octree, as tetrahedra; the mean edge length of that mesh is
the target. The size given to another mesher is corrected, by the mean edge length that it made of it, until
that is within 2 % of the target. The hybrid mesh has the same cells as the tetrahedral one.
"""

import argparse
import json
import math
import os
import statistics
import sys
import tempfile
from typing import Callable, List, NamedTuple, Tuple

import figures
from figures import Failure, Figures, say

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = {"sphere": 5, "bracket": 5, "cube_minus_cylinder": 4, "cube_minus_sphere": 4, "cylinders": 5,
          "shaft": 6}  # with their levels
# The first tells the mean edge length of the others.
MORTISE = [("Mortise, tetrahedra", ["--elements", "tet"]),
           ("Mortise, tetrahedra from 28 degrees", ["--elements", "tet", "--min-angle", "28"]),
           ("Mortise, tetrahedra from 40 degrees", ["--elements", "tet", "--min-angle", "40"]),
           ("Mortise, tetrahedra from 44 degrees", ["--elements", "tet", "--min-angle", "44"]),
           ("Mortise, hybrid", []), ("Mortise, hybrid from 28 degrees", ["--min-angle", "28"])]
LIMIT = 900.0  # seconds for one run of one program
TOLERANCE = 0.02  # of the mean edge length
ROUNDS = 10


class Result(NamedTuple):
    mesher: str
    figures: Figures
    edge: float
    seconds: float


# Makes a mesh file with elements of about the given size and returns the seconds that the program ran.
Mesher = Callable[[str, float, str], float]


class Programs:
    def __init__(self, options: argparse.Namespace, folder: str) -> None:
        self.options = options
        self.folder = folder

    def mortise(self, model: str, level: int, mesh_options: List[str], path: str) -> Tuple[float, float]:
        """Cell size and seconds. The bracket is meshed from the project's own asset."""
        asset = os.path.join(HERE, "..", "assets", "models", model + ".csg")
        source = asset if os.path.exists(asset) else os.path.join(HERE, "models", model + ".geo")
        threads = str(self.options.threads)
        text, seconds = figures.run(
            [self.options.mortise, source, "-o", path, "--level", str(level), *mesh_options,
             "--threads", threads, "--json", *self.options.mortise_option],
            LIMIT, figures.limit_cores(self.options.threads))
        return json.loads(text)["cell_size"], seconds

    def gmsh(self, algorithm: int, optimise_netgen: bool) -> Mesher:
        def mesh(model: str, size: float, path: str) -> float:
            arguments = ["gmsh", "-3", os.path.join(HERE, "models", "gmsh", model + ".geo"), "-o", path,
                         "-format", "msh22", "-v", "1", "-nt", str(self.options.threads),
                         "-clmin", repr(size), "-clmax", repr(size),
                         "-setnumber", "Mesh.Algorithm3D", str(algorithm),
                         "-setnumber", "Mesh.Optimize", "1",
                         "-setnumber", "Mesh.OptimizeNetgen", "1" if optimise_netgen else "0"]
            return figures.run(arguments, LIMIT, folder=self.folder)[1]
        return mesh

    def netgen(self) -> Mesher:
        def mesh(model: str, size: float, path: str) -> float:
            arguments = [self.options.python_netgen, os.path.join(HERE, "netgen_mesh.py"),
                         os.path.join(HERE, "models", model + ".geo"), repr(size), path]
            return figures.run(arguments, LIMIT, folder=self.folder)[1]
        return mesh


def find_peers(programs: Programs) -> List[Tuple[str, Mesher]]:
    """The other meshers that are installed; a line for each that is not."""
    peers: List[Tuple[str, Mesher]] = []
    try:
        # Gmsh prints its build options on stderr.
        text, _ = figures.run(["sh", "-c", "gmsh -info 2>&1"], 60)
        options = next((line for line in text.splitlines() if line.startswith("Build options")), "").split()
        netgen_inside = "Netgen" in options
        if not netgen_inside:
            say("this Gmsh is built without Netgen's optimiser (Debian's is): only Gmsh's own is used")
        if "OpenCASCADE" in options:
            name = "Gmsh Delaunay, optimised" + (" (+ Netgen)" if netgen_inside else "")
            peers.append((name, programs.gmsh(1, netgen_inside)))
            if "Hxt" in options:
                peers.append(("Gmsh HXT, optimised", programs.gmsh(10, False)))
            else:
                say("this Gmsh has no HXT: left out")
        else:
            say("this Gmsh has no OpenCASCADE, so no solids: left out")
    except Failure:
        say("no gmsh (Debian: gmsh): left out")
    try:
        figures.run([programs.options.python_netgen, "-c", "import netgen.csg"], 60)
        peers.append(("Netgen", programs.netgen()))
    except Failure:
        say("no Netgen for Python (Debian: python3-netgen): left out")
    return peers


def measure_peer(name: str, mesher: Mesher, model: str, target: float, programs: Programs) -> Result:
    """Finds the size that makes the mean edge length equal the target, then repeats that run.

    Not every mesher repeats itself (HXT does not, even with one thread): the best mesh of the runs is shown.
    """
    path = os.path.join(programs.folder, "peer.msh")
    size = target
    tried: List[Tuple[float, float]] = []  # size, mean edge length
    for _ in range(ROUNDS):
        mesher(model, size, path)
        tried.append((size, figures.mean_edge_length(path)))
        if abs(tried[-1][1] - target) <= TOLERANCE * target:
            break
        below = max((row[0] for row in tried if row[1] < target), default=0.0)
        above = min((row[0] for row in tried if row[1] > target), default=math.inf)
        size *= target / tried[-1][1]
        if not below < size < above and 0 < below < above < math.inf:  # meshes depend on sizes in steps
            size = 0.5 * (below + above)
    best = min(tried, key=lambda row: abs(row[1] - target))
    runs = []
    for _ in range(programs.options.runs):
        seconds = mesher(model, best[0], path)
        runs.append(Result(name, figures.check(programs.options.mortise, path), figures.mean_edge_length(path),
                           seconds))
    shown = max(runs, key=lambda result: result.figures.low)
    return shown._replace(seconds=statistics.median(result.seconds for result in runs))


def measure_model(model: str, peers: List[Tuple[str, Mesher]], programs: Programs) -> List[Result]:
    level = MODELS[model] + programs.options.finer
    path = os.path.join(programs.folder, "mortise.msh")
    results = []
    for name, mesh_options in MORTISE:
        say(f"{model}: {name}, level {level}")
        times = [programs.mortise(model, level, mesh_options, path) for _ in range(programs.options.runs)]
        results.append(Result(name, figures.check(programs.options.mortise, path),
                              figures.mean_edge_length(path), statistics.median(time for _, time in times)))
    cell = times[0][0]
    target = results[0].edge
    for name, mesher in peers:
        say(f"{model}: {name}")
        try:
            results.append(measure_peer(name, mesher, model, target, programs))
        except (Failure, ValueError, KeyError) as failure:
            say(f"{model}: {name} made no mesh: {failure}")
    for result in results:
        # The same solid was written down three times; this would show a slip.
        if abs(result.figures.volume - results[0].figures.volume) > 0.02 * results[0].figures.volume:
            say(f"warning: {model}: {result.mesher} has volume {result.figures.volume:.6g}, "
                f"Mortise {results[0].figures.volume:.6g}")
    print(f"\n{model}: cell size {cell:.4g} (level {level}), mean edge length to match {target:.4g}")
    rows = [["mesher", "valid", "elements", "nodes", "mean edge", "seconds", "min", "1 %", "99 %", "max",
             "scaled Jacobian"]]
    for name, f, edge, seconds in results:
        rows.append([name, "yes" if f.valid else "NO", str(f.elements), str(f.nodes), f"{edge:.4f}",
                     f"{seconds:.2f}", f"{f.low:.2f}", f"{f.low_percentile:.2f}", f"{f.high_percentile:.2f}",
                     f"{f.high:.2f}", f"{f.scaled_jacobian:.3f}"])
    figures.print_table(rows)
    for result in results:
        if abs(result.edge - target) > TOLERANCE * target and not result.mesher.startswith("Mortise"):
            print(f"  {result.mesher}: no size gave a mean edge length closer to that "
                  f"({result.edge / target - 1:+.0%})")
    return results


def compare(model: str, results: List[Result]) -> List[List[str]]:
    """A row for each of Mortise's meshes: its angles, each with the peers that have a better one."""
    peers = [result for result in results if not result.mesher.startswith("Mortise")]
    rows = []
    for result in results:
        if result in peers:
            continue
        row = [model, result.mesher.split(", ")[1]]
        for figure, sign in (("low", 1), ("low_percentile", 1), ("high_percentile", -1), ("high", -1)):
            value = getattr(result.figures, figure)
            better = [peer.mesher.split(",")[0].replace("Gmsh ", "") for peer in peers
                      if sign * getattr(peer.figures, figure) > sign * value]
            row.append(f"{value:.1f}" + (f" ({', '.join(better)})" if better else ""))
        rows.append(row)
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench/quality.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", metavar="MODEL",
                        help="of " + ", ".join(MODELS) + "; all by default")
    parser.add_argument("--mortise", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--python-netgen", default="/usr/bin/python3", help=argparse.SUPPRESS)
    parser.add_argument("--runs", type=int, default=3,
                        help="times are medians of so many runs, other meshers' figures their best (3)")
    parser.add_argument("--threads", type=int, default=1,
                        help="threads of each program (1; with more, HXT's meshes may have cracks)")
    parser.add_argument("--finer", type=int, default=0, help="levels to add to every model's own (0)")
    parser.add_argument("--mortise-option", action="append", default=[], metavar="OPTION",
                        help="handed to Mortise, as in --mortise-option=--no-templates; may be repeated")
    parser.add_argument("--json", metavar="FILE", help="writes all figures")
    options = parser.parse_args()
    unknown = [model for model in options.models if model not in MODELS]
    if unknown or options.runs < 1 or options.threads < 1:
        parser.error(f"unknown model '{unknown[0]}'" if unknown else "--runs and --threads begin at 1")
    with tempfile.TemporaryDirectory() as folder:
        programs = Programs(options, folder)
        peers = find_peers(programs)
        print("Dihedral angles in degrees, over all angles of all elements; all figures by `mortise check`.\n"
              f"Seconds: whole process with its output file, median of {options.runs} runs, {options.threads} "
              "thread(s) each; rough, if\nother work runs on the machine. Others: the run with the largest "
              "smallest angle, at the mean edge\nlength of Mortise's tetrahedra.", flush=True)
        everything = {}
        verdicts = [["model", "mesh", "min", "1 %", "99 %", "max"]]
        try:
            for model in options.models or MODELS:
                results = measure_model(model, peers, programs)
                verdicts += compare(model, results) if peers else []
                everything[model] = [{"mesher": r.mesher, "mean_edge": r.edge, "seconds": r.seconds,
                                      **r.figures._asdict()} for r in results]
        except Failure as failure:
            say(f"Mortise failed: {failure}")
            return 3
        if peers:
            print("\nMortise against the others; in brackets: who is better")
            figures.print_table(verdicts, len(verdicts[0]))
        if options.json:
            with open(options.json, "w", encoding="utf-8") as file:
                json.dump(everything, file, indent=1)
    return 0


sys.exit(main())
