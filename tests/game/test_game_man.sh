#!/usr/bin/env bash
# test_game_man.sh FOLDER: checks that every manual page has its sections and all flags of --help, and that groff, if it is
# installed, prints no warning.
set -euo pipefail
failures=0 pages=0
for page in "$1"/*.1; do
	pages=$((pages + 1))
	name=$(basename "$page" .1)
	text=$(sed 's/\\-/-/g; s/\\e/\\/g; s/\\&//g' "$page")
	for section in NAME SYNOPSIS DESCRIPTION 'EXIT STATUS' 'SEE ALSO'; do
		grep -qx "\.SH $section" <<<"$text" || { echo "$name: no section $section"; failures=$((failures + 1)); }
	done
	while read -r flag; do
		grep -q -- "^\.B $flag\b" <<<"$text" || { echo "$name: does not tell $flag"; failures=$((failures + 1)); }
	done < <(sed -n 's/^  \(--*[a-z][a-z-]*\).*/\1/p' "$1/$name.help")
	if command -v groff >/dev/null; then
		said=$(groff -man -ww -z "$page" 2>&1)
		[ -z "$said" ] || { echo "$name: groff warns: $said"; failures=$((failures + 1)); }
	fi
done
# stilb trace diff exits with 1 for a result, not for a failure, so its page has an EXIT STATUS of its own.
grep -qx 'a zone is slower' "$1/stilb-trace-diff.1" || { echo "stilb-trace-diff: another EXIT STATUS"; failures=$((failures + 1)); }
[ $pages -ge 16 ] || { echo "only $pages pages in $1"; exit 1; }
[ $failures -eq 0 ] && echo "$pages pages have all flags"
