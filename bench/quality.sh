#!/bin/bash
# Quality of meshes beside Gmsh's and Netgen's at equal element size:  bash bench/quality.sh [--help] [MODEL ...]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there), Python 3, and for the comparison
# Debian's gmsh and python3-netgen. Those three are installed with apt-get if missing; a mesher that cannot be
# is left out, with a line that says so.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# shellcheck source=.ci/setup.sh
. "$root/.ci/setup.sh"
# shellcheck source=bench/tools.sh
. "$root/bench/tools.sh"
need_mortise || exit 5
need_command python3 python3 || exit 5
need_command gmsh gmsh
/usr/bin/python3 -c 'import netgen.csg' 2>/dev/null || install_optional python3-netgen
export PYTHONDONTWRITEBYTECODE=1
exec python3 "$root/bench/quality.py" --mortise "$MORTISE" "$@"
