#!/bin/bash
# Quality of meshes beside Gmsh's and Netgen's at equal element size:  bash bench/quality.sh [--help] [MODEL ...]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there), Python 3, and for the comparison
# Debian's gmsh and python3-netgen. Those three are installed with apt-get if missing; a mesher that cannot be
# is left out, with a line that says so.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
need_python
need_command gmsh gmsh
/usr/bin/python3 -c 'import netgen.csg' 2>/dev/null || install_optional python3-netgen
run_python quality "$@"
