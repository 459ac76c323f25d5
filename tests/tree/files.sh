#!/usr/bin/env bash
# files.sh [ROOT]: the files of the tree, one per line: neither hidden ones nor anything in a build folder.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/../..}"
find . \( -path ./build -o -path './.?*' -o -type d -exec test -e '{}/CMakeCache.txt' ';' \) -prune \
	-o -type f -printf '%P\n' | LC_ALL=C sort
