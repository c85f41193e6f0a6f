#!/bin/bash
# Meshes a model on a bare Debian 12:  bash mesh.sh MODEL -o OUT [options]
#
# Installs missing packages (apt; root or sudo), builds the release on first use and after changes, compiles its
# kernels, then runs build/release/mortise with the arguments. Paths are relative to the caller's folder.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$root/build/release"
ready="$folder/ready"  # made when the last successful build began

up_to_date() {
    [ -x "$folder/mortise" ] && [ -f "$ready" ] &&
        [ -z "$(find "$root/CMakeLists.txt" "$root/.ci/packages.txt" "$root/host" "$root/include" "$root/kernels" \
            -newer "$ready" -print -quit)" ]
}

if ! up_to_date; then
    . "$root/.ci/setup.sh"
    mkdir -p "$folder" || exit 5
    exec 9>"$folder/lock"
    flock 9  # another mesh.sh may be building
    if ! up_to_date; then
        install_packages || exit 5
        touch "$ready.new"
        say "building Mortise (on first use and after changes)"
        build "$folder" -DMORTISE_WERROR=OFF -- mortise || {
            say "the build failed; see its messages above"
            exit 5
        }
        mv "$ready.new" "$ready"
        # Where the program looks for them. A failure shows, with its message, in the run that follows.
        "$folder/mortise" kernels -o "$folder/compiled-kernels" >/dev/null 2>&1
    fi
    exec 9>&-
fi
exec "$folder/mortise" "$@"
