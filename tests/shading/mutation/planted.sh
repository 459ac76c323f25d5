#!/bin/sh
# planted.sh LIST PROGRAM: mutate.sh must name the literals that planted/shade_planted.h marks as unproved, and no other.
set -u
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d ./planted_XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
if "$here/mutate.sh" "$1" "$2" > "$work/said"; then
	echo "mutate.sh found nothing"
	exit 1
fi
sed -n '/.*\/\/ unproved \(.*\)/{=;s//\1/p;}' "$here/planted/shade_planted.h" | paste -d' ' - - |
	while read -r line literal; do
		echo "shade_planted.h:$line: $literal times 0.999"
		echo "shade_planted.h:$line: $literal times 1.001"
	done > "$work/wanted"
sed -n 's/^\(shade_planted.*\): no test notices.*/\1/p' "$work/said" > "$work/found"
[ -s "$work/wanted" ] && diff "$work/wanted" "$work/found" && tail -n 1 "$work/said"
