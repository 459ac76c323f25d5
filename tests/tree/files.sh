#!/usr/bin/env bash
# files.sh [ROOT]: lists the files of the tree, one per line, without hidden ones and build folders.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/../..}"
find . \( -path ./build -o -path './.?*' -o -type d -exec test -e '{}/CMakeCache.txt' ';' \) -prune \
	-o -type f -printf '%P\n' | LC_ALL=C sort
