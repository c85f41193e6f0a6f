#!/bin/bash
# What bench/run.sh --json FILE measured, as Markdown: targets first, then tables.
#
#   bash bench/summary.sh FILE.json [TEXT]      (a name for the text; default: standard output)
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
[ $# -eq 1 ] || [ $# -eq 2 ] || {
    say "expected a file of bench/run.sh --json, and perhaps a name for the text"
    exit 2
}
export PYTHONDONTWRITEBYTECODE=1
[ $# -eq 1 ] || exec >"$2" || exit 6
exec python3 "$root/bench/summary.py" "$1"
