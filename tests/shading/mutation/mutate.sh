#!/bin/sh
# mutate.sh LIST PROGRAM...: does a test fail if a literal of the shading headers changes by 0.1 %?
#
# LIST is what mutants.sh made, PROGRAM the tests built with its headers. Every program first runs unchanged: it must pass,
# and tells which literals it comes across. Then each literal is made larger, and made smaller, and those programs run one
# after the other, the fastest first, until one fails. A change that no program fails on is printed; exit 1 if there is any.
set -u
list=$1
shift
[ $# -gt 0 ] || { echo "mutate.sh: no program"; exit 1; }
work=$(mktemp -d ./mutate_XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
export STILB_SHADE_QUICK=1

for program in "$@"; do
	began=$(date +%s%N)
	if ! STILB_MUTANTS_SEEN="$work/$(basename "$program")" "$program" > "$work/output" 2>&1; then
		cat "$work/output"
		echo "$program fails with unchanged literals"
		exit 1
	fi
	took=$(($(date +%s%N) - began))
	sed "s|\$| $took $program|" "$work/$(basename "$program")" >> "$work/each"
done
sort -n -k 2,2 "$work/each" > "$work/seen"

# One line per literal: ID PLACE LITERAL PROGRAM...
awk -v seen="$work/seen" 'BEGIN { while ((getline line < seen) > 0) { split(line, f, " "); programs[f[1]] = programs[f[1]] " " f[3] } }
	{ print $0 programs[$1] }' "$list" > "$work/work"
# A program that ends by a signal or runs for long (seconds of CPU time: on a busy machine all run for long) has noticed
# too; the shell's word on it is not wanted.
cat > "$work/one.sh" << 'END'
id=$1 place=$2 literal=$3
shift 3
ulimit -t 10
ulimit -c 0
noticed() {
	factor=$1
	shift
	for program in "$@"; do
		STILB_MUTANT="$id $factor" "$program" > /dev/null 2>&1 || return 0
	done
	return 1
}
for factor in 1.001 0.999; do
	noticed $factor "$@" || echo "$place: $literal times $factor: no test notices${1:+ ($(basename -a "$@" | tr '\n' ' ')came across it)}"
done
END
xargs -P "$(nproc)" -L 1 sh "$work/one.sh" < "$work/work" > "$work/survivors" 2> /dev/null
sort -V "$work/survivors"
echo "$(wc -l < "$list") literals, $(wc -l < "$work/survivors") changes that no test notices"
[ -s "$list" ] && [ ! -s "$work/survivors" ]
