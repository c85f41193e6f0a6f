#!/bin/bash
# One smooth surface: worst elements over a million boundary cells of random solids, before and after improvement,
# beside the project's targets:  bash bench/smooth.sh [--help]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there) and Python 3. The exit code is 3
# if a mesh is invalid or could not be made; missing a target does not count.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
need_python
run_python smooth "$@"
