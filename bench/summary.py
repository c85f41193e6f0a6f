"""What a benchmark run shows, as Markdown: the targets that it tells about, then its tables; run by summary.sh.

Targets are ratios within the run, so that they mean the same on every machine. What the run did not measure is
left out.
"""

import json
import sys
from typing import Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence


class Target(NamedTuple):
    what: str
    wanted: float
    measured: Optional[float]  # None: not in this run
    is_limit: bool = False  # smaller is better
    unit: str = ""


def number(value: float) -> str:
    """Three significant digits, without an exponent."""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{value:,.0f}"
    digits = 1 if abs(value) >= 10 else 2
    while abs(value) < 10 ** (1 - digits) and digits < 9:
        digits += 1
    return f"{value:.{digits}f}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> List[str]:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows] + [""]


def median(measured: dict) -> float:
    return measured["median"]


# Elements/s or nodes/s of Mortise to those of others: at 10^7 elements, at 10^6 half of that.
PEER_TARGETS = (("nodes/s", "nodes_per_second", "Gmsh HXT", 100),
                ("nodes/s", "nodes_per_second", "CGAL Mesh_3, 2", 100),
                ("nodes/s", "nodes_per_second", "Netgen", 2000),
                ("nodes/s", "nodes_per_second", "Quartet", 20),
                ("elements/s", "elements_per_second", "Gmsh HXT", 30),
                ("elements/s", "elements_per_second", "CGAL Mesh_3, 2", 20),
                ("elements/s", "elements_per_second", "Quartet", 5),
                ("tetrahedra/s", "tetrahedra_per_second", "Quartet", 10))


def peer_targets(run: dict) -> List[Target]:
    targets = []
    for model in run.get("peers", {}).get("models", []):
        for size, share in (("10,000,000", 1.0), ("1,000,000", 0.5)):
            for what, field, peer, wanted in PEER_TARGETS:
                ratios = [(ratio["peer"], ratio[field]) for ratio in model["ratios"]
                          if ratio["peer"].startswith(peer) and ratio["mesh"].startswith(size) and field in ratio]
                targets += [Target(f"{model['model']}, {size} elements: {what} to {name}", wanted * share, ratio)
                            for name, ratio in ratios]
    return targets


def find(items: Iterable[dict], **wanted: object) -> Optional[dict]:
    return next((item for item in items if all(item.get(key) == value for key, value in wanted.items())), None)


def mesh_targets(run: dict) -> List[Target]:
    section = run.get("mesh", {})
    cases = section.get("cases", [])
    targets = []
    sphere = find(cases, model="sphere", level=8)
    if sphere and "copy" in run:
        share = sphere["geometry_bytes_per_second"] / run["copy"]["bytes_per_second"]
        targets.append(Target("level-8 sphere: mesh made, of the copy bandwidth", 5, 100 * share, unit=" %"))
    for model, exponent in section.get("growth_exponents", {}).items():
        targets.append(Target(f"{model}: exponent of time in elements", 1.05, exponent, is_limit=True))
    for case in cases:
        grown = case["peak_bytes"] - case["idle_bytes"]
        name = f"{case['model']}, level {case['level']}"
        if case["model"] == "lattice" and sphere:
            share = case["elements_per_second"] / sphere["elements_per_second"]
            targets.append(Target(f"{name}: elements/s, of the level-8 sphere's", 10, 100 * share, unit=" %"))
            continue
        targets.append(Target(f"{name}: peak memory to the mesh", 2, grown / case["mesh_bytes"], is_limit=True))
        targets.append(Target(f"{name}: peak memory, bytes an element", 150, grown / case["elements"], is_limit=True))
    return targets


def other_targets(run: dict) -> List[Target]:
    targets = []
    octree = run.get("octree", [])
    cost = {case["model"]: case.get("cell_cost_to_random_30") for case in octree}
    thirty = find(octree, model="random:30")
    if thirty:
        targets.append(Target("descent, 30 primitives: to the scalar reference", 8, thirty["kernels_to_reference"]))
    targets.append(Target("descent, 300 primitives: cost of a cell to that at 30", 2, cost.get("random:300"), True))
    targets.append(Target("descent, 3,000 primitives: the same", 4, cost.get("random:3000"), True))
    most = max((case["tree_bytes_per_undecided_cell"] for case in octree if "cells" in case), default=None)
    targets.append(Target("descent: bytes of the tree by undecided cell", 40, most, True))
    for one in run.get("threads", []):
        targets.append(Target(f"{one['all_threads']['model']}: two threads to one", 1.7, one["speedup"]))
    for one in run.get("stages", []):
        plain = one["files"]["plain_arrays"]["share_of_plain_rate"]
        targets.append(Target(f"{one['model']}: .vtu with plain arrays, of a plain write", 70, 100 * plain, unit=" %"))
    command = run.get("command", {})
    if "cold_seconds" in command:
        targets.append(Target("bracket of 100,000 elements: the whole command, warm", 0.25,
                              median(command["seconds"]), True, " s"))
        targets.append(Target("cold, with the kernels that came with the program", 4,
                              median(command["cold_with_compiled_kernels_seconds"]), True, " s"))
        targets.append(Target("cold, compiling them", 4, median(command["cold_seconds"]), True, " s"))
    batch = run.get("batch", {})
    targets.append(Target("random brackets: models a minute", 4000, batch.get("models_per_minute")))
    return targets


def show_targets(run: dict) -> List[str]:
    targets = [t for t in peer_targets(run) + mesh_targets(run) + other_targets(run) if t.measured is not None]
    rows = []
    for t in targets:
        met = t.measured <= t.wanted if t.is_limit else t.measured >= t.wanted
        sign = "≤" if t.is_limit else "≥"
        rows.append((t.what, f"{sign} {t.wanted:,g}{t.unit}", f"{number(t.measured)}{t.unit}",
                     "yes" if met else "**no**"))
    return table(("target", "wanted", "measured", "met"), rows)


def show_peers(run: dict) -> List[str]:
    lines = []
    for model in run.get("peers", {}).get("models", []):
        target = model["rows"][0]["mean_edge"]
        rows = [(row["name"], number(row["elements"]), number(row["nodes"]), number(row["mean_edge"] / target),
                 number(median(row["seconds"])), f"{100 * row['spread']:.0f} %",
                 number(1e-3 * row["elements_per_second"]), number(1e-3 * row["nodes_per_second"]))
                for row in model["rows"]]
        lines += table((model["model"], "elements", "nodes", "edge to target", "time, s", "spread", "1,000 elements/s",
                        "1,000 nodes/s"), rows)
    return lines


def show_mesh(run: dict) -> List[str]:
    rows = []
    for case in run.get("mesh", {}).get("cases", []):
        grown = case["peak_bytes"] - case["idle_bytes"]
        rows.append((f"{case['model']}, {case['level']}", number(case["elements"]), number(median(case["seconds"])),
                     f"{100 * case['spread']:.0f} %", number(case["first_seconds"]),
                     number(1e-6 * case["elements_per_second"]), number(grown / case["elements"])))
    head = ("model, level", "elements", "time, s", "spread", "first, s", "million elements/s", "peak, bytes/element")
    return table(head, rows) if rows else []


def show_stages(run: dict) -> List[str]:
    sections = run.get("stages", [])
    if not sections:
        return []
    head = ["stage"]
    for one in sections:
        head += [f"{one['model']}, {one['level']}: ms", "MB moved", "of copy bandwidth"]
    rows = []
    for stages in zip(*(one["stages"] for one in sections)):
        row = [stages[0]["stage"]]
        for stage in stages:
            share = stage.get("share_of_copy_bandwidth")
            row += [number(1e3 * median(stage["seconds"])), number(1e-6 * stage["bytes"]),
                    "" if share is None else f"{100 * share:.1f} %"]
        rows.append(row)
    return table(head, rows)


def show_octree(run: dict) -> List[str]:
    rows = [(f"{case['model']}, level {case['level']}", number(case["cells"]),
             number(1e-6 * case["kernel_cells_per_second_per_core"]), number(case["kernels_to_reference"]),
             number(case["all_threads_to_reference"])) for case in run.get("octree", []) if "cells" in case]
    head = ("descent", "cells", "million cells/s, one core", "to the scalar reference", "all threads to it")
    return table(head, rows) if rows else []


def show_load(run: dict) -> List[str]:
    busy = [name for name, load in run.get("load", {}).items()
            if load.get("others_share", 0) + load.get("stolen_share", 0) > 0.1]
    return [f"Others used more than a tenth of the machine during: {', '.join(busy)}.", ""] if busy else []


def main() -> int:
    path = sys.argv[1]
    try:
        with open(path, encoding="utf-8") as file:
            run = json.load(file)
    except (OSError, ValueError) as error:
        print(f"summary: cannot read '{path}': {error}; expected a file of bench/run.sh --json", file=sys.stderr)
        return 2
    if not isinstance(run, dict) or run.get("format") != "mortise-bench 1":
        print(f"summary: '{path}' is no file of bench/run.sh --json: its format is not mortise-bench 1",
              file=sys.stderr)
        return 2
    machine = run["machine"]
    print(f"{machine['processor']}, {machine['cores']} cores, {1e-9 * machine['memory_bytes']:.0f} GB; "
          f"medians of {run['repeats']} runs.\n")
    parts: Dict[str, Callable[[dict], List[str]]] = {
        "Targets": show_targets, "Beside other meshers": show_peers, "In memory": show_mesh, "Stages": show_stages,
        "Descent": show_octree}
    print("\n".join(show_load(run)), end="")
    for title, show in parts.items():
        lines = show(run)
        if lines:
            print("\n".join([f"## {title}", ""] + lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
