#!/bin/sh
# man.sh PROGRAM BENCH VERSION OUT PAGE...: writes manual pages into the folder OUT, from the output of --help. The name of
# a page is its command with dashes: stilb-trace-top is `stilb trace top`; stilb-bench is the program BENCH.
set -eu
program=$1 bench=$2 version=$3 out=$4
shift 4
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$out"
for page in "$@"; do
	if [ "$page" = stilb-bench ]; then
		"$bench" --help > "$out/$page.help"
	else
		# shellcheck disable=SC2046
		"$program" $(printf '%s' "${page#stilb}" | tr - ' ') --help > "$out/$page.help"
	fi
	awk -v page="$page" -v version="$version" -v others="$*" -f "$here/man.awk" "$out/$page.help" > "$out/$page.1.new"
	mv "$out/$page.1.new" "$out/$page.1"
done
