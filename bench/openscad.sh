#!/bin/bash
# Volumes of models beside OpenSCAD's own (Debian: openscad), an independent reader and kernel:
#
#     bash bench/openscad.sh [--level N] [--count N] [--seed N] [--facets exact|smooth] [FOLDER...]
#
# Takes .csg and .scad files of the folders (default: the corpora, MORTISE_CORPORA) in an order that follows from their names
# and the seed (default 1), until COUNT (default 40) could be compared, and prints per file: OpenSCAD's volume,
# Mortise's, their difference in percent. Files that one of the two cannot do are listed with the reason and do not
# count. Ends with the number of models within 1 %.
# MORTISE names the program (default: build/release/mortise), MORTISE_OPTIONS more options of it (--no-improve is
# faster), MORTISE_LIMIT the longest time for each of the two (default 120 s).
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
level=6 count=40 seed=1 facets=exact
limit="${MORTISE_LIMIT:-120}" options=(${MORTISE_OPTIONS:-})
while [ $# -gt 0 ]; do
    case "$1" in
    --level) level="$2" && shift 2 ;;
    --count) count="$2" && shift 2 ;;
    --seed) seed="$2" && shift 2 ;;
    --facets) facets="$2" && shift 2 ;;
    --help | -h) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" && exit 0 ;;
    -*) echo "openscad.sh: unknown option $1; see --help" >&2 && exit 1 ;;
    *) break ;;
    esac
done
corpora="${MORTISE_CORPORA:-$root/../shared/corpora}"
[ $# -gt 0 ] || set -- "$corpora/prusa-i3" "$corpora/openscad-examples" "$corpora/openscad-new-format" "$corpora/mcad"
program="${MORTISE:-$root/build/release/mortise}"
command -v openscad >/dev/null || { echo "openscad.sh: install Debian's package openscad" >&2; exit 1; }
[ -x "$program" ] || { echo "openscad.sh: $program does not exist; build it, or set MORTISE" >&2; exit 1; }
scratch="$(mktemp -d)" || exit 1
trap 'rm -rf "$scratch"' EXIT

# Signed volume of a text STL, by the divergence theorem.
stl_volume() {
    awk '$1 == "vertex" { for (j = 0; j < 3; j++) v[3 * n + j] = $(j + 2)
            if (++n == 3) { n = 0
                s += v[0] * (v[4] * v[8] - v[5] * v[7]) + v[1] * (v[5] * v[6] - v[3] * v[8]) + v[2] * (v[3] * v[7] - v[4] * v[6]) } }
         END { printf "%.9g", s / 6 }' "$1"
}

# Ordered by a checksum of seed and name: the same on every machine.
mapfile -t files < <(find "$@" -name '*.csg' -o -name '*.scad' | LC_ALL=C sort | while read -r file; do
    printf '%010d %s\n' "$(printf '%s %s' "$seed" "${file#"$corpora"/}" | cksum | cut -d ' ' -f 1)" "$file"
done | LC_ALL=C sort | cut -d ' ' -f 2-)
[ ${#files[@]} -gt 0 ] || { echo "openscad.sh: no .csg or .scad files in: $*" >&2; exit 1; }
printf 'openscad\tmortise\tdifference_percent\tmodel\n'
compared=0 within=0
for file in "${files[@]}"; do
    [ $compared -lt "$count" ] || break
    name="${file#"$corpora"/}"
    rm -f "$scratch"/*
    if ! timeout "$limit" openscad -o "$scratch/o.stl" "$file" >"$scratch/log" 2>&1 || [ ! -s "$scratch/o.stl" ]; then
        printf -- '-\t-\t-\t%s: openscad: %s\n' "$name" "$(tail -1 "$scratch/log")"
        continue
    fi
    timeout "$limit" "$program" "$file" -o "$scratch/m.vtu" --level "$level" --facets "$facets" "${options[@]}" >"$scratch/log" 2>&1
    code=$?
    if [ $code -ne 0 ]; then
        printf -- '-\t-\t-\t%s: mortise: exit %d: %s\n' "$name" "$code" "$(grep -v '^warning' "$scratch/log" | tail -1)"
        continue
    fi
    theirs="$(stl_volume "$scratch/o.stl")"
    ours="$("$program" check "$scratch/m.vtu" --json | tr ',' '\n' | sed -n 's/.*"volume": *\([-+.0-9e]*\).*/\1/p' | head -1)"
    difference="$(awk -v a="$theirs" -v b="$ours" 'BEGIN { printf "%.3f", 100 * (b - a) / (a != 0 ? a : 1) }')"
    printf '%s\t%s\t%s\t%s\n' "$theirs" "$ours" "$difference" "$name"
    compared=$((compared + 1))
    within=$((within + $(awk -v d="$difference" 'BEGIN { print (d < 1 && d > -1) ? 1 : 0 }')))
done
echo "$within of $compared models within 1 % of OpenSCAD's volume, level $level, facets $facets, seed $seed"
