#!/bin/bash
# Meshes a model on a bare Debian 12:  bash mesh.sh MODEL -o OUT [options]
#
# Installs missing packages (apt; root or sudo), builds the release on first use and after changes, fills the
# kernel cache, then runs build/release/mortise with the arguments. Paths are relative to the caller's folder.
set -uo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$root/build/release"
ready="$folder/ready"  # made when the last successful build began

up_to_date() {
    [ -x "$folder/mortise" ] && [ -f "$ready" ] &&
        [ -z "$(find "$root/CMakeLists.txt" "$root/.ci/packages.txt" "$root/host" "$root/include" "$root/kernels" \
            -newer "$ready" -print -quit)" ]
}

# Kernels compile at first use; a small solid takes them all through, so that the first real run is fast.
warm_kernel_cache() {
    local scratch
    scratch="$(mktemp -d)" || return 0
    printf 'algebraic3d\nsolid s = orthobrick (0, 0, 0; 1, 1, 1) and not sphere (0, 0, 0; 0.5);\ntlo s;\n' \
        >"$scratch/warm.geo"
    MORTISE_JACOBIANS=own "$folder/mortise" "$scratch/warm.geo" -o "$scratch/warm.vtu" --level 3 >/dev/null 2>&1
    rm -rf "$scratch"
    return 0  # a failure shows, with its message, in the run that follows
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
        warm_kernel_cache
    fi
    exec 9>&-
fi
exec "$folder/mortise" "$@"
