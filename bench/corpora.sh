#!/bin/bash
# Meshes every .csg file of the corpora, one after the other, and says what became of each.
#
#   bash bench/corpora.sh [--level N] [--timeout SECONDS] [SET ...]
#
# MORTISE=program (default build/release/mortise), MORTISE_CORPORA=folder (default ../shared/corpora beside the
# checkout). Prints tab-separated lines: set, file, result, seconds, elements, worst scaled Jacobian, slowest
# stage and its seconds, message. Results: valid; refused (model not understood, with the reason); failed
# (no valid mesh, or a crash); timeout. At the end one line a set.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
corpora="${MORTISE_CORPORA:-$root/../shared/corpora}"
program="${MORTISE:-$root/build/release/mortise}"
level=6
limit=60
sets=()
usage() {
    echo "usage: bash bench/corpora.sh [--level N] [--timeout SECONDS] [SET ...]" >&2
    exit 1
}
while [ $# -gt 0 ]; do
    case "$1" in
        --level | --timeout)
            [[ "${2:-}" =~ ^[0-9]+$ ]] || usage
            if [ "$1" = --level ]; then level="$2"; else limit="$2"; fi
            shift 2
            ;;
        -*) usage ;;
        *)
            sets+=("$1")
            shift
            ;;
    esac
done
[ ${#sets[@]} -gt 0 ] || sets=(prusa-i3 openscad-examples openscad-new-format mcad)
[ -x "$program" ] || {
    echo "no program $program; set MORTISE" >&2
    exit 1
}
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# Figures of a report, tab-separated: elements, worst scaled Jacobian, slowest stage, its seconds.
figures() {
    python3 - "$1" <<'PYTHON'
import json, sys
try:
    report = json.load(open(sys.argv[1]))
    times = {entry["stage"]: entry["wall_seconds"] for entry in report["stages"]}
    slowest = max(times, key=times.get)
    worst = min(value for value in report["min_scaled_jacobian"].values() if value is not None)
    print(sum(report["elements"].values()), "%.3g" % worst, slowest, "%.2f" % times[slowest], sep="\t")
except (OSError, ValueError, KeyError):
    print("-\t-\t-\t-")
PYTHON
}

printf 'set\tfile\tresult\tseconds\telements\tworst\tstage\tstage seconds\tmessage\n'
summary=""
for set in "${sets[@]}"; do
    if [ ! -d "$corpora/$set" ]; then
        summary+="$set: skipped, no such folder"$'\n'
        continue
    fi
    declare -A count=([valid]=0 [refused]=0 [failed]=0 [timeout]=0)
    files=0
    while IFS= read -r -d '' file; do
        rm -f "$work"/*
        start="$(date +%s.%N)"
        nice timeout "$limit" "$program" "$file" -o "$work/mesh.vtu" --level "$level" --check \
            --report "$work/report.json" --quiet >"$work/out" 2>"$work/err"
        code=$?
        seconds="$(echo "$(date +%s.%N) $start" | awk '{ printf "%.2f", $1 - $2 }')"
        case $code in
            0) result=valid ;;
            2 | 6) result=refused ;;
            124) result=timeout ;;
            *) result="failed" ;;
        esac
        message=""
        if [ "$result" = refused ] || [ "$result" = failed ]; then
            message="exit $code: $(grep -v '^warning' "$work/err" | tail -n 1 | tr '\t' ' ')"
            message="${message//"$corpora/"/}"
        fi
        count[$result]=$((count[$result] + 1))
        files=$((files + 1))
        printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$set" "${file#"$corpora/$set/"}" "$result" "$seconds" \
            "$(figures "$work/report.json")" "$message"
    done < <(find "$corpora/$set" -name '*.csg' -print0 | sort -z)
    summary+="$set: $files files, ${count[valid]} meshed, ${count[refused]} refused, "
    summary+="${count[failed]} failed, ${count[timeout]} timed out"$'\n'
done
printf '\n%s' "$summary"
