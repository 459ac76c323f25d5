#!/usr/bin/env bash
# example.sh PROGRAM SOURCE [EMULATOR...]: the program must print what its first comment says, and succeed.
set -euo pipefail
program=$1 source=$2
shift 2
wanted=$(sed -n 's/^ \* Prints: //p' "$source")
[ -n "$wanted" ] || { echo "$source does not say what it prints"; exit 1; }
said=$("$@" "$program") || { echo "exit status $? after: $said"; exit 1; }
[ "$said" = "$wanted" ] || { printf 'expected: %s\nprinted:  %s\n' "$wanted" "$said"; exit 1; }
echo "$said"
