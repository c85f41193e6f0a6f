"""Meshes .geo files and checks regions and interfaces; see geo.sh."""

import argparse
import glob
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from typing import Dict, List, Tuple

import figures
import vtu
from figures import Failure

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SETS = ("netgen-tutorials", "ngsolve-pde", "nmag", "finmag", "mpt-calculator")
TITLES = ("set", "file", "result", "regions", "levels", "elements", "seconds", "cpu seconds", "stage", "worst",
          "volume change", "interface", "closed", "message")


def mesh(mortise: str, path: str, out: str, limit: float, options: List[str]) -> Tuple[int, float, str, Dict]:
    """Exit code (124: out of time), seconds, stderr, report."""
    report = out + ".json"
    for old in (out, report):
        if os.path.exists(old):
            os.remove(old)
    begin = time.monotonic()
    try:
        done = subprocess.run([mortise, path, "-o", out, "--report", report, "--quiet", *options],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return 124, limit, "", {}
    seconds = time.monotonic() - begin
    found: Dict = {}
    if os.path.exists(report):
        with open(report, encoding="utf-8") as file:
            found = json.load(file)
    return done.returncode, seconds, done.stderr.decode(errors="replace"), found


def cpu_seconds() -> float:
    """Of all programs run so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def volume_change(arguments: argparse.Namespace, path: str, folder: str, volumes: List[float]) -> str:
    """Largest difference of a region's volume from a finer mesh's, relative to the region's."""
    if arguments.compare == 0:
        return "-"
    out = os.path.join(folder, "finer.vtu")
    code, _, _, _ = mesh(arguments.mortise, path, out, arguments.timeout,
                         ["--level", str(arguments.compare), "--no-improve"])
    if code != 0:
        return "timeout" if code == 124 else f"exit {code}"
    _, finer, _ = vtu.facet_volumes(out)
    change = 0.0
    for region in range(max(len(volumes), max(finer, default=0))):
        this = volumes[region] if region < len(volumes) else 0.0
        other = finer.get(region + 1, 0.0)
        if this != other:
            change = max(change, abs(this - other) / max(this, other))
    return f"{change:.1e}"


def measure(arguments: argparse.Namespace, path: str, folder: str, row: Dict[str, str]) -> None:
    out = os.path.join(folder, "mesh.vtu")
    before = cpu_seconds()
    code, seconds, errors, report = mesh(arguments.mortise, path, out, arguments.timeout,
                                         ["--check", *arguments.options.split()])
    row["cpu seconds"] = f"{cpu_seconds() - before:.2f}"
    lines = [line.replace("\t", " ") for line in errors.splitlines() if line.strip()]
    row["seconds"] = f"{seconds:.2f}"
    row["result"] = {0: "valid", 2: "refused", 6: "refused", 124: "timeout"}.get(code, "failed")
    if code != 0:
        row["message"] = f"exit {code}: {lines[-1]}" if lines else f"exit {code}"
        return
    times: Dict[str, float] = {}
    for stage in report["stages"]:
        times[stage["stage"]] = times.get(stage["stage"], 0.0) + stage["wall_seconds"]
    slowest = max(times, key=lambda stage: times[stage])
    cells = report.get("cells_by_level", [])
    row["regions"] = str(len(report["regions"]))
    row["levels"] = " ".join(f"{level}:{count}" for level, count in enumerate(cells) if count)
    row["elements"] = str(sum(report["elements"].values()))
    row["stage"] = f"{slowest} {times[slowest]:.2f}"
    row["worst"] = "%.3g" % min(v for v in report["min_scaled_jacobian"].values() if v is not None)
    checked = json.loads(figures.run([arguments.mortise, "check", out, "--json"], 600)[0])
    volumes = checked["region_volume"]
    regions = vtu.measure(out, len(volumes))
    row["interface"] = f"{regions.interface:.6g}"
    closed = max((abs(a - b) / max(a, b) for a, b in zip(volumes, regions.volume) if a != b), default=0.0)
    row["closed"] = f"{closed:.0e}"
    row["volume change"] = volume_change(arguments, path, folder, volumes)
    lines += [f"region {region['name']} is empty" for region in report["regions"] if not region["elements"]]
    row["message"] = "; ".join(lines)
    # Small regions in large boxes lose digits in the sum over facets.
    if closed > 1e-6:
        regions.defects.append("elements and facets give different volumes")
    if regions.defects:
        row["result"] = "failed"
        row["message"] = f"{len(regions.defects)} defects, the first: {regions.defects[0]}"


def find_files(names: List[str], corpora: str) -> List[Tuple[str, str]]:
    """(set, path), and a line for each set that is not there."""
    files = []
    for name in names:
        if name.endswith(".geo"):
            files.append(("files", name))
            continue
        folder = os.path.join(corpora, name)
        if not os.path.isdir(folder):
            figures.say(f"{name}: skipped, no such folder")
            continue
        files += [(name, path) for path in sorted(glob.glob(os.path.join(folder, "**", "*.geo"), recursive=True))]
    return files


def main() -> int:
    parser = argparse.ArgumentParser(prog="geo.sh")
    parser.add_argument("--mortise", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--timeout", type=float, default=60, help="seconds for a mesh (60)")
    parser.add_argument("--compare", type=int, default=7, help="level of the mesh to compare volumes with; 0: none")
    parser.add_argument("--options", default="", help="more options for the mesher, in one word")
    parser.add_argument("names", nargs="*", metavar="SET|FILE.geo")
    arguments = parser.parse_args()
    corpora = os.environ.get("MORTISE_CORPORA", os.path.join(ROOT, "..", "shared", "corpora"))
    counts: Dict[str, Dict[str, int]] = {}
    print("\t".join(TITLES), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, path in find_files(arguments.names or list(SETS), corpora):
            row = {title: "-" for title in TITLES}
            row["set"], row["file"] = name, os.path.basename(path)
            try:
                measure(arguments, path, folder, row)
            except Failure as failure:
                row["result"], row["message"] = "failed", str(failure)
            row["message"] = row["message"].replace(path, os.path.basename(path))
            print("\t".join(row[title] for title in TITLES), flush=True)
            count = counts.setdefault(name, {})
            count[row["result"]] = count.get(row["result"], 0) + 1
    print()
    for name, count in counts.items():
        print(f"{name}: {sum(count.values())} files, " +
              ", ".join(f"{count.get(result, 0)} {result}" for result in ("valid", "refused", "failed", "timeout")))
    return 3 if any(count.get("failed") for count in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
