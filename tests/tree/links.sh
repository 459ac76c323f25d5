#!/usr/bin/env bash
# links.sh [ROOT]: checks that the links of all Markdown files lead to files of the tree and to headings that exist. Links
# to the web are not followed. Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C.UTF-8
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

# The anchors of a file's headings, as viewers of Markdown make them: in lower case, with - for spaces, without other signs.
anchors() {
	awk '/^```/ { code = !code } !code && /^#+ / { sub(/^#+ /, ""); print tolower($0) }' "$1" |
		sed 's/[^[:alnum:] _-]//g; s/ /-/g'
}

count=0 violations=0
while IFS=: read -r file line target; do
	count=$((count + 1))
	path=${target%%#*} anchor=
	[[ $target != *'#'* ]] || anchor=${target#*#}
	place=$file
	if [ -n "$path" ]; then
		place=$(dirname "$file")/$path
		if [ ! -e "$place" ]; then
			echo "$file:$line: there is no $path"
			violations=$((violations + 1))
			continue
		fi
	fi
	if [ -n "$anchor" ] && ! anchors "$place" | grep -qxF -- "$anchor"; then
		echo "$file:$line: $place has no heading #$anchor"
		violations=$((violations + 1))
	fi
done < <("$here/files.sh" "$PWD" | grep '\.md$' | while read -r file; do
	awk -v file="$file" '/^```/ { code = !code; next } code { next } {
		rest = $0
		gsub(/`[^`]*`/, "", rest)
		while (match(rest, /\]\([^)]*\)/)) {
			target = substr(rest, RSTART + 2, RLENGTH - 3)
			if (target !~ /^(https?|mailto):/) print file ":" NR ":" target
			rest = substr(rest, RSTART + RLENGTH)
		}
	}' "$file"
done)
[ $count -gt 0 ] || { echo "links.sh: found no link"; exit 1; }
[ $violations -eq 0 ] || exit 1
echo "$count links lead somewhere"
