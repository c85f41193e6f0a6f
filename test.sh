#!/bin/bash
# Builds everything, warnings as errors, and runs all tests:  bash test.sh [ctest options]
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
. "$root/.ci/setup.sh"
install_packages || exit 1
install_packages python || say "the Python module is left out"
build "$root/build/test" -DMORTISE_WERROR=ON -- || {
    say "the build failed; see its messages above"
    exit 1
}
cd "$root/build/test" && exec ctest --output-on-failure --parallel "$(nproc)" "$@"
