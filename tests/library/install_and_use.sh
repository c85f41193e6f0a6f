#!/bin/bash
# Installs a build into a scratch folder, then configures, builds and runs a program that uses the library:
#     install_and_use.sh BUILD_FOLDER PROGRAM_THAT_CHECKS_MESHES [PYTHON]
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
cmake --install "$1" --prefix "$scratch/prefix" >/dev/null
cmake -S "$here" -B "$scratch/build" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$scratch/build" >/dev/null
"$scratch/build/example" "$scratch"
"$scratch/prefix/bin/mortise" --version
# Kernels came with it: with empty caches nothing is compiled, by the program or through the library.
for user in "$scratch/prefix/bin/mortise $here/../../assets/models/block.csg --level 3 -o $scratch/block.vtu" \
    "$scratch/build/example $scratch"; do
    mkdir "$scratch/cache"
    # shellcheck disable=SC2086  # a command and its arguments
    MORTISE_CACHE="$scratch/cache" POCL_CACHE_DIR="$scratch/cache/pocl" $user >/dev/null
    if [ "$(find "$scratch/cache" -name '*.bin' | wc -l)" -ne 1 ]; then # what the probe of the arithmetic found
        echo "compiled its kernels again: $user"
        exit 1
    fi
    rm -r "$scratch/cache"
done
# The same without CMake.
packages="$(dirname "$(find "$scratch/prefix" -name mortise.pc)")"
read -ra flags <<<"$(PKG_CONFIG_PATH="$packages" pkg-config --cflags --libs mortise)"
"${CXX:-c++}" -std=c++17 "$here/example.cpp" "${flags[@]}" -Wl,-rpath,"$(dirname "$packages")" -o "$scratch/by_pkg_config"
"$scratch/by_pkg_config" "$scratch" >/dev/null
for mesh in "$scratch"/plate1.vtu "$scratch"/plate20.vtu "$scratch"/large.vtu; do
    "$2" check "$mesh" >/dev/null
done
# The Python module finds the library and its kernels from its own place.
if [ -n "${3:-}" ]; then
    module="$(find "$scratch/prefix" -name 'mortise.cpython-*.so')"
    PYTHONPATH="$(dirname "$module")" "$3" -c '
import mortise
mesh = mortise.generate(mortise.parse_model("cube([1, 2, 3]);", "csg"), level=3)
assert abs(mesh.check().volume - 6) < 1e-9'
fi
# Every function that a header declares is there.
shown="$(nm -DC --defined-only "$(find "$scratch/prefix" -name libmortise.so)")"
declared="$(sed -n '/^inline\|^struct\|^class/d; s/^[A-Za-z][A-Za-z0-9_:<>, ]* \**&*\([a-z_0-9]*\)(.*/\1/p' "$scratch"/prefix/include/mortise/*.hpp)"
[ "$(wc -w <<<"$declared")" -gt 15 ] || { echo "no functions found in the headers"; exit 1; }
for name in $declared; do
    grep -q " mortise::$name\((\|\[\)" <<<"$shown" || { echo "the library hides mortise::$name"; exit 1; }
done
# Whoever links it must not see Mortise's insides.
if grep -E ' mortise::(improve|cnio|octree|device|tape|pipeline|assembly)::' <<<"$shown"; then
    echo "the library shows these"
    exit 1
fi
