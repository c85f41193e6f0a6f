#!/bin/bash
# Fails on an #include that the table "may include" of ARCHITECTURE.md does not allow, and on what it allows
# but nobody needs.
#
#     bash .ci/check_dependencies.sh [FOLDER]      (default: this checkout)
#
# The table's rows are `| folder | may include |`, the second cell a list with commas: other folders such as
# host/octree, include/mortise, kernels/shared. Any folder may include its own files and system headers, but
# OpenCL, Boost.Compute and CLBlast only host/device may. A row `kernels` stands for all kernel folders without
# a row of their own, except kernels/shared. Subfolders belong to their folder; tests are free.
set -uo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}" || exit 1
[ -f ARCHITECTURE.md ] || {
    echo "check_dependencies: ARCHITECTURE.md not found" >&2
    exit 1
}

{
    grep -rnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]' --include='*.cpp' --include='*.hpp' \
        --include='*.h' --include='*.cl' --include='*.def' include host kernels 2>/dev/null
} | awk -v table=ARCHITECTURE.md '
    function folder_of(path, parts, count) {
        count = split(path, parts, "/")
        if (count < 3) return parts[1]
        if (parts[1] == "kernels" && parts[2] != "shared" && !("kernels/" parts[2] in known)) return "kernels"
        return parts[1] "/" parts[2]
    }
    function report(message) { print "check_dependencies: " message; failures++ }
    BEGIN {
        while ((getline row < table) > 0) {
            gsub(/[`[:space:]]/, "", row)
            if (tolower(row) ~ /^\|folder\|mayinclude\|/) { inside = 1; continue }
            if (row !~ /^\|/) inside = 0
            if (!inside || row ~ /^\|[-:|]+$/) continue
            split(row, cells, "|")
            known[cells[2]] = 1
            rows++
            count = split(cells[3], names, ",")
            for (i = 1; i <= count; i++) allowed[cells[2], names[i]] = 1
        }
        if (!rows) { report("ARCHITECTURE.md has no table with the head | folder | may include |"); exit 1 }
    }
    {
        split($0, place, ":")
        file = place[1]
        folder = folder_of(file)
        match($0, /["<][^">]*[">]/)
        quoted = substr($0, RSTART, RLENGTH)
        target = substr(quoted, 2, length(quoted) - 2)
        if (!(folder in known)) {
            if (!(folder in named)) report(folder " is missing from the table in ARCHITECTURE.md; add a row for it")
            named[folder] = 1
            next
        }
        checked++
        if (quoted ~ /^</) {
            if (target ~ /^(CL\/|boost\/compute|clblast)/ && folder != "host/device")
                report(file ":" place[2] ": <" target "> is for host/device only")
            next
        }
        if (target ~ /^mortise\//) other = "include/mortise"
        else if (target ~ /^shared\//) other = "kernels/shared"
        else if (target ~ /^(host|kernels|tests|bench)\//) other = folder_of(target)
        else next                                       # beside the file: the same folder
        used[folder, other] = 1
        if (other != folder && !((folder, other) in allowed))
            report(file ":" place[2] ": " folder " may not include " target " (table in ARCHITECTURE.md)")
    }
    END {
        for (pair in allowed) {
            split(pair, names, SUBSEP)
            if (names[2] != "" && !(pair in used))
                report(names[1] " does not include " names[2] "; remove it from the table in ARCHITECTURE.md")
        }
        if (rows && !checked && !failures) report("no #include found; run it in the checkout")
        exit failures > 0
    }' >&2
