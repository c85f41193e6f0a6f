"""Meshes all corpora and tells what became of each file; see table.sh."""

import argparse
import hashlib
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Dict, List, Tuple

import figures

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FORMATS = ("csg", "geo", "stl", "obj", "off", "vm", "frep", "formula")
# Of files that describe no bounded solid, or not all of it: what the message says, and what to call it.
NO_SOLID = (
    (r"2D shapes only|function of x and y|does not depend on z|names no z", "2D only"),
    (r"cannot be read: No such file|there is no file", "a file that it names is missing"),
    (r"holds no solid|solid is empty|there is no solid|no 'tlo'|defines no|the file is empty", "no solid in it"),
    (r"first word of a Netgen geometry|the solid '.*' is not defined", "part of a model only"),
    (r"infinite|not bounded|unbounded|--box", "infinite"),
)
# Of solids that are refused.
REASONS = (
    (r"singular", "a matrix that flattens the solid"),
    (r"\bnan\b|\binf\b|is 0; expected|is -[0-9.]+; expected", "a size that is zero, negative or not finite"),
    (r"not supported", "something not supported"),
    (r"unknown node|unknown word|has no argument|expected", "not understood"),
)


def digest(path: str) -> str:
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:16]


def last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("warning")]
    return lines[-1] if lines else ""


def run(words: List[str], limit: float) -> Tuple[int, str, str]:
    """Exit code (124: out of time), stdout, stderr."""
    try:
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return 124, "", ""
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def mesh(arguments: argparse.Namespace, path: str) -> Dict:
    """One file: result (valid, refused, failed, timeout), seconds, message, elements, worst."""
    row: Dict = {"result": "failed", "message": ""}
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "mesh.vtu")
        begin = time.monotonic()
        code, _, errors = run([arguments.mortise, path, "-o", out, "--level", str(arguments.level), "--quiet"],
                              arguments.timeout)
        row["seconds"] = round(time.monotonic() - begin, 2)
        if code != 0:
            row["result"] = {2: "refused", 6: "refused", 124: "timeout"}.get(code, "failed")
            message = last_line(errors).replace("mortise: ", "", 1)
            if not message and code != 124:
                message = f"exit code {code}"
            # The place stays, the folders go.
            row["message"] = message.replace(path, os.path.basename(path)).replace(arguments.corpora + os.sep, "")
            return row
        code, text, errors = run([arguments.mortise, "check", out, "--json"], 600)
        try:
            report = json.loads(text)
        except ValueError:
            row["message"] = last_line(errors) or f"check: exit code {code}"
            return row
        row["elements"] = sum(report["elements"].values())
        row["worst"] = min(v for v in report["min_scaled_jacobian"].values() if v is not None)
        if report["valid"]:
            row["result"] = "valid"
        else:
            row["message"] = "check: " + "; ".join(f"{defect['what']}, {defect['count']} of them, the first: "
                                                   f"{defect['first']}" for defect in report["defects"])
    return row


def group_of(row: Dict) -> Tuple[bool, str]:
    """Whether a refused file describes a bounded solid, and the reason in few words."""
    for pattern, name in NO_SOLID:
        if re.search(pattern, row["message"]):
            return False, name
    for pattern, name in REASONS:
        if re.search(pattern, row["message"]):
            return True, name
    return True, "something else"


def find_files(corpora: str, names: List[str]) -> List[Tuple[str, str]]:
    files = []
    for name in names or sorted(os.listdir(corpora)):
        for folder, _, children in sorted(os.walk(os.path.join(corpora, name))):
            for child in sorted(children):
                # A .geo of triangles' own format or a drawing is told by its reader.
                if child.rsplit(".", 1)[-1].lower() in FORMATS:
                    path = os.path.join(folder, child)
                    files.append((name, os.path.relpath(path, os.path.join(corpora, name))))
    return files


def run_all(arguments: argparse.Namespace, files: List[Tuple[str, str]]) -> Dict[Tuple[str, str], Dict]:
    """Results by file; those that are there already are not made again."""
    run_key = f"{digest(arguments.mortise)} {arguments.level} {arguments.timeout:g}"
    known: Dict[Tuple[str, str], Dict] = {}
    if os.path.exists(arguments.results) and not arguments.fresh:
        with open(arguments.results, encoding="utf-8") as file:
            for line in file:
                try:
                    row = json.loads(line)
                except ValueError:  # the last line of a run that was ended
                    continue
                if row["run"] != run_key:
                    continue
                known.pop((row["set"], row["file"]), None)
                if not (arguments.again and row["result"] == "timeout"):
                    known[row["set"], row["file"]] = row
    os.makedirs(os.path.dirname(os.path.abspath(arguments.results)), exist_ok=True)
    open_files = [entry for entry in files if entry not in known]
    figures.say(f"{len(files)} files, {len(files) - len(open_files)} of them done")
    with open(arguments.results, "w" if arguments.fresh else "a", encoding="utf-8") as out:
        def one(entry: Tuple[str, str]) -> None:
            row = mesh(arguments, os.path.join(arguments.corpora, *entry))
            row.update({"run": run_key, "set": entry[0], "file": entry[1]})
            known[entry] = row
            out.write(json.dumps(row) + "\n")
            out.flush()
            figures.say(f"{len(known)}/{len(files)} {entry[0]}/{entry[1]}: {row['result']} {row['message']}")

        with ThreadPoolExecutor(arguments.jobs) as pool:
            list(pool.map(one, open_files))
    return known


def share(part: int, whole: int) -> str:
    return f"{part} of {whole}" + (f" ({100 * part / whole:.0f} %)" if whole else "")


def table_row(name: str, rows: List[Dict]) -> str:
    refused = [row for row in rows if row["result"] == "refused"]
    solids = len(rows) - sum(1 for row in refused if not group_of(row)[0])
    valid = [row for row in rows if row["result"] == "valid"]
    counts = [sum(1 for row in rows if row["result"] == result) for result in ("timeout", "failed")]
    worst = sorted(row["worst"] for row in valid)
    ending = (f"{worst[0]:.2g} | {statistics.median(worst):.2g} | {sum(1 for w in worst if w >= 0.1)}"
              if worst else "- | - | -")
    return (f"| {name} | {len(rows)} | {solids} | {share(len(valid), solids)} | "
            f"{len(refused) - (len(rows) - solids)} | {counts[0]} | {counts[1]} | {ending} |")


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def document(arguments: argparse.Namespace, results: Dict[Tuple[str, str], Dict]) -> str:
    sets: Dict[str, List[Dict]] = {}
    for key in sorted(results):
        sets.setdefault(key[0], []).append(results[key])
    everything = [row for rows in sets.values() for row in rows]
    lines = [
        "# Models of others",
        "",
        f"Made by `bash bench/table.sh`: every model of the corpora at level {arguments.level}, other options as "
        f"they are, {arguments.timeout:g} s for each; every mesh is read back and validated by `mortise check`. "
        "The models are not part of this repository.",
        "",
        "*Solids* are the files that describe a bounded solid: all but those refused because they are 2D, hold "
        "no solid, are infinite, are part of a model only, or name a file that is missing. *Worst* is the smallest scaled Jacobian of a "
        "mesh: the smallest of the set, the median, and the number of meshes that have 0.1 or more.",
        "",
        "| set | files | solids | meshed, valid | refused | out of time | failed | worst | median | ≥ 0.1 |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [table_row(name, rows) for name, rows in sets.items()]
    lines += [table_row("**all**", everything), "", "## Files that were not meshed", ""]
    groups: Dict[Tuple[int, str], List[Dict]] = {}
    for row in everything:
        if row["result"] == "valid":
            continue
        if row["result"] == "refused":
            solid, reason = group_of(row)
            key = (1, f"Refused: {reason}") if solid else (2, f"No bounded solid: {reason}")
        else:
            key = (0, "Out of time" if row["result"] == "timeout" else "Failed")
        groups.setdefault(key, []).append(row)
    for (_, title), rows in sorted(groups.items()):
        lines += [f"### {title}: {len(rows)}", ""]
        for row in rows:
            message = row["message"] or f"more than {arguments.timeout:g} s"
            name = os.path.basename(row["file"])
            # The file is named already; a place in it stays.
            message = message[len(name):].lstrip(":").strip() if message.startswith(name + ":") else message
            lines.append(f"- {row['set']}/{row['file']}: {cell(message)}")
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="table.sh")
    parser.add_argument("--mortise", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--level", type=int, default=6)
    parser.add_argument("--timeout", type=float, default=120, help="seconds for a mesh (120)")
    parser.add_argument("--jobs", type=int, default=1, help="models at a time (1)")
    parser.add_argument("--output", default=os.path.join(ROOT, "docs", "corpora.md"))
    parser.add_argument("--results", default=os.path.join(ROOT, "build", "corpora.jsonl"))
    parser.add_argument("--again", action="store_true", help="try models again that ran out of time")
    parser.add_argument("--fresh", action="store_true", help="forget earlier results")
    parser.add_argument("names", nargs="*", metavar="SET")
    arguments = parser.parse_args()
    arguments.corpora = os.path.abspath(
        os.environ.get("MORTISE_CORPORA", os.path.join(ROOT, "..", "shared", "corpora")))
    if not os.path.isdir(arguments.corpora):
        figures.say(f"no folder {arguments.corpora}; set MORTISE_CORPORA")
        return 6
    files = find_files(arguments.corpora, arguments.names)
    known = run_all(arguments, files)
    results = {entry: known[entry] for entry in files}
    with open(arguments.output, "w", encoding="utf-8") as out:
        out.write(document(arguments, results))
    figures.say(f"written: {arguments.output}")
    return 3 if any(row["result"] == "failed" for row in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
