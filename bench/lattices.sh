#!/bin/bash
# Lattices of rods and minimal surfaces, and how they are meshed:  bash bench/lattices.sh [--help] [options]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there), OpenSCAD (Debian: openscad) and
# Python 3. The exit code is 3 if one could not be meshed.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
need_python
need_command openscad openscad || exit 5
run_python lattices "$@"
