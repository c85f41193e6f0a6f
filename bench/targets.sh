#!/bin/bash
# Worst elements over a list of models, beside the project's targets:  bash bench/targets.sh [--help] [FILE ...]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there) and Python 3. The exit code is 3
# if a mesh is invalid or could not be made; missing a target does not count.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# shellcheck source=.ci/setup.sh
. "$root/.ci/setup.sh"
# shellcheck source=bench/tools.sh
. "$root/bench/tools.sh"
need_mortise || exit 5
need_command python3 python3 || exit 5
export PYTHONDONTWRITEBYTECODE=1
exec python3 "$root/bench/targets.py" --mortise "$MORTISE" "$@"
