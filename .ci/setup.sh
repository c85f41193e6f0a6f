# Functions for mesh.sh, test.sh and .ci/run: sourced, not run. The caller sets `root` to the checkout.
# shellcheck shell=bash disable=SC2154
# Messages go to stderr: stdout belongs to the program that is run at the end.

say() { echo "$(basename "$0"): $*" >&2; }

# install_packages [tests|python]: installs what is missing of .ci/packages.txt; with a word its lines too.
install_packages() {
    local missing=() name use
    while read -r name use; do
        case "$name" in '' | '#'*) continue ;; esac
        [ -z "$use" ] || [ "$use" = "${1:-}" ] || continue
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
    done <"$root/.ci/packages.txt"
    [ ${#missing[@]} -ne 0 ] || return 0
    command -v apt-get >/dev/null || {
        say "not a Debian system; install what corresponds to: ${missing[*]}"
        return 1
    }
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || {
            say "as root, run: apt-get install ${missing[*]}"
            return 1
        }
        as_root=(sudo)
    fi
    say "installing ${missing[*]}"
    # The lists that are there may do; they are fetched only if the first attempt fails.
    local install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends)
    "${install[@]}" "${missing[@]}" >&2 2>/dev/null && return 0
    { "${as_root[@]}" apt-get update -q && "${install[@]}" "${missing[@]}"; } >&2 || {
        say "apt-get could not install ${missing[*]}; see its messages above"
        return 1
    }
}

# build FOLDER CMAKE_OPTIONS... -- TARGETS...: configures once, then builds.
build() {
    local folder="$1" options=()
    shift
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    shift
    if [ ! -f "$folder/build.ninja" ]; then
        cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DMORTISE_JOIN=ON "${options[@]}" >&2 || return
    fi
    cmake --build "$folder" --parallel "$(nproc)" ${1:+--target "$@"} >&2
}
