#!/bin/bash
# Fails on the name of a file, in documents and comments, that no file of this checkout has.
#
#     bash .ci/check_references.sh
#
# Looked at: every name that ends with .md in sources and documents, and every source file between backticks in documents
# (but not in CHANGELOG.md, which tells of the past). A name without a folder may be anywhere.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
folders=(include host kernels tests bench docs .ci)
files=$(find "${folders[@]}" assets . -maxdepth 6 -type f -not -path './build*' -not -path './.git/*' | sed 's|^\./||' | sort -u)

{
    grep -rnoE '[A-Za-z0-9_][A-Za-z0-9_./-]*\.md\b' "${folders[@]}" CMakeLists.txt README.md ARCHITECTURE.md
    grep -noE '`[A-Za-z0-9_./-]+\.(cpp|hpp|h|cl|def|sh|py)`' README.md ARCHITECTURE.md docs/*.md docs/*/*.md |
        tr -d '`'
} | awk -v files="$files" '
    BEGIN {
        count = split(files, list, "\n")
        for (i = 1; i <= count; i++) {
            path = list[i]
            known[path] = 1
            # Any end of the path, from a folder on.
            while (match(path, "/")) {
                path = substr(path, RSTART + 1)
                known[path] = 1
            }
        }
    }
    {
        split($0, part, ":")
        name = part[3]
        sub(/^(\.\.?\/)+/, "", name)
        checked++
        if (!(name in known)) {
            print "check_references: " part[1] ":" part[2] ": there is no file " part[3]
            failures++
        }
    }
    END {
        if (!checked) print "check_references: nothing found; run it in the checkout"
        exit failures > 0 || !checked
    }' >&2
