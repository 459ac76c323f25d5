#!/usr/bin/env bash
# test_job_example.sh PROGRAM SOURCE: the program must print what its first comment says, and succeed.
set -euo pipefail
wanted=$(sed -n 's/^ \* Prints: //p' "$2")
[ -n "$wanted" ] || { echo "$2 does not say what it prints"; exit 1; }
said=$("$1") || { echo "exit status $? after: $said"; exit 1; }
[ "$said" = "$wanted" ] || { printf 'expected: %s\nprinted:  %s\n' "$wanted" "$said"; exit 1; }
echo "$said"
