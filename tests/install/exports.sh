#!/usr/bin/env bash
# exports.sh LIBRARY: prints the names that a shared library exports, with what each is: function, data.
# exports.txt holds those of libstilb.so: after a change of a public header, look at the difference and write it anew,
#     tests/install/exports.sh build/release/lib/libstilb.so >tests/install/exports.txt
set -euo pipefail
export LC_ALL=C
nm --dynamic --defined-only --format=posix "$1" | awk '{ print $1, $2 == "T" ? "function" : $2 ~ /[BDR]/ ? "data" : $2 }' | sort
