# For quality.sh and targets.sh: sourced, not run, after .ci/setup.sh.
# shellcheck shell=bash disable=SC2154

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
