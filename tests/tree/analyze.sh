#!/usr/bin/env bash
# analyze.sh BUILD: runs clang-tidy (.clang-tidy names the checks) and gcc's analyzer on the modules below, with the flags
# of BUILD, a build by gcc. Prints their findings; exit 1 if there are any, 77 if clang-tidy is not installed.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=$(cd "$1" && pwd)
modules='game|jobs|job_prof|profiler|engine/(base|image|input|numeric|ui|window)'
command -v clang-tidy >/dev/null || { echo "skipped: no clang-tidy here (package clang-tidy)"; exit 77; }

# "FILE COMMAND" for each C file of the modules, without examples, and of the engine's own folder. JSON puts a \ before
# each \ and ".
commands=$(sed -n 's/^ *"command": "\(.* -c \([^ ]*\)\)",\{0,1\}$/\2 \1/p' "$build/compile_commands.json" |
	grep -E "^$PWD/(($modules)/[^ ]*|engine/[^ /]*)\.c " | grep -v '/examples/' | sort -u -k 1,1 | sed 's/\\\(.\)/\1/g')
files=$(wc -l <<<"$commands")
[ "$files" -gt 30 ] || { echo "$build/compile_commands.json names $files files of ours: too few"; exit 1; }

tidy() {
	cut -d ' ' -f 1 <<<"$commands" | xargs -P "$(nproc)" -n 4 clang-tidy -p "$build" --quiet 2>/dev/null
}

# Two warnings are off: gcc 12 does not understand that a loop fills an array, nor that a pointer in a structure has an
# owner. clang-tidy and the sanitizers check both. The object files are thrown away.
gcc_analyzer() {
	local analyzer="-fanalyzer -Wno-analyzer-use-of-uninitialized-value -Wno-analyzer-malloc-leak -Werror"
	cd "$build" && cut -d ' ' -f 2- <<<"$commands" |
		sed -E "s/^[^ ]*ccache //; s/ -M[DTF]( [^ -][^ ]*)?//g; s/ -o [^ ]*/ $analyzer -o \/dev\/null/" |
		xargs -P "$(nproc)" -d '\n' -n 1 sh -c
}

status=0
tidy || status=1
(gcc_analyzer) 2>&1 || status=1
[ $status -ne 0 ] || echo "nothing found in $files files"
exit $status
