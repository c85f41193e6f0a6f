#!/bin/bash
# Draws what bench/run.sh --json FILE measured:  bash bench/plot.sh FILE.json OUT.png|OUT.svg
#
# Needs Debian's python3-matplotlib, which is installed with apt-get if missing.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
[ $# -eq 2 ] || {
    say "expected a file of bench/run.sh --json, and a name for the picture (.png or .svg)"
    exit 2
}
/usr/bin/python3 -c 'import matplotlib' 2>/dev/null || install_optional python3-matplotlib || exit 5
export PYTHONDONTWRITEBYTECODE=1
exec /usr/bin/python3 "$root/bench/plot.py" "$@"
