#!/bin/sh
# mutants.sh HEADERS OUT LIST: changes the headers of the folder HEADERS for the mutation check (mutants.awk). The folder OUT
# holds them; the file LIST has a line "ID PLACE LITERAL" for each literal.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
headers=$1 out=$2 list=$3
rm -rf "$out"
mkdir -p "$out"
: > "$list"
for header in "$headers"/*.h; do
	name=$(basename "$header")
	case $name in glsl_*) cp "$header" "$out/" && continue ;; esac
	: > "$list.part"
	awk -v first="$(wc -l < "$list")" -v place="$name" -v list="$list.part" -f "$here/mutants.awk" "$header" > "$out/$name"
	cat "$list.part" >> "$list"
	rm "$list.part"
done
most=$(sed -n 's/^#define SHADE_MUTANT_COUNT \([0-9]*\).*/\1/p' "$here/mutant.h")
[ "$(wc -l < "$list")" -lt "$most" ] || { echo "more than $most literals: raise SHADE_MUTANT_COUNT"; exit 1; }
