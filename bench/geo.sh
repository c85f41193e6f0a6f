#!/bin/bash
# Meshes the Netgen .geo files of the corpora at default settings and says what became of each; sizes in the
# files are followed, so most trees with several regions are graded.
#
#   bash bench/geo.sh [--timeout SECONDS] [--compare LEVEL] [--options "OPTIONS"] [SET | FILE.geo ...]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there) and Python 3; the corpora are in
# $MORTISE_CORPORA (default ../shared/corpora beside the checkout). Prints tab-separated lines:
#
#   set, file, result   valid; refused (model not understood, with the reason); failed (no valid mesh, a crash,
#                       or figures that disagree); timeout (--timeout, 60 s by default)
#   regions, levels     cells by level, e.g. 4:120 5:64, where there are several levels
#   elements, seconds, cpu seconds, stage (the slowest, with its seconds), worst (scaled Jacobian)
#   volume change       the largest of a region's, relative, against a mesh of --compare LEVEL (default 7;
#                       0: none) without --check and improvement
#   interface           area between regions; both sides are measured on the elements, and must agree to 1e-12
#   closed              largest difference, relative, of a region's volume by its elements and by its facets
#   message             reason, or warnings
#
# At the end one line a set. The exit code is 3 if a mesh failed.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
need_python
run_python geo "$@"
