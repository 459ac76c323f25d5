#!/usr/bin/env bash
# statics.sh [ROOT]: checks the names of static functions and variables. One may not begin with the prefix of another
# module, nor exist in two files of the same module: a search for a name must find one definition.
# Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

"$here/files.sh" "$PWD" | grep -E '^(jobs|profiler|engine|game)/.*\.[ch]$' | grep -v '/examples/' | xargs -d '\n' awk '
	BEGIN {
		split("jobs:job profiler:prof base:base shading:shade numeric:numeric image:image scene:scene window:window input:input " \
			"culling:cull gpu:gpu render:render gi:gi ui:ui engine:engine bench:bench", pairs, " ")
		for (i in pairs) { split(pairs[i], pair, ":"); prefix[pair[1]] = pair[2] }
	}
	FNR == 1 {
		module = FILENAME
		own = "" # a subcommand may use the name of its folder as prefix
		if (module ~ /^game\/[a-z]+\//) { own = module; sub(/^game\//, "", own); sub(/\/.*/, "", own) }
		sub(/^engine\//, "", module)
		if (!sub(/\/.*/, "", module)) module = "engine"
	}
	# The name of a static function, array or variable is the last word before the first of ( [ = ;
	# A prototype is no second definition.
	/^static / && !/^static_assert/ && !/\(\*/ && !/^[^=]*\);$/ {
		name = $0
		sub(/[(=\[;].*/, "", name)
		n = split(name, word, /[ \t*]+/)
		while (n > 0 && word[n] == "") n--
		name = word[n]
		if (name !~ /^[a-z]/ || name ~ /^(__attribute__|struct|union|inline|void|int)$/) next
		for (other in prefix)
			if (other != module && index(name, prefix[other] "_") == 1 && index(name, prefix[module] "_") != 1 && index(name, own "_") != 1) {
				print FILENAME ":" FNR ": " name " carries the prefix of " other
				violations++
			}
		if ((module, name) in place && place[module, name] != FILENAME) {
			print FILENAME ":" FNR ": " name " is static in " place[module, name] " too"
			violations++
		}
		place[module, name] = FILENAME
		names++
	}
	END {
		if (!names) { print "statics.sh: found no static name"; exit 1 }
		if (violations) exit 1
		print names " static names are their module'\''s own"
	}'
