#!/bin/bash
# Meshes every model of the corpora and writes a table of what became of them to docs/corpora.md.
#
#   bash bench/table.sh [--level N] [--timeout SECONDS] [--jobs COUNT] [--output FILE] [--results FILE] [--again]
#                       [--fresh] [SET ...]
#
# Needs Mortise ($MORTISE, or build/release/mortise, built if it is not there) and Python 3; the corpora are in
# $MORTISE_CORPORA (default ../shared/corpora beside the checkout). Defaults: level 6, 120 s a model, one model at
# a time. What is done is kept in --results (default build/corpora.jsonl), a line a model: an interrupted run
# goes on where it was, unless the program, the level or the limit changed (or --fresh). --again tries models
# again that ran out of time: on a busy machine that may not be their fault. Every mesh is written
# and validated with `mortise check`. The exit code is 3 if a mesh is not valid.
set -uo pipefail
# shellcheck source=bench/tools.sh
. "$(dirname "${BASH_SOURCE[0]}")/tools.sh"
need_python
run_python table "$@"
