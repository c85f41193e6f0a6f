#!/bin/bash
# Builds a release and measures it:  bash bench/run.sh [options of mortise_bench, such as --json FILE]
#
# For figures worth keeping, let nothing else run. What each section measures: docs/benchmarks.md, --help.
# The other meshers that Mortise is compared with are Debian's gmsh, python3-netgen, tetgen and CGAL (libcgal-dev,
# libtbb-dev, for bench/cgal_mesh.cpp); they are installed with apt-get if missing, and one that cannot be is left
# out, with a line that says so. --no-peers leaves them all out.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
folder="$root/build/bench"

# Whether the arguments, of mortise_bench, ask for the comparison.
peers_wanted() {
    local only='' named='' argument
    for argument in "$@"; do
        case "$argument" in
            --no-peers | --quick | --help | -h) return 1 ;;
            --only | --only=*) only=yes ;;
        esac
        case "$argument" in peers | --only=peers) named=yes ;; esac
    done
    [ -z "$only" ] || [ -n "$named" ]
}

# Two minutes of compiling, once.
make_cgal_mesh() {
    local source="$root/bench/cgal_mesh.cpp" program="$folder/cgal_mesh"
    [ ! "$program" -nt "$source" ] || return 0
    say "building $(basename "$source")"
    g++ -std=c++17 -O2 -DNDEBUG -DCGAL_CONCURRENT_MESH_3 -DCGAL_LINKED_WITH_TBB "$source" -o "$program.new" \
        -ltbb -ltbbmalloc -lgmp -lmpfr -pthread >&2 && mv "$program.new" "$program"
}

# shellcheck disable=SC2119  # without the packages of the tests
install_packages || exit 5
build "$folder" -DMORTISE_WERROR=OFF -- mortise mortise_bench || {
    say "the build failed; see its messages above"
    exit 5
}
options=(--mortise "$folder/mortise")
if peers_wanted "$@"; then
    need_command gmsh gmsh
    need_command tetgen tetgen
    /usr/bin/python3 -c 'import netgen.csg' 2>/dev/null || install_optional python3-netgen
    { [ -e /usr/include/CGAL/make_mesh_3.h ] || install_optional libcgal-dev; } &&
        { [ -e /usr/include/tbb/global_control.h ] || install_optional libtbb-dev; } &&
        make_cgal_mesh && options+=(--cgal "$folder/cgal_mesh")
fi
exec "$folder/bench/mortise_bench" "${options[@]}" "$@"
