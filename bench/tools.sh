# For the scripts beside it that run Mortise: sourced, not run.
# shellcheck shell=bash
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# shellcheck source=.ci/setup.sh
. "$root/.ci/setup.sh"

# install_optional PACKAGE: by apt-get; false, with a line, where that is not possible.
install_optional() {
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then as_root=(sudo -n); fi
    if command -v apt-get >/dev/null; then
        say "installing $1"
        local install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q
            --no-install-recommends "$1")
        "${install[@]}" >/dev/null 2>&1 && return 0
        { "${as_root[@]}" apt-get update -q && "${install[@]}"; } >/dev/null 2>&1 && return 0
    fi
    say "could not install $1; to have it, as root: apt-get install $1"
    return 1
}

# need_command COMMAND PACKAGE
need_command() { command -v "$1" >/dev/null || install_optional "$2"; }

# Sets MORTISE to the program: as given, else the release build, which is made if need be.
need_mortise() {
    if [ -z "${MORTISE:-}" ]; then
        MORTISE="$root/build/release/mortise"
        if [ ! -x "$MORTISE" ]; then
            install_packages || return
            build "$root/build/release" -DMORTISE_WERROR=OFF -- mortise || {
                say "the build failed; see its messages above"
                return 1
            }
        fi
    fi
    MORTISE="$(command -v "$MORTISE")" || {
        say "MORTISE names no program"
        return 1
    }
    MORTISE="$(realpath "$MORTISE")"
}

# need_python: Mortise and Python 3, or the end. run_python NAME ARGUMENTS: bench/NAME.py, in place of the script.
need_python() { need_mortise && need_command python3 python3 || exit 5; }
run_python() {
    local name="$1"
    shift
    export PYTHONDONTWRITEBYTECODE=1
    exec nice python3 "$root/bench/$name.py" --mortise "$MORTISE" "$@"
}
