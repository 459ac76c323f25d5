#!/usr/bin/env bash
# analyze.sh BUILD [FILE]: runs clang-tidy (.clang-tidy names the checks) and gcc's analyzer on the modules below, with the
# flags of BUILD, a build by gcc. Prints their findings; exit 1 if there are any, 77 if clang-tidy is not installed. What
# begins while FILE exists has the lowest priority.
# Asserts are on: they tell the analyzers which paths are impossible. A file without findings is skipped until its text,
# a header, a flag, a check or an analyzer changes; BUILD/analyzed/ has a file for each such state.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=$(cd "$1" && pwd)
yields=${2:-}
modules='game|jobs|job_prof|profiler|engine/(bake|base|culling|debug|geometry|gi|gpu|image|input|light|numeric|post|render|scene|shading|shadow|ui|window)'
command -v clang-tidy >/dev/null || { echo "skipped: no clang-tidy here (package clang-tidy)"; exit 77; }

# "FILE COMMAND" for each C file of the modules, without examples, and of the engine's own folder. JSON puts a \ before
# each \ and ".
commands=$(sed -n 's/^ *"command": "\(.* -c \([^ ]*\)\)",\{0,1\}$/\2 \1/p' "$build/compile_commands.json" |
	grep -E "^$PWD/(($modules)/[^ ]*|engine/[^ /]*)\.c " | grep -v '/examples/' | sort -u -k 1,1 | sed 's/\\\(.\)/\1/g')
files=$(wc -l <<<"$commands")
[ "$files" -gt 30 ] || { echo "$build/compile_commands.json names $files files of ours: too few"; exit 1; }

# Steps after which clang leaves a function; its own limit is nine times as high. Few functions get there, and they take
# most of the time. Of faults planted at the ends of functions all 28 that are found with 50,000 steps are found with
# these, and 27 with 20,000.
steps=25000

# Two warnings are off: gcc 12 does not understand that a loop fills an array, nor that a pointer in a structure has an
# owner. clang-tidy and the sanitizers check both. With -Og gcc generates code in less time, of which nothing is kept, and it
# finds more: -O3 takes a block away that is only allocated and freed, before the analyzer looks.
gcc_options='-Og -S -fanalyzer -Wno-analyzer-use-of-uninitialized-value -Wno-analyzer-malloc-leak -Werror'

# tidy FILE COMPILE: findings in headers of the modules count too. It does not read compile_commands.json, where the
# profiler's files stand twice: a second file in one run of clang-tidy 14 has false findings about va_list.
tidy() {
	local header="^$PWD/($modules)/"
	(cd "$build" && eval "clang-tidy --quiet --header-filter='$header' '$1' -- ${2#* } \
		-Wreserved-identifier -Wreserved-macro-identifier -Xclang -analyzer-config -Xclang max-nodes=$steps" 2>/dev/null)
}

# analyze "FILE COMMAND": runs both, unless they have found nothing in the same text. What gcc writes is thrown away.
analyze() {
	local file=${1%% *} compile text
	[ ! -e "$yields" ] || renice -n 19 "$BASHPID" >/dev/null
	compile=$(sed -E 's/^([^ ]* )?[^ ]*ccache //; s/ -M[DTF]( [^ -][^ ]*)?//g; s/ -o [^ ]*//' <<<"${1#* } -UNDEBUG")
	# With comments, which may hold NOLINT, and with the definitions of macros, which need not be expanded for that.
	text=$(echo "$about $compile"; cd "$build" && eval "$compile -E -CC -fdirectives-only")
	text=$(sha256sum <<<"$text")
	[ ! -e "$build/analyzed/${text%% *}" ] || return 0
	tidy "$file" "$compile" && (cd "$build" && eval "$compile $gcc_options -o /dev/null" 2>&1) && : >"$build/analyzed/${text%% *}"
}

mkdir -p "$build/analyzed" && find "$build/analyzed" -type f -mtime +30 -delete
about=$(cat .clang-tidy tests/tree/analyze.sh; clang-tidy --version; gcc --version)
export build yields modules steps gcc_options about
export -f tidy analyze
if xargs -P "$(nproc)" -d '\n' -n 1 bash -c 'analyze "$1" || exit 1' analyze <<<"$commands"; then
	echo "nothing found in $files files"
else
	exit 1
fi
