#!/bin/bash
# Builds a release and measures it:  bash bench/run.sh [options of mortise_bench, such as --json FILE]
#
# For figures worth keeping, let nothing else run. Compared with Gmsh if `gmsh` is on PATH.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# shellcheck source=.ci/setup.sh
. "$root/.ci/setup.sh"
install_packages || exit 5
folder="$root/build/bench"
build "$folder" -DMORTISE_WERROR=OFF -- mortise mortise_bench || {
    say "the build failed; see its messages above"
    exit 5
}
exec "$folder/bench/mortise_bench" --mortise "$folder/mortise" "$@"
