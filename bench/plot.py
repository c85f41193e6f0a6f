"""Draws the figures of a benchmark run; run by plot.sh.

One panel for each part of the run that there is: rates beside other meshers for each model, time by number of
elements, share of the copy bandwidth by stage, cost of a cell of the descent.
"""

import json
import sys
from typing import Callable, List

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

Panel = Callable[["pyplot.Axes"], None]
MARKS = "os^Dv"


def peers_panel(model: dict) -> Panel:
    def draw(axes: "pyplot.Axes") -> None:
        rows = model["rows"][::-1]
        places = range(len(rows))
        for offset, field, label, colour in ((0.2, "nodes_per_second", "nodes/s", "tab:blue"),
                                             (-0.2, "elements_per_second", "elements/s", "tab:orange")):
            counts = "nodes" if field.startswith("nodes") else "elements"
            rates = [row[field] for row in rows]
            slowest = [row[field] - row[counts] / row["seconds"]["high"] for row in rows]
            fastest = [row[counts] / row["seconds"]["low"] - row[field] for row in rows]
            axes.barh([place + offset for place in places], rates, 0.38, label=label, color=colour,
                      xerr=(slowest, fastest), error_kw={"elinewidth": 1})
        axes.set_yticks(list(places), [row["name"] for row in rows], fontsize=8)
        axes.set_xscale("log")
        axes.legend(fontsize=8)
        axes.set_title(f"{model['model']}: edge length of Mortise's level {model['level']}")
    return draw


def growth_panel(section: dict) -> Panel:
    def draw(axes: "pyplot.Axes") -> None:
        models: dict = {}
        for case in section["cases"]:
            models.setdefault(case["model"], []).append((case["elements"], case["seconds"]["median"]))
        for mark, (model, points) in zip(MARKS, models.items()):
            exponent = section["growth_exponents"].get(model)
            label = model if exponent is None else f"{model}: elements^{exponent:.2f}"
            axes.plot(*zip(*points), marker=mark, label=label)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("elements")
        axes.set_ylabel("seconds")
        axes.legend(fontsize=8)
        axes.set_title("End to end in memory")
    return draw


def stages_panel(section: List[dict]) -> Panel:
    def draw(axes: "pyplot.Axes") -> None:
        names = [stage["stage"] for stage in section[0]["stages"]]
        height = 0.8 / len(section)
        for i, measured in enumerate(section):
            shares = [100 * stage.get("share_of_copy_bandwidth", 0) for stage in measured["stages"]]
            axes.barh([place + i * height for place in range(len(names))], shares[::-1], height,
                      label=f"{measured['model']}, level {measured['level']}")
        axes.set_yticks([place + 0.5 * height * (len(section) - 1) for place in range(len(names))], names[::-1],
                        fontsize=8)
        axes.set_xscale("log")
        axes.set_xlabel("% of the copy bandwidth")
        axes.legend(fontsize=8)
        axes.set_title("Bytes moved by stage")
    return draw


def octree_panel(section: List[dict]) -> Panel:
    def draw(axes: "pyplot.Axes") -> None:
        done = [row for row in section if "failed" not in row]
        names = [f"{row['model']}, {row['level']}" for row in done]
        kernels = [row["kernel_cells_per_second_per_core"] for row in done]
        reference = [row["reference_cells_per_second"] for row in done]
        places = range(len(names))
        axes.bar([place - 0.2 for place in places], kernels, 0.38, label="kernels")
        axes.bar([place + 0.2 for place in places], reference, 0.38, label="scalar reference")
        axes.set_xticks(list(places), names, fontsize=8)
        axes.set_yscale("log")
        axes.set_ylabel("cells/s on one core")
        axes.legend(fontsize=8)
        axes.set_title("Descent")
    return draw


def panels_of(report: dict) -> List[Panel]:
    panels = [peers_panel(model) for model in report.get("peers", {}).get("models", [])]
    if "mesh" in report:
        panels.append(growth_panel(report["mesh"]))
    if "stages" in report:
        panels.append(stages_panel(report["stages"]))
    if "octree" in report:
        panels.append(octree_panel(report["octree"]))
    return panels


def main() -> int:
    source, target = sys.argv[1:]
    try:
        with open(source, encoding="utf-8") as file:
            report = json.load(file)
        if report.get("format") != "mortise-bench 1":
            raise ValueError("not a file of bench/run.sh --json")
        panels = panels_of(report)
        if not panels:
            raise ValueError("none of the sections peers, mesh, stages, octree are in it")
        rows = (len(panels) + 1) // 2
        figure, grid = pyplot.subplots(rows, 2, figsize=(13, 4.2 * rows), squeeze=False)
        for axes, panel in zip(grid.flat, panels):
            panel(axes)
        for axes in grid.flat[len(panels):]:
            axes.axis("off")
        figure.tight_layout()
        figure.savefig(target, dpi=120)
    except (OSError, ValueError, KeyError, AttributeError) as error:
        print(f"plot: {source} to {target}: {error}", file=sys.stderr)
        return 2
    return 0


sys.exit(main())
